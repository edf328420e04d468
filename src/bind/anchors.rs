//! From pins on vertices of a mesh to anchors of particles.

use bevy::math::{Affine3A, DVec3, Mat3, Vec3A, Vec4};
use bevy::prelude::*;

use super::paint::{attribute, color};
use super::placement::seen_from;
use super::{Authored, Placement};
use crate::components::{ClothError, ClothErrorKind, ClothPinSelect, ClothPins};
use crate::solver::anchors::{Anchors, RIGID};
use crate::solver::rest::RestShape;
use crate::solver::scales::RESPONSE_TIME;

/// What holds the anchors.
#[derive(Clone, Debug, Default)]
pub(crate) struct AnchorSets {
    pub sets: Vec<AnchorSet>,
    /// Set of each anchor.
    pub set_of: Vec<u32>,
    /// Position of each anchor `[m]`, in the space that its set moves.
    pub local: Vec<Vec3>,
    /// Weight that each anchor is to have (dimensionless, 0 to 1).
    pub weights: Vec<f32>,
}

/// One pin set and its target.
#[derive(Clone, Debug)]
pub(crate) struct AnchorSet {
    /// None: the cloth's own entity, or its skin.
    pub target: Option<Entity>,
    /// Where the cloth was, as seen from the target, when the two were joined: the target moves this space.
    pub relation: Affine3A,
    /// Where the target was last, in the world.
    pub at: Affine3A,
    /// Whether the target is gone.
    pub lost: bool,
    /// Whether the set was let go.
    pub released: bool,
}

impl AnchorSet {
    /// Held by the cloth's own entity or skin.
    pub(crate) fn own(placement: &Placement) -> Self {
        let at = Affine3A::from_rotation_translation(placement.rotation, placement.translation);
        Self { target: None, relation: Affine3A::IDENTITY, at, lost: false, released: false }
    }

    /// Held by another entity, which is at `affine` while the cloth is at `placement`.
    pub(crate) fn new(target: Entity, affine: &Affine3A, placement: &Placement) -> Self {
        let own = Self::own(placement);
        // Differences first: far from the origin the two translations are large and close together.
        let offset = (placement.translation.as_dvec3() - Vec3::from(affine.translation).as_dvec3()).as_vec3();
        let inverse = affine.matrix3.inverse();
        let relation = Affine3A { matrix3: inverse * own.at.matrix3, translation: inverse * Vec3A::from(offset) };
        Self { target: Some(target), relation, at: *affine, ..own }
    }

    /// The space of the anchors as seen from `origin`.
    pub(crate) fn space_from(&self, origin: DVec3) -> Affine3A {
        seen_from(&self.at, origin) * self.relation
    }
}

/// Which particles are held, how firmly and by which set.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Resolved {
    pub particles: Vec<u32>,
    pub weights: Vec<f32>,
    pub set_of: Vec<u32>,
    /// Vertices that the mesh does not have.
    pub bad_pins: Vec<u32>,
}

/// Resolves pins on a mesh; sets for which `released` holds are left out.
pub(crate) fn resolve(
    pins: &ClothPins,
    released: impl Fn(usize) -> bool,
    mesh: &Mesh,
    authored: &Authored,
    rest: &RestShape,
) -> Result<Resolved, ClothError> {
    let mut held: Vec<(f32, u32)> = vec![(0.0, 0); rest.positions.len()];
    let isolated: Vec<u32> = rest.isolated.iter().map(|(v, _)| *v).collect();
    let mut resolved = Resolved::default();
    for (s, set) in pins.sets.iter().enumerate().filter(|(s, _)| !released(*s)) {
        // Vertices that went into another, with what they would hold.
        let mut gone: Vec<(u32, f32)> = Vec::new();
        let mut hold = |vertex: u32, weight: f32| {
            let Some(&particle) = rest.particle_of_vertex.get(vertex as usize) else {
                resolved.bad_pins.push(vertex);
                return;
            };
            // A NaN stays one and holds nothing.
            let weight = (weight * set.weight).clamp(0.0, 1.0);
            if rest.is_gone(vertex) {
                gone.push((particle, weight));
                return;
            }
            let best = &mut held[particle as usize];
            if weight > best.0 && isolated.binary_search(&vertex).is_err() {
                *best = (weight, s as u32);
            }
        };
        match &set.select {
            ClothPinSelect::Vertices(vertices) => vertices.iter().for_each(|&v| hold(v, 1.0)),
            ClothPinSelect::Weighted(weights) => weights.iter().for_each(|&(v, w)| hold(v, w)),
            ClothPinSelect::Position(predicate) => {
                (0..).zip(&authored.positions).filter(|(_, p)| predicate.holds(**p)).for_each(|(v, _)| hold(v, 1.0));
            }
            ClothPinSelect::Color(channel) => (0..).zip(color(mesh, *channel).map_err(no_paint)?).for_each(|(v, w)| hold(v, w)),
            ClothPinSelect::Attribute(name) => {
                (0..).zip(attribute(mesh, name).map_err(no_paint)?).for_each(|(v, w)| hold(v, w));
            }
        }
        // They hold where nothing beside is held: what stands for a row of pins holds it.
        for (particle, weight) in gone.into_iter().filter(|(_, weight)| *weight > 0.0) {
            let beside = rest.topology.around(particle).iter().map(|(p, _)| *p);
            if beside.chain([particle]).all(|p| held[p as usize].0 == 0.0) {
                held[particle as usize] = (weight, s as u32);
            }
        }
    }
    resolved.bad_pins.sort_unstable();
    resolved.bad_pins.dedup();
    for (particle, &(weight, set)) in (0..).zip(&held).filter(|(_, (w, _))| *w > 0.0) {
        resolved.particles.push(particle);
        resolved.weights.push(weight);
        resolved.set_of.push(set);
    }
    Ok(resolved)
}

fn no_paint(reason: String) -> ClothError {
    ClothError { kind: ClothErrorKind::NoPinAttribute, detail: format!("its pins {reason}") }
}

/// Where anchors of a cloth that is already simulated stay: an old anchor keeps its place, a new one is held where its particle
/// is.
pub(crate) struct Continuing<'a> {
    pub sets: &'a AnchorSets,
    pub anchors: &'a Anchors,
    /// The old set that each new one goes on from.
    pub known: &'a [Option<usize>],
    /// Positions of the particles in the world, less `origin` `[m]`.
    pub positions: &'a [Vec4],
    pub origin: DVec3,
    /// From the old scale to the new one.
    pub rescale: Mat3,
}

impl Resolved {
    /// Holds particles rigidly, sorted, by the set with that number, except where a set holds them so already. Whether it holds
    /// any.
    pub(crate) fn pin(&mut self, particles: impl Iterator<Item = u32>, set: usize) -> bool {
        let mut any = false;
        for particle in particles {
            match self.particles.binary_search(&particle) {
                Ok(at) if self.weights[at] >= RIGID => continue,
                Ok(at) => (self.weights[at], self.set_of[at]) = (1.0, set as u32),
                Err(at) => {
                    self.particles.insert(at, particle);
                    self.weights.insert(at, 1.0);
                    self.set_of.insert(at, set as u32);
                }
            }
            any = true;
        }
        any
    }

    /// Anchors and the sets that hold them. Targets are filled in by the frame.
    pub(crate) fn into_anchors(
        self,
        sets: Vec<AnchorSet>,
        rest: &RestShape,
        before: Option<&Continuing<'_>>,
    ) -> (Anchors, AnchorSets) {
        let place = |(&particle, &set): (&u32, &u32)| {
            let at_rest = rest.positions[particle as usize];
            let Some(before) = before else { return (at_rest, None) };
            let old = before.anchors.particles.binary_search(&particle).ok();
            let held = old.and_then(|old| {
                Some((*before.sets.set_of.get(old)?, *before.sets.local.get(old)?, *before.anchors.to.get(old)?))
            });
            let known = before.known.get(set as usize).copied().flatten();
            if let Some((_, local, to)) = held.filter(|(of, ..)| known == Some(*of as usize)) {
                return (before.rescale * local, Some(to));
            }
            let now = held.map(|(.., to)| to).or_else(|| before.positions.get(particle as usize).map(|x| x.truncate()));
            let Some(now) = now else { return (at_rest, None) };
            let space = sets.get(set as usize).map(|s| s.space_from(before.origin).inverse());
            (space.map_or(at_rest, |space| space.transform_point3(now)), Some(now))
        };
        let places: Vec<(Vec3, Option<Vec3>)> = self.particles.iter().zip(&self.set_of).map(place).collect();
        let to: Vec<Vec3> = places.iter().map(|(local, to)| to.unwrap_or(*local)).collect();
        let local = places.into_iter().map(|(local, _)| local).collect();
        // What was held goes on as firmly as it was: what holds it at once where it was not would throw it.
        let weight = |(&particle, &wanted): (&u32, &f32)| {
            let before = before.map(|before| before.anchors);
            let old = before.and_then(|anchors| Some(anchors.weights[anchors.particles.binary_search(&particle).ok()?]));
            old.unwrap_or(wanted)
        };
        let now = self.particles.iter().zip(&self.weights).map(weight).collect();
        let anchors = Anchors { particles: self.particles, weights: now, from: to.clone(), to };
        (anchors, AnchorSets { sets, set_of: self.set_of, local, weights: self.weights })
    }
}

/// Moves weights towards those that anchors are to have, for `dt` `[s]`. Whether one moved, and whether one became rigid or
/// ceased to be.
pub(crate) fn ramp_weights(anchors: &mut Anchors, wanted: &[f32], dt: f32) -> [bool; 2] {
    let step = (dt / RESPONSE_TIME).max(0.0);
    let (mut moved, mut turned) = (false, false);
    for (weight, &wanted) in anchors.weights.iter_mut().zip(wanted).filter(|(weight, wanted)| weight != wanted) {
        let was = *weight >= RIGID;
        *weight += (wanted - *weight).clamp(-step, step);
        moved = true;
        turned |= was != (*weight >= RIGID);
    }
    [moved, turned]
}
