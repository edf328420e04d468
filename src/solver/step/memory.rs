//! Memory: what is kept of one cloth from frame to frame, beside its particles.

use glam::Vec4;

use super::factors::Factors;
use super::frame::Frame;
use crate::solver::body::{BodyContacts, FaceContacts, Pierced, Pinches, Provisional};
use crate::solver::buffer::Buffer;
use crate::solver::couple::Coupling;
use crate::solver::integrate::{air, pull, spring};
use crate::solver::rest::RestShape;
use crate::solver::skinned::TangledLimits;
#[cfg(feature = "debug")]
use crate::solver::state::ClothState;
use crate::solver::state::StateMut;
use crate::solver::wind::WindForces;

/// Memory of one cloth that decides its next frame, such as contacts and loads. With it are the factors of
/// constraints that [`prepare`](super::prepare) derives, and what the app sets for the next frame: the bodies that the cloth
/// moves, and what pulls at it. No allocation once warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Memory {
    pub(super) factors: Factors,
    pub(super) overlong: spring::Overlong,
    pub(super) tight: spring::Tight,
    pub(super) contacts: BodyContacts,
    pub(super) faces: FaceContacts,
    pub(super) provisional: Provisional,
    pub(super) carried: air::Carried,
    pub(super) coupling: Coupling,
    /// Particles that are pinned to bodies that cloth can move.
    pub(super) pinned_to_bodies: Vec<u32>,
    /// Particles between two bones of who wears it.
    pub(super) pinches: Pinches,
    /// Particles that bones do not meet, because they go through the cloth there.
    pub(super) pierced: Pierced,
    /// How far from its skin what is tangled may be.
    pub(in crate::solver) tangled_limits: TangledLimits,
    pub(super) wind: WindForces,
    pub(super) pulls: pull::Pulls,
    pub(super) acceleration: Buffer<Vec<Vec4>>,
    /// What particles did in the last substep `[m]`, `w` their inverse mass `[1/kg]`, while it is damped.
    pub(super) motion: Buffer<Vec<Vec4>>,
    pub(super) before: Buffer<Vec<Vec4>>,
    /// Ways in the substep `[m]` before anything held the cloth together, if it bounces.
    pub(super) inbound: Buffer<Vec<Vec4>>,
    pub(super) displaced: Buffer<Vec<Vec4>>,
    /// How much farther the velocity of the last inner step would have got in the substep `[m]`.
    pub(super) late: Buffer<Vec<Vec4>>,
    /// Inner steps of the last substep; 0 before the first.
    pub(super) inner_steps: u32,
    /// Worst edge of the last frame before it was finished (dimensionless).
    pub(super) worst_edge: f32,
    /// Whether the last frame took it for strained, and for taut.
    pub(super) strained: bool,
    pub(super) taut: bool,
    /// By how much of their length at rest tethers give way to bodies (dimensionless).
    pub(super) give: f32,
    /// See [`Memory::meets_fast_body`].
    pub(super) fast_body: bool,
    /// How many times as many substeps it takes for the bodies that it bears; 0 before the first frame.
    pub(super) for_heavy_body: u32,
    /// For how long it was slow `[s]`.
    pub(super) slow_for: f32,
    pub(super) frame: Option<Frame>,
}

impl Memory {
    /// Forgets all that it knows of the last frames. What was set for the next one stays: the bodies that cloth moves, and what
    /// pulls at it.
    pub(crate) fn forget(&mut self) {
        let Self { coupling, pulls, .. } = core::mem::take(self);
        *self = Self { coupling, pulls, ..Self::default() };
    }

    /// Takes over what was set for the next frame: the bodies that cloth moves, and what pulls at it.
    pub(crate) fn take_surroundings(&mut self, of: Self) {
        (self.coupling, self.pulls) = (of.coupling, of.pulls);
    }

    /// Whether [`prepare`](super::prepare) was called for a rest shape of these sizes, and nothing was forgotten since.
    #[must_use]
    pub fn is_prepared_for(&self, rest: &RestShape) -> bool {
        self.factors.sizes == Some(Factors::sizes_of(rest))
    }

    /// What pulls at the cloth in the frames to come; it stays until it is changed.
    pub(crate) fn pulls_mut(&mut self) -> &mut pull::Pulls {
        &mut self.pulls
    }

    /// Number of the body, particle and mean push per substep `[m]` of every contact in the last substep. Of particles, by
    /// body, then of faces, by body, each as if its nearest corner bore it alone.
    pub fn touches(&self) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        self.contacts.loads().chain(self.faces.loads())
    }

    /// Particles that touched a body in the last substep.
    pub(crate) fn grounded(&self) -> impl Iterator<Item = u32> + '_ {
        self.contacts.touching().chain(self.faces.touching())
    }

    /// Whether any particle may touch a body in this frame.
    pub(super) fn is_near_bodies(&self) -> bool {
        self.contacts.candidates() + self.faces.candidates() > 0
    }

    /// The time over which velocities were the last substep's `[s]`: that of its last inner step.
    pub(super) fn last_step(&self, state: &StateMut<'_>) -> f32 {
        *state.substep / self.inner_steps.max(1) as f32
    }

    /// Takes no air along for the rest of the frame: what is tangled has none between its layers.
    pub(crate) fn leave_air(&mut self) {
        self.carried.end();
    }

    /// Notes which particles lie on cloth, once the frame has begun: no air is between.
    pub(crate) fn lies_on_cloth(&mut self, particles: impl Iterator<Item = u32>) {
        self.carried.leave_out(particles);
    }

    /// Ends a substep for the air: what it carries keeps of the change of velocity its share.
    pub(super) fn keep_air(&mut self, state: &mut StateMut<'_>) {
        self.carried.leave_out(self.contacts.touching().chain(self.faces.touching()));
        self.carried.keep(*state.substep, state.positions, state.previous);
    }

    /// Particles that touched a body in the last substep, one once for each of its faces that did. Each comes with the force of
    /// the body on it `[N]`, on average over the last substeps. That is `F = m C / h²`, with the mean push `C` of a substep
    /// `h`. What other cloth lies on them is not in it.
    #[cfg(feature = "debug")]
    pub(crate) fn body_forces<'a>(&'a self, state: &'a ClothState) -> impl Iterator<Item = (u32, f32)> + 'a {
        self.touches().filter_map(|(_, p, load)| {
            let force = load / (state.positions.get(p as usize)?.w * state.substep * state.substep);
            force.is_finite().then_some((p, force))
        })
    }

    /// The next frame lists other bodies than the last one: `number` says which place each has now, in the same order, or none.
    /// What is known of those that stay goes with them.
    pub(crate) fn renumber_bodies(&mut self, number: impl Fn(u32) -> Option<u32>) {
        self.contacts.renumber(&number);
        self.faces.renumber(&number);
        self.pierced.renumber(&number);
    }

    /// The bodies that take what the cloth gives them.
    #[must_use]
    pub fn coupling(&self) -> &Coupling {
        &self.coupling
    }

    /// The bodies that take what the cloth gives them; filled before each frame. When the pins on movable bodies or those
    /// bodies' masses change, [`prepare`](super::prepare) must follow.
    pub fn coupling_mut(&mut self) -> &mut Coupling {
        &mut self.coupling
    }

    /// Heap of factors and forces `[B]`; contacts and gusts come on top where there are any.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.factors.bytes()
            + self.carried.bytes()
            + size_of_val(&self.acceleration[..])
            + size_of_val(&self.motion[..])
            + size_of_val(&self.before[..])
            + size_of_val(&self.inbound[..])
            + size_of_val(&self.displaced[..])
            + size_of_val(&self.late[..])
    }
}
