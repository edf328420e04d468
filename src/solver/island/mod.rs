//! Cloths that can meet, untangled together as one surface.
//!
//! ```text
//! step: (constrain ─► (lay on bodies ─► keep apart), twice if calm ─► bodies ─► hold what sticks ─► rebound ─► guard)* ─► finish ─► guard
//! gather ─► detect ─► resolve: take back what is new ─► (advance ─► springs ─► look)* ─► undo what got worse ─► scatter what moved
//!     ─► bodies ─► stay: put back what they pushed ─► evaluate: look again, one verdict per cloth
//! ```
//!
//! Each cloth lives in a frame of its own; `offset` brings it into that of the group, and 0 for the only cloth of a group changes no bit.
//! While nothing crosses nothing is written back, so that a clean cloth has the same bits with and without a group.

mod look;
mod undo;

use core::ops::Range;

use glam::{Vec3, Vec3A, Vec4};

use super::body::Touch;
use super::detect::{Crossing, PartRef, Surface, SurfaceError};
use super::evaluate::{EvaluateSettings, Evaluator, Outcome, Pose, Resort, Shown, Verdict};
use super::resolve::{Contour, Method, ResolveSettings, Strategy, Untangler};
use super::respond::{CALM_PASSES, Contacts, Finder, Moment};
use super::retreat::Retreat;
use super::settings::Stepping;
use super::state::ClothState;
use super::step::{Scratch, StepReport, Stepped};
use undo::Undo;

/// Rings of neighbours around a tangle over which a held shape passes into the live one.
const RINGS: usize = 3;

/// Looks after which the rest of a tangle that came up within a frame is not taken back any more.
const MOST_RETREATS: usize = 8;
/// Rounds in which one cloth after the other stays where it was.
const MOST_ROUNDS: usize = 8;

/// How far ahead pairs are looked for at most `[s]`: in a longer frame all are looked for again. Boxes swept farther meet half of the cloth.
const LONGEST_LOOK: f32 = 1.0 / 30.0;

/// Time between looks for what strayed within a frame, to the nearest substep `[s]`, where what slips by in between can be taken back at its
/// end. Looking in every substep costs twice as much for a flag in the wind or a sheet that falls on a ball.
const LOOK_AGAIN: f32 = 1.0 / 120.0;
/// Pairs on each particle from which on cloth is crowded, and looked at in every substep: ten sheets that fall on a ball, looked at less
/// often, cross.
const CROWDED: usize = 2;

/// Time in which [`Group::blend`] should draw a tangle to a pose `[s]`.
pub const BLEND_TIME: f32 = 0.25;

/// How a group is untangled in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UntangleSettings {
    /// Method and steps.
    pub resolve: ResolveSettings,
    /// Most iterations per frame. Default 4; 0 only detects. Cost is proportional, while tangled only.
    pub iterations: u32,
    /// Sweeps of the springs after each iteration. Default 2. 0 tears the edges around a tangle; many slow it down.
    pub relaxations: u32,
}

impl Default for UntangleSettings {
    fn default() -> Self {
        Self { resolve: ResolveSettings::default(), iterations: 4, relaxations: 2 }
    }
}

/// A cloth of a group that is stepped.
#[derive(Debug)]
pub struct Member<'a> {
    /// What it is stepped with.
    pub cloth: Stepped<'a>,
    /// Its substeps; all take as many as the one that needs most.
    pub stepping: &'a Stepping,
    /// Its particles.
    pub state: &'a mut ClothState,
    /// Its buffers.
    pub scratch: &'a mut Scratch,
    /// From its frame of simulation to that of the group `[m]`.
    pub offset: Vec3,
    /// Whether other cloths can push it.
    pub moves: bool,
}

/// The cloths of a group, as [`Group::step`] asks for them.
pub trait Members {
    /// Cloth `part`, in the order in which the group was made.
    fn member(&mut self, part: usize) -> Option<Member<'_>>;
    /// Is told what the frame of cloth `part` did.
    fn done(&mut self, part: usize, report: StepReport);
}

/// Several cloths as one surface, with reused buffers; nothing is allocated once warm.
#[derive(Clone, Debug, Default)]
pub struct Group {
    surface: Surface,
    untangler: Untangler,
    positions: Vec<Vec4>,
    previous: Vec<Vec4>,
    before: Vec<Vec4>,
    weights: Vec<f32>,
    /// Whether the weights are those of the last frame.
    weighed: bool,
    verdicts: Vec<Verdict>,
    total: Verdict,
    iterations: u32,
    /// Whether something moved since it was gathered, and since the last look.
    moved: bool,
    stale: bool,
    finder: Finder,
    contacts: Contacts,
    substep: Vec<f32>,
    /// Cloths that are not to be moved.
    fixed: Vec<bool>,
    /// Particles that pins hold, whether or not their cloth is to be moved.
    pinned: Vec<bool>,
    retreat: Retreat,
    /// Whether what comes to cross within a frame will be taken back at its end.
    takes_back: bool,
    touch: Vec<Touch>,
    takes_part: Vec<bool>,
    /// Substeps that the last frame took.
    count: u32,
    /// Time for which pairs were looked for `[s]`, and the share of it that has passed.
    horizon: f32,
    share: f32,
    looks: u32,
    undo: Undo,
    /// Where everything was before an iteration; particles of what crosses.
    start: Vec<Vec4>,
    caught: Vec<bool>,
    /// Whether what was found at the last look is still known, as long as nothing moves far.
    known: bool,
}

impl Group {
    /// Concatenates the cloths.
    ///
    /// # Errors
    /// [`SurfaceError`] when rest positions do not match a topology, or when there are too many cloths or particles.
    pub fn new(cloths: &[PartRef<'_>]) -> Result<Self, SurfaceError> {
        let surface = Surface::new(cloths)?;
        let n = surface.len();
        Ok(Self {
            untangler: Untangler::new(&surface),
            finder: Finder::new(&surface),
            substep: vec![0.0; surface.parts.len()],
            fixed: vec![false; surface.parts.len()],
            pinned: vec![false; n],
            positions: vec![Vec4::ZERO; n],
            previous: vec![Vec4::ZERO; n],
            verdicts: vec![Verdict::default(); surface.parts.len()],
            surface,
            ..Self::default()
        })
    }

    /// Changes the settings of cloth `part`: its layer, whether it meets itself, its thickness `[m]`. What is known of it stays known, except where it may
    /// cross itself.
    pub fn tune(&mut self, part: usize, layer: i32, self_collision: bool, thickness: f32) {
        let Some(settings) = self.surface.parts.get_mut(part) else { return };
        if settings.self_collision != self_collision {
            self.known = false;
            self.untangler.detector.forget();
        }
        (settings.layer, settings.self_collision, settings.thickness) = (layer, self_collision, thickness);
    }

    /// Takes over the state of cloth `part`, moved by `offset` `[m]`. A `fixed` cloth is an obstacle for the others and never moved.
    pub fn gather(&mut self, part: usize, state: &ClothState, offset: Vec3, fixed: bool) {
        let range = self.range(part);
        if state.positions.len() != range.len() || state.previous.len() != range.len() {
            return;
        }
        self.substep[part] = state.substep;
        self.fixed[part] = fixed;
        self.untangler.detector.set_moving(part, fixed && state.positions.iter().any(|x| x.w > 0.0));
        let offset = offset.extend(0.0);
        let all = self.positions[range.clone()].iter_mut().zip(&mut self.pinned[range.clone()]);
        for ((to, pinned), from) in all.zip(&state.positions) {
            *to = *from + offset;
            *pinned = from.w == 0.0;
            if fixed {
                to.w = 0.0;
            }
        }
        for (to, from) in self.previous[range].iter_mut().zip(&state.previous) {
            *to = *from + offset;
        }
    }

    /// Says that the pairs will be wanted that may touch within the next `dt` `[s]`, the longest of the frames that the cloths will take:
    /// `touch` says of each cloth how it does, `takes_part` whether it does.
    pub fn expect(&mut self, dt: f32, touch: &[Touch], takes_part: impl Fn(usize) -> bool) {
        let parts = self.surface.parts.len();
        self.known &= self.touch == touch && (0..parts).map(&takes_part).eq(self.takes_part.iter().copied());
        self.takes_part.clear();
        self.takes_part.extend((0..parts).map(takes_part));
        self.touch.clear();
        self.touch.extend_from_slice(touch);
        // While no time passes, nobody knows how much will.
        let horizon = if dt > 0.0 {
            self.finder.horizon(dt.min(LONGEST_LOOK), dt / self.count.max(1) as f32, touch)
        } else {
            self.horizon
        };
        (self.horizon, self.share, self.looks) = (horizon, 0.0, 0);
    }

    /// Finds the pairs that may touch before the next frame, unless [`Self::detect`] found them and nothing moved since. Pairs of a tangle
    /// are left out.
    pub fn respond(&mut self) {
        if self.looks == 0 || self.moved || !self.total.is_clean() {
            self.share = 0.0;
            if self.total.is_clean() {
                let Self { contacts, retreat, .. } = self;
                contacts.absolve(|v| retreat.took(v));
            }
            self.find(false);
        }
        self.finder.note(&self.positions);
    }

    /// Finds the pairs that may touch until the horizon: all, or those of particles that strayed.
    fn find(&mut self, strayed: bool) {
        self.looks += 1;
        self.known &= strayed;
        if self.touch.len() != self.surface.parts.len() || !self.takes_part.contains(&true) {
            self.contacts.clear();
            return;
        }
        let Self { surface, untangler, finder, contacts, weights, pinned, .. } = self;
        let clean = self.total.is_clean();
        let takes_part = &self.takes_part;
        let tangled = |v: u32| if clean { 0.0 } else { weights.get(v as usize).copied().unwrap_or_default() };
        let (positions, previous, substep, touch) = (&self.positions, &self.previous, &self.substep, &self.touch);
        let moment = Moment { positions, previous, substep, touch, takes_part, pinned };
        let tree = untangler.detector.tree();
        if strayed {
            let (share, rest) = (self.share, self.horizon * (1.0 - self.share));
            finder.find_strayed(surface, tree, &moment, share, rest, tangled, contacts);
        } else {
            finder.find(surface, tree, &moment, self.horizon, tangled, contacts);
        }
    }

    /// Steps all cloths by a frame side by side, and keeps apart what touches. A cloth that cannot be stepped stays, and the others meet it
    /// where it is.
    pub fn step(&mut self, cloths: &mut impl Members) {
        let parts = self.surface.parts.len();
        let (mut count, mut longest) = (0, 0.0f32);
        for part in 0..parts {
            if let Some(m) = cloths.member(part) {
                count = count.max(m.cloth.substeps(m.stepping, m.state, m.scratch));
                longest = longest.max(m.cloth.input.dt.min(m.stepping.max_frame));
                if m.moves {
                    self.retreat.forget_if_moved(&self.surface, part, &m.state.positions, m.offset);
                }
            }
        }
        self.takes_back &= self.retreat.knows();
        self.count = count;
        // Share of the time looked ahead that passes in a substep.
        let each = if self.horizon > 0.0 { longest / (count.max(1) as f32 * self.horizon) } else { 1.0 };
        let gap = (LOOK_AGAIN * count as f32 / longest.max(f32::MIN_POSITIVE)).round().max(1.0) as u32;
        self.share = 0.0;
        self.contacts.note_meetings();
        for part in 0..parts {
            let range = self.surface.parts[part].particles.clone();
            let own = |p: u32| range.contains(&p).then(|| p - range.start);
            if let Some(m) = cloths.member(part) {
                let tangled = !self.contours().is_empty();
                // Inner steps would draw back what untangling moves.
                let whole = Stepping { inner_rate: 0.0, ..m.stepping.clone() };
                m.cloth.begin(if tangled { &whole } else { m.stepping }, Some(count), m.state, m.scratch);
                if tangled {
                    m.scratch.leave_air();
                }
                m.scratch.lies_on_cloth(self.contacts.pushes().flat_map(|(particles, ..)| particles).filter_map(own));
            }
        }
        for n in 1..=count {
            self.contacts.lift();
            self.note_start(cloths);
            let lies = self.lies_on_bodies(cloths);
            for part in 0..parts {
                if let Some(m) = cloths.member(part) {
                    m.cloth.constrain(m.state, m.scratch);
                }
            }
            if lies {
                self.lay(cloths);
            }
            self.keep_apart(cloths, lies);
            for part in 0..parts {
                if let Some(m) = cloths.member(part) {
                    m.cloth.project(m.state, m.scratch);
                    let first = self.surface.parts[part].particles.start;
                    m.scratch.grounded().for_each(|p| self.contacts.ground(first + p));
                }
            }
            if lies {
                self.hold_what_sticks(cloths);
            }
            self.rebound(cloths);
            self.guard(cloths, false);
            self.share += each;
            if n < count {
                let often = !self.takes_back || self.contacts.len() > CROWDED * self.surface.len();
                self.look_ahead(cloths, each, often || n % gap == 0);
            }
        }
        self.note_start(cloths);
        let crowded = !self.contacts.is_empty();
        for part in 0..parts {
            if let Some(m) = cloths.member(part)
                && let Some(report) = m.cloth.finish(crowded, m.state, m.scratch)
            {
                cloths.done(part, report);
            }
        }
        // Overlong edges were shortened without heed to what is between them.
        self.guard(cloths, true);
    }

    /// Whether cloth that lies on bodies may touch cloth, so that care is to be taken of both at once. Folds of one cloth in motion cross no less
    /// without, and a sheet of 64² on a ball takes an eighth longer with it.
    fn lies_on_bodies(&self, cloths: &mut impl Members) -> bool {
        let parts = self.surface.parts.len();
        let mut lies = |m: Member<'_>| (parts > 1 || m.scratch.is_calm()) && m.scratch.grounded().next().is_some();
        !self.contacts.is_empty() && (0..parts).any(|part| cloths.member(part).is_some_and(&mut lies))
    }

    /// Puts what lies on bodies where they will put it.
    fn lay(&self, cloths: &mut impl Members) {
        for part in 0..self.surface.parts.len() {
            if let Some(m) = cloths.member(part) {
                m.cloth.lay(self.contacts.meets_other(part), m.state, m.scratch);
            }
        }
    }

    /// Notes where everything is that may touch, and how fast.
    fn note_start(&mut self, cloths: &mut impl Members) {
        if self.contacts.is_empty() {
            return;
        }
        self.contacts.begin_start();
        for part in 0..self.surface.parts.len() {
            let Some(Member { state, offset, moves, .. }) = cloths.member(part) else { continue };
            let offset = offset.extend(0.0);
            let per_second = if moves && state.substep > 0.0 { state.substep.recip() } else { 0.0 };
            self.contacts.note_start(part, |i| match (state.positions.get(i), state.previous.get(i)) {
                (Some(&x), Some(&old)) => (x + offset, Vec3A::from_vec4(x - old) * per_second),
                _ => (Vec4::NAN, Vec3A::ZERO),
            });
        }
    }

    /// Keeps apart what touches at the end of a substep; `lies`: cloth on bodies was laid there.
    fn keep_apart(&mut self, cloths: &mut impl Members, lies: bool) {
        if self.contacts.is_empty() {
            self.contacts.rest();
            return;
        }
        let (mut h, mut calm) = (0.0f32, true);
        for part in 0..self.surface.parts.len() {
            if let Some(Member { state, scratch, moves: true, .. }) = cloths.member(part) {
                calm &= scratch.is_calm();
                h = h.max(state.substep);
            }
        }
        let passes = if calm { CALM_PASSES } else { 1 };
        let gravity = self.gravity(cloths);
        self.contacts.begin_solve(h, passes);
        self.gather_pairs(cloths);
        for pass in 1..=passes {
            if pass > 1 && lies {
                // What was pushed into a body lies on it again.
                self.scatter_pairs(cloths);
                self.lay(cloths);
                self.gather_pairs(cloths);
            }
            self.contacts.solve(pass == passes, gravity);
        }
        self.scatter_pairs(cloths);
    }

    /// Sum of what pulls the cloths that move `[m/s²]`, for its direction.
    fn gravity(&self, cloths: &mut impl Members) -> Vec3 {
        let mut of = |part: usize| cloths.member(part).filter(|m| m.moves).map_or(Vec3::ZERO, |m| m.cloth.input.gravity);
        (0..self.surface.parts.len()).map(&mut of).sum()
    }

    /// Holds pairs that stick, when bodies have pushed, too.
    fn hold_what_sticks(&mut self, cloths: &mut impl Members) {
        self.gather_pairs(cloths);
        self.contacts.hold(self.gravity(cloths));
        self.scatter_pairs(cloths);
    }

    /// Gives what met fast in the substep its speed apart, when bodies have pushed, too: they go by where it was when the substep began.
    fn rebound(&mut self, cloths: &mut impl Members) {
        if self.contacts.has_impacts() {
            self.gather_pairs(cloths);
            self.contacts.rebound();
            self.scatter_pairs(cloths);
        }
    }

    /// Takes in where the particles of pairs are and where they were when the substep began.
    fn gather_pairs(&mut self, cloths: &mut impl Members) {
        self.contacts.begin_gather();
        for part in 0..self.surface.parts.len() {
            let Some(Member { state, offset, moves, .. }) = cloths.member(part) else { continue };
            let offset = offset.extend(0.0);
            self.contacts.gather(part, |i| match (state.positions.get(i), state.previous.get(i)) {
                (Some(&now), Some(&old)) if moves => (now + offset, old + offset),
                // What stays has no speed, whatever it had.
                (Some(&now), _) if !moves => (now.truncate().extend(0.0) + offset, now + offset),
                _ => (Vec4::NAN, Vec4::NAN),
            });
        }
    }

    /// Gives back where they are and where they were.
    fn scatter_pairs(&mut self, cloths: &mut impl Members) {
        for part in 0..self.surface.parts.len() {
            let Some(Member { state, offset, moves: true, .. }) = cloths.member(part) else { continue };
            let offset = offset.extend(0.0);
            self.contacts.scatter(part, |i, now, old| {
                if let (Some(x), Some(was)) = (state.positions.get_mut(i), state.previous.get_mut(i)) {
                    // What nothing touched keeps every bit.
                    if *x + offset != now {
                        *x = now - offset;
                    }
                    if *was + offset != old {
                        *was = old - offset;
                    }
                }
            });
        }
    }

    /// Stops on its way what would have passed through since [`Self::note_start`]; `finished`: on the way that [`Stepped::finish`] moved it, which gave
    /// it no speed. To be stopped there gives a calm cloth none either; to others it is a brake: without it edges of a strip that is overwound get seven
    /// times as long.
    fn guard(&mut self, cloths: &mut impl Members, finished: bool) {
        if self.contacts.is_empty() {
            return;
        }
        let parts = self.surface.parts.len();
        for part in 0..parts {
            let Some(Member { state, offset, moves, .. }) = cloths.member(part) else { continue };
            let offset = offset.extend(0.0);
            self.contacts.gather_end(part, |i| match state.positions.get(i) {
                Some(&now) if moves => now + offset,
                Some(&now) => now.truncate().extend(0.0) + offset,
                None => Vec4::NAN,
            });
        }
        if !self.contacts.guard() {
            return;
        }
        for part in 0..parts {
            let Some(Member { state, scratch, offset, moves: true, .. }) = cloths.member(part) else { continue };
            let (offset, silent) = (offset.extend(0.0), finished && scratch.is_calm());
            self.contacts.scatter_cut(part, |i, now| {
                if let (Some(x), Some(old)) = (state.positions.get_mut(i), state.previous.get_mut(i)) {
                    let to = now - offset;
                    if silent {
                        *old += to - *x;
                    }
                    *x = to;
                }
            });
        }
    }

    /// Looks for pairs again where cloth will not be in the next substep, which takes a share `each` of the time looked ahead, where it was
    /// foreseen to be; everywhere when that time is up. Otherwise only when that is `due`.
    fn look_ahead(&mut self, cloths: &mut impl Members, each: f32, due: bool) {
        let (next, over) = (self.share + each, self.share + 0.5 * each > 1.0);
        if !due && !over {
            return;
        }
        let mut strayed = over;
        for ((i, part), touch) in self.surface.parts.iter().enumerate().zip(&self.touch).filter(|_| !over) {
            let Some(m) = cloths.member(i).filter(|m| m.moves) else { continue };
            if m.state.positions.len() == part.particles.len() {
                let first = part.particles.start as usize;
                let ClothState { positions, previous, .. } = &*m.state;
                strayed |= self.finder.strayed(first, positions, previous, m.offset, next, touch.thickness);
            }
        }
        if strayed {
            for part in 0..self.surface.parts.len() {
                if let Some(m) = cloths.member(part) {
                    self.gather(part, m.state, m.offset, !m.moves);
                    if !m.moves {
                        self.hold(part);
                    }
                }
            }
            if over {
                self.share = 0.0;
            }
            self.find(!over);
            if over {
                // Not before: what moved since the last time is not stuck.
                self.finder.note(&self.positions);
            }
        }
    }

    /// How often pairs were looked for since [`Self::respond`], that look included.
    #[must_use]
    pub fn looks(&self) -> u32 {
        self.looks
    }

    /// How far ahead pairs are looked for `[s]`: a frame, or less.
    #[must_use]
    pub fn horizon(&self) -> f32 {
        self.horizon
    }

    /// The pairs that may touch.
    #[must_use]
    pub fn contacts(&self) -> &Contacts {
        &self.contacts
    }

    /// Calls `found` for every pair of different cloths that touched in the last substep: both cloths, a point between them `[m]` in the
    /// frame of the group, the unit normal towards the first, and the mean push per substep times the mass it moves `[kg·m]`.
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

    /// Says that cloth `part`, as gathered, stays where it is, whatever speed it had when it was stopped.
    pub fn hold(&mut self, part: usize) {
        self.substep[part] = 0.0;
        self.untangler.detector.set_moving(part, false);
    }

    /// Looks for crossings in what was gathered.
    pub fn detect(&mut self) -> Verdict {
        self.moved = false;
        self.iterations = 0;
        if self.touch.len() != self.surface.parts.len() || !self.takes_part.contains(&true) {
            self.contacts.clear();
            self.contacts.rest();
            (self.stale, self.known) = (false, false);
            self.total = self.untangler.look_again(&self.surface, &self.positions);
            self.sum_up();
        } else if self.total.is_clean() {
            if !self.look_where_drifted() {
                self.look_and_find();
            }
        } else {
            // Still tangled, most likely: what may touch is found when nothing moves any more.
            self.look();
        }
        self.total
    }

    /// Looks for crossings and, at the same pairs of faces until something crosses, for what may touch.
    fn look_and_find(&mut self) {
        let Self { surface, untangler, finder, contacts, positions, previous, substep, touch, takes_part, pinned, .. } = self;
        let moment = Moment { positions, previous, substep, touch, takes_part, pinned };
        finder.begin(surface, &moment, self.horizon, contacts);
        untangler.detector.tree().refit(surface, positions, Some(finder.ahead()));
        let ask = finder.ask(surface, &moment, |_| 0.0, contacts, false);
        let crossings = untangler.detector.detect_and(surface, positions, Finder::reach(&moment), ask);
        self.total = untangler.resolver.analyse(surface, crossings, positions);
        self.looks = 1;
        self.stale = false;
        // Of a cloth that was left out nothing is known.
        let all = (0..surface.parts.len()).all(|part| !untangler.detector.is_quarantined(part as u16));
        self.known = all && self.total.is_clean();
        self.sum_up();
    }

    /// The same, where cloth has hardly moved since the last time: nothing crosses but faces that were close then, and only for what moved
    /// is looked anew. False where that is not so, or something crosses.
    fn look_where_drifted(&mut self) -> bool {
        let Self { surface, untangler, finder, contacts, positions, previous, substep, touch, takes_part, pinned, .. } = self;
        let moment = Moment { positions, previous, substep, touch, takes_part, pinned };
        let detector = &mut untangler.detector;
        if !(self.known && finder.refresh(surface, detector.tree(), &moment, self.horizon, |_| 0.0, contacts)) {
            return false;
        }
        let crossings = detector.detect_among(surface, positions, contacts.close_faces());
        if !crossings.is_empty() {
            return false;
        }
        self.total = untangler.resolver.analyse(surface, crossings, positions);
        self.looks = 1;
        self.stale = false;
        self.sum_up();
        true
    }

    /// Takes the crossings found apart. `relax` sweeps the springs of a cloth, given its number and its positions.
    pub fn resolve(&mut self, settings: &UntangleSettings, mut relax: impl FnMut(usize, &mut [Vec4])) {
        self.takes_back = settings.iterations > 0 && self.total.is_clean() && !self.fixed.contains(&true);
        self.undo.forget();
        if !self.fixed.contains(&false) {
            return;
        }
        if settings.iterations > 0 {
            self.take_back();
        }
        if self.total.is_clean() {
            self.undo.forget_least();
        }
        // Layers go to their order through whatever lies between.
        let Self { surface, untangler, undo, positions, .. } = self;
        let may_undo = settings.resolve.method == Method::ByEndType && !untangler.resolver.orders_layers();
        if may_undo && !self.total.is_clean() {
            undo.begin(surface, positions, parts_of_contours(surface, untangler));
        }
        for i in 0..settings.iterations {
            let underway = i > 0 && self.untangler.resolver.carry_on(&mut self.positions, &mut self.previous);
            if i > 0 && !underway {
                self.look();
            }
            let Self { surface, untangler: Untangler { detector, resolver }, positions, previous, .. } = self;
            self.start.clear();
            if !self.total.is_clean() {
                self.start.extend_from_slice(positions);
                self.caught.clear();
                self.caught.resize(positions.len(), false);
                for c in detector.crossings() {
                    let ends = surface.topology.edges[c.edge as usize];
                    let corners = surface.topology.faces[c.face as usize];
                    ends.iter().chain(&corners).for_each(|&v| self.caught[v as usize] = true);
                }
            }
            // Even when clean: memories of contours that are gone are dropped, and layers may lie in the wrong order.
            let moved = underway || resolver.advance(surface, detector, positions, previous, &settings.resolve);
            self.moved |= moved;
            self.stale |= moved;
            if self.total.is_clean() && (!moved || settings.resolve.method == Method::History) {
                break;
            }
            self.iterations += 1;
            if settings.relaxations > 0 {
                self.relax(settings.relaxations, &mut relax);
            }
            self.keep_others_apart();
        }
        self.undo_what_got_worse();
    }

    fn undo_what_got_worse(&mut self) {
        if !self.undo.is_due() {
            return;
        }
        if self.stale {
            self.look();
        }
        let Self { surface, untangler, undo, positions, previous, .. } = self;
        let mut undone = undo.end(surface, parts_of_contours(surface, untangler), positions, previous);
        // One more cloth each time.
        while undone {
            self.look();
            let Self { surface, untangler, undo, positions, previous, .. } = self;
            undone = undo.follow(surface, parts_of_contours(surface, untangler), positions, previous);
            if !undone {
                untangler.resolver.give_up_plans(|v| undo.has_undone(surface.part(v)));
            }
        }
    }

    /// Stops what would pass, on its way out of a tangle, through cloth that has no part in it.
    fn keep_others_apart(&mut self) {
        if self.contacts.is_empty() || self.start.len() != self.positions.len() {
            return;
        }
        let Self { surface, contacts, positions, previous, start, weights, weighed, caught, .. } = self;
        contacts.begin_start();
        contacts.begin_gather();
        for (part, range) in surface.parts.iter().map(|p| p.particles.start as usize).enumerate() {
            contacts.note_start(part, |i| (start[range + i], Vec3A::ZERO));
            contacts.gather_end(part, |i| positions[range + i]);
        }
        // Weights of a tangle that was taken apart long ago say nothing.
        let weights = if *weighed { weights.as_slice() } else { &[] };
        let tangled =
            |ids: &[u32]| ids.iter().any(|&v| caught[v as usize] || weights.get(v as usize).is_some_and(|&w| w > 0.0));
        if contacts.guard_all_but(|a, b| tangled(a) && tangled(b)) {
            for (part, range) in surface.parts.iter().map(|p| p.particles.start as usize).enumerate() {
                contacts.scatter_cut(part, |i, x| {
                    let v = range + i;
                    previous[v] += x - positions[v];
                    positions[v] = x;
                });
            }
        }
    }

    /// Takes back what crosses since the last frame, if that ended clean and cloth is to be kept apart.
    fn take_back(&mut self) {
        let touches = self.takes_part.contains(&true);
        let crossings = self.untangler.detector.crossings();
        if !touches || self.total.is_clean() {
            return;
        }
        if !self.retreat.begin(&self.surface, crossings, &self.positions, &self.previous, &self.takes_part, self.count) {
            return;
        }
        self.put_back(MOST_RETREATS, Retreat::take);
        // What touched before may cross by rounding.
        self.put_back(MOST_RETREATS, Retreat::take_there);
        self.put_back(MOST_RETREATS, Retreat::take_along);
    }

    /// Puts back what crosses and looks again, some `rounds` at most, until nothing is left to put; whether there was any.
    fn put_back(
        &mut self,
        rounds: usize,
        put: impl Fn(&mut Retreat, &Surface, &[Crossing], &mut [Vec4], &mut [Vec4]) -> bool,
    ) -> bool {
        let mut any = false;
        for _ in 0..rounds {
            let Self { surface, untangler, retreat, positions, previous, .. } = self;
            if self.total.is_clean() || !put(retreat, surface, untangler.detector.crossings(), positions, previous) {
                break;
            }
            (any, self.moved) = (true, true);
            self.look();
        }
        any
    }

    /// When bodies pushed what was taken back, and something crosses again: it goes to the very place where it was when nothing did; where
    /// that is not enough, the cloths that cross stay where they were, as a whole. Whether anything does, and is to be
    /// [scattered](Self::scatter) once more. Call it after [`Self::regather`].
    pub fn stay(&mut self) -> bool {
        if !(self.stale && self.retreat.retreats()) {
            return false;
        }
        self.look();
        let there = self.put_back(MOST_RETREATS, Retreat::take_there);
        // A cloth that stays may be met by one that went on.
        let whole = self.put_back(self.surface.parts.len().min(MOST_ROUNDS), Retreat::stay);
        there || whole
    }

    /// Moves the frame of the group: everything that is known lies `by` `[m]` elsewhere in it from now on.
    pub fn carry(&mut self, by: Vec3) {
        self.retreat.carry(by);
        self.finder.carry(by);
        self.known = false;
    }

    /// Uses stronger means from now on; `None` goes back to the ordinary ones.
    pub fn escalate(&mut self, resort: Resort) {
        self.untangler.resolver.escalate(resort);
    }

    /// Looks at the order of layers of all particles in the next iteration, not only of a few.
    pub fn inspect_layers(&mut self) {
        self.untangler.resolver.inspect_layers();
    }

    /// Draws the tangled particles of cloth `part`, as weighed by the last [`Self::evaluate`], to a pose `[m]` in the cloth's own frame, by a
    /// fraction of the way: [`Resort::Blend`]. All others weigh at least `least`. Call it between [`Self::resolve`] and [`Self::scatter`].
    pub fn blend(&mut self, part: usize, pose: &[Vec3], offset: Vec3, fraction: f32, least: f32) {
        let range = self.range(part);
        if pose.len() != range.len() || self.weights.len() != self.positions.len() || self.total.is_clean() {
            return;
        }
        for (i, &to) in range.zip(pose) {
            let by = (to + offset - self.positions[i].truncate()) * (fraction * self.weights[i].max(least)).clamp(0.0, 1.0);
            if by != Vec3::ZERO && by.is_finite() && self.positions[i].w > 0.0 {
                self.positions[i] += by.extend(0.0);
                self.previous[i] += by.extend(0.0);
                (self.moved, self.stale) = (true, true);
            }
        }
    }

    pub(super) fn positions(&self) -> &[Vec4] {
        &self.positions
    }

    pub(super) fn keep_moved(&mut self, moved: bool) {
        self.moved |= moved;
    }

    /// Sweeps the springs of every cloth; previous positions go along, so that no velocity comes of it.
    fn relax(&mut self, sweeps: u32, relax: &mut impl FnMut(usize, &mut [Vec4])) {
        self.before.clone_from(&self.positions);
        for part in (0..self.surface.parts.len()).filter(|&part| !self.fixed[part]) {
            let range = self.range(part);
            for _ in 0..sweeps {
                relax(part, &mut self.positions[range.clone()]);
            }
        }
        for ((old, now), before) in self.previous.iter_mut().zip(&self.positions).zip(&self.before) {
            if now != before {
                *old += *now - *before;
            }
        }
    }

    /// Gives what was moved back to cloth `part`; the inverse of [`Self::gather`]. Particles that did not move keep every bit.
    pub fn scatter(&self, part: usize, state: &mut ClothState, offset: Vec3) {
        let range = self.range(part);
        if !self.moved || state.positions.len() != range.len() || state.previous.len() != range.len() {
            return;
        }
        let put = |states: &mut [Vec4], mine: &[Vec4]| {
            for (to, from) in states.iter_mut().zip(mine) {
                if to.truncate() + offset != from.truncate() && from.is_finite() {
                    *to = (from.truncate() - offset).extend(to.w);
                }
            }
        };
        put(&mut state.positions, &self.positions[range.clone()]);
        put(&mut state.previous, &self.previous[range]);
    }

    /// Takes over again what was [scattered](Self::scatter) and moved on.
    pub fn regather(&mut self, part: usize, state: &ClothState, offset: Vec3) {
        self.gather(part, state, offset, self.fixed[part]);
        (self.moved, self.stale) = (true, true);
    }

    /// Looks again if something moved, and weighs how much each particle belongs to a tangle.
    pub fn evaluate(&mut self) -> Verdict {
        if self.stale {
            self.look();
        }
        self.weighed = !self.total.is_clean();
        if self.weighed {
            let Untangler { detector, resolver } = &mut self.untangler;
            resolver.mark(&self.surface, detector.crossings(), &self.positions, RINGS, &mut self.weights);
        }
        // On which side what starts in the same place belongs, nobody knows; what came to touch has one. What no contact keeps apart is not
        // taken back.
        let touches = self.takes_part.contains(&true);
        let clean = touches && self.total.is_clean() && (self.retreat.knows() || !self.contacts.coincide());
        self.retreat.note(&self.surface, &self.positions, &self.previous, clean);
        self.total
    }

    fn look(&mut self) {
        (self.stale, self.known) = (false, false);
        self.total = self.untangler.look(&self.surface, &self.positions);
        self.sum_up();
    }

    /// Gives each cloth its share of the verdict.
    fn sum_up(&mut self) {
        self.verdicts.fill(Verdict::default());
        for (contour, [a, b]) in parts_of_contours(&self.surface, &self.untangler) {
            for part in [Some(a), (a != b).then_some(b)].into_iter().flatten() {
                let verdict = &mut self.verdicts[usize::from(part)];
                verdict.crossings += contour.count;
                verdict.contours += 1;
                verdict.contour_length += contour.length;
                verdict.regions += u32::from(contour.kind.separates());
            }
        }
    }

    fn range(&self, part: usize) -> Range<usize> {
        let range = &self.surface.parts[part].particles;
        range.start as usize..range.end as usize
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

    /// How much each particle of cloth `part` belongs to a tangle, 0 to 1, as of the last [`Self::evaluate`]; empty before the first tangle.
    #[must_use]
    pub fn weights(&self, part: usize) -> &[f32] {
        if part < self.surface.parts.len() { self.weights.get(self.range(part)).unwrap_or(&[]) } else { &[] }
    }

    /// Whether [`Self::resolve`] moved anything in this frame.
    #[must_use]
    pub fn has_moved(&self) -> bool {
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

    /// Cloths whose layers are in another order than pins hold them, the one with the higher layer first: nothing is done about their order.
    pub fn overruled_layers(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.untangler.resolver.overruled_layers().map(|pair| pair.map(usize::from))
    }

    /// What was done last about each contour that was found then.
    pub fn strategies(&self) -> impl Iterator<Item = Strategy> + '_ {
        self.untangler.resolver.strategies()
    }

    /// Segments `[m]` of all contours found last, in the frame of the group, each with the number of its contour.
    pub fn segments(&self) -> impl Iterator<Item = (usize, [Vec3; 2])> + '_ {
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

/// What one cloth shows, and what it showed before.
#[derive(Clone, Debug, Default)]
pub struct Display {
    evaluator: Evaluator,
    decided: bool,
    /// Positions to show `[m]`; empty while the live ones are shown.
    shown: Vec<Vec3>,
}

impl Display {
    /// Forgets clean shapes and history; for a cloth that starts anew.
    pub fn reset(&mut self) {
        self.evaluator.reset();
        self.shown.clear();
    }

    /// Decides a frame of `dt` `[s]` from the verdict on one cloth. `weights` says how much each particle belongs to a tangle, `pose` where
    /// what carries the cloth is.
    pub fn settle(
        &mut self,
        verdict: &Verdict,
        state: &ClothState,
        weights: &[f32],
        pose: Pose,
        dt: f32,
        settings: &EvaluateSettings,
    ) -> Outcome {
        let outcome = self.evaluator.judge(verdict, dt, settings);
        self.decided = true;
        self.shown.clear();
        if outcome.shown == Shown::Clean {
            self.evaluator.keep(&state.positions, pose);
        } else if outcome.hold > 0.0 {
            self.evaluator.present(&state.positions, weights, pose, settings, &mut self.shown);
        }
        outcome
    }

    /// Whether no frame was decided yet.
    #[must_use]
    pub fn is_new(&self) -> bool {
        !self.decided
    }

    /// The decision of the last frame.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        self.evaluator.outcome()
    }

    /// Positions to show `[m]` instead of the live ones, while the cloth is held or fades.
    #[must_use]
    pub fn held(&self) -> Option<&[Vec3]> {
        (!self.shown.is_empty()).then_some(self.shown.as_slice())
    }

    /// The last clean shape `[m]`, in the place where it was.
    #[must_use]
    pub fn clean_shape(&self) -> Option<&[Vec3]> {
        self.evaluator.clean_shape().map(|(shape, _)| shape)
    }

    /// Moves what is shown.
    pub fn carry(&mut self, motion: impl Fn(Vec3) -> Vec3) {
        for x in &mut self.shown {
            *x = motion(*x);
        }
    }
}
