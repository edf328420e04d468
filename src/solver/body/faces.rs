//! Faces of cloth against bodies that are finer than the mesh: a needle between particles, a corner, a ball smaller than a face.
//!
//! ```text
//!      o-----------o      particles at the distance kept: enough while the sagitta e² / 8 R of an edge e over a radius R is small
//!     /     .-.     \
//!    /    .'   '.    \    n: normal of the part at the point p = Σ wᵢ xᵢ of the face that is nearest to it, d: distance there
//!   o----/-------\----o
//!       /  body   \       Δxᵢ = wᵢ mᵢ⁻¹ Δp / Σ wⱼ² mⱼ⁻¹
//! ```
//!
//! *Edges* that cross the edge of a box meet it at a point that stays where it is, the nearest point of a face there jumps from one of them to the other.
//! So the edges of faces are looked at by themselves, and their nearest points pushed; faces then only where they are touched between their edges.
//! Two sheets over a box come to rest with it, and shook without **`[measured]`**. Balls, capsules and creases meet whole faces, where it is no
//! better, and so does what is thinner than an edge of cloth: it might slip between them **`[measured: needles did]`**.
//!
//! Parts that are round enough for the mesh have no faces listed and cost nothing. For the others a face is kept at [`SHARE`] of the
//! distance that particles keep, so that what lies flat is carried by its particles alone. Most faces are passed over by one sample at the
//! middle: a convex part lies behind its tangent plane, and a face that begins and ends in front of that never met it.
//!
//! *Nothing passes.* A face that was outside and may have gone through is stopped where it first touches, whatever its speed
//! ([`first_touch`]); it starts each substep outside, hence stays there. *A side is kept.* Where other causes moved it onto the part (cloth
//! that pushes cloth, overlong edges, tangles taken apart), the normal it last had tells where it belongs: it is brought back along that,
//! at the speed of particles that start inside. The shortest way out of a needle is sideways, and cloth with a needle in it cannot go
//! there.
//!
//! *Surfaces* of triangles are looked at by particles for their triangles and here for their sharp edges ([`Creases`]), each as a convex
//! part of its own.
//!
//! *Between two parts* that leave no room for twice the distance kept, a face goes to the middle, instead of being pushed to and fro.
//!
//! The nearest point of a face and a distance field: Macklin et al. 2020, "Local optimization for robust signed distance field collision".

use glam::{Vec3, Vec3A, Vec4};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose;
use parry3d::shape::{Shape, SharedShape, TypedShape};

use super::advance::{first_touch, longest_way};
use super::creases::{self, Crease, Creases};
use super::distance::Sample;
use super::geometry::{self, Geometry};
use super::laid::{Grounds, Laid};
use super::motion::{Motion, Yielding, farthest_push, finite_or_zero, swept_box, valid};
use super::nearest::{Convex, Face, Near, at, to_point};
use super::respond::{BAND, Friction, Plane, RECOVERY_SPEED, respond};
use super::room::Rooms;
use super::sweep::{SLIDES, plane_at};
use super::{Body, Touch};
use crate::solver::couple::Coupling;
use crate::solver::rest::Topology;

/// Distance that faces keep, as a share of what particles keep (dimensionless). Nearer 1 cloth lies more evenly on fine bodies and more
/// faces have to be asked for.
const SHARE: f32 = 0.5;
/// Faces whose boxes are looked at as one.
const BLOCK: usize = 16;
/// How far back a face that was moved onto a part is looked for along its last normal: this many times twice as far, beginning with the
/// distance kept.
const DOUBLINGS: u32 = 8;
/// Tangent planes that are tried before the nearest point is asked for.
const PLANES: u32 = 4;
/// How much nearer another point may be than the nearest, as a share of its distance (dimensionless).
const EXACT: f32 = 0.02;
/// Least mobility of the nearest point, as a share of that of the lightest corner: a face that hangs by a corner from two that are held is
/// not levered.
const LEAST_MOBILITY: f32 = 0.05;
/// Least weight of every corner of a face that is touched between its edges (dimensionless).
const WITHIN: f32 = 0.02;
/// Farthest corner that is looked at `[m]`.
const FARTHEST: f32 = 1.0e6;

/// Pairs listed for each face and its edges, at most: what comes on top, where a fine mesh goes by fast, is left to particles.
const MOST: usize = 64;

/// Pieces of a face: its edges, and itself.
const PIECES: u32 = 4;
/// How far from its edges a face is touched between them, at least, in distances that it keeps (dimensionless): they reach farther than that.
const OWN: f32 = 0.5;

/// What of a face is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Piece {
    /// One of its edges, by number: a face whose third corner is its second.
    Edge(u8),
    /// What lies between its edges.
    Within,
    /// All of it.
    Whole,
}

impl Piece {
    /// Those of the three particles that count.
    fn of(self, particles: &[u32; 3]) -> &[u32] {
        if let Self::Edge(_) = self { &particles[..2] } else { particles }
    }

    /// Weights of its middle.
    fn middle(self) -> [f32; 3] {
        if let Self::Edge(_) = self { [0.5, 0.5, 0.0] } else { [1.0 / 3.0; 3] }
    }

    /// Its place among the pieces of all faces.
    fn place(self, face: u32) -> u32 {
        PIECES * face + if let Self::Edge(k) = self { u32::from(k) } else { PIECES - 1 }
    }
}

/// A face, or a piece of one, that may meet a part of a body in this frame.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    face: u32,
    piece: Piece,
    /// Which of the creases of a surface; of no meaning for a convex part.
    crease: u32,
    /// Corner nearest to the touch.
    corner: u32,
    particles: [u32; 3],
    /// Running mean of the push per substep `[m]`; 0 out of contact.
    load: f32,
    /// What the push would be if that corner alone bore it (dimensionless).
    share: f32,
    /// The plane on which it was put when it last touched, in the space of the part, and weights of its point there.
    plane: Plane,
    weights: [f32; 3],
    /// Normal of the part where the face was last outside, in its own space; zero: not known.
    side: Vec3,
    /// On which side of the part it lay when last touched within it, by its own normal: 1, -1, or 0 when it did not.
    over: f32,
    /// Corners when a tangent plane was last found, in the part's own space `[m]`, and how far they may go until one has to be looked for again `[m]`.
    corners: [Vec3; 3],
    clear: f32,
    /// Whether a corner is pinned to a body.
    left_out: bool,
}

/// One convex shape or surface of a body, with the faces near it.
#[derive(Clone, Debug)]
struct Part {
    body: u32,
    index: u32,
    local: Pose,
    planes: (u32, u32),
    candidates: (u32, u32),
    radius: f32,
    /// Whether it could go through a face, being smaller.
    pierces: bool,
}

/// Faces of one cloth near bodies that are finer than its mesh. Buffers are reused: nothing is allocated once they are warm.
#[derive(Clone, Debug, Default)]
pub struct FaceContacts {
    parts: Vec<Part>,
    planes: Vec<Vec4>,
    candidates: Vec<Candidate>,
    /// Numbers of those that touched when last projected, in ascending order; nothing while nobody has asked.
    touching: Vec<u32>,
    is_listed: bool,
    /// Sharp edges of surfaces, in their own space; the first is that of convex parts, which have none.
    creases: Vec<Crease>,
    finder: Creases,
    parts_before: Vec<Part>,
    candidates_before: Vec<Candidate>,
    creases_before: Vec<Crease>,
    /// Boxes around faces, [`BLOCK`] at a time.
    blocks: Vec<(Vec3, Vec3)>,
    rooms: Rooms,
    dt: f32,
}

/// What [`FaceContacts::gather`] has to know of a cloth.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    /// Its faces and edges.
    pub topology: &'a Topology,
    /// Length of its longest edge `[m]`.
    pub longest_edge: f32,
    /// Positions `[m]` with inverse masses `[1/kg]`.
    pub positions: &'a [Vec4],
    /// Thickness of the fabric `[m]`.
    pub thickness: f32,
}

impl Sheet<'_> {
    /// Box around faces `[m]`.
    fn bounds(&self, faces: &[[u32; 3]]) -> (Vec3, Vec3) {
        let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &p in faces.iter().flatten() {
            if let Some(x) = self.positions.get(p as usize) {
                bounds = (bounds.0.min(x.truncate()), bounds.1.max(x.truncate()));
            }
        }
        bounds
    }
}

impl FaceContacts {
    /// Number of pairs of a face, or an edge of one, and a part of a body that are looked at in each substep of this frame.
    #[must_use]
    pub fn candidates(&self) -> usize {
        self.candidates.len()
    }

    /// Number of the body, particle and mean push per substep `[m]` of every touch when last projected, as if the nearest corner bore it alone.
    pub fn loads(&self) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        self.parts.iter().flat_map(|part| {
            let candidates = self.candidates.get(part.candidates.0 as usize..part.candidates.1 as usize).unwrap_or(&[]);
            candidates.iter().filter(|c| c.load > 0.0).map(|c| (part.body as usize, c.corner, c.load * c.share))
        })
    }

    /// Once per frame of `dt` `[s]`, before its first substep: lists the faces that could reach a part that is fine for them. `way`: bound on
    /// the way of any particle `[m]`.
    pub fn gather(&mut self, bodies: &[Body], sheet: &Sheet<'_>, way: f32, dt: f32) {
        core::mem::swap(&mut self.parts, &mut self.parts_before);
        core::mem::swap(&mut self.candidates, &mut self.candidates_before);
        core::mem::swap(&mut self.creases, &mut self.creases_before);
        self.parts.clear();
        self.planes.clear();
        self.candidates.clear();
        self.is_listed = false;
        self.blocks.clear();
        self.creases.clear();
        self.creases.push(Crease::default());
        self.finder.begin();
        self.dt = dt;
        let passes = dt > 0.0;
        if !passes {
            return;
        }
        let thickness = finite_or_zero(sheet.thickness);
        let way = way + farthest_push(bodies);
        let mut known = 0;
        for (b, body) in (0_u32..).zip(bodies) {
            let (Some(from), Some(to)) = (valid(body.from), valid(body.to)) else {
                continue;
            };
            let keep = thickness + finite_or_zero(body.margin);
            let off = if body.rigid.is_some() { way } else { 0.0 };
            geometry::for_each_part(&*body.shape.0, |index, local, shape| {
                let Some(local) =
                    valid(local).filter(|_| is_fine(smallest_radius(shape), sheet.longest_edge, keep, body.rigid.is_some()))
                else {
                    return;
                };
                let (from, to) = (from * local, to * local);
                let (swept, bulge, radius) = swept_box(shape, &from, &to);
                let reach = way + off + keep + bulge;
                let first = self.candidates.len() as u32;
                if shape.as_support_map().is_some() {
                    self.list(
                        sheet,
                        (!has_wide_edges(shape, sheet.longest_edge)).then_some(0),
                        swept.mins - reach,
                        swept.maxs + reach,
                    );
                } else {
                    self.list_creases(sheet, (&body.shape, [b, index], shape), (&from, &to), reach, keep);
                }
                let candidates = (first, self.candidates.len() as u32);
                if candidates.1 == candidates.0 {
                    return;
                }
                while self.parts_before.get(known).is_some_and(|p| (p.body, p.index) < (b, index)) {
                    known += 1;
                }
                if let Some(before) = self.parts_before.get(known).filter(|p| (p.body, p.index) == (b, index)) {
                    let was = (&self.candidates_before[..], &self.creases_before[..]);
                    remember(was, before.candidates, &mut self.candidates[first as usize..], &self.creases);
                }
                let first_plane = self.planes.len() as u32;
                if let TypedShape::ConvexPolyhedron(polyhedron) = shape.as_typed_shape() {
                    geometry::hull_planes(polyhedron, &mut self.planes);
                }
                let planes = (first_plane, self.planes.len() as u32);
                let pierces = smallest_radius(shape) < sheet.longest_edge;
                self.parts.push(Part { body: b, index, local, planes, candidates, radius, pierces });
            });
        }
        self.rooms.begin(self.parts.len(), PIECES as usize * sheet.topology.faces.len());
    }

    /// Lists the faces near the sharp edges of a surface that goes from one pose to another.
    fn list_creases(
        &mut self,
        sheet: &Sheet<'_>,
        part: (&SharedShape, [u32; 2], &dyn Shape),
        (from, to): (&Pose, &Pose),
        reach: f32,
        keep: f32,
    ) {
        self.fill_blocks(sheet);
        let all = self.blocks.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), (c, d)| (a.min(*c), b.max(*d)));
        if !(all.0.cmple(all.1).all() && all.0.is_finite() && all.1.is_finite()) {
            return;
        }
        let cloth = Aabb::new(all.0 - reach, all.1 + reach);
        let near = cloth.transform_by(&from.inverse()).merged(&cloth.transform_by(&to.inverse()));
        let flat = creases::flat(sheet.longest_edge, (1.0 - SHARE) * keep);
        let first = self.creases.len();
        self.finder.near(part, &near, flat, &mut self.creases);
        for k in first..self.creases.len() {
            let Crease { a, b } = self.creases[k];
            let ends = [*from * a, *from * b, *to * a, *to * b];
            let low = ends.into_iter().fold(Vec3::INFINITY, Vec3::min);
            let high = ends.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
            self.list(sheet, Some(k as u32), low - reach, high + reach);
        }
    }

    fn fill_blocks(&mut self, sheet: &Sheet<'_>) {
        if self.blocks.is_empty() {
            self.blocks.extend(sheet.topology.faces.chunks(BLOCK).map(|faces| sheet.bounds(faces)));
        }
    }

    /// Particles of faces that touched when last projected.
    pub fn touching(&self) -> impl Iterator<Item = u32> + '_ {
        self.candidates.iter().filter(|c| c.load > 0.0).flat_map(|c| c.particles)
    }

    /// Lists the faces whose boxes meet a box: as a `whole` for that crease, 0 for a part without edges; for other parts their edges, then what is
    /// between.
    fn list(&mut self, sheet: &Sheet<'_>, whole: Option<u32>, low: Vec3, high: Vec3) {
        let topology = sheet.topology;
        if let Some(crease) = whole {
            self.list_faces(sheet, low, high, |face, of| of(Piece::Whole, topology.faces[face as usize], crease));
            return;
        }
        self.list_faces(sheet, low, high, |face, of| {
            for (k, &edge) in (0..).zip(&topology.face_edges[face as usize]) {
                let [a, b] = topology.edges[edge as usize];
                if topology.edge_faces[edge as usize][0] == face {
                    of(Piece::Edge(k), [a, b, b], 0);
                }
            }
        });
        self.list_faces(sheet, low, high, |face, of| of(Piece::Within, topology.faces[face as usize], 0));
    }

    /// Lists those `pieces` of the faces whose boxes meet a box that do so themselves: piece, particles and crease.
    fn list_faces(
        &mut self,
        sheet: &Sheet<'_>,
        low: Vec3,
        high: Vec3,
        pieces: impl Fn(u32, &mut dyn FnMut(Piece, [u32; 3], u32)),
    ) {
        self.fill_blocks(sheet);
        let Self { blocks, candidates, .. } = self;
        let meets = |(a, b): (Vec3, Vec3)| a.cmple(high).all() && b.cmpge(low).all();
        let free = |particles: &[u32]| particles.iter().any(|&p| sheet.positions.get(p as usize).is_some_and(|x| x.w > 0.0));
        let all = &sheet.topology.faces;
        for ((block, faces), first) in blocks.iter().zip(all.chunks(BLOCK)).zip((0_u32..).step_by(BLOCK)) {
            if !meets(*block) {
                continue;
            }
            for (&particles, face) in faces.iter().zip(first..) {
                if candidates.len() >= MOST * all.len() {
                    return;
                }
                if meets(sheet.bounds(&[particles])) {
                    pieces(face, &mut |piece, particles, crease| {
                        if free(&particles) && (piece >= Piece::Within || meets(sheet.bounds(&[particles]))) {
                            candidates.push(Candidate::new(face, piece, crease, particles));
                        }
                    });
                }
            }
        }
    }

    /// Takes out the faces of particles that are pinned to bodies, in ascending order.
    pub(crate) fn leave_out(&mut self, particles: &[u32]) {
        if particles.is_empty() {
            return;
        }
        self.is_listed = false;
        for candidate in &mut self.candidates {
            if candidate.particles.iter().any(|p| particles.binary_search(p).is_ok()) {
                (candidate.left_out, candidate.load) = (true, 0.0);
            }
        }
    }

    /// The same for faces as [`BodyContacts::lay`](super::BodyContacts::lay), after it.
    pub fn lay(&mut self, grounds: &mut Grounds<'_>, positions: &mut [Vec4], previous: &[Vec4], laid: &mut Laid) {
        if !self.is_listed {
            let touches = |c: &Candidate| c.load > 0.0 && !c.left_out;
            self.touching.clear();
            self.touching.extend((0..).zip(&self.candidates).filter(|(_, c)| touches(c)).map(|(k, _)| k));
            self.is_listed = true;
        }
        let mut touching = &self.touching[..];
        for part in &self.parts {
            let (here, others) = touching.split_at(touching.partition_point(|k| *k < part.candidates.1));
            touching = others;
            let Some(ground) = grounds.part(part.body, part.local, part.radius) else { continue };
            for candidate in here.iter().filter_map(|k| self.candidates.get(*k as usize)) {
                let Candidate { particles, weights, plane, load, .. } = candidate;
                let at = |of: &[Vec4]| particles.map(|p| of.get(p as usize).copied().unwrap_or(Vec4::NAN));
                let middle = |corners: [Vec4; 3]| (0..3).map(|i| Vec3A::from_vec4(corners[i]) * weights[i]).sum::<Vec3A>();
                let corners = at(positions);
                let ways = [middle(at(previous)), middle(corners)];
                let Some(way) = ground.way_out(*plane, *load, ways, SHARE * ground.keep) else { continue };
                let Some(mobility) = mobility(weights, &corners.map(|x| x.w)) else { continue };
                for ((&p, weight), x) in candidate.piece.of(particles).iter().zip(weights).zip(corners) {
                    laid.put(p, way * (weight * x.w / mobility), positions);
                }
            }
        }
    }

    /// Once per substep, after the particles: keeps faces out of parts. As [`BodyContacts::project`](super::BodyContacts::project); returns
    /// the number of touches.
    #[expect(clippy::too_many_arguments, reason = "arrays of a cloth and of a substep, which the frame keeps apart")]
    pub fn project(
        &mut self,
        bodies: &[Body],
        s0: f32,
        s1: f32,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        touch: &Touch,
        coupling: &mut Coupling,
    ) -> u32 {
        let h = (s1 - s0).max(0.0) * self.dt;
        let mut touches = 0;
        self.is_listed = false;
        self.rooms.advance();
        for (number, part) in (0_u32..).zip(&self.parts) {
            let Some(body) = bodies.get(part.body as usize) else {
                continue;
            };
            let Some(shape) = geometry::part(&*body.shape.0, part.index) else {
                continue;
            };
            let Some(candidates) = self.candidates.get_mut(part.candidates.0 as usize..part.candidates.1 as usize) else {
                continue;
            };
            let planes = self.planes.get(part.planes.0 as usize..part.planes.1 as usize).unwrap_or(&[]);
            let slot = body.rigid.and_then(|slot| coupling.slot_mut(slot));
            let mut motion = Motion::new(body, part.local, part.radius, s0, s1);
            if let Some(slot) = &slot {
                motion.follow(slot, part.radius);
            }
            let support = shape.as_support_map();
            let mut setting = Setting {
                part: Convex { geometry: Geometry::of(shape, planes), support },
                motion,
                radius: part.radius,
                pierces: part.pierces,
                number,
                keep: SHARE * touch.kept(body),
                recovery: RECOVERY_SPEED * h,
                friction: touch.friction(body),
            };
            let mut rigid = slot.filter(|_| h > 0.0).map(|slot| Yielding::new(slot, s1, h));
            for candidate in candidates.iter_mut().filter(|candidate| !candidate.left_out) {
                if support.is_none() {
                    setting.take(self.creases.get(candidate.crease as usize));
                }
                if setting.is_clear(candidate, positions) {
                    continue;
                }
                let load = candidate.load;
                let mut state = State { candidate, positions, previous, rigid: &mut rigid };
                let touched = setting.project(&mut state, &mut self.rooms);
                touches += u32::from(touched);
                if h == 0.0 {
                    // While no time passes loads stay.
                    state.candidate.load = load;
                } else if !touched {
                    state.candidate.load = 0.0;
                } else if let Some(rigid) = &rigid {
                    setting.motion.follow(rigid.slot, part.radius);
                }
            }
        }
        touches
    }
}

impl Candidate {
    fn new(face: u32, piece: Piece, crease: u32, particles: [u32; 3]) -> Self {
        let (side, corners) = (Vec3::ZERO, [Vec3::ZERO; 3]);
        Self {
            face,
            piece,
            crease,
            corner: particles[0],
            particles,
            load: 0.0,
            share: 0.0,
            plane: Plane::default(),
            weights: [0.0; 3],
            side,
            over: 0.0,
            corners,
            clear: f32::NEG_INFINITY,
            left_out: false,
        }
    }

    /// Notes where the face is outside.
    fn lies(&mut self, near: &Near, face: &Face) {
        self.side = near.sample.normal.into();
        if !matches!(self.piece, Piece::Edge(_)) && is_within(&near.weights) {
            self.over = near.sample.normal.dot(normal(face)).signum();
        }
    }

    /// Notes that the face is in front of the part, and that its corners may go as far as `clear` `[m]` from here.
    fn pass_by(&mut self, normal: Vec3A, clear: f32, corners: &Face) {
        if normal != Vec3A::ZERO {
            self.side = normal.into();
        }
        self.over = 0.0;
        (self.clear, self.corners) = (clear, corners.map(Vec3::from));
    }
}

/// Smallest radius of curvature of a shape `[m]`; infinite for those that faces are not looked at for.
fn smallest_radius(shape: &dyn Shape) -> f32 {
    match shape.as_typed_shape() {
        TypedShape::HalfSpace(_) => f32::INFINITY,
        TypedShape::Ball(ball) => ball.radius,
        TypedShape::Capsule(capsule) => capsule.radius,
        TypedShape::TriMesh(_) | TypedShape::HeightField(_) => 0.0,
        _ if shape.as_support_map().is_some() => 0.0,
        _ => f32::INFINITY,
    }
}

/// Whether a convex shape has edges or corners, and is wider than an edge of cloth `[m]` in every direction: what is not pierces faces.
fn has_wide_edges(shape: &dyn Shape, edge: f32) -> bool {
    let is_round = matches!(shape.as_typed_shape(), TypedShape::Ball(_) | TypedShape::Capsule(_));
    !is_round && shape.compute_local_aabb().half_extents().min_element() > 0.5 * edge
}

/// Whether particles alone would let a shape of that radius through a mesh with edges of `edge` `[m]` that is kept `keep` `[m]` away.
fn is_fine(radius: f32, edge: f32, keep: f32, yields: bool) -> bool {
    // One that cloth moves would not come to rest on faces: only what is smaller than they are.
    edge * edge > 8.0 * (radius + keep) * (1.0 - SHARE) * keep && (!yields || edge > radius)
}

/// Passes on what is known of faces that stay; both lists are in the order of creases, edges before what is between them, and faces.
fn remember(
    (before, creases_before): (&[Candidate], &[Crease]),
    (first, end): (u32, u32),
    now: &mut [Candidate],
    creases: &[Crease],
) {
    let key = |c: &Candidate, creases: &[Crease]| {
        (creases.get(c.crease as usize).map(Crease::key), c.piece >= Piece::Within, c.face, c.piece)
    };
    let mut before = before.get(first as usize..end as usize).unwrap_or(&[]).iter().peekable();
    for candidate in now {
        let wanted = key(candidate, creases);
        while before.next_if(|old| key(old, creases_before) < wanted).is_some() {}
        if let Some(old) = before.next_if(|old| key(old, creases_before) == wanted) {
            // The part may have become another one, or grown.
            let clear = f32::NEG_INFINITY;
            *candidate = Candidate { particles: candidate.particles, crease: candidate.crease, clear, left_out: false, ..*old };
        }
    }
}

/// Whether a point of a face lies between its edges.
fn is_within(weights: &[f32; 3]) -> bool {
    weights.iter().all(|w| *w > WITHIN)
}

/// Unit normal; zero without area.
fn normal(face: &Face) -> Vec3A {
    (face[1] - face[0]).cross(face[2] - face[0]).normalize_or_zero()
}

/// Corners at both ends of the substep, in the part's own space `[m]`, and inverse masses `[1/kg]`.
struct Way {
    from: Face,
    to: Face,
    masses: [f32; 3],
}

/// What tangent planes tell of a face.
enum Pass {
    /// It never met the part; a normal there, and its least height over the plane `[m]`.
    By(Vec3A, f32),
    /// Its nearest point at the end.
    Near(Near),
    /// Nothing; about where it lies.
    Unsure(Vec3A),
}

/// Everything that is the same for all faces near one part in one substep.
struct Setting<'a> {
    part: Convex<'a>,
    motion: Motion,
    radius: f32,
    pierces: bool,
    /// Place of the part among the parts.
    number: u32,
    /// Distance kept `[m]`.
    keep: f32,
    /// Way that an overlap is recovered in the substep `[m]`.
    recovery: f32,
    friction: Friction,
}

impl Setting<'_> {
    /// Looks at a crease from now on: a capsule without radius.
    fn take(&mut self, crease: Option<&Crease>) {
        let Some(&Crease { a, b }) = crease else { return };
        let ab = Vec3A::from(b - a);
        let length2 = ab.length_squared();
        let inverse_length2 = if length2 > 1.0e-20 { 1.0 / length2 } else { 0.0 };
        self.part.geometry = Geometry::Capsule { a: a.into(), ab, inverse_length2, radius: 0.0 };
    }

    /// `None` for corners that are left out or not numbers.
    #[inline]
    fn way(&self, particles: [u32; 3], positions: &[Vec4], previous: &[Vec4]) -> Option<Way> {
        let mut way = Way { from: [Vec3A::ZERO; 3], to: [Vec3A::ZERO; 3], masses: [0.0; 3] };
        for (i, p) in particles.into_iter().enumerate() {
            let (x, old) = (positions.get(p as usize)?, previous.get(p as usize)?);
            way.from[i] = self.motion.rotation0.transpose() * (Vec3A::from_vec4(*old) - self.motion.translation0);
            way.to[i] = self.motion.rotation1.transpose() * (Vec3A::from_vec4(*x) - self.motion.translation1);
            way.masses[i] = x.w;
            // False for what is not a number.
            let near = way.from[i].abs().max_element() < FARTHEST && way.to[i].abs().max_element() < FARTHEST;
            if !(near && way.from[i].is_finite() && way.to[i].is_finite()) {
                return None;
            }
        }
        Some(way)
    }

    /// Whether no corner has got far enough to touch.
    #[inline]
    fn is_clear(&self, candidate: &Candidate, positions: &[Vec4]) -> bool {
        let room = candidate.clear;
        // What touched has to be looked at until it does not.
        room > 0.0
            && candidate.load <= 0.0
            && candidate.particles.iter().zip(candidate.corners).all(|(&p, corner)| {
                // False for what is not a number.
                positions.get(p as usize).is_some_and(|x| {
                    let q = self.motion.rotation1.transpose() * (Vec3A::from_vec4(*x) - self.motion.translation1);
                    q.distance_squared(corner.into()) < room * room
                })
            })
    }

    /// Looks for a tangent plane of the part that leaves the way of a face in front of it: at the middle of the face, then at where the
    /// face is nearest to what was nearest to that, and so on.
    #[inline]
    fn pass(&self, way: &Way, mut weights: [f32; 3]) -> Pass {
        let Way { from, to, .. } = way;
        let middle = at(to, &weights);
        let reach = longest_way(to, &[middle; 3]) + longest_way(from, to) + self.keep;
        let mut towards = Vec3A::ZERO;
        for _ in 0..PLANES {
            let point = at(to, &weights);
            let sample = self.part.geometry.sample(point, reach);
            let Sample { distance, normal } = sample;
            if normal == Vec3A::ZERO {
                return if distance >= reach { Pass::By(towards, f32::NEG_INFINITY) } else { Pass::Unsure(towards) };
            }
            towards = normal;
            let foot = normal.dot(point) - distance;
            let height = |face: &Face| face.iter().map(|x| normal.dot(*x) - foot).fold(f32::INFINITY, f32::min);
            let least = height(to);
            if least >= (1.0 + BAND) * self.keep && height(from) > 0.0 {
                return Pass::By(normal, least);
            }
            if !(distance > 0.0) {
                break;
            }
            // No point of the face can be nearer than its lowest corner is to the plane.
            if least >= (1.0 - EXACT) * distance {
                return Pass::Near(Near { weights, point, sample });
            }
            weights = to_point(to, point - normal * distance).0;
        }
        Pass::Unsure(towards)
    }

    /// Whether the face touched.
    fn project(&self, state: &mut State<'_, '_>, rooms: &mut Rooms) -> bool {
        let Some(mut way) = self.way(state.candidate.particles, state.positions, state.previous) else { return false };
        let (end, towards) = match self.pass(&way, state.candidate.piece.middle()) {
            Pass::By(normal, height) => {
                state.candidate.pass_by(normal, height - self.keep, &way.to);
                return false;
            }
            Pass::Near(near) => (Some(near), near.sample.normal),
            Pass::Unsure(towards) => (self.part.nearest(&way.to, towards), towards),
        };
        let nearest = |face: &Face| self.part.nearest(face, towards);
        let outside = |near: &Near| near.sample.distance > 0.0;
        let clear = end.filter(outside).is_some_and(|near| {
            let foot = near.sample.normal.dot(near.point) - near.sample.distance;
            way.from.iter().all(|x| near.sample.normal.dot(*x) > foot)
        });
        let keep = end.map_or(self.keep, |Near { sample, .. }| {
            let normal = self.motion.rotation1 * sample.normal;
            rooms.keep(state.candidate.piece.place(state.candidate.face), self.number, normal, sample.distance, self.keep)
        });
        if !clear && nearest(&way.from).as_ref().is_some_and(outside) {
            if let Some(touched) = self.stop(&nearest, keep, &mut way, state) {
                return touched;
            }
        } else if !clear {
            // What went into it within goes out through it, however it lies now.
            let Candidate { side, over, .. } = *state.candidate;
            let within = end.is_none() && over != 0.0;
            let side = if within { normal(&way.to) * over } else { Vec3A::from(side) };
            let known = side != Vec3A::ZERO;
            // Where the nearest point lies on its own side it is pushed out from there, and from round parts wherever it lies.
            let is_round = matches!(self.part.geometry, Geometry::Ball { .. } | Geometry::Capsule { .. });
            if known && end.is_none_or(|near| !is_round && near.sample.normal.dot(side) <= 0.0) {
                return self.bring_back(&nearest, side, &way, state);
            }
        }
        let Some(near) = end else { return false };
        if near.sample.distance > 0.0 {
            state.candidate.lies(&near, &way.to);
        }
        let gap = near.sample.distance - keep;
        let touches = gap < 0.0 || (state.candidate.load > 0.0 && gap < BAND * keep);
        touches && self.push(&near, plane_at(near.point, near.sample, keep), &mut way, state)
    }

    /// Whether a touch is for a piece to take: of what is between edges, what is not as near to one of them as it reaches itself.
    fn takes(&self, piece: Piece, weights: &[f32; 3], face: &Face) -> bool {
        let area = (face[1] - face[0]).cross(face[2] - face[0]).length();
        piece != Piece::Within
            || (0..3).all(|i| {
                let edge = (face[(i + 1) % 3] - face[(i + 2) % 3]).length();
                // wᵢ times the height over an edge is the distance from it.
                weights[i] > WITHIN || weights[i] * area > OWN * self.keep * edge
            })
    }

    /// Stops a face that starts outside where it touches, and lets it slide on from there. `None`: it touches nothing.
    fn stop(
        &self,
        nearest: &impl Fn(&Face) -> Option<Near>,
        keep: f32,
        way: &mut Way,
        state: &mut State<'_, '_>,
    ) -> Option<bool> {
        let mut start = way.from;
        let mut touched = None;
        for _ in 0..SLIDES {
            let Some((face, near)) = first_touch(nearest, &start, &way.to, keep) else { return touched };
            if !self.takes(state.candidate.piece, &near.weights, &face) {
                return touched;
            }
            state.candidate.lies(&near, &face);
            touched = Some(self.push(&near, plane_at(near.point, near.sample, keep), way, state));
            start = face;
        }
        if self.pierces && first_touch(nearest, &start, &way.to, keep).is_some() {
            // Wedged: it stays at the last place known to be outside. What is rounder than that gets no farther than particles let it.
            for (i, &p) in state.candidate.piece.of(&state.candidate.particles).iter().enumerate() {
                if way.masses[i] > 0.0
                    && let Some(x) = state.positions.get_mut(p as usize)
                {
                    let by = self.motion.rotation1 * (start[i] - way.to[i]);
                    *x += by.extend(0.0);
                    if let Some(rigid) = &mut *state.rigid {
                        rigid.react(Vec3A::from_vec4(*x), by / way.masses[i]);
                    }
                }
            }
            if let Some(rigid) = &mut *state.rigid {
                rigid.give_now();
            }
        }
        touched
    }

    /// Brings a face back to the side that it was on, from wherever something moved it to.
    fn bring_back(&self, nearest: &impl Fn(&Face) -> Option<Near>, side: Vec3A, way: &Way, state: &mut State<'_, '_>) -> bool {
        let mut off = 2.0 * self.keep;
        for _ in 0..DOUBLINGS {
            let before = way.to.map(|x| x + side * off);
            if nearest(&before).is_some_and(|near| near.sample.distance > 0.0 && near.sample.normal.dot(side) > 0.0) {
                return first_touch(nearest, &before, &way.to, self.keep).is_some_and(|(face, near)| {
                    let mut way = Way { ..*way };
                    // Back the way it came, not off the surface: it may be steep.
                    let plane = Plane { normal: side, offset: side.dot(at(&face, &near.weights)) };
                    self.push(&near, plane, &mut way, state)
                });
            }
            off *= 2.0;
            if off > 4.0 * self.radius {
                break;
            }
        }
        false
    }

    /// Pushes the nearest point of a face out, with friction, and shares that out by mass; whether anything could.
    fn push(&self, near: &Near, plane: Plane, way: &mut Way, state: &mut State<'_, '_>) -> bool {
        let State { candidate, positions, previous, rigid } = state;
        if !self.takes(candidate.piece, &near.weights, &way.to) {
            return false;
        }
        let w = near.weights;
        let Some(mobility) = mobility(&w, &way.masses) else { return false };
        let (start, end) = (at(&way.from, &w), at(&way.to, &w));
        let place = |q: Vec3A| self.motion.rotation1 * q + self.motion.translation1;
        let friction = match rigid {
            Some(rigid) if rigid.is_movable() => {
                self.friction.times(rigid.slide(mobility, place(end), self.motion.rotation1 * plane.normal))
            }
            _ => self.friction,
        };
        let response = respond(plane, start, end, end, self.recovery, candidate.load, friction, 0.0);
        let mut by = self.motion.rotation1 * (response.end - end);
        let mut silent = self.motion.rotation0 * response.shift;
        if !(by.is_finite() && silent.is_finite()) {
            return false;
        }
        if let Some(rigid) = rigid
            && by != Vec3A::ZERO
        {
            // Faces share particles: one after the other, and the body moves with each.
            (by, silent) = rigid.split(mobility, place(response.end), by, silent);
            rigid.give_now();
        }
        (candidate.load, candidate.plane, candidate.weights) = (response.load, plane, w);
        let mut most = 0.0;
        for (i, &p) in candidate.particles.iter().enumerate() {
            let share = w[i] * way.masses[i] / mobility;
            let (Some(x), Some(old)) = (positions.get_mut(p as usize), previous.get_mut(p as usize)) else { continue };
            *x += (by * share).extend(0.0);
            *old += (silent * share).extend(0.0);
            way.to[i] += self.motion.rotation1.transpose() * (by * share);
            way.from[i] += self.motion.rotation0.transpose() * (silent * share);
            if w[i] > most && way.masses[i] > 0.0 {
                // M C = m c: the same impulse from the corner alone.
                (most, candidate.corner, candidate.share) = (w[i], p, way.masses[i] / mobility);
            }
        }
        if let Piece::Edge(_) = candidate.piece {
            (way.to[2], way.from[2]) = (way.to[1], way.from[1]);
        }
        true
    }
}

/// How far a unit push moves the point with these weights `[1/kg]`; nothing where that is too little for it to be pushed.
fn mobility(weights: &[f32; 3], masses: &[f32; 3]) -> Option<f32> {
    let mobility: f32 = weights.iter().zip(masses).map(|(weight, mass)| weight * weight * mass).sum();
    let lightest = masses.iter().copied().fold(0.0, f32::max);
    // NaN passes no comparison.
    (mobility > LEAST_MOBILITY * lightest).then_some(mobility)
}

/// What a push changes.
struct State<'a, 'b> {
    candidate: &'a mut Candidate,
    positions: &'a mut [Vec4],
    previous: &'a mut [Vec4],
    rigid: &'a mut Option<Yielding<'b>>,
}
