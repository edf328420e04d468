//! What the simulation keeps on a cloth's entity, a component per kind of data: rest, state, inputs, scratch, shown.
//!
//! None of these is cloned with the entity: the clone binds anew from the mesh that was authored.

use std::sync::Arc;

use bevy::math::{Affine3A, DVec3, Mat3, Vec4};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use crate::bind::{AnchorSets, Placement, Skin, Surface};
use crate::components::checked::Checked;
use crate::components::{ClothDetail, ClothLod, ClothPins, RecoveryCause, RecoveryLevel, WaitingFor};
use crate::solver::anchors::Anchors;
use crate::solver::body::Body;
use crate::solver::evaluate::EvaluateSettings;
use crate::solver::island::{Display, UntangleSettings};
use crate::solver::kick;
use crate::solver::recover::{Limits, Recovery};
use crate::solver::rest::RestShape;
use crate::solver::settings::{Fabric, Stepping};
use crate::solver::slew::Slew;
use crate::solver::state::ClothState;
use crate::solver::step::{FrameInput, Scratch, StepReport};
use crate::solver::wind::Wind;
use crate::systems::couple::Coupled;
use crate::systems::sleep::Slumber;

/// What changed since a cloth was bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Change {
    #[default]
    None,
    Pins,
    Scale,
    Mesh,
}

/// Which meshes and which scale a cloth was made from.
#[derive(Component)]
#[component(clone_behavior = Ignore)]
pub(crate) struct Binding {
    /// The authored mesh: read, never written.
    pub source: Handle<Mesh>,
    /// The entity's own mesh: written. None while the cloth cannot be simulated.
    pub instance: Option<Handle<Mesh>>,
    /// Scale and shear that the rest shape has baked in.
    pub bake: Mat3,
    /// Whether the entity had `NoAutoAabb` before.
    pub own_bounds: bool,
    /// What changed and could not be bound yet.
    pub pending: Change,
}

/// The skin that was taken off a cloth's entity. A clone of the entity takes it along, with its own joints where those are cloned, too.
#[derive(Component, Clone, Debug, Default)]
pub(crate) struct TakenSkin {
    pub inverse_bindposes: Handle<SkinnedMeshInverseBindposes>,
    #[entities]
    pub joints: Vec<Entity>,
    /// Whether `DynamicSkinnedMeshBounds` was taken off, too.
    pub bounds: bool,
}

impl TakenSkin {
    /// The component that was taken off.
    pub fn skin(&self) -> SkinnedMesh {
        SkinnedMesh { inverse_bindposes: self.inverse_bindposes.clone(), joints: self.joints.clone() }
    }
}

/// How long a cloth has waited.
#[derive(Component, Clone, Copy)]
#[component(clone_behavior = Ignore)]
pub(crate) struct WaitingSince {
    /// What for.
    pub reason: WaitingFor,
    /// Real time at the start `[s]`.
    pub at: f64,
    /// Whether the user was told.
    pub told: bool,
}

/// Rest: the shape the cloth was made with, shared by every cloth of one mesh and scale.
#[derive(Component, Clone, Debug)]
#[component(clone_behavior = Ignore)]
pub struct ClothRest(pub(crate) Arc<RestShape>);

impl ClothRest {
    /// The shape.
    #[must_use]
    pub fn shape(&self) -> &RestShape {
        &self.0
    }

    /// Whether two cloths share one shape in memory.
    #[must_use]
    pub fn is_shared_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// State: the particles, in a frame with the axes of the world and its origin near the cloth.
#[derive(Component, Clone, Debug)]
#[component(clone_behavior = Ignore)]
pub struct ClothParticles {
    pub(crate) state: ClothState,
    /// Origin of the frame of simulation in the world `[m]`.
    pub(crate) origin: DVec3,
    /// Positions at the start of the last frame `[m]`; only kept when shown positions are interpolated.
    pub(crate) before: Vec<Vec3>,
    pub(crate) recovery: Recovery,
    /// What is shown instead of the live shape while it is tangled.
    pub(crate) display: Display,
    /// Where the carrier was in the last simulated frame.
    pub(crate) carrier: Option<Isometry3d>,
    /// Whether something other than a step moved it: it wakes.
    pub(crate) disturbed: bool,
}

impl ClothParticles {
    /// Number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.state.positions.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.state.positions.is_empty()
    }

    /// Simulated positions in the world `[m]`, one per particle: not in the order of the mesh's vertices, whose particles are
    /// [`RestShape::particle_of_vertex`].
    pub fn world_positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.state.positions.iter().map(|x| self.origin + x.truncate().as_dvec3())
    }

    /// Positions to show in the world `[m]`, one per particle: the simulated ones, except where a tangled cloth is held. With a fixed clock,
    /// what is drawn lies between these and those of the frame before.
    pub fn shown_positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        let held = self.display.held().filter(|held| held.len() == self.len());
        let live = self.state.positions.iter().enumerate();
        live.map(move |(i, x)| self.origin + held.map_or(x.truncate(), |held| held[i]).as_dvec3())
    }

    /// State of the solver, relative to [`Self::origin`].
    #[must_use]
    pub fn state(&self) -> &ClothState {
        &self.state
    }

    /// State of the solver, to be changed at your own risk: lengths must stay, and the next frame judges the numbers.
    #[must_use]
    pub fn state_mut(&mut self) -> &mut ClothState {
        self.disturbed = true;
        &mut self.state
    }

    /// Gives an impulse `[N·s]` to the particles within `radius` `[m]` of a point in the world `[m]`, as one piece, fading towards the rim. Held
    /// particles stay; no velocity changes by more than 100 m/s. Returns how many particles took part; none when a number is not finite or
    /// `radius` not above 0.
    pub fn apply_impulse(&mut self, point: Vec3, impulse: Vec3, radius: f32) -> u32 {
        let point = (point.as_dvec3() - self.origin).as_vec3();
        kick::impulse(self.state_mut(), point, impulse, radius)
    }

    /// Blows the particles within `radius` `[m]` away from a point in the world `[m]`. `impulse` `[N·s]` is what the whole cloth gets close by;
    /// it fades to nothing at `radius`. Held particles stay; no velocity changes by more than 100 m/s. Returns how many particles took
    /// part; none when a number is not finite or `radius` not above 0.
    pub fn apply_explosion(&mut self, center: Vec3, impulse: f32, radius: f32) -> u32 {
        let center = (center.as_dvec3() - self.origin).as_vec3();
        kick::explosion(self.state_mut(), center, impulse, radius)
    }

    /// Origin of the frame of simulation in the world `[m]`.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Moves every position the particles remember.
    pub(crate) fn carry(&mut self, motion: impl Fn(Vec3) -> Vec3) {
        self.disturbed = true;
        for x in self.state.positions.iter_mut().chain(&mut self.state.previous) {
            *x = motion(x.truncate()).extend(x.w);
        }
        for x in &mut self.before {
            *x = motion(*x);
        }
        self.display.carry(&motion);
        self.recovery.carry(motion);
    }

    /// Puts every particle at `pose` `[m]`, without velocity.
    pub(crate) fn place(&mut self, pose: impl Iterator<Item = Vec3>) {
        self.disturbed = true;
        let state = &mut self.state;
        for ((x, old), at) in state.positions.iter_mut().zip(&mut state.previous).zip(pose) {
            *x = at.extend(x.w);
            *old = *x;
        }
        state.folds.clear();
        self.before.clear();
        self.display.reset();
        self.recovery.start(&self.state);
    }
}

/// Inputs: everything the solver is given in a frame.
#[derive(Component, Clone)]
#[component(clone_behavior = Ignore)]
#[require(Slumber)]
pub(crate) struct ClothInputs {
    /// Whether to simulate at all.
    pub active: bool,
    /// Whether it is left alone until something happens to it.
    pub asleep: bool,
    /// Fabric of this frame, on its way to the one that is wanted.
    pub fabric: Fabric,
    pub slew: Slew,
    pub stepping: Stepping,
    pub limits: Limits,
    pub untangle: UntangleSettings,
    pub evaluate: EvaluateSettings,
    pub gravity: Vec3,
    pub time_scale: f32,
    /// Whether it stands still for being far away, and is carried along.
    pub carried: bool,
    /// Whether it was carried anywhere in this frame.
    pub rode: bool,
    /// Level of detail, if it has any.
    pub lod: Option<ClothLod>,
    /// Level of detail by distance alone, and the time for which nobody saw it `[s]`.
    pub by_distance: ClothDetail,
    pub unseen_for: f32,
    /// Least jump `[m]` and turn `[rad]` of the carrier that count as a teleport.
    pub teleport: (f32, f32),
    /// The pins that anchors were made from.
    pub pins: ClothPins,
    pub anchors: Anchors,
    pub sets: AnchorSets,
    pub skin: Option<Skin>,
    /// Skinning matrices in the frame of simulation.
    pub joints: Vec<Affine3A>,
    /// Where the cloth's own entity is.
    pub placement: Placement,
    /// Radius of the ball around the shape at rest `[m]`.
    pub radius: f32,
    pub bodies: Vec<Body>,
    /// The entity of each body.
    pub body_entities: Vec<Entity>,
    /// The bodies that take what the cloth gives.
    pub coupled: Coupled,
    pub wind: Wind,
    /// Whether fabric or anchors changed since the solver was prepared.
    pub stale: bool,
    /// Whether the fabric, or how firmly a pin holds, is on its way to what it is to be.
    pub tuned: bool,
    pub checked: Checked,
}

impl ClothInputs {
    /// Inputs of a frame in which the clock of the schedule moves by `dt` `[s]`.
    pub fn frame(&self, dt: f32) -> FrameInput<'_> {
        FrameInput { dt: dt * self.time_scale, gravity: self.gravity, bodies: &self.bodies, wind: &self.wind }
    }

    /// Defaults for everything that the frame fills in.
    pub fn new(
        placement: Placement,
        radius: f32,
        anchors: Anchors,
        sets: AnchorSets,
        skin: Option<Skin>,
        joints: Vec<Affine3A>,
    ) -> Self {
        Self {
            active: true,
            asleep: false,
            fabric: Fabric::default(),
            slew: Slew::of_length(2.0 * radius),
            stepping: Stepping::default(),
            limits: Limits::default(),
            untangle: UntangleSettings::default(),
            evaluate: EvaluateSettings::default(),
            gravity: Vec3::ZERO,
            time_scale: 1.0,
            carried: false,
            rode: false,
            lod: None,
            by_distance: ClothDetail::Full,
            unseen_for: 0.0,
            teleport: (f32::INFINITY, f32::INFINITY),
            pins: ClothPins::default(),
            anchors,
            sets,
            skin,
            joints,
            placement,
            radius,
            bodies: Vec::new(),
            body_entities: Vec::new(),
            coupled: Coupled::default(),
            wind: Wind::default(),
            stale: true,
            tuned: false,
            checked: Checked::default(),
        }
    }

    /// What carries the cloth as a whole: its entity or skin, or the first target if others hold it all.
    pub fn carrier(&self) -> Isometry3d {
        let sets = &self.sets.sets;
        match sets.first() {
            Some(first) if self.skin.is_none() && sets.iter().all(|s| s.target.is_some()) => {
                let (_, rotation, translation) = first.at.to_scale_rotation_translation();
                Isometry3d::new(translation, rotation.normalize())
            }
            _ => self.placement.isometry(),
        }
    }

    /// Starts the anchors' frame where the last one ended, and ends it where their targets are now, as seen from `origin`.
    pub fn aim(&mut self, origin: DVec3) {
        let Anchors { particles, from, to, .. } = &mut self.anchors;
        core::mem::swap(from, to);
        let AnchorSets { sets, set_of, local, .. } = &self.sets;
        let mut space = (u32::MAX, Affine3A::IDENTITY);
        for (i, to) in to.iter_mut().enumerate() {
            let Some(set) = sets.get(set_of[i] as usize) else { continue };
            *to = match &self.skin {
                Some(skin) if set.target.is_none() => skin.pose(&self.joints, particles[i] as usize),
                _ => {
                    if space.0 != set_of[i] {
                        space = (set_of[i], set.space_from(origin));
                    }
                    space.1.transform_point3(local[i])
                }
            };
        }
    }

    /// Puts the anchors where their targets are now, so that nothing is dragged there in the first frame.
    pub fn settle(&mut self, origin: DVec3) {
        self.aim(origin);
        self.anchors.from.clone_from(&self.anchors.to);
    }

    /// Lets go of the anchors whose sets were released.
    pub fn drop_released(&mut self) {
        let sets = &self.sets.sets;
        let keep: Vec<bool> = self.sets.set_of.iter().map(|&s| sets.get(s as usize).is_some_and(|set| !set.released)).collect();
        fn filter<T>(list: &mut Vec<T>, keep: &[bool]) {
            let mut at = keep.iter();
            list.retain(|_| at.next().copied().unwrap_or(true));
        }
        filter(&mut self.anchors.particles, &keep);
        filter(&mut self.anchors.weights, &keep);
        filter(&mut self.anchors.from, &keep);
        filter(&mut self.anchors.to, &keep);
        filter(&mut self.sets.set_of, &keep);
        filter(&mut self.sets.local, &keep);
        filter(&mut self.sets.weights, &keep);
        self.stale = true;
    }

    /// The pose at rest, or the animated one, in the frame of simulation `[m]`.
    pub fn pose<'a>(&'a self, rest: &'a RestShape, origin: DVec3) -> impl Iterator<Item = Vec3> + 'a {
        let place = self.placement.in_frame(origin);
        rest.positions.iter().enumerate().map(move |(i, &p)| match &self.skin {
            Some(skin) => skin.pose(&self.joints, i),
            None => place.transform_point3(p),
        })
    }
}

/// Scratch: reused buffers, and what the last frame has to tell.
#[derive(Component, Clone)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ClothScratch {
    pub solver: Scratch,
    /// Whether the solver was not prepared yet.
    pub fresh: bool,
    /// What the frame did, when it was stepped side by side with others.
    pub done: Option<StepReport>,
    /// What the last frame had to recover from.
    pub recovered: Option<(RecoveryLevel, RecoveryCause)>,
    /// Box of the cloth in the world at the last look `[m]`.
    pub bounds: Option<(DVec3, DVec3)>,
    /// The island of cloths it can meet, and its number there.
    pub island: Option<(u32, u32)>,
}

impl Default for ClothScratch {
    fn default() -> Self {
        Self { solver: Scratch::default(), fresh: true, done: None, recovered: None, bounds: None, island: None }
    }
}

/// Shown: what the mesh gets.
#[derive(Component, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ClothShown {
    /// How vertices hang on particles.
    pub surface: Surface,
    /// Shown positions of the particles `[m]`, in the frame of simulation.
    pub particles: Vec<Vec3>,
    /// Normals of the particles.
    pub normals: Vec<Vec3>,
    /// Their sums before they are normalized.
    pub sums: Vec<Vec3>,
    /// Buffers that change places with the attributes of the mesh.
    pub vertices: VertexBuffers,
    /// Bounds of the vertices, in the space of the mesh.
    pub bounds: (Vec3, Vec3),
    /// Where the entity was when the vertices were written.
    pub affine: Affine3A,
    /// Origin when the vertices were written `[m]`.
    pub origin: DVec3,
    /// Whether the vertices are newer than those of the mesh.
    pub fresh: bool,
    /// Whether to write even if nothing moved.
    pub forced: bool,
    /// Whether nothing moved since it fell asleep.
    pub still: bool,
}

impl ClothShown {
    /// Sizes the buffers for the surface.
    pub fn fit(&mut self, vertices: usize) {
        let buffers = &mut self.vertices;
        buffers.positions.resize(vertices, [0.0; 3]);
        buffers.normals.resize(if self.surface.normals { vertices } else { 0 }, [0.0; 3]);
        let handedness = &self.surface.handedness;
        buffers.tangents.clear();
        buffers.tangents.extend(handedness.iter().map(|&w| Vec4::new(1.0, 0.0, 0.0, w)));
    }
}

/// Attributes of the mesh, in its own space.
#[derive(Default)]
pub(crate) struct VertexBuffers {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub tangents: Vec<Vec4>,
}
