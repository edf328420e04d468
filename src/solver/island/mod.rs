//! Cloths that can meet, stepped and untangled together as one surface.
//!
//! ```text
//! integrate ─► detect ─► resolve ─► evaluate ─► respond
//! ```
//!
//! [`Stage::FRAME`] is the whole frame: [`Island::run`] runs each stage once, in this order, for systems, scenes and recordings
//! alike, on a slice of [`Member`]s. Integrate takes their particles in once, each cloth in its own frame of simulation, and
//! publishes them once. Detect copies them into the frame of the island. While nothing crosses, Resolve writes nothing back: a
//! clean cloth has the same bits with and without an island.

mod detect;
mod follow;
mod gather;
pub mod load;
mod look;
mod member;
mod particles;
mod deferred;
mod rescale;
mod resolve;
mod skins;
mod stage;
mod substep;
mod undo;

use core::ops::Range;
use std::sync::Arc;

use glam::{Vec3, Vec4};

pub use deferred::Deferred;
pub use load::LoadReport;
pub use member::{Animation, Member};
pub use stage::Stage;

use super::body::Touch;
use super::buffer::Buffer;
use super::detect::tree::{Tree, TreeTopology};
use super::detect::{Crossing, Detector, PartRef, PartSettings, Surface, SurfaceError};
use super::effort::Effort;
use super::jobs::JobSystem;
use super::resolve::{Contour, ResolveSettings, Resolver, Untangler};
#[cfg(feature = "debug")]
use super::respond::Touching;
use super::respond::{Contacts, NeighborList};
use super::rigid::Rigid;
use super::rollback::Rollback;
use super::verdict::Verdict;
use particles::StepParticles;
use skins::Skins;
use undo::Undo;

/// Rings of neighbours around a tangle over which a held shape passes into the live one.
const RINGS: usize = 3;

/// Rounds of each way to roll back what came up within a frame: after them the rest is untangled.
const MOST_ROUNDS: usize = 8;

/// How far ahead pairs are looked for at most `[s]`: in a longer frame all are looked for again. Boxes swept farther meet half
/// of the cloth.
const LONGEST_LOOK: f32 = 1.0 / 30.0;

/// Time between looks for stray cloth within a frame, to the nearest substep `[s]`. It holds where a pair that slips by in
/// between can be rolled back at the end of the frame. It does not where a fast body is by then. Looking in every substep costs
/// twice as much for a flag in the wind or a sheet that falls on a ball.
const LOOK_AGAIN: f32 = 1.0 / 120.0;
/// From this number of pairs on each particle on, cloth is crowded, and looked at in every substep. Ten sheets that fall on a
/// ball, looked at less often, cross.
const CROWDED: usize = 2;

/// How an island is untangled in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct UntangleSettings {
    /// Method and steps.
    pub resolve: ResolveSettings,
    /// Most iterations per frame. Default 4; 0 only detects. Cost is proportional, while tangled only.
    pub iterations: u32,
    /// Sweeps of the springs after each iteration. Default 2. 0 tears the edges around a tangle; many slow it down.
    pub relaxations: u32,
    /// Most work of a frame beyond the work in proportion to its size, in visits for each face. A visit is to one particle,
    /// edge, crossing or pair. The bound holds for each look, for untangling, and for the looks within a frame of up to 1/30 s.
    /// It is higher in proportion for a longer frame. Cloth that is rolled back as a whole is looked at beyond it. Default 512,
    /// range 16 to 1,000,000. Work beyond it goes on in the next frame. A garment of many layers that starts tangled takes 170.
    /// Less keeps the layers tangled for longer, and lets piles that land hard cross. More holds up the frame where a heap
    /// crosses all over.
    pub effort: u32,
}

impl Default for UntangleSettings {
    fn default() -> Self {
        Self { resolve: ResolveSettings::default(), iterations: 4, relaxations: 2, effort: 512 }
    }
}

/// The cloths of an island as one surface, with reused buffers; nothing is allocated once warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Island {
    surface: Surface,
    untangler: Untangler,
    /// All particles while they are stepped, and while untangling keeps others apart.
    particles: Buffer<StepParticles>,
    /// The same between the stages, in the frame of the island `[m]`.
    positions: Vec<Vec4>,
    previous: Vec<Vec4>,
    before: Buffer<Vec<Vec4>>,
    weights: Vec<f32>,
    /// Whether the weights are those of the last frame.
    weighed: bool,
    verdicts: Vec<Verdict>,
    /// Crossings of each cloth that are held as they are.
    authored: Vec<u32>,
    total: Verdict,
    iterations: u32,
    /// Whether something moved since it was gathered, and since the last look.
    moved: bool,
    stale: bool,
    neighbors: NeighborList,
    contacts: Contacts,
    substep: Vec<f32>,
    /// Cloths that are not to be moved.
    fixed: Vec<bool>,
    /// Particles that pins hold, whether or not their cloth is to be moved, and those that their skin holds as tightly.
    pinned: Vec<bool>,
    held: Vec<bool>,
    rollback: Rollback,
    /// Whether what comes to cross within a frame can be rolled back at its end.
    can_roll_back: bool,
    /// Thickness and friction of each cloth, and whether it rests on others; of this frame and of the last.
    touch: Vec<Touch>,
    takes_part: Vec<bool>,
    touch_before: Buffer<Vec<Touch>>,
    took_part: Buffer<Vec<bool>>,
    /// A pose to blend to.
    pose: Buffer<Vec<Vec3>>,
    /// Substeps that the last frame took.
    count: u32,
    /// For how long frames are still to take twice as many, since one was rolled back `[s]`.
    refined_for: f32,
    /// Time for which pairs were looked for `[s]`, and the share of it that has passed.
    horizon: f32,
    share: f32,
    looks: u32,
    undo: Undo,
    /// Where everything was before an iteration; particles of what crosses.
    start: Buffer<Vec<Vec4>>,
    caught: Buffer<Vec<bool>>,
    /// Whether what was found at the last look is still known, as long as nothing moves far.
    known: bool,
    skins: Skins,
    /// What untangling at load did so far, while it goes on.
    loading: Option<LoadReport>,
    /// Work that a look, the CCD and the untangling of a frame may be, and that of the looks within this frame.
    most: Effort,
    within: Effort,
    /// Work that the pairs were that the CCD of this frame asked again.
    asked: Effort,
    /// What untangling was in the last frame `[visits]`.
    worked: u64,
    /// Threads that share its work.
    jobs: Buffer<Option<Arc<dyn JobSystem>>>,
}

impl Island {
    /// Concatenates the cloths, each with the topology of the search tree of its rest shape.
    ///
    /// # Errors
    /// [`SurfaceError`] when rest positions do not match a topology, or when there are too many cloths or particles.
    pub fn new(cloths: &[(PartRef<'_>, &Arc<TreeTopology>)]) -> Result<Self, SurfaceError> {
        let parts: Vec<PartRef<'_>> = cloths.iter().map(|(part, _)| *part).collect();
        let trees: Vec<_> = cloths.iter().map(|&(part, tree)| (tree, part.topology.particles)).collect();
        let surface = Surface::new(&parts)?;
        let detector = Detector::with_tree(&surface, Tree::new(TreeTopology::join(&trees)));
        let untangler = Untangler { detector, resolver: Resolver::default() };
        let n = surface.len();
        let mut island = Self {
            neighbors: NeighborList::new(&surface, untangler.detector.tree_ref()),
            untangler,
            substep: vec![0.0; surface.parts.len()],
            fixed: vec![false; surface.parts.len()],
            pinned: vec![false; n],
            held: vec![false; n],
            authored: vec![0; surface.parts.len()],
            positions: vec![Vec4::ZERO; n],
            previous: vec![Vec4::ZERO; n],
            verdicts: vec![Verdict::default(); surface.parts.len()],
            surface,
            ..Self::default()
        };
        island.bound(UntangleSettings::default().effort);
        Ok(island)
    }

    /// Lends it threads, which a clone does not have: where they are worth it, they share its looks for pairs. They change no
    /// bit of the result. None by default.
    pub fn share(&mut self, jobs: Option<Arc<dyn JobSystem>>) {
        *self.jobs = jobs;
    }

    /// Whether threads are worth waking for its looks for pairs, if they cost as much as the last ones.
    #[must_use]
    pub fn is_worth_sharing(&self) -> bool {
        self.neighbors.is_worth_sharing()
    }

    /// Changes the settings of cloth `part`: its layer, whether it meets itself, its thickness `[m]`. What is known of it stays
    /// known, except where it may cross itself.
    pub fn tune(&mut self, part: usize, settings: PartSettings) {
        let Some(part) = self.surface.parts.get_mut(part) else { return };
        let PartSettings { garment_layer, self_collision, thickness } = settings;
        if part.self_collision != self_collision {
            self.known = false;
            self.untangler.detector.forget();
        }
        (part.garment_layer, part.self_collision, part.thickness) = (garment_layer, self_collision, thickness);
    }

    /// How often pairs were looked for since [`Stage::Respond`], that look included.
    #[must_use]
    pub fn looks(&self) -> u32 {
        self.looks
    }

    /// How far ahead pairs are looked for `[s]`: a frame, or less.
    #[must_use]
    pub fn horizon(&self) -> f32 {
        self.horizon
    }

    /// Pairs of cloth that may touch, and those that touched in the last substep.
    #[must_use]
    pub fn pairs(&self) -> (usize, u32) {
        (self.contacts.len(), self.contacts.touching())
    }

    /// The pairs that may touch.
    #[must_use]
    pub(crate) fn contacts(&self) -> &Contacts {
        &self.contacts
    }

    /// The pairs that touched in the last substep.
    #[cfg(feature = "debug")]
    pub(crate) fn touching_pairs(&self) -> impl Iterator<Item = Touching> + '_ {
        self.contacts.touching_pairs(&self.surface, &self.particles.positions)
    }

    /// Calls `found` for every pair of different cloths that touched in the last substep. Its arguments are both cloths, a
    /// point between them `[m]` in the frame of the island, and the unit normal towards the first. The last is the mean push
    /// per substep times the mass it moves `[kg·m]`.
    pub fn touches(&self, mut found: impl FnMut([usize; 2], Vec3, Vec3, f32)) {
        for (ids, weights, normal, drive) in self.contacts.pushes() {
            let parts = [ids[0], ids[3]].map(|v| usize::from(self.surface.part(v)));
            if parts[0] == parts[1] {
                continue;
            }
            let at = |(&v, weight): (&u32, f32)| self.positions[v as usize].truncate() * (0.5 * weight.abs());
            // Weights of either side add up to one.
            let point = ids.iter().zip(weights).map(at).sum();
            found(parts, point, normal, drive);
        }
    }

    /// Moves the frame of the island: everything that is known lies `by` `[m]` elsewhere in it from now on.
    pub fn carry(&mut self, by: Vec3) {
        self.take_along(&Rigid::shift(by));
        self.known = false;
    }

    fn range(&self, part: usize) -> Range<usize> {
        self.surface.parts[part].range()
    }

    /// The verdict on all cloths together.
    #[must_use]
    pub fn total(&self) -> Verdict {
        self.total
    }

    /// The verdict on cloth `part`: every contour it takes part in.
    #[must_use]
    pub fn verdict(&self, part: usize) -> Verdict {
        self.verdicts.get(part).copied().unwrap_or_default()
    }

    /// Crossings of cloth `part` that pins or the skin hold as they are, which [`Self::verdict`] does not count: nothing can be
    /// done about them.
    #[must_use]
    pub fn authored(&self, part: usize) -> u32 {
        self.authored.get(part).copied().unwrap_or_default()
    }

    /// How much each particle of cloth `part` belongs to a tangle, 0 to 1, as of the last [`Stage::Evaluate`]; empty before the
    /// first tangle.
    #[must_use]
    pub fn weights(&self, part: usize) -> &[f32] {
        if part < self.surface.parts.len() { self.weights.get(self.range(part)).unwrap_or(&[]) } else { &[] }
    }

    /// Whether [`Stage::Resolve`] moved anything in this frame.
    #[must_use]
    pub(crate) fn has_moved(&self) -> bool {
        self.moved
    }

    /// Iterations taken in this frame.
    #[must_use]
    pub fn iterations(&self) -> u32 {
        self.iterations
    }

    /// The cloths as one surface.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The crossings found last.
    #[must_use]
    pub fn crossings(&self) -> &[Crossing] {
        self.untangler.detector.crossings()
    }

    /// The contours found last.
    #[must_use]
    pub fn contours(&self) -> &[Contour] {
        &self.untangler.resolver.graph().contours
    }

    /// Cloths whose layers are in another order than pins hold them, the one with the higher layer first: nothing is done about
    /// their order.
    pub fn overruled_layers(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.untangler.resolver.overruled_layers().map(|pair| pair.map(usize::from))
    }

    /// Segments `[m]` of all contours found last, in the frame of the island, each with the number of its contour.
    pub(crate) fn segments(&self) -> impl Iterator<Item = (usize, [Vec3; 2])> + '_ {
        let resolver = &self.untangler.resolver;
        let (graph, points) = (resolver.graph(), resolver.points());
        points.iter().enumerate().flat_map(move |(i, &from)| {
            let onward = graph.linked(i).filter(move |&j| j as usize > i);
            onward.map(move |j| (graph.contour_of[i] as usize, [from, points[j as usize]]))
        })
    }
}

/// Every contour found last, with the two cloths that it is between, or twice the one.
fn parts_of_contours<'a>(surface: &'a Surface, untangler: &'a Untangler) -> impl Iterator<Item = (&'a Contour, [u16; 2])> {
    let Untangler { detector, resolver } = untangler;
    let graph = resolver.graph();
    graph.contours.iter().enumerate().filter_map(move |(k, contour)| {
        // A contour stays between the two cloths that its first crossing is between.
        let first = &detector.crossings()[*graph.nodes_of(k).first()? as usize];
        Some((contour, [surface.part_of_edge(first.edge), surface.part_of_face(first.face)]))
    })
}
