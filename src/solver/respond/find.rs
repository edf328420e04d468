//! Which pairs may touch before the next frame.
//!
//! Each face is boxed together with where it is foreseen to be, relative to the motion all cloths share. Of two faces whose boxes meet,
//! each asks with the particles and edges it owns, so that every pair is asked for once.

use glam::{Vec3, Vec3A, Vec4};

use super::contact::Contact;
use super::{Contacts, Touch};
use crate::solver::body::Friction;
use crate::solver::detect::proximity::{closest_edges, distance_at_rest, vertex_face};
use crate::solver::detect::seams::{loose, seams};
use crate::solver::detect::surface::FARTHEST;
use crate::solver::detect::tree::{Bounds, FLAT, Tree};
use crate::solver::detect::{Proximity, Surface};
use crate::solver::rest::NONE;
use crate::solver::step::STUCK;

/// How much farther than its thickness a pair is looked for, in thicknesses (dimensionless): what accelerates within a frame comes from there.
const MARGIN: f32 = 0.25;

/// How far particles may stray from where they were foreseen, as a share of the distance within which pairs were found: two that both stray by less
/// than half of it cannot meet.
const STRAY: f32 = 0.45;

/// How far particles may drift from where they were at the last look for it to hold in the next frame, too, as a share of the margin. What
/// drifted is looked at where it is, against others that may drift from one side of where they were to the other. Two that nobody knew come
/// to within `1 + MARGIN - 3 DRIFT MARGIN` thicknesses, a half, before they are known: cloth is thinner there for a moment, but far from
/// crossing.
const DRIFT: f32 = 1.0;
/// The same as a share of the least height that a face had when it was last looked at: up to the first its normal cannot have turned, beyond the
/// second much else may have changed.
const DRIFT_OF_HEIGHT: [f32; 2] = [0.1, 0.5];
/// Cosine of how far a normal may have turned since, or will, for what was flat to be flat still: 0.2 radians.
const TURNED: f32 = 0.98;
/// Share of the particles that may have drifted; with more, a whole look costs less.
const MOST_DRIFTED: f32 = 0.4;

/// Mean way of the cloth until the next look that is not worth knowing, in thicknesses (dimensionless).
const HARDLY: f32 = 1.0 / 24.0;

/// What is [stuck](STUCK) went less than this since the last look at everything, too, in thicknesses (dimensionless).
const STILL: f32 = 0.05;

/// How far ahead a particle is looked for, at most, in mean edges plus thicknesses. Boxes swept farther meet half of the cloth.
const FARTHEST_EDGES: f32 = 4.0;
const FARTHEST_THICKNESSES: f32 = 4.0;
/// Mean way of particles until the next look from which on cloth flutters, in thicknesses (dimensionless).
const FLUTTER: f32 = 2.0;
/// Pairs listed for each particle, at most; what comes on top, in cloth that is crushed, is left to untangling.
const MOST_PAIRS: usize = 32;

/// Pairs of one cloth are kept no farther apart than this share of their distance at rest (dimensionless). In folds of less than 60°, which are
/// taken for [flat](FLAT), they may get to half of it; 0.5 here took twice as long to untangle a garment of many layers **`[measured]`**.
const REST_SHARE: f32 = 0.7;

/// Share of their thickness at which pairs are kept apart where how far they are is not up to them (dimensionless): where both sides are pinned
/// somewhere, as cloth beside pins that are closer would have to stretch, and around a tangle if they are no farther apart. None lets cloth
/// cross there; all of it is that stretch, and that buckling.
const LEAST_KEPT: f32 = 0.1;

/// How much both sides of a pair belong to a tangle (0 to 1, dimensionless) from which on it is left to untangling. Where they do less, around
/// it, a pair is kept about as far apart as it is: pushed to their thickness, sheets that cross at a small angle would buckle and cross more.
const WITHIN_TANGLE: f32 = 0.9;

/// Distances are not known better than to this share of the coordinates (dimensionless).
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// How far beyond its ends an edge may be passed, at least, as a share of its length: edges slide within a frame.
const SLACK: f32 = 0.1;

/// What pairs are looked for in: the state of all cloths after a substep.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// Position `[m]` and, in `w`, inverse mass `[1/kg]` of every particle.
    pub positions: &'a [Vec4],
    /// Positions `[m]` at the start of the substep.
    pub previous: &'a [Vec4],
    /// Length `[s]` of the substep, for each cloth.
    pub substep: &'a [f32],
    /// Thickness and friction of each cloth.
    pub touch: &'a [Touch],
    /// Whether each cloth rests on cloths at all.
    pub takes_part: &'a [bool],
    /// Whether pins hold each particle; what is not to be moved has no inverse mass either.
    pub pinned: &'a [bool],
}

impl Moment<'_> {
    fn thickest(&self) -> f32 {
        self.touch.iter().map(|t| t.thickness).fold(0.0, f32::max)
    }
}

/// Which face asks for which particle and edge, and how far each particle goes.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Finder {
    /// Bits 0 to 2: corners the face owns; bits 3 to 5: its edges.
    owns: Vec<u8>,
    /// Where each particle is foreseen to be in the next frame `[m]`, less the motion that all cloths share.
    ahead: Vec<Vec3A>,
    /// Where each particle was at the last look `[m]`.
    start: Vec<Vec3A>,
    /// Where each particle was when the time looked ahead began, a frame or half of one ago `[m]`.
    before: Vec<Vec3A>,
    /// Particles that are elsewhere than foreseen, those that were so at a substep since the last look, and faces with one.
    astray: Vec<bool>,
    shifted: Vec<bool>,
    marked: Vec<bool>,
    flatness: Flatness,
    /// The motion that all share until the next frame `[m]`.
    shared: Vec3A,
    /// Mean speed at the last look at everything, less what all cloths share `[m/s]`.
    haste: f32,
    /// Each face when it was last looked at.
    faces: Vec<Looked>,
    /// How far each particle has drifted, or will, since the last look `[m]`.
    drift: Vec<f32>,
    /// Where to `[m]`.
    there: Vec<Vec3A>,
    /// Longest edge of each cloth at rest `[m]`.
    longest: Vec<f32>,
    /// Particles around which cloth may lie over itself although normals agree.
    loose: Vec<bool>,
}

/// A face when it was last looked at.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Looked {
    /// Twice its area along its normal `[m²]`.
    normal: Vec3A,
    /// Its least height `[m]`.
    height: f32,
    /// How far its particles had drifted then, at most `[m]`.
    drift: f32,
}

impl Looked {
    fn at([a, b, c]: [Vec3A; 3], drift: f32) -> Self {
        let normal = (b - a).cross(c - a);
        let base = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        Self { normal, height: (normal.length_squared() / base.max(f32::MIN_POSITIVE)).sqrt(), drift }
    }

    /// Whether it has turned since, its particles having drifted as far as `drift` `[m]`; `now` and `there`: where they are and will be `[m]`.
    #[inline]
    fn has_turned(&self, drift: f32, now: impl Fn() -> [Vec3A; 3], there: impl Fn() -> [Vec3A; 3]) -> bool {
        let [still, far] = DRIFT_OF_HEIGHT.map(|share| share * self.height);
        let drift = drift + self.drift;
        let turned = |[a, b, c]: [Vec3A; 3]| {
            let normal = (b - a).cross(c - a);
            let along = normal.dot(self.normal);
            !(along > 0.0 && along * along >= TURNED * TURNED * normal.length_squared() * self.normal.length_squared())
        };
        // NaN passes no comparison.
        !(drift <= still) && (!(drift <= far) || turned(now()) || turned(there()))
    }
}

/// Where the cloth hardly bends: particles around which all normals lie, and will lie, within 60° of their sum, so that distances across
/// a crease are at least half of those at rest.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Flatness {
    /// Normals of faces as long as twice their area `[m²]`, and their sums around particles.
    normals: Vec<Vec3A>,
    sums: Vec<Vec3A>,
    /// Whether particles are flat; none where it was not asked for since everything moved.
    flat: Vec<Option<bool>>,
    /// Particles for which it was.
    asked: u32,
}

/// Asked for more than one in this many particles, it is cheaper to find out about all.
const ONE_IN: usize = 64;

impl Flatness {
    fn new(surface: &Surface) -> Self {
        let n = surface.len();
        let normals = vec![Vec3A::ZERO; surface.topology.faces.len()];
        Self { normals, sums: vec![Vec3A::ZERO; n], flat: vec![None; n], asked: 0 }
    }

    /// Everything moved: nothing is known.
    fn forget(&mut self) {
        self.asked = 0;
        self.flat.fill(None);
    }

    /// Whether particle `v` is flat.
    #[inline]
    fn holds(&mut self, v: u32, surface: &Surface, positions: &[Vec4], ahead: &[Vec3A]) -> bool {
        self.flat[v as usize].unwrap_or_else(|| self.find(v, surface, positions, ahead))
    }

    /// Finds out about particle `v`, or about all when that was asked [often](ONE_IN).
    #[cold]
    fn find(&mut self, v: u32, surface: &Surface, positions: &[Vec4], ahead: &[Vec3A]) -> bool {
        let now = |v: u32| Vec3A::from_vec4(positions[v as usize]);
        let then = |v: u32| ahead[v as usize];
        self.asked += 1;
        if self.asked as usize * ONE_IN <= self.flat.len() {
            let flat = is_flat(v, surface, now) && is_flat(v, surface, then);
            self.flat[v as usize] = Some(flat);
            return flat;
        }
        self.flat.fill(Some(true));
        self.keep(surface, now);
        self.keep(surface, then);
        self.flat[v as usize] == Some(true)
    }

    fn keep(&mut self, surface: &Surface, at: impl Fn(u32) -> Vec3A) {
        let Self { normals, sums, flat, .. } = self;
        sums.fill(Vec3A::ZERO);
        // Any direction will do, so large faces may count for more.
        for (&[a, b, c], normal) in surface.topology.faces.iter().zip(normals.iter_mut()) {
            let origin = at(a);
            *normal = (at(b) - origin).cross(at(c) - origin);
            sums[a as usize] += *normal;
            sums[b as usize] += *normal;
            sums[c as usize] += *normal;
        }
        for (t, &normal) in surface.topology.faces.iter().zip(normals.iter()) {
            let limit = FLAT * FLAT * normal.length_squared();
            for &v in t {
                let sum = sums[v as usize];
                let along = normal.dot(sum);
                if !(along > 0.0 && along * along > limit * sum.length_squared()) {
                    flat[v as usize] = Some(false);
                }
            }
        }
    }
}

/// Whether all normals around a particle lie within 60° of their sum.
fn is_flat(v: u32, surface: &Surface, at: impl Fn(u32) -> Vec3A) -> bool {
    let topology = &surface.topology;
    // Each face twice: it has two edges there.
    let faces = || topology.around(v).iter().flat_map(|&(_, e)| topology.edge_faces[e as usize]).filter(|&f| f != NONE);
    let normal = |f: u32| {
        let [a, b, c] = topology.faces[f as usize].map(&at);
        (b - a).cross(c - a)
    };
    let sum: Vec3A = faces().map(normal).sum();
    faces().map(normal).all(|normal| {
        let along = normal.dot(sum);
        along > 0.0 && along * along > FLAT * FLAT * normal.length_squared() * sum.length_squared()
    })
}

impl Finder {
    /// Prepares finding on a surface.
    #[must_use]
    pub fn new(surface: &Surface) -> Self {
        let topology = &surface.topology;
        let mut owns = vec![0; topology.faces.len()];
        let mut owned = vec![false; surface.len()];
        for (f, t) in topology.faces.iter().enumerate() {
            for (k, &v) in t.iter().enumerate() {
                if !std::mem::replace(&mut owned[v as usize], true) {
                    owns[f] |= 1 << k;
                }
                if topology.edge_faces[topology.face_edges[f][k] as usize][0] == f as u32 {
                    owns[f] |= 8 << k;
                }
            }
        }
        let length = |e: u32| {
            let [a, b] = topology.edges[e as usize].map(|v| surface.rest[v as usize]);
            a.distance(b)
        };
        let longest = surface.parts.iter().map(|part| part.edges.clone().map(length).fold(0.0, f32::max)).collect();
        let start = vec![Vec3A::ZERO; surface.len()];
        let (astray, marked) = (vec![false; surface.len()], vec![false; topology.faces.len()]);
        let shifted = astray.clone();
        Self {
            owns,
            ahead: start.clone(),
            before: vec![Vec3A::NAN; surface.len()],
            there: start.clone(),
            start,
            astray,
            shifted,
            marked,
            flatness: Flatness::new(surface),
            shared: Vec3A::ZERO,
            haste: 0.0,
            faces: vec![Looked::default(); topology.faces.len()],
            drift: vec![0.0; surface.len()],
            longest,
            loose: loose(surface, &seams(surface)),
        }
    }

    /// Prepares for looking at all pairs that may touch within `dt` `[s]`: with [`Self::ask`], in whatever order [`Tree::pairs`] finds faces within
    /// [`Self::reach`] in a tree fitted to where particles are and [will be](Self::ahead).
    pub fn begin(&mut self, surface: &Surface, moment: &Moment<'_>, dt: f32, contacts: &mut Contacts) {
        contacts.begin();
        contacts.fit(surface);
        self.foresee(surface, moment, dt);
        self.flatness.forget();
    }

    /// Finds the pairs that may touch within `dt` `[s]`. `tangled` says how much a particle belongs to a tangle (0 to 1), within which there is no
    /// right side.
    pub fn find(
        &mut self,
        surface: &Surface,
        tree: &mut Tree,
        moment: &Moment<'_>,
        dt: f32,
        tangled: impl Fn(u32) -> f32,
        contacts: &mut Contacts,
    ) {
        self.begin(surface, moment, dt, contacts);
        tree.refit(surface, moment.positions, Some(&self.ahead));
        let mut ask = self.ask(surface, moment, tangled, contacts, false);
        tree.pairs(surface, Self::reach(moment), |f, g| {
            ask(f, g);
        });
    }

    /// Brings the last look at all pairs up to date, if particles have drifted so little that it still holds but for a few, which are
    /// looked at anew. False, and nothing is done, where they have not.
    pub fn refresh(
        &mut self,
        surface: &Surface,
        tree: &mut Tree,
        moment: &Moment<'_>,
        dt: f32,
        tangled: impl Fn(u32) -> f32,
        contacts: &mut Contacts,
    ) -> bool {
        // Where something lay in the same place, nobody knows yet on which side.
        if self.shared != Vec3A::ZERO || contacts.coincide {
            return false;
        }
        let most = (MOST_DRIFTED * surface.len() as f32) as usize;
        let mut drifted = 0;
        for ((part, &h), touch) in surface.parts.iter().zip(moment.substep).zip(moment.touch) {
            let scale = if h > 0.0 { dt / h } else { 0.0 };
            let limit = DRIFT * MARGIN * touch.thickness;
            for v in part.particles.start as usize..part.particles.end as usize {
                let (now, start) = (Vec3A::from_vec4(moment.positions[v]), self.start[v]);
                let motion = foreseen(moment, v, scale, self.before[v], 1.0, touch.thickness);
                self.there[v] = now + motion;
                self.drift[v] = now.distance_squared(start).max(self.there[v].distance_squared(start)).sqrt();
                self.astray[v] = self.shifted[v] || !(self.drift[v] <= limit);
                drifted += usize::from(self.astray[v]);
            }
        }
        if drifted <= most {
            drifted += self.find_turned(surface, moment.positions);
        }
        if drifted > most {
            return false;
        }
        if drifted > 0 {
            self.find_strayed(surface, tree, moment, 0.0, dt, tangled, contacts);
        }
        true
    }

    /// Finds the particles of faces that have turned since they were looked at, or will, though none of them has drifted too far; how many.
    fn find_turned(&mut self, surface: &Surface, positions: &[Vec4]) -> usize {
        let Self { there, drift, astray, faces, .. } = self;
        let mut count = 0;
        for (&t, face) in surface.topology.faces.iter().zip(&*faces) {
            // With one astray it is looked at anew.
            if t.iter().any(|&v| astray[v as usize]) {
                continue;
            }
            let [a, b, c] = t.map(|v| drift[v as usize]);
            let now = || t.map(|v| Vec3A::from_vec4(positions[v as usize]));
            if face.has_turned(a.max(b).max(c), now, || t.map(|v| there[v as usize])) {
                t.iter().for_each(|&v| astray[v as usize] = true);
                count += 3;
            }
        }
        count
    }

    /// Where each particle is foreseen to be `[m]`, less the motion that all cloths share.
    #[must_use]
    pub fn ahead(&self) -> &[Vec3A] {
        &self.ahead
    }

    /// How far ahead to look `[s]` when the next look at everything is due in `dt` `[s]`: half of that where cloth flutters, as boxes swept
    /// half as far meet a third of the faces; a whole number of substeps of `h` `[s]`.
    #[must_use]
    pub fn horizon(&self, dt: f32, h: f32, touch: &[Touch]) -> f32 {
        let thickest = touch.iter().map(|t| t.thickness).fold(0.0, f32::max);
        if self.haste * dt > FLUTTER * thickest { (h * (0.5 * dt / h - 1.0e-3).ceil()).min(dt) } else { dt }
    }

    /// Moves everything that is known `by` `[m]`.
    pub fn carry(&mut self, by: Vec3) {
        let by = Vec3A::from(by);
        [&mut self.before, &mut self.start, &mut self.ahead].into_iter().flatten().for_each(|x| *x += by);
    }

    /// Notes where all particles are `[m]` at the end of a frame, or of the time looked ahead within one, to tell at the next look which of
    /// them are stuck.
    pub fn note(&mut self, positions: &[Vec4]) {
        self.before.iter_mut().zip(positions).for_each(|(before, &x)| *before = Vec3A::from_vec4(x));
    }

    /// How close boxes must come for their faces to be asked `[m]`.
    #[must_use]
    pub fn reach(moment: &Moment<'_>) -> f32 {
        (1.0 + MARGIN) * moment.thickest()
    }

    /// Finds the pairs anew whose particles have [strayed](Self::strayed), for the rest `dt` `[s]` of the time looked ahead, of which `share`
    /// has passed.
    #[expect(clippy::too_many_arguments, reason = "arrays of an island, which it keeps apart")]
    pub fn find_strayed(
        &mut self,
        surface: &Surface,
        tree: &mut Tree,
        moment: &Moment<'_>,
        share: f32,
        dt: f32,
        tangled: impl Fn(u32) -> f32,
        contacts: &mut Contacts,
    ) {
        for ((marked, face), t) in self.marked.iter_mut().zip(&mut self.faces).zip(&surface.topology.faces) {
            *marked = t.iter().any(|&v| self.astray[v as usize]);
            if *marked {
                // What is astray is looked at where it is. How far the others have drifted within a frame nobody knows: it is looked at again.
                let drift = |v: u32| if self.astray[v as usize] { 0.0 } else { self.drift[v as usize] };
                let drift = if share > 0.0 { f32::INFINITY } else { t.iter().map(|&v| drift(v)).fold(0.0, f32::max) };
                *face = Looked::at(t.map(|v| Vec3A::from_vec4(moment.positions[v as usize])), drift);
            }
        }
        let longest = FARTHEST_EDGES * surface.mean_edge + FARTHEST_THICKNESSES * moment.thickest();
        // Of the time since the last look at everything and until the next: at its end all of it.
        let since = if share > 0.0 { (1.0 - share) / share } else { 1.0 };
        contacts.note_loads();
        contacts.pairs.retain(|pair| pair.behind || pair.faces.iter().all(|&f| !self.marked[f as usize]));
        contacts.close.retain(|faces| faces.iter().all(|&f| !self.marked[f as usize]));
        contacts.note_behind();
        for ((part, &h), touch) in surface.parts.iter().zip(moment.substep).zip(moment.touch) {
            let scale = if h > 0.0 { dt / h } else { 0.0 };
            for v in part.particles.start as usize..part.particles.end as usize {
                if core::mem::take(&mut self.astray[v]) {
                    // Others were looked at where they were at that substep, not where they will have drifted from.
                    self.shifted[v] = share > 0.0;
                    let now = Vec3A::from_vec4(moment.positions[v]) - self.shared * share;
                    let motion = foreseen(moment, v, scale, self.before[v], since, touch.thickness);
                    self.ahead[v] = now + limited(motion - self.shared * (1.0 - share), longest);
                    // So that it is here now.
                    self.start[v] = (now - self.ahead[v] * share) / (1.0 - share);
                }
            }
        }
        self.flatness.forget();
        tree.refit(surface, moment.positions, Some(&self.ahead));
        let marked = core::mem::take(&mut self.marked);
        let mut ask = self.ask(surface, moment, tangled, contacts, true);
        tree.pairs_with(surface, Self::reach(moment), &marked, |f, g| {
            ask(f, g);
        });
        drop(ask);
        self.marked = marked;
    }

    /// What to do with two faces whose boxes meet: their primitives are asked how far apart they are and will be. Whether it is asked
    /// `anew`, of faces nobody has looked for crossings at since they were elsewhere. Says of two faces whether they may cross now.
    pub fn ask<'a>(
        &'a mut self,
        surface: &'a Surface,
        moment: &Moment<'a>,
        tangled: impl Fn(u32) -> f32 + 'a,
        contacts: &'a mut Contacts,
        anew: bool,
    ) -> impl FnMut(u32, u32) -> bool + 'a {
        let &Moment { positions, touch, takes_part, pinned, .. } = moment;
        let (reach, thickest) = (Self::reach(moment), moment.thickest());
        let topology = &surface.topology;
        let Self { owns, ahead, longest, flatness, loose, .. } = self;
        let (owns, ahead, longest, loose): (&[u8], &[Vec3A], &[f32], &[bool]) = (owns, ahead, longest, loose);
        let at = |v: u32| positions[v as usize].truncate();
        let path = |v: u32| Path { now: Vec3A::from_vec4(positions[v as usize]), ahead: ahead[v as usize] };
        let most = MOST_PAIRS * surface.len();
        let ask = move |contacts: &mut Contacts, pair: Proximity, first: usize, faces: [u32; 2]| {
            if contacts.len() >= most {
                return;
            }
            let ids = pair.particles;
            let (p, q) = (surface.part(ids[0]), surface.part(ids[3]));
            if !(takes_part[usize::from(p)] && takes_part[usize::from(q)]) {
                return;
            }
            let (mine, other) = (&touch[usize::from(p)], &touch[usize::from(q)]);
            let whole = 0.5 * (mine.thickness + other.thickness);
            let (mut thickness, margin) = (whole, MARGIN * whole);
            let delta: Vec3 = (0..4).map(|i| at(ids[i]) * pair.weights[i]).sum();
            // Closer than coordinates can tell, two cloths have no side to be on; what a cloth does to itself is taken back if it was wrong.
            let size = ids.map(|v| at(v).abs()).into_iter().fold(Vec3::ZERO, Vec3::max).max_element();
            let known = pair.distance > ROUNDING * size || p == q;
            let normal = delta.try_normalize().filter(|_| known).unwrap_or(Vec3::NAN);
            let tangled = |ids: &[u32]| ids.iter().map(|&v| tangled(v)).fold(0.0, f32::max);
            let tangled = tangled(&ids[..first]).min(tangled(&ids[first..]));
            if !normal.is_finite() || tangled > WITHIN_TANGLE {
                contacts.coincide |= !normal.is_finite();
                return;
            }
            let far = |thickness: f32| {
                let reach = thickness + margin;
                let axis = Vec3A::from(normal);
                let along = |v: u32| axis.dot(ahead[v as usize]);
                let low = ids[..first].iter().map(|&v| along(v)).fold(f32::INFINITY, f32::min);
                let high = ids[first..].iter().map(|&v| along(v)).fold(f32::NEG_INFINITY, f32::max);
                pair.distance >= reach && low - high >= reach
            };
            if far(thickness) {
                return;
            }
            if p == q {
                let near = thickness / REST_SHARE + 2.0 * longest[usize::from(p)];
                if surface.rest[ids[0] as usize].distance_squared(surface.rest[ids[3] as usize]) < near * near {
                    thickness = thickness.min(REST_SHARE * distance_at_rest(surface, &pair));
                    if thickness <= 0.0 || far(thickness) {
                        return;
                    }
                }
            }
            if contacts.is_behind(pair.kind, ids) {
                return;
            }
            // Looked for as far as any other, so that nothing meets unseen.
            let is_pinned = |ids: &[u32]| ids.iter().any(|&v| pinned[v as usize]);
            if is_pinned(&ids[..first]) && is_pinned(&ids[first..]) {
                thickness = thickness.min(LEAST_KEPT * whole);
            } else if tangled > 0.0 {
                thickness = thickness.min(pair.distance.max(LEAST_KEPT * whole));
            }
            let rub = |touch: &Touch| (touch.static_friction, touch.dynamic_friction);
            let friction = Friction::between(rub(mine), rub(other));
            let (slots, [load, drive]) = (ids.map(|v| contacts.slot(v)), contacts.load(pair.kind, ids));
            contacts.pairs.push(Contact {
                kind: pair.kind,
                faces,
                slots,
                weights: pair.weights,
                normal,
                thickness,
                friction,
                restitution: mine.restitution.max(other.restitution),
                across: p != q,
                load,
                drive,
                sticks: false,
                behind: false,
                was_behind: false,
            });
        };
        let reach_of = |u: u32, v: u32| {
            let [a, b] = [u, v].map(|v| touch[usize::from(surface.part(v))].thickness);
            (1.0 + MARGIN) * 0.5 * (a + b)
        };
        move |f: u32, g: u32| {
            let (tf, tg) = (topology.faces[f as usize], topology.faces[g as usize]);
            // Faces of a fan that hardly bends are hardly closer than at rest.
            if let Some(&v) = tf.iter().find(|&&v| tg.contains(&v) && flatness.holds(v, surface, positions, ahead)) {
                // Nor do they cross, unless cloth is cut or sewn there.
                let may_cross = loose[v as usize];
                if anew && may_cross {
                    contacts.close.push([f, g]);
                }
                return may_cross;
            }
            let (pf, pg) = (corners(tf, path), corners(tg, path));
            // A thick cloth does not make the others look farther.
            let reach = if touch.len() == 1 { reach } else { reach_of(tf[0], tg[0]) };
            let gaps = Gaps::between(&pf, &pg);
            if gaps.exceed(reach, gaps.now.min(gaps.ahead)) {
                return false;
            }
            // What drifts no farther does not meet.
            let may_cross = !gaps.exceed(3.0 * DRIFT * MARGIN * thickest, gaps.now);
            if may_cross {
                contacts.close.push([f, g]);
            }
            let wide = Vec3A::splat(reach);
            let (bf, bg) = (corners([0, 1, 2], |k: usize| pf[k].bounds()), corners([0, 1, 2], |k: usize| pg[k].bounds()));
            let (own_f, own_g) = (owns[f as usize], owns[g as usize]);
            let (whole_f, whole_g) = (bf[0].union(bf[1]).union(bf[2]), bg[0].union(bg[1]).union(bg[2]));
            for (own, t, u, boxes, whole) in [(own_f, tf, tg, &bf, &whole_g), (own_g, tg, tf, &bg, &whole_f)] {
                for k in 0..3 {
                    if own & (1 << k) != 0 && !u.contains(&t[k]) && boxes[k].meets(whole, wide) {
                        ask(contacts, vertex_face([t[k], u[0], u[1], u[2]], at), 1, [f, g]);
                    }
                }
            }
            if own_f & 0b11_1000 == 0 || own_g & 0b11_1000 == 0 {
                return may_cross;
            }
            for (i, next) in CYCLE {
                let e = [tf[i], tf[next]];
                let edge = bf[i].union(bf[next]);
                if own_f & (8 << i) == 0 || !edge.meets(&whole_g, wide) {
                    continue;
                }
                for (j, next_j) in CYCLE {
                    let h = [tg[j], tg[next_j]];
                    if own_g & (8 << j) != 0
                        && !h.contains(&e[0])
                        && !h.contains(&e[1])
                        && bg[j].union(bg[next_j]).meets(&edge, wide)
                        && may_pass([pf[i], pf[next]], [pg[j], pg[next_j]])
                    {
                        ask(contacts, closest_edges([e[0], e[1], h[0], h[1]], at), 2, [f, g]);
                    }
                }
            }
            may_cross
        }
    }

    /// Notes which particles of the cloth that begins at particle `first` may touch something that was not found before the next substep
    /// ends, when `share` (0 to 1) of the time looked ahead will have passed. `positions` and `previous` and `offset` `[m]` as gathered,
    /// `thickness` `[m]` of the cloth. Whether there are any.
    pub fn strayed(
        &mut self,
        first: usize,
        positions: &[Vec4],
        previous: &[Vec4],
        offset: Vec3,
        share: f32,
        thickness: f32,
    ) -> bool {
        let common = Vec3A::from(offset) - self.shared * share;
        let limit = STRAY * (1.0 + MARGIN) * thickness;
        let range = first..first + positions.len();
        let stray = |(x, old): (&Vec4, &Vec4), (start, ahead): (&Vec3A, &Vec3A)| {
            Vec3A::from_vec4(*x * 2.0 - *old) + common - *start - (*ahead - *start) * share
        };
        let known = || positions.iter().zip(previous).zip(self.start[range.clone()].iter().zip(&self.ahead[range.clone()]));
        let mut far = Vec3A::ZERO;
        for (now, foreseen) in known() {
            let stray = stray(now, foreseen);
            far = far.max(stray * stray);
        }
        // The largest of each axis: no less than the farthest particle's.
        if far.element_sum() <= limit * limit {
            return false;
        }
        let mut any = false;
        for ((now, foreseen), astray) in known().zip(&mut self.astray[range.clone()]) {
            *astray = !(stray(now, foreseen).length_squared() <= limit * limit);
            any |= *astray;
        }
        any
    }

    /// Takes the motion of the last substep for that of the next frame, less what all cloths share.
    fn foresee(&mut self, surface: &Surface, moment: &Moment<'_>, dt: f32) {
        let substep = moment.substep;
        for (face, t) in self.faces.iter_mut().zip(&surface.topology.faces) {
            *face = Looked::at(t.map(|v| Vec3A::from_vec4(moment.positions[v as usize])), 0.0);
        }
        self.astray.fill(false);
        self.shifted.fill(false);
        let mut mean = Vec3A::ZERO;
        for ((part, &h), touch) in surface.parts.iter().zip(substep).zip(moment.touch) {
            let scale = if h > 0.0 { dt / h } else { 0.0 };
            for v in part.particles.start as usize..part.particles.end as usize {
                let motion = limited(foreseen(moment, v, scale, self.before[v], 1.0, touch.thickness), FARTHEST);
                self.start[v] = Vec3A::from_vec4(moment.positions[v]);
                self.ahead[v] = self.start[v] + motion;
                mean += motion;
            }
        }
        mean /= surface.len().max(1) as f32;
        // Cloth that hardly moves is looked at as it is, so that the look holds longer.
        let hardly = HARDLY * moment.touch.iter().map(|t| t.thickness).fold(f32::INFINITY, f32::min);
        if mean.length_squared() <= hardly * hardly {
            mean = Vec3A::ZERO;
        }
        self.shared = mean;
        let longest = FARTHEST_EDGES * surface.mean_edge + FARTHEST_THICKNESSES * moment.thickest();
        let mut sum = 0.0;
        for (ahead, &start) in self.ahead.iter_mut().zip(&self.start) {
            let motion = *ahead - start - mean;
            sum += motion.length();
            *ahead = start + limited(motion, longest);
        }
        self.haste = if dt > 0.0 { sum / (surface.len().max(1) as f32 * dt) } else { 0.0 };
    }
}

/// The motion of particle `v` until the next look `[m]`: that of the last substep times `scale`. Where constraints pull against each other
/// the last substep tells nothing: what is as good as where it was `before` moves on as it did since, `ahead` times as far.
#[inline]
fn foreseen(moment: &Moment<'_>, v: usize, scale: f32, before: Vec3A, ahead: f32, thickness: f32) -> Vec3A {
    let motion = Vec3A::from_vec4(moment.positions[v] - moment.previous[v]) * scale;
    let way = Vec3A::from_vec4(moment.positions[v]) - before;
    let still = (STILL * thickness).powi(2).min(STUCK * STUCK * motion.length_squared());
    // Not a number where nothing is known.
    if way.length_squared() < still { way * ahead } else { motion }
}

/// A motion no longer than `longest` `[m]`: of what goes farther, the rest is looked for when it gets there.
fn limited(motion: Vec3A, longest: f32) -> Vec3A {
    let motion = motion.clamp_length_max(longest);
    if motion.is_finite() { motion } else { Vec3A::ZERO }
}

/// The corners of a face, each with the next.
const CYCLE: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// As `map`, which is not always inlined.
#[inline(always)]
fn corners<T: Copy, U>([a, b, c]: [T; 3], of: impl Fn(T) -> U) -> [U; 3] {
    [of(a), of(b), of(c)]
}

/// Where a particle is, and where it is foreseen to be `[m]`.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Path {
    now: Vec3A,
    ahead: Vec3A,
}

impl Path {
    #[inline]
    fn bounds(self) -> Bounds {
        Bounds { min: self.now.min(self.ahead), max: self.now.max(self.ahead) }
    }
}

/// How far two faces are apart along the line between their centres, now and ahead, times its length `[m²]`.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Gaps {
    now: f32,
    ahead: f32,
    /// Square of that length `[m²]`.
    square: f32,
}

impl Gaps {
    #[inline]
    fn between(f: &[Path; 3], g: &[Path; 3]) -> Self {
        let axis = (f[0].now + f[1].now + f[2].now) - (g[0].now + g[1].now + g[2].now);
        let apart = |of: fn(&Path) -> Vec3A| {
            let origin = of(&g[0]);
            let along = |p: &Path| (of(p) - origin).dot(axis);
            along(&f[0]).min(along(&f[1])).min(along(&f[2])) - along(&g[1]).max(along(&g[2])).max(0.0)
        };
        Self { now: apart(|p| p.now), ahead: apart(|p| p.ahead), square: axis.length_squared() }
    }

    /// Whether a gap is wider than `reach` `[m]`.
    #[inline]
    fn exceed(&self, reach: f32, gap: f32) -> bool {
        gap > 0.0 && gap * gap > reach * reach * self.square
    }
}

/// Whether the lines of two edges come closest inside both, or may do so soon. Where they never do, a particle is closer.
fn may_pass([p, q]: [Path; 2], [r, s]: [Path; 2]) -> bool {
    let (u, v, w) = (q.now - p.now, s.now - r.now, p.now - r.now);
    let (a, b, c, d, e) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let det = a * c - b * b;
    let motion = 0.5 * ((p.ahead - p.now) + (q.ahead - q.now) - (r.ahead - r.now) - (s.ahead - s.now));
    let slack = SLACK + (motion.length_squared() / a.min(c)).sqrt();
    let inside = |x: f32| (x - 0.5 * det).abs() <= (0.5 + slack) * det;
    // Edges that are almost parallel may pass anywhere.
    !(det > 1.0e-3 * a * c) || (inside(b * e - c * d) && inside(a * e - b * d))
}

#[cfg(test)]
mod tests {
    use glam::{Quat, vec3};

    use super::*;

    #[test]
    fn a_face_has_turned_by_its_normal_or_when_nobody_can_tell() {
        let corners = [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.3, 0.6, 0.0)].map(Vec3A::from);
        let face = Looked::at(corners, 0.0);
        assert!((face.height - 0.6).abs() < 1e-6, "{}", face.height);
        let by = |angle: f32| corners.map(|x| Vec3A::from(Quat::from_rotation_y(angle) * Vec3::from(x)));
        let asked = |drift: f32, now: f32, there: f32| face.has_turned(drift, || by(now), || by(there));
        assert!(!asked(0.2, 0.15, -0.15));
        assert!(asked(0.2, 0.25, 0.0) && asked(0.2, 0.0, -0.25), "now, or soon");
        assert!(asked(0.2, 3.1, 0.0), "turned over");
        assert!(!asked(0.059, 1.0, 1.0), "what hardly moved is not asked");
        assert!(asked(0.31, 0.0, 0.0), "what moved by half of its height is not known any more");
        assert!(asked(f32::NAN, 0.0, 0.0) && asked(0.2, f32::NAN, 0.0));
        let drifted = Looked::at(corners, 0.1);
        assert!(drifted.has_turned(0.059, || by(0.25), || corners), "nor is what had drifted before, known not to have moved");
        assert!(Looked::at([corners[0]; 3], 0.0).has_turned(0.1, || corners, || corners), "a face without area");
    }
}
