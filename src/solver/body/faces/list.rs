//! Which faces of a cloth, and which of their pieces, lie in a box.

use glam::{Vec3, Vec4};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose;
use parry3d::shape::{Shape, SharedShape};

use super::piece::Piece;
use super::{Candidate, FaceContacts, SHARE};
use crate::solver::body::feature_edges::{self, FeatureEdge};
use crate::solver::body::respond::Plane;
use crate::solver::topology::Topology;

/// Faces whose boxes are looked at as one.
const BLOCK: usize = 16;
/// Pairs listed for each face and its edges, at most: what comes on top, where a fine mesh goes by fast, is left to particles.
const MOST: usize = 64;

/// What [`FaceContacts::gather`] has to know of a cloth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sheet<'a> {
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
    /// Lists the faces near the sharp edges of a surface that goes from one pose to another.
    pub(super) fn list_feature_edges(
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
        // What is farther than numbers reach meets nothing.
        if !(near.mins.is_finite() && near.maxs.is_finite()) {
            return;
        }
        let flat = feature_edges::flat(sheet.longest_edge, (1.0 - SHARE) * keep);
        let first = self.feature_edges.len();
        self.edge_cache.near(part, &near, flat, &mut self.feature_edges);
        for k in first..self.feature_edges.len() {
            let FeatureEdge { a, b } = self.feature_edges[k];
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

    /// Lists the faces whose boxes meet a box. With `whole`, each face is listed as a whole for that feature edge, 0 for a part
    /// without edges. For other parts, the edges of the faces are listed, then what lies between their edges.
    pub(super) fn list(&mut self, sheet: &Sheet<'_>, whole: Option<u32>, low: Vec3, high: Vec3) {
        let topology = sheet.topology;
        if let Some(feature_edge) = whole {
            self.list_faces(sheet, low, high, |face, of| of(Piece::Whole, topology.faces[face as usize], feature_edge));
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

    /// Lists those `pieces` of the faces whose boxes meet a box that do so themselves: piece, particles and feature edge.
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
                    pieces(face, &mut |piece, particles, feature_edge| {
                        if free(&particles) && (piece >= Piece::Within || meets(sheet.bounds(&[particles]))) {
                            candidates.push(Candidate::new(face, piece, feature_edge, particles));
                        }
                    });
                }
            }
        }
    }
}

impl Candidate {
    fn new(face: u32, piece: Piece, feature_edge: u32, particles: [u32; 3]) -> Self {
        let (side, corners) = (Vec3::ZERO, [Vec3::ZERO; 3]);
        Self {
            face,
            piece,
            feature_edge,
            corner: particles[0],
            particles,
            load: 0.0,
            floor: 0.0,
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
}
