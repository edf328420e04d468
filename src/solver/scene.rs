//! Cloth without an engine: cloths, bodies and weather that are stepped together. The laboratory and the preview of the panel
//! stand on it, and tests, benchmarks and programs measure on it.

use std::sync::Arc;

use glam::{Vec3, vec3};

use super::anchors::Anchors;
use super::body::Body;
use super::detect::tree::TreeTopology;
use super::detect::{PartRef, SurfaceError};
use super::evaluate::{EvaluateSettings, Outcome, Pose, Shown};
use super::island::{Island, LoadReport, Member, Stage, UntangleSettings};
use super::resolve::Contour;
use super::rest::{RestShape, SourceMesh};
use super::settings::{Fabric, Stepping};
use super::sim::ClothSim;
use super::step::{self, FrameInput, StepReport, Stepped};
use super::verdict::Verdict;
use super::wind::Wind;

/// Standard gravity `[m/s²]`.
pub const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// A rectangle of `columns` x `rows` vertices at `point(u, v)`, `u` and `v` from 0 to 1; vertex `(i, j)` has index
/// `i * rows + j`.
///
/// The diagonals alternate, so that the mesh prefers no direction.
#[must_use]
pub fn grid(columns: u32, rows: u32, point: impl Fn(f32, f32) -> Vec3) -> SourceMesh {
    let (columns, rows) = (columns.max(2), rows.max(2));
    let mut mesh = SourceMesh::default();
    for i in 0..columns {
        for j in 0..rows {
            mesh.positions.push(point(i as f32 / (columns - 1) as f32, j as f32 / (rows - 1) as f32));
        }
    }
    for i in 0..columns - 1 {
        for j in 0..rows - 1 {
            let (a, b) = (i * rows + j, i * rows + j + 1);
            let (c, d) = (a + rows, b + rows);
            mesh.triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] });
        }
    }
    mesh
}

/// One cloth of a scene.
#[derive(Clone, Debug)]
pub struct SceneCloth {
    /// Rest shape, shared by equal cloths.
    pub rest: Arc<RestShape>,
    /// Material.
    pub fabric: Fabric,
    /// Substeps.
    pub stepping: Stepping,
    /// Pins.
    pub anchors: Anchors,
    /// See [`ClothSim`].
    pub sim: ClothSim,
    /// The last frame.
    pub report: StepReport,
    /// Order of layers: larger numbers are worn outside; set it before [`Scene::untangled`].
    pub garment_layer: i32,
}

impl SceneCloth {
    /// A cloth with the shape of `rest` moved by `at` `[m]`, held rigidly at the render vertices `pins`.
    #[must_use]
    pub fn new(rest: Arc<RestShape>, fabric: Fabric, at: Vec3, pins: &[u32]) -> Self {
        let mut particles: Vec<u32> = pins.iter().filter_map(|&v| rest.particle_of_vertex.get(v as usize).copied()).collect();
        particles.sort_unstable();
        particles.dedup();
        let targets: Vec<Vec3> = particles.iter().map(|&p| rest.positions[p as usize] + at).collect();
        let weights = vec![1.0; particles.len()];
        let anchors = Anchors { particles, weights, from: targets.clone(), to: targets };
        let mut sim = ClothSim::default();
        sim.state.positions.extend(rest.positions.iter().map(|p| (*p + at).extend(0.0)));
        sim.state.previous.clone_from(&sim.state.positions);
        let mut cloth =
            Self { rest, fabric, stepping: Stepping::default(), anchors, sim, report: StepReport::default(), garment_layer: 0 };
        cloth.prepare();
        cloth
    }

    /// Must follow a change of `fabric` or of the set of pins.
    pub fn prepare(&mut self) {
        let ClothSim { state, memory, .. } = &mut self.sim;
        step::prepare(&self.rest, &self.fabric, &self.anchors, state, memory);
    }

    /// Advances by one frame.
    pub fn step(&mut self, input: &FrameInput<'_>) {
        let ClothSim { state, memory, .. } = &mut self.sim;
        self.report = step::step(&self.rest, &self.fabric, &self.stepping, &self.anchors, input, state, memory);
        self.anchors.from.clone_from(&self.anchors.to);
    }

    fn member<'a>(&'a mut self, input: FrameInput<'a>, contact: bool, last_resort: f32) -> Member<'a> {
        let Self { rest, fabric, stepping, anchors, sim, .. } = self;
        Member {
            cloth: Stepped { rest, fabric, anchors, input },
            stepping,
            sim,
            animation: None,
            offset: Vec3::ZERO,
            moves: true,
            clock: input.dt,
            fixed: false,
            still: false,
            contact,
            at_load: false,
            last_resort,
        }
    }

    /// Kinetic energy plus potential energy against the origin `[J]`; what the springs store is not counted.
    #[must_use]
    pub fn energy(&self, gravity: Vec3) -> f64 {
        let mut energy = 0.0;
        for (i, area) in self.rest.areas.iter().enumerate() {
            let mass = f64::from(self.fabric.density * area);
            let x = self.sim.state.positions[i].truncate();
            energy += mass * (0.5 * f64::from(self.sim.state.velocity(i).length_squared()) - f64::from(gravity.dot(x)));
        }
        energy
    }

    /// Lowest particle `[m]`.
    #[must_use]
    pub fn lowest(&self) -> f32 {
        self.sim.state.positions.iter().map(|x| x.y).fold(f32::INFINITY, f32::min)
    }
}

/// Cloths, bodies and weather.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Independent cloths.
    pub cloths: Vec<SceneCloth>,
    /// Bodies; `from` is where they were, `to` where they are.
    pub bodies: Vec<Body>,
    /// Wind.
    pub wind: Wind,
    /// Gravity `[m/s²]`.
    pub gravity: Vec3,
    /// Time simulated so far `[s]`.
    pub time: f32,
    /// Moves bodies and pins: given the time at the end of a frame `[s]`, sets where they go.
    pub drive: Option<fn(&mut Self, f32)>,
    /// Untangling; none: cloths pass through each other.
    pub untangle: Option<Untangling>,
    /// What the time is `[s]`, to measure [`Self::times`] by; a clock that stands still by default.
    pub clock: fn() -> f64,
    /// What the last frame cost by [`Self::clock`].
    pub times: StageTimes,
}

/// How the cloths of a scene are untangled.
#[derive(Clone, Debug, Default)]
pub struct Untangling {
    /// All cloths.
    pub island: Island,
    /// How they are taken apart.
    pub settings: UntangleSettings,
    /// What is shown meanwhile.
    pub skip: EvaluateSettings,
    /// Whether cloths rest on each other, and on themselves.
    pub contact: bool,
    roster: Roster,
}

/// Room for a list of members, kept from frame to frame.
#[derive(Debug, Default)]
struct Roster(Vec<Member<'static>>);

impl Roster {
    fn take<'a>(&mut self) -> Vec<Member<'a>> {
        core::mem::take(&mut self.0)
    }

    /// Empties a list, and keeps its allocation: collecting a vector from one of the same layout reuses that.
    fn keep(&mut self, mut members: Vec<Member<'_>>) {
        members.clear();
        self.0 = members.into_iter().map_while(|_| None).collect();
    }
}

impl Clone for Roster {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Time that each [`Stage`] took in a frame `[ms]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTimes {
    /// Stepping all cloths `[ms]`.
    pub integrate: f64,
    /// Looking for crossings, and for what may touch in the next frame `[ms]`.
    pub detect: f64,
    /// Taking them apart `[ms]`.
    pub resolve: f64,
    /// Looking again, and deciding what to show `[ms]`.
    pub evaluate: f64,
    /// Looking for what may touch again, where something moved since `[ms]`.
    pub respond: f64,
}

impl StageTimes {
    fn of(&mut self, stage: Stage) -> &mut f64 {
        match stage {
            Stage::Integrate => &mut self.integrate,
            Stage::Detect => &mut self.detect,
            Stage::Resolve => &mut self.resolve,
            Stage::Evaluate => &mut self.evaluate,
            Stage::Respond => &mut self.respond,
        }
    }
}

impl Scene {
    /// Cloths that pass through each other, in still air under standard gravity.
    #[must_use]
    pub fn new(cloths: Vec<SceneCloth>) -> Self {
        Self {
            cloths,
            bodies: Vec::new(),
            wind: Wind::STILL,
            gravity: GRAVITY,
            time: 0.0,
            drive: None,
            untangle: None,
            clock: || 0.0,
            times: StageTimes::default(),
        }
    }

    /// Untangles from now on: each cloth with the others, and with itself if `self_collision`.
    ///
    /// # Errors
    /// [`SurfaceError`] when there are too many cloths or particles.
    pub fn untangled(
        mut self,
        settings: UntangleSettings,
        skip: EvaluateSettings,
        self_collision: bool,
    ) -> Result<Self, SurfaceError> {
        let part = |cloth: &'_ SceneCloth| (cloth.rest.clone(), cloth.fabric.thickness, cloth.garment_layer);
        let cloths: Vec<_> = self.cloths.iter().map(part).collect();
        let parts: Vec<(PartRef<'_>, &Arc<TreeTopology>)> = cloths
            .iter()
            .map(|(rest, thickness, layer)| {
                let (topology, positions) = (&rest.topology, &rest.positions);
                let part = PartRef { topology, rest: positions, garment_layer: *layer, self_collision, thickness: *thickness };
                (part, rest.tree_topology())
            })
            .collect();
        self.untangle =
            Some(Untangling { island: Island::new(&parts)?, settings, skip, contact: true, roster: Roster::default() });
        Ok(self)
    }

    /// Takes the cloths apart before the first frame, in at most `most` iterations; nothing without untangling.
    pub fn untangle_at_load(&mut self, most: u32) -> LoadReport {
        let Some((Untangling { island, settings, roster, .. }, mut members)) = self.together(0.0) else {
            return LoadReport::default();
        };
        let report = island.untangle_at_load(settings, most, &mut members);
        roster.keep(members);
        report
    }

    /// The island and the cloths in it, for a frame of `dt` `[s]`; none without untangling.
    pub(super) fn together(&mut self, dt: f32) -> Option<(&mut Untangling, Vec<Member<'_>>)> {
        let Self { cloths, bodies, wind, gravity, untangle, .. } = self;
        let untangling = untangle.as_mut()?;
        let input = FrameInput { dt, gravity: *gravity, bodies, wind, skinned: None };
        let (contact, last_resort) = (untangling.contact, untangling.skip.last_resort);
        let mut members = untangling.roster.take();
        members.extend(cloths.iter_mut().map(|cloth| cloth.member(input, contact, last_resort)));
        Some((untangling, members))
    }

    /// Runs `stages` of a frame of `dt` `[s]` of the island; nothing without untangling.
    fn run(&mut self, stages: &[Stage], dt: f32) {
        let (mut times, clock) = (self.times, self.clock);
        let Some((Untangling { island, settings, roster, .. }, mut members)) = self.together(dt) else { return };
        for &stage in stages {
            let start = clock();
            island.run(stage, dt, settings, &mut members);
            *times.of(stage) = 1.0e3 * (clock() - start);
        }
        roster.keep(members);
        self.times = times;
    }

    /// Lets cloths that are untangled pass through each other until they are, instead of resting on each other.
    #[must_use]
    pub fn without_contact(mut self) -> Self {
        if let Some(untangling) = &mut self.untangle {
            untangling.contact = false;
        }
        self
    }

    /// Moves every free particle by up to a thousandth of an edge, another way for every seed: what holds from one start only
    /// is luck.
    #[must_use]
    pub fn jittered(mut self, seed: u64) -> Self {
        let mut rng = fastrand::Rng::with_seed(seed);
        for SceneCloth { rest, sim: ClothSim { state, .. }, .. } in &mut self.cloths {
            let size = 1.0e-3 * rest.mean_edge;
            let mut one = || size * (2.0 * rng.f32() - 1.0);
            for (x, old) in state.positions.iter_mut().zip(&mut state.previous) {
                let by = vec3(one(), one(), one()).extend(0.0);
                if x.w > 0.0 {
                    *x += by;
                    *old += by;
                }
            }
        }
        self
    }

    /// Sets where bodies and pins go in a frame of `dt` `[s]`; [`Self::step`] does.
    pub fn steer(&mut self, dt: f32) {
        self.time += dt;
        if let Some(drive) = self.drive {
            self.bodies.iter_mut().for_each(|body| body.from = body.to);
            drive(self, self.time);
        }
    }

    /// Advances every cloth by `dt` `[s]`, one after the other or, where they touch, side by side, and untangles.
    pub fn step(&mut self, dt: f32) {
        self.steer(dt);
        self.times = StageTimes::default();
        if self.untangle.as_ref().is_some_and(|untangling| untangling.contact) {
            self.run(&Stage::FRAME, dt);
            for SceneCloth { anchors, report, sim, .. } in &mut self.cloths {
                if let Some(done) = sim.report.take() {
                    *report = done;
                    anchors.from.clone_from(&anchors.to);
                }
            }
            self.decide(dt);
        } else {
            let start = (self.clock)();
            let input = FrameInput { dt, gravity: self.gravity, bodies: &self.bodies, wind: &self.wind, skinned: None };
            self.cloths.iter_mut().for_each(|cloth| cloth.step(&input));
            self.times.integrate = 1.0e3 * ((self.clock)() - start);
            self.finish_frame(dt);
        }
        self.wind.advance(dt);
    }

    /// Runs what follows after the cloths were stepped by `dt` `[s]`, and decides what is shown.
    pub fn finish_frame(&mut self, dt: f32) {
        self.run(&Stage::AFTER_INTEGRATE, dt);
        self.decide(dt);
    }

    /// Decides what is shown.
    fn decide(&mut self, dt: f32) {
        let Self { cloths, untangle: Some(Untangling { island, skip, .. }), clock, times, .. } = self else { return };
        let start = clock();
        for (part, SceneCloth { sim: ClothSim { display, state, .. }, .. }) in cloths.iter_mut().enumerate() {
            display.decide(&island.verdict(part), state, island.weights(part), Pose::default(), dt, skip);
        }
        times.evaluate += 1.0e3 * (clock() - start);
    }

    /// Looks for crossings as the cloths lie, and moves nothing.
    pub fn look(&mut self) -> Verdict {
        let Some((Untangling { island, roster, .. }, members)) = self.together(0.0) else { return Verdict::default() };
        let verdict = island.inspect(&members);
        roster.keep(members);
        verdict
    }

    /// The contours found last; none without untangling.
    #[must_use]
    pub fn contours(&self) -> &[Contour] {
        self.untangle.as_ref().map_or(&[], |u| u.island.contours())
    }

    /// Edges that cross faces; 0 without untangling.
    #[must_use]
    pub fn crossings(&self) -> u32 {
        self.untangle.as_ref().map_or(0, |u| u.island.total().all_crossings())
    }

    /// Whether a cloth is shown in its last clean shape.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.cloths.iter().map(|c| c.sim.display.outcome()).any(|Outcome { shown, .. }| shown == Shown::Held)
    }
}
