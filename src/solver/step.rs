//! The whole frame of one cloth as one function: what systems, tests, benches and docs call.

use glam::{Vec3, Vec4};

use super::anchors::{Anchors, RIGID};
use super::body::{Approach, Body, BodyContacts, FaceContacts, Grounds, Laid, Sheet, Touch};
use super::couple::{Coupling, Pull};
use super::integrate::{air, anchor, bend, damp, leash, membrane, net, predict, pull, spring, tether};
use super::respond::CALM_PASSES;
use super::rest::RestShape;
use super::settings::{Fabric, MembraneModel, Stepping, drape_rate};
use super::state::ClothState;
use super::wind::{Aerodynamics, Wind, WindForces};

/// Inputs of one frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameInput<'a> {
    /// Length of the frame `[s]`; 0, less or not finite: nothing moves.
    pub dt: f32,
    /// Gravity `[m/s²]`.
    pub gravity: Vec3,
    /// Bodies, in the frame of simulation.
    pub bodies: &'a [Body],
    /// Wind at the cloth, in the frame of simulation.
    pub wind: &'a Wind,
}

/// What one frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct StepReport {
    /// Substeps taken.
    pub substeps: u32,
    /// Time beyond [`Stepping::max_frame`] that was not simulated `[s]`.
    pub lost_time: f32,
    /// Largest edge length over rest length after the frame (dimensionless); infinite when a position is not finite.
    pub worst_edge: f32,
    /// Mean edge length over rest length after the frame (dimensionless).
    pub mean_edge: f32,
    /// Particles and faces that touched a body in the last substep.
    pub body_contacts: u32,
    /// Inner steps in each substep.
    pub inner_steps: u32,
    /// Share of the bending stiffness that the substeps held (dimensionless): 1, unless the mesh is very fine for them.
    pub bend_held: f32,
}

/// Reused buffers and what [`prepare`] derives for one cloth; no allocation once warm.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Scratch {
    springs: spring::SpringFactors,
    /// Whether triangles hold it together in its plane, in place of springs.
    triangles: bool,
    bends: bend::BendFactors,
    tethers: tether::Tethers,
    hubs: net::Hubs,
    leash: leash::Leash,
    overlong: spring::Overlong,
    tight: spring::Tight,
    contacts: BodyContacts,
    faces: FaceContacts,
    laid: Laid,
    carried: air::Carried,
    /// Area at rest `[m²]`.
    area: f32,
    /// Longest edge at rest `[m]`.
    longest_edge: f32,
    coupling: Coupling,
    /// Particles that are pinned to bodies that cloth can move.
    welded: Vec<u32>,
    wind: WindForces,
    pulls: pull::Pulls,
    rigid: Vec<u32>,
    acceleration: Vec<Vec4>,
    /// What particles did in the last substep `[m]`, `w` their inverse mass `[1/kg]`, while it is damped.
    motion: Vec<Vec4>,
    before: Vec<Vec4>,
    /// Ways in the substep `[m]` before anything held the cloth together, if it bounces.
    inbound: Vec<Vec4>,
    displaced: Vec<Vec4>,
    /// How much farther the velocity of the last inner step would have got in the substep `[m]`.
    late: Vec<Vec4>,
    /// Inner steps of the last substep; 0 before the first.
    inner_steps: u32,
    /// Whether springs run along the threads of the fabric, as far as anything tells those.
    along_threads: bool,
    /// Worst edge of the last frame before it was finished (dimensionless).
    worst_edge: f32,
    /// Whether the last frame took it for strained, and for taut.
    strained: bool,
    taut: bool,
    /// By how much of their length at rest tethers give way to bodies (dimensionless).
    give: f32,
    /// Whether a body that cloth cannot stop moves much faster than the pins and may meet the cloth in the frame to come.
    driven: bool,
    /// How many times as many substeps it takes for the bodies that it bears; 0 before the first frame.
    borne: u32,
    /// For how long it was slow `[s]`.
    slow_for: f32,
    frame: Option<Frame>,
    /// Substep the factors were computed for `[s]`; 0: none yet.
    factors_for: f32,
}

impl Scratch {
    /// What pulls at the cloth in the frames to come; it stays until it is changed.
    pub fn pulls_mut(&mut self) -> &mut pull::Pulls {
        &mut self.pulls
    }

    /// Number of the body, particle and mean push per substep `[m]` of every contact in the last substep: of particles, by body, then of
    /// faces, by body, each as if its nearest corner bore it alone.
    pub fn touches(&self) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        self.contacts.loads().chain(self.faces.loads())
    }

    /// Particles that touched a body in the last substep.
    pub fn grounded(&self) -> impl Iterator<Item = u32> + '_ {
        self.contacts.touching().chain(self.faces.touching())
    }

    /// The time over which velocities were the last substep's `[s]`: that of its last inner step.
    fn last_step(&self, state: &ClothState) -> f32 {
        state.substep / self.inner_steps.max(1) as f32
    }

    /// Takes no air along for the rest of the frame: what is tangled has none between its layers.
    pub fn leave_air(&mut self) {
        self.carried.end();
    }

    /// Notes which particles lie on cloth, once the frame has begun: no air is between.
    pub fn lies_on_cloth(&mut self, particles: impl Iterator<Item = u32>) {
        self.carried.leave_out(particles);
    }

    /// Ends a substep for the air: what it carries keeps of the change of velocity its share.
    fn keep_air(&mut self, state: &mut ClothState) {
        self.carried.leave_out(self.contacts.touching().chain(self.faces.touching()));
        self.carried.keep(state.substep, &state.positions, &mut state.previous);
    }

    /// Whether the cloth has been slow for a while.
    #[must_use]
    pub fn is_calm(&self) -> bool {
        self.slow_for >= CALM_AFTER
    }

    /// Whether an edge was so far beyond the strain limit that the last frame solved the coarse net, too.
    #[must_use]
    pub fn is_strained(&self) -> bool {
        self.strained
    }

    /// Particles that touched a body in the last substep, one once for each of its faces that did, each with the force of the body on it
    /// `[N]`, on average over the last substeps: `F = m C / h²`, `C` the mean push of a substep `h`. What other cloth lies on them is not in
    /// it.
    pub fn body_forces<'a>(&'a self, state: &'a ClothState) -> impl Iterator<Item = (u32, f32)> + 'a {
        self.touches().filter_map(|(_, p, load)| {
            let force = load / (state.positions.get(p as usize)?.w * state.substep * state.substep);
            force.is_finite().then_some((p, force))
        })
    }

    /// The bodies that take what the cloth gives them.
    #[must_use]
    pub fn coupling(&self) -> &Coupling {
        &self.coupling
    }

    /// The bodies that take what the cloth gives them; filled before each frame. When the pins on movable bodies or those bodies' masses change,
    /// [`prepare`] must follow.
    pub fn coupling_mut(&mut self) -> &mut Coupling {
        &mut self.coupling
    }

    /// Elongation of the worst edge after the substeps of the last frame (dimensionless).
    fn strain(&self) -> f32 {
        self.worst_edge - 1.0
    }

    /// Memory held by factors, tethers and forces `[B]`; contacts and gusts come on top where there are any.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.springs.bytes()
            + self.bends.bytes()
            + self.tethers.bytes()
            + self.hubs.bytes()
            + self.leash.bytes()
            + self.carried.bytes()
            + size_of_val(&self.acceleration[..])
            + size_of_val(&self.motion[..])
            + size_of_val(&self.before[..])
            + size_of_val(&self.late[..])
    }
}

/// Wind forces are evaluated at least this often `[Hz]`.
const WIND_RATE: f32 = 60.0;

/// Tethers are solved once in this many substeps; in every substep of a calm cloth, which the alternation would keep from rest.
const TETHER_EVERY: u64 = 2;

/// Root mean square of the speeds over a frame below which a cloth becomes calm `[m/s]`; at twice that it no longer is.
const CALM_SPEED: f32 = 0.03;

/// Time for which it has to be that slow `[s]`.
const CALM_AFTER: f32 = 0.25;

/// What a calm cloth loses of its velocities on top of drag `[1/s]`: what one sweep over constraints in a row leaves over keeps going around
/// for ever otherwise.
const CALM_DRAG: f32 = 6.0;

/// What got less far within a frame than this share of the way its speed would take it (dimensionless) is stuck: constraints pull it to and
/// fro between them. In a calm cloth it has the speed of its mean motion.
pub(super) const STUCK: f32 = 0.25;

/// Beyond this many strain limits a cloth is strained, until it is within [`EASED`]: its coarse net is solved in the next frame, and the
/// frame ends with its overlong edges shortened.
const STRAINED: f32 = 1.5;

/// The same at the end of a frame of a calm cloth: what is shortened moves, and is shortened in the next frame again.
const CALM_STRAINED: f32 = 2.5;

/// Beyond this many strain limits a cloth is taut, until it is within [`EASED`]: in the substeps of the next frame those of its springs
/// that are close to the limit are also swept [`TAUT_SWEEPS`] times for it alone.
const TAUT: f32 = 2.0;

/// Beyond this many strain limits a cloth is in a storm: any of its springs may get to its limit within a frame.
const WILD: f32 = 8.0;

/// Within this many strain limits a cloth is neither. Less than the others: a cloth that is held at a bound by what is done beyond it would
/// do it every other frame.
const EASED: f32 = 0.5;

/// Most by which tethers give way, as a share of their length at rest (dimensionless), and how fast they do, and come back `[1/s]`: cloth that is let go
/// from a body would be thrown.
const MOST_GIVE: f32 = 0.05;
const GIVE_WAY: f32 = 10.0;
const GIVE_BACK: f32 = 0.5;

/// Sweeps for the strain limit in each substep of a taut cloth.
const TAUT_SWEEPS: u32 = 2;

/// The same near bodies that are finer than the mesh: cloth hangs on their corners.
const HUNG_SWEEPS: u32 = 4;

/// The same for a calm cloth, whose edges are shortened at the end of a frame only [far beyond](CALM_STRAINED) the limit.
const CALM_SWEEPS: u32 = 8;

/// Share of the thickness by which a particle that may touch cloth is moved at most, to shorten edges: two that are moved farther could
/// pass through each other unseen.
const CROWDED: f32 = 0.5;

/// Passes over edges that are beyond the strain limit at the end of a frame.
const FINISH_PASSES: u32 = 8;

/// Up to this share of the strain limit in its mean edge a cloth is strained in places, not as a whole (dimensionless).
const EVEN: f32 = 0.2;

/// Sets inverse masses from density and anchors, constraint factors and tethers.
///
/// Call after bind and whenever what [`Fabric::prepared`] tells of the fabric, the set of anchored particles or which of them are held
/// rigidly changed. Keeps positions and velocities.
pub fn prepare(rest: &RestShape, fabric: &Fabric, anchors: &Anchors, state: &mut ClothState, scratch: &mut Scratch) {
    for (x, &area) in state.positions.iter_mut().zip(&rest.areas) {
        x.w = 1.0 / (fabric.density * area).max(1.0e-9);
    }
    scratch.coupling.weigh(anchors);
    let mut rigid: Vec<u32> =
        anchors.particles.iter().zip(&anchors.weights).filter(|(_, w)| **w >= RIGID).map(|(p, _)| *p).collect();
    for &p in &rigid {
        state.positions[p as usize].w = 0.0;
    }
    for (anchor, w) in scratch.coupling.weights() {
        if let Some(&p) = anchors.particles.get(anchor) {
            state.positions[p as usize].w = w;
        }
    }
    rigid.retain(|&p| state.positions[p as usize].w == 0.0);
    for (x, old) in state.positions.iter().zip(&mut state.previous) {
        old.w = x.w;
    }
    if scratch.rigid != rigid || scratch.factors_for == 0.0 {
        scratch.tethers = tether::Tethers::new(rest, &rigid);
        scratch.hubs.hold(rest, &rigid);
        scratch.leash = leash::Leash::new(rest, &rigid);
        scratch.rigid = rigid;
    }
    let longest =
        |longest: f32, e: &[u32; 2]| rest.positions[e[0] as usize].distance_squared(rest.positions[e[1] as usize]).max(longest);
    scratch.longest_edge = rest.topology.edges.iter().fold(0.0, longest).sqrt();
    scratch.area = rest.areas.iter().sum();
    scratch.along_threads = rest.springs.run_along_threads(fabric.warp_angle);
    scratch.bends.update(&rest.bends, fabric, &rest.areas, &state.positions);
    scratch.factors_for = 0.0;
}

/// Advances one cloth by one frame. [`prepare`] must have been called.
pub fn step(
    rest: &RestShape,
    fabric: &Fabric,
    stepping: &Stepping,
    anchors: &Anchors,
    input: &FrameInput<'_>,
    state: &mut ClothState,
    scratch: &mut Scratch,
) -> StepReport {
    let cloth = Stepped { rest, fabric, anchors, input: *input };
    cloth.begin(stepping, None, state, scratch);
    while cloth.constrain(state, scratch) {
        cloth.project(state, scratch);
    }
    cloth.finish(false, state, scratch).unwrap_or_default()
}

/// What a cloth is stepped with. [`step`] does all of a frame; cloths that touch each other go through it side by side, and are kept apart
/// after [`project`](Self::project).
#[derive(Clone, Copy, Debug)]
pub struct Stepped<'a> {
    /// Rest shape.
    pub rest: &'a RestShape,
    /// Material.
    pub fabric: &'a Fabric,
    /// Pins.
    pub anchors: &'a Anchors,
    /// Inputs of the frame.
    pub input: FrameInput<'a>,
}

/// A frame under way.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Frame {
    dt: f32,
    /// Length of a substep `[s]`.
    h: f32,
    /// Substeps begun.
    begun: u32,
    gusts: u32,
    /// Inner steps in a substep.
    steps: u32,
    strained: bool,
    taut: bool,
    calm: bool,
    /// Drag `[1/s]`.
    drag: f32,
    report: StepReport,
}

impl Frame {
    /// What of a way over the last step, of `last` `[s]`, is taken over a step of `h` `[s]` where `motion` is without drag (dimensionless), and what an
    /// acceleration is multiplied by for that step `[s²]`.
    fn forces(&self, h: f32, motion: f32, last: f32) -> (f32, f32) {
        (motion * (-self.drag * h).exp(), 0.5 * h * (last + h))
    }

    /// Shares of the frame that have passed at the start and at the end of the current substep.
    fn span(&self) -> (f32, f32) {
        let n = self.report.substeps as f32;
        ((self.begun - 1) as f32 / n, self.begun as f32 / n)
    }
}

/// Most times as many substeps a cloth takes while a body comes through, and the way of the body in one of them that needs no more, in
/// thicknesses (dimensionless): at three thicknesses a ball of 0.1 m that goes through the middle of a hanging sheet at 5 m/s is there
/// before the pull is, and edges around it get many times as long.
const MOST_DRIVEN: f32 = 8.0;
const DRIVEN: f32 = 0.4;

/// How far a heavier body may press cloth in a substep, in the mean over what it touches, in edges at the strain limit beyond their length at rest
/// (dimensionless): what springs cannot draw back in one the next adds to, and the cloth bears it no longer.
const PRESSED: f32 = 0.25;
/// Largest strain limit that counts there (dimensionless): springs of what is elastic draw back no sooner.
const ELASTIC: f32 = 0.1;
/// Cosine of the angle to gravity within which what cloth gives a body is its own weight: 60°.
const LIES: f32 = 0.5;

/// Substeps that a cloth that nothing drives takes for a frame of `dt` `[s]`.
#[must_use]
pub fn substeps_of(stepping: &Stepping, dt: f32) -> u32 {
    substeps(dt.min(stepping.max_frame), stepping.substep_rate)
}

impl Stepped<'_> {
    /// Substeps that the next frame should take: as many as `stepping` says, and up to eight times as many while a body that is heavier than the
    /// cloth and moves much faster than the pins may meet it, or lies on it.
    #[must_use]
    pub fn substeps(&self, stepping: &Stepping, state: &ClothState, scratch: &mut Scratch) -> u32 {
        let Self { fabric, anchors, input, .. } = *self;
        let count = substeps_of(stepping, input.dt);
        scratch.driven = false;
        if input.bodies.is_empty() {
            return count;
        }
        // Of bodies that cloth cannot stop, and of others: those may stay.
        let (mut driven, mut borne) = (1, scratch.borne.max(1));
        // What hangs on a character that runs goes with it.
        let sum: Vec3 = anchors.from.iter().zip(&anchors.to).map(|(from, to)| *to - *from).sum();
        let mean = sum / anchors.particles.len().max(1) as f32;
        // What is lighter than the cloth gives way to it.
        let own = self.mass();
        let mass = |body: &Body| body.rigid.map_or(f32::INFINITY, |slot| scratch.coupling.mass(slot));
        // How many times as far a body gets in a substep as it may; what cloth can stop may press it, too.
        let haste = |body: &Body| {
            let free = DRIVEN * fabric.thickness;
            let most = if mass(body).is_finite() { free.max(self.most_pressed()) } else { free };
            (body.to.translation - body.from.translation - mean).length() / (count as f32 * most)
        };
        let drives = |body: &Body| mass(body) > own && haste(body) > 1.0 && haste(body).is_finite();
        if !input.bodies.iter().any(drives) {
            return count * borne;
        }
        let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = state.positions.iter().fold(none, |(low, high), x| (low.min(x.truncate()), high.max(x.truncate())));
        let (low, high) = (low.min(low + mean) - fabric.thickness, high.max(high + mean) + fabric.thickness);
        for (index, body) in input.bodies.iter().enumerate().filter(|(_, body)| drives(body)) {
            let (finite, times) = (mass(body).is_finite(), haste(body).min(MOST_DRIVEN).ceil() as u32);
            // What cloth is to stop finds it in small steps already.
            if body.sweeps(low, high) || (finite && scratch.contacts.is_near(index)) {
                let most = if finite { &mut borne } else { &mut driven };
                *most = (*most).max(times);
            }
        }
        (scratch.driven, scratch.borne) = (driven > 1, borne);
        count * borne.max(driven)
    }

    /// How far a heavier body may press the cloth in a substep `[m]`.
    fn most_pressed(&self) -> f32 {
        PRESSED * self.fabric.strain_limit.min(ELASTIC) * self.rest.mean_edge
    }

    /// Mass of the cloth `[kg]`, if bodies take what it does to them; 0 otherwise.
    fn mass(&self) -> f32 {
        let takes = self.input.bodies.iter().any(|body| body.rigid.is_some());
        if takes { self.fabric.density * self.rest.areas.iter().sum::<f32>() } else { 0.0 }
    }

    /// Finds out how many times as many substeps the cloth takes from now on for heavier bodies that lie on it: as the root of what they are heavier by,
    /// from when one presses it too far, or as many as for the speed with which one came, until none is near. Not by how hard it is pressed: more substeps
    /// in cloth that is drawn out already throw it up. What the cloth lies on, and presses down, is none of them.
    fn bear(&self, scratch: &mut Scratch) {
        let (own, bound) = (self.mass(), self.most_pressed());
        let mut borne = 1;
        for (index, body) in self.input.bodies.iter().enumerate() {
            let mass = body.rigid.map_or(f32::INFINITY, |slot| scratch.coupling.mass(slot));
            let heavier = mass / own;
            if !(heavier > 1.0 && mass.is_finite()) {
                continue;
            }
            let pushes = scratch.touches().filter(|(body, ..)| *body == index);
            let (push, count) = pushes.fold((0.0, 0.0), |(push, count), (_, _, load)| (push + load, count + 1.0));
            if count > 0.0 || scratch.contacts.is_near(index) {
                borne = borne.max(scratch.borne);
            }
            let given = body.rigid.map_or(Vec3::ZERO, |slot| scratch.coupling.given(slot).linear);
            let lies_on_it = given.dot(self.input.gravity) > LIES * given.length() * self.input.gravity.length();
            if push > bound * count && !lies_on_it {
                borne = borne.max(heavier.sqrt().min(MOST_DRIVEN).ceil() as u32);
            }
        }
        scratch.borne = borne;
    }

    /// Inner steps in a substep of `h` `[s]`: as many as tension needs to get along the cloth.
    fn inner_steps(&self, stepping: &Stepping, h: f32) -> u32 {
        let rate = drape_rate(self.rest.mean_edge).min(stepping.inner_rate);
        substeps(h, rate)
    }

    /// Prepares a frame of as many substeps as asked for, or as `stepping` says. None begins when no time passes or the
    /// state does not fit.
    pub fn begin(&self, stepping: &Stepping, count: Option<u32>, state: &mut ClothState, scratch: &mut Scratch) {
        scratch.frame = None;
        let Self { rest, fabric, anchors, input } = *self;
        // NaN fails the comparison; `min` alone would let it pass as a whole frame.
        if !(input.dt > 0.0) || state.positions.len() != rest.positions.len() {
            return;
        }
        let dt = input.dt.min(stepping.max_frame);
        let substeps = count.unwrap_or_else(|| self.substeps(stepping, state, scratch)).max(1);
        let h = dt / substeps as f32;
        scratch.coupling.begin(dt, anchors, &state.positions);
        scratch.welded.clear();
        scratch.welded.extend(scratch.coupling.welded(anchors));
        scratch.welded.sort_unstable();
        // Bodies that pins move go along in substeps, and of a first frame nobody knows whether it is tangled.
        let steps = if scratch.welded.is_empty() && scratch.worst_edge > 0.0 { self.inner_steps(stepping, h) } else { 1 };
        let step = h / steps as f32;
        if scratch.factors_for != step {
            scratch.springs.update(&rest.springs, fabric, &state.positions, step);
            scratch.hubs.update(&rest.net, &state.positions);
            scratch.factors_for = step;
        }
        scratch.triangles = !rest.membrane.is_empty()
            && match stepping.membrane {
                MembraneModel::Auto => !scratch.along_threads,
                MembraneModel::Springs => false,
                MembraneModel::Triangles => true,
            };
        let calm = scratch.is_calm();
        scratch.bends.fold(&rest.bends, fabric, &state.positions, &mut state.folds);
        if fabric.damping > 0.0 {
            let Scratch { motion, .. } = &mut *scratch;
            damp::note(&state.positions, &state.previous, motion);
            bend::rub(&rest.bends, fabric, dt, state.substep, motion);
            damp::solve(&rest.springs, fabric.damping, dt, &state.positions, motion);
            damp::apply(&state.positions, motion, &mut state.previous);
        }
        let approach = Approach {
            dt,
            substep: state.substep,
            gravity: input.gravity,
            thickness: fabric.thickness,
            extra: anchors.longest_way() + input.wind.fastest() * dt + scratch.pulls.reach(dt, &state.positions),
        };
        scratch.contacts.gather(input.bodies, &state.positions, &state.previous, &approach);
        let sheet = Sheet {
            topology: &rest.topology,
            longest_edge: scratch.longest_edge,
            positions: &state.positions,
            thickness: fabric.thickness,
        };
        scratch.faces.gather(input.bodies, &sheet, scratch.contacts.way(), dt);
        // Of its first frame nothing is known: a cloth may start in a storm.
        let beyond = |limits: f32, was: bool| scratch.strain() > if was { EASED } else { limits } * fabric.strain_limit;
        let (strained, taut) = (beyond(STRAINED, scratch.strained) || scratch.worst_edge == 0.0, beyond(TAUT, scratch.taut));
        (scratch.strained, scratch.taut) = (strained, taut);
        // Where little moves the air does nothing, and what is drawn back to its length must get there.
        let air =
            if calm || strained { 0.0 } else { air::share(fabric, scratch.area, input.gravity.length(), input.wind.density) };
        scratch.carried.begin(air, rest, &state.positions);
        if taut {
            // A calm cloth would feel a list that shrinks.
            let all = scratch.strain() > WILD * fabric.strain_limit;
            scratch.tight.find(&rest.springs, fabric.strain_limit, (all, calm), &state.positions);
        }
        let lie = scratch.contacts.candidates()
            + 3 * scratch.faces.candidates().min(rest.topology.faces.len() + rest.topology.edges.len());
        // Not only in calm cloth, since the list would grow when it becomes so.
        let times = if taut && scratch.faces.candidates() > 0 { CALM_SWEEPS } else { CALM_PASSES };
        scratch.laid.begin(lie * times as usize);
        scratch.before.clone_from(&state.positions);
        scratch.contacts.leave_out(&scratch.welded);
        scratch.faces.leave_out(&scratch.welded);
        scratch.frame = Some(Frame {
            dt,
            h,
            begun: 0,
            gusts: self::substeps(dt, WIND_RATE).min(substeps),
            steps,
            strained,
            taut,
            calm,
            drag: fabric.drag + if calm && fabric.damping > 0.0 { CALM_DRAG } else { 0.0 },
            report: StepReport { substeps, inner_steps: steps, lost_time: input.dt - dt, ..StepReport::default() },
        });
    }

    /// Begins the next substep: forces, prediction, and all that holds the cloth together. False when the frame is over, or none was begun.
    pub fn constrain(&self, state: &mut ClothState, scratch: &mut Scratch) -> bool {
        let Some(frame) = &mut scratch.frame else { return false };
        let Self { rest, fabric, input, .. } = *self;
        let (n, count) = (frame.begun, frame.report.substeps);
        if n == count {
            return false;
        }
        frame.begun += 1;
        let frame = *frame;
        Self::give_back(state, scratch);
        let (x, old) = (&mut state.positions, &mut state.previous);
        let windy = input.wind.density > 0.0;
        if windy && (n == 0 || n * frame.gusts / count > (n - 1) * frame.gusts / count) {
            scratch.acceleration.clear();
            scratch.acceleration.resize(x.len(), input.gravity.extend(0.0));
            let air = Aerodynamics { drag: fabric.drag_coefficient, lift: fabric.lift_coefficient };
            let hold = frame.dt / frame.gusts as f32;
            let faces = &rest.topology.faces;
            scratch.wind.apply(input.wind, air, faces, x, old, state.substep, hold, &mut scratch.acceleration);
        }
        if n > 0 {
            scratch.keep_air(state);
        }
        scratch.carried.note(state.substep, &state.positions, &state.previous);
        if frame.steps > 1 {
            self.advance_in_steps(&frame, state, scratch);
        } else {
            self.advance(&frame, state, scratch);
        }
        state.substeps += 1;
        true
    }

    /// Moves free particles by a share `carry` of their way over the last substep (dimensionless), and by their acceleration times `push` `[s²]`.
    fn predict(&self, (carry, push): (f32, f32), state: &mut ClothState, scratch: &Scratch) {
        let (x, old) = (&mut state.positions, &mut state.previous);
        if self.input.wind.density > 0.0 {
            predict::predict(x, old, &scratch.acceleration, carry, push);
        } else {
            predict::predict_uniform(x, old, self.input.gravity.extend(0.0), carry, push);
        }
    }

    /// The way of a substep of `h` `[s]` over that of the last one (dimensionless), 0 after none.
    fn motion(state: &ClothState, h: f32) -> f32 {
        if state.substep > 0.0 { h / state.substep } else { 0.0 }
    }

    /// Finds the folds again where the cloth is now, in the middle of a frame of a calm cloth: bends turn within a frame, and what lags behind by a whole one
    /// would keep it from rest.
    fn fold_again(&self, frame: &Frame, positions: &[Vec4], folds: &mut Vec<Vec4>, bends: &mut bend::BendFactors) {
        let begun = frame.begun - 1;
        if frame.calm && begun > 0 && begun == frame.report.substeps / 2 {
            bends.fold(&self.rest.bends, self.fabric, positions, folds);
        }
    }

    /// A substep in one step: prediction, and all that holds the cloth together.
    fn advance(&self, frame: &Frame, state: &mut ClothState, scratch: &mut Scratch) {
        let Self { rest, fabric, anchors, .. } = *self;
        let h = frame.h;
        self.predict(frame.forces(h, Self::motion(state, h), scratch.last_step(state)), state, scratch);
        state.substep = h;
        scratch.inner_steps = 1;
        let (x, old) = (&mut state.positions, &mut state.previous);
        scratch.inbound.clear();
        if fabric.restitution > 0.0 {
            scratch.inbound.extend(x.iter().zip(&*old).map(|(x, old)| *x - *old));
        }
        let (_, s) = frame.span();
        anchor::solve(anchors, s, h, x);
        scratch.coupling.advance(h);
        scratch.coupling.place(anchors, s, x);
        scratch.pulls.solve(s, h, x);
        self.fold_again(frame, x, &mut state.folds, &mut scratch.bends);
        scratch.bends.solve(&rest.bends, h, x);
        // They are at a bound, which holds for more than one substep.
        if frame.calm || !state.substeps.is_multiple_of(TETHER_EVERY) {
            scratch.tethers.solve(fabric.tether_scale + scratch.give, x);
        }
        if frame.strained {
            scratch.hubs.solve(&rest.net, fabric.strain_limit, x);
        }
        hold_together(rest, fabric, scratch, x);
        if frame.taut {
            self.tighten(frame, x, old, scratch);
        }
        self.pull(h, s, self.input.gravity, scratch, x);
    }

    /// A substep in inner steps: forces, bending and membrane act in each; bounds on lengths and soft pins follow at its end, and contacts after it (multiple time
    /// stepping, Tuckerman et al. 1992).
    ///
    /// Bounds and contacts act on the mean velocity of the substep, `(x - start) / h`, so that what they hold in its place has none. That of the last inner step
    /// differs by what the forces of the substep do, and the difference is [given back](Self::give_back) after contacts: no momentum is lost.
    fn advance_in_steps(&self, frame: &Frame, state: &mut ClothState, scratch: &mut Scratch) {
        let Self { rest, fabric, anchors, input } = *self;
        let (h, steps) = (frame.h, frame.steps as f32);
        let step = h / steps;
        let (s0, s1) = frame.span();
        let mut forces = frame.forces(step, Self::motion(state, h) / steps, scratch.last_step(state));
        state.substep = h;
        scratch.inner_steps = frame.steps;
        scratch.late.clone_from(&state.positions);
        self.fold_again(frame, &state.positions, &mut state.folds, &mut scratch.bends);
        scratch.coupling.advance(h);
        scratch.inbound.clear();
        for k in 1..=frame.steps {
            self.predict(forces, state, scratch);
            forces = frame.forces(step, 1.0, step);
            let x = &mut state.positions;
            if k == 1 && fabric.restitution > 0.0 {
                scratch.inbound.extend(x.iter().zip(&state.previous).map(|(x, old)| (*x - *old) * steps));
            }
            let s = s0 + (s1 - s0) * k as f32 / steps;
            anchor::solve_rigid(anchors, s, x);
            scratch.coupling.place(anchors, s, x);
            scratch.pulls.solve(s, step, x);
            scratch.bends.solve(&rest.bends, step, x);
            hold_together(rest, fabric, scratch, x);
            self.pull(step, s, input.gravity, scratch, x);
        }
        let (x, old) = (&mut state.positions, &mut state.previous);
        for ((x, old), late) in x.iter().zip(&mut *old).zip(&mut scratch.late) {
            let start = core::mem::replace(late, (*x - *old) * steps - (*x - *late));
            *old = start;
        }
        scratch.coupling.place(anchors, s1, x);
        anchor::solve_soft(anchors, s1, h, x);
        if frame.calm || !state.substeps.is_multiple_of(TETHER_EVERY) {
            scratch.tethers.solve(fabric.tether_scale + scratch.give, x);
        }
        if frame.strained {
            scratch.hubs.solve(&rest.net, fabric.strain_limit, x);
        }
        if frame.taut {
            self.tighten(frame, x, old, scratch);
        }
        self.pull(h, s1, Vec3::ZERO, scratch, x);
    }

    /// Ends a substep taken [in inner steps](Self::advance_in_steps): velocities become those of the last, and what bounds and contacts added.
    fn give_back(state: &mut ClothState, scratch: &mut Scratch) {
        for (old, late) in state.previous.iter_mut().zip(&scratch.late) {
            *old -= *late;
        }
        scratch.late.clear();
    }

    /// Tells bodies what the cloth did to pins on them in a step of `h` `[s]` that ended at the share `s` of the frame.
    fn pull(&self, h: f32, s: f32, gravity: Vec3, scratch: &mut Scratch, positions: &mut [Vec4]) {
        let pull = Pull { rest: self.rest, anchors: self.anchors, s, h, gravity, density: self.fabric.density };
        scratch.coupling.react(&pull, positions);
    }

    /// Shortens springs that are beyond the strain limit. Near bodies with corners cloth is laid on bodies before each sweep: what hangs on a corner
    /// could not draw at its neighbours otherwise, which would follow it into the body, and only the edges next to it would stretch. Round bodies bear it
    /// all around: a sheet of 64² that falls on a ball would take a quarter longer.
    fn tighten(&self, frame: &Frame, positions: &mut [Vec4], previous: &[Vec4], scratch: &mut Scratch) {
        let Self { rest, fabric, input, .. } = *self;
        let Scratch { tight, springs, contacts, faces, coupling, laid, .. } = scratch;
        let mut grounds = Grounds { bodies: input.bodies, span: frame.span(), touch: Touch::of(fabric), rubs: false, coupling };
        let hangs = faces.candidates() > 0;
        let sweeps = match (frame.calm, hangs) {
            (true, _) => CALM_SWEEPS,
            (false, true) => HUNG_SWEEPS,
            (false, false) => TAUT_SWEEPS,
        };
        for _ in 0..sweeps {
            if hangs {
                contacts.lay(&mut grounds, positions, previous, laid);
                faces.lay(&mut grounds, positions, previous, laid);
            }
            tight.solve(&rest.springs, springs, fabric.strain_limit, positions);
        }
        laid.take_back(positions);
    }

    /// Puts what lies on bodies where [`Self::project`] will put it, until that begins; for what is done in between. `rubs`: whether friction is to hold
    /// it there, too.
    pub fn lay(&self, rubs: bool, state: &mut ClothState, scratch: &mut Scratch) {
        let Some(span) = scratch.frame.as_ref().map(Frame::span) else { return };
        let Scratch { contacts, faces, coupling, laid, .. } = scratch;
        let mut grounds = Grounds { bodies: self.input.bodies, span, touch: Touch::of(self.fabric), rubs, coupling };
        contacts.lay(&mut grounds, &mut state.positions, &state.previous, laid);
        faces.lay(&mut grounds, &mut state.positions, &state.previous, laid);
    }

    /// Ends the substep: keeps the cloth out of bodies.
    pub fn project(&self, state: &mut ClothState, scratch: &mut Scratch) {
        let Some(frame) = &mut scratch.frame else { return };
        let (s0, s1) = frame.span();
        let touch = Touch::of(self.fabric);
        let (x, old, coupling) = (&mut state.positions, &mut state.previous, &mut scratch.coupling);
        scratch.laid.take_back(x);
        frame.report.body_contacts =
            scratch.contacts.project(self.input.bodies, s0, s1, x, old, &scratch.inbound, &touch, coupling);
        frame.report.body_contacts += scratch.faces.project(self.input.bodies, s0, s1, x, old, &touch, coupling);
        // Without a fast body once a frame is enough.
        if scratch.driven || s1 == 1.0 {
            let since = if scratch.driven { frame.h } else { frame.dt };
            scratch.give = give(self.fabric, scratch, x, since);
        }
    }

    /// Ends the frame; nothing when none was begun. `crowded`: whether it may touch cloth.
    pub fn finish(&self, crowded: bool, state: &mut ClothState, scratch: &mut Scratch) -> Option<StepReport> {
        let frame = scratch.frame.take()?;
        let Self { rest, fabric, .. } = *self;
        let mut report = frame.report;
        state.time += f64::from(frame.dt);
        Self::give_back(state, scratch);
        report.bend_held = scratch.bends.held(frame.h / frame.steps as f32);
        scratch.keep_air(state);
        scratch.carried.end();
        if frame.calm && fabric.damping > 0.0 {
            slow_what_is_stuck(&scratch.before, 1.0 / report.substeps as f32, state);
        }
        let speed2 = mean_square_speed(&state.positions, &scratch.before, frame.dt);
        (report.worst_edge, report.mean_edge) = spring::strain(&rest.springs, &state.positions);
        scratch.worst_edge = report.worst_edge;
        let limits = if scratch.is_calm() { CALM_STRAINED } else { STRAINED };
        if scratch.strain() > limits * fabric.strain_limit {
            shorten(self, crowded, state, scratch, report.mean_edge);
            // Pins on bodies that cloth moves have a mass, but stay where they are.
            scratch.coupling.place(self.anchors, 1.0, &mut state.positions);
            (report.worst_edge, report.mean_edge) = spring::strain(&rest.springs, &state.positions);
        }
        self.bear(scratch);
        let bound = if scratch.is_calm() { 2.0 * CALM_SPEED } else { CALM_SPEED };
        // False for what is not a number.
        scratch.slow_for = if speed2 <= bound * bound { (scratch.slow_for + frame.dt).min(1.0) } else { 0.0 };
        Some(report)
    }
}

/// How far tethers give way now, as a share of their length at rest (dimensionless), a time of `dt` `[s]` after they gave `scratch.give`. Cloth that a
/// body holds farther from its pins than they are long, by more than its thickness, is longer all the way to them, within its strain limit, not
/// only where the body is.
fn give(fabric: &Fabric, scratch: &Scratch, positions: &[Vec4], dt: f32) -> f32 {
    let excess = scratch.tethers.excess(scratch.grounded(), fabric.tether_scale, fabric.thickness, positions);
    let most = fabric.strain_limit.clamp(0.0, MOST_GIVE);
    scratch.give + (excess.min(most) - scratch.give).clamp(-GIVE_BACK * dt, GIVE_WAY * dt)
}

/// Gives particles that hardly moved [`STUCK`] since they were `before`, a substep being the `share` of that time, the speed with which they did.
fn slow_what_is_stuck(before: &[Vec4], share: f32, state: &mut ClothState) {
    for ((x, old), before) in state.positions.iter().zip(&mut state.previous).zip(before) {
        let (motion, mean) = (*x - *old, (*x - *before) * share);
        if mean.length_squared() < STUCK * STUCK * motion.length_squared() {
            *old = *x - mean;
        }
    }
}

/// Mean square of speeds `[m²/s²]`: of free particles that were `before` and are where they are after a frame of `dt` `[s]`. Where constraints pull
/// against each other within it, they only tremble.
fn mean_square_speed(positions: &[Vec4], before: &[Vec4], dt: f32) -> f32 {
    let (mut sum, mut count) = (0.0, 0u32);
    for (x, before) in positions.iter().zip(before) {
        if x.w > 0.0 {
            sum += (*x - *before).truncate().length_squared();
            count += 1;
        }
    }
    sum / (count.max(1) as f32 * dt * dt)
}

/// Shortens edges that are beyond the strain limit at the end of a frame. No particle gains speed by it or goes into a body.
fn shorten(cloth: &Stepped<'_>, crowded: bool, state: &mut ClothState, scratch: &mut Scratch, mean_edge: f32) {
    let Stepped { rest, fabric, input: FrameInput { bodies, .. }, .. } = *cloth;
    let bound = 1.0 + fabric.strain_limit;
    let x = &mut state.positions;
    let before = &mut scratch.before;
    before.clone_from(x);
    scratch.overlong.shorten(&rest.springs, &scratch.springs, bound, FINISH_PASSES, x);
    // A cloth that is stretched as a whole would be crumpled.
    if mean_edge < 1.0 + EVEN * fabric.strain_limit && !scratch.leash.is_empty() {
        let worst = spring::strain(&rest.springs, x).0;
        scratch.displaced.clone_from(x);
        scratch.leash.solve(rest, bound, x);
        // Each particle was drawn to the last of its neighbours: even that out.
        scratch.overlong.shorten(&rest.springs, &scratch.springs, bound, FINISH_PASSES / 2, x);
        // Where what was drawn to one pin meets what was drawn to another, it does not fit.
        if spring::strain(&rest.springs, x).0 > worst {
            x.clone_from(&scratch.displaced);
        }
    }
    // No farther than the distance kept to bodies: nothing can be behind one then. Nor through cloth that nobody has looked for.
    let farthest = fabric.thickness * if crowded { CROWDED } else { 1.0 };
    for (x, before) in x.iter_mut().zip(&*before) {
        let way = *x - *before;
        let square = way.length_squared();
        if square > farthest * farthest {
            *x = *before + way * (farthest / square.sqrt());
        }
    }
    let slip = Touch::frictionless(fabric);
    scratch.contacts.project(bodies, 1.0, 1.0, x, before, &[], &slip, &mut scratch.coupling);
    scratch.faces.project(bodies, 1.0, 1.0, x, before, &slip, &mut scratch.coupling);
    for ((old, x), before) in state.previous.iter_mut().zip(x).zip(before) {
        *old += *x - *before;
    }
}

/// Lets something else than time move the cloth, as untangling does, and keeps it out of bodies on its way: no speed comes of that. Whether
/// bodies stopped anything.
pub fn displace(
    fabric: &Fabric,
    bodies: &[Body],
    state: &mut ClothState,
    scratch: &mut Scratch,
    displace: impl FnOnce(&mut ClothState),
) -> bool {
    if bodies.is_empty() {
        displace(state);
        return false;
    }
    let Scratch { before, displaced, contacts, faces, coupling, .. } = scratch;
    before.clone_from(&state.positions);
    displace(state);
    if state.positions == *before {
        return false;
    }
    let x = &mut state.positions;
    displaced.clone_from(x);
    let slip = Touch::frictionless(fabric);
    contacts.project(bodies, 1.0, 1.0, x, before, &[], &slip, coupling);
    faces.project(bodies, 1.0, 1.0, x, before, &slip, coupling);
    let mut stopped = false;
    for ((x, old), displaced) in x.iter().zip(&mut state.previous).zip(displaced) {
        if x != displaced {
            *old += *x - *displaced;
            stopped = true;
        }
    }
    stopped
}

/// Sweeps the springs or triangles once, as a substep does, without letting time pass. Nothing happens before the first [`step`].
pub fn relax(rest: &RestShape, fabric: &Fabric, scratch: &Scratch, positions: &mut [Vec4]) {
    if positions.len() == rest.positions.len() && scratch.factors_for > 0.0 {
        hold_together(rest, fabric, scratch, positions);
    }
}

/// Solves the membrane once, for the substep that the factors were computed for.
fn hold_together(rest: &RestShape, fabric: &Fabric, scratch: &Scratch, positions: &mut [Vec4]) {
    if scratch.triangles {
        membrane::solve(&rest.membrane, fabric, scratch.factors_for, positions);
    } else {
        spring::solve(&rest.springs, &scratch.springs, fabric.strain_limit, positions);
    }
}

/// Substeps of equal length in a frame of `dt` `[s]` at `rate` `[Hz]`: at least one, and not one more for rounding.
fn substeps(dt: f32, rate: f32) -> u32 {
    ((dt * rate - 1.0e-3).ceil() as u32).max(1)
}
