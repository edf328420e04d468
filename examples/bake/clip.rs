//! What a clip does to a cloth.

use std::collections::BTreeSet;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_drape::ClothSkinQuery;
use bevy_drape::prelude::*;
use bevy_drape::solver::rest::RestShape;
use serde_json::{Value, json};

/// What is asked after every frame.
pub type Asked<'w, 's> = (
    Query<'w, 's, (&'static ClothRest, &'static ClothMaterial, &'static ClothParticles, &'static ClothReport)>,
    ClothSkinQuery<'w, 's>,
);

/// Time in which a cloth falls into shape [s]: it begins as its skin, wherever that is.
const SETTLES: f64 = 0.5;

/// The worst of something, and where it was.
#[derive(Clone, Debug, Default)]
struct Worst {
    value: f32,
    frame: u32,
    /// Vertices of the mesh.
    vertices: Vec<u32>,
    /// All particles or edges that it concerns.
    all: BTreeSet<usize>,
}

impl Worst {
    fn note(&mut self, value: f32, frame: u32, vertices: impl FnOnce() -> Vec<u32>) {
        if value > self.value {
            (self.value, self.frame, self.vertices) = (value, frame, vertices());
        }
    }
}

/// What a clip did to a cloth, frame by frame.
pub struct Clip {
    cloth: Entity,
    name: String,
    clip: String,
    frames: u32,
    free: usize,
    edges: usize,
    strain_limit: f32,
    /// Free particles whose place on the skin is in a body, by depth [m].
    inside: Worst,
    /// Edges that the skin stretches beyond the strain limit, by length over length at rest.
    stretched: Worst,
    /// Free particles that are in a body once they have settled, by depth [m].
    sunk: Worst,
    worst_edge: f32,
    held: u32,
    tangled: u32,
    crossings: u32,
    recoveries: u32,
}

impl Clip {
    pub fn new(cloth: Entity, name: &str, clip: &str) -> Self {
        Self {
            cloth,
            name: name.into(),
            clip: clip.into(),
            frames: 0,
            free: 0,
            edges: 0,
            strain_limit: 0.0,
            inside: Worst::default(),
            stretched: Worst::default(),
            sunk: Worst::default(),
            worst_edge: 0.0,
            held: 0,
            tangled: 0,
            crossings: 0,
            recoveries: 0,
        }
    }

    /// Takes in the last frame.
    pub fn look(&mut self, (cloths, skins): &Asked, frame: u32, fps: f64) {
        let Ok((rest, material, particles, report)) = cloths.get(self.cloth) else { return };
        let shape = rest.shape();
        let is_free: Vec<bool> = particles.state().positions.iter().map(|x| x.w > 0.0).collect();
        self.frames += 1;
        self.free = is_free.iter().filter(|free| **free).count();
        (self.edges, self.strain_limit) = (shape.topology.edges.len(), material.strain_limit);
        self.worst_edge = self.worst_edge.max(report.worst_edge);
        self.held += u32::from(report.held);
        self.tangled += u32::from(report.crossings > 0);
        self.crossings = self.crossings.max(report.crossings);
        self.recoveries = report.restores + report.resets;

        let places: Vec<DVec3> = skins.places(self.cloth).into_iter().flatten().collect();
        let depths = |points: Vec<DVec3>| skins.depths(self.cloth, points).unwrap_or_default();
        let deep = |worst: &mut Worst, depths: &[f32]| {
            let found = depths.iter().enumerate().filter(|(i, depth)| **depth > 0.0 && is_free.get(*i) == Some(&true));
            for (i, &depth) in found {
                worst.all.insert(i);
                worst.note(depth, frame, || vec![vertex_of(shape, i)]);
            }
        };
        deep(&mut self.inside, &depths(places.clone()));
        if f64::from(frame) > SETTLES * fps {
            deep(&mut self.sunk, &depths(particles.world_positions().collect()));
        }
        for (edge, ends) in shape.topology.edges.iter().enumerate() {
            let [a, b] = ends.map(|end| end as usize);
            let (Some(p), Some(q)) = (places.get(a), places.get(b)) else { continue };
            let ratio = p.distance(*q) as f32 / shape.positions[a].distance(shape.positions[b]);
            if ratio > 1.0 + self.strain_limit {
                self.stretched.all.insert(edge);
                self.stretched.note(ratio, frame, || vec![vertex_of(shape, a), vertex_of(shape, b)]);
            }
        }
    }

    /// As JSON.
    pub fn describe(&self) -> Value {
        let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        let deep = |worst: &Worst| {
            json!({
                "vertices": worst.all.len(),
                "share": share(worst.all.len(), self.free),
                "worst_depth": worst.value,
                "worst_frame": worst.frame,
                "worst_vertex": worst.vertices.first(),
            })
        };
        json!({
            "cloth": self.name,
            "clip": self.clip,
            "frames": self.frames,
            "free_vertices": self.free,
            "skin_in_bodies": deep(&self.inside),
            "skin_stretched": {
                "strain_limit": self.strain_limit,
                "edges": self.stretched.all.len(),
                "share": share(self.stretched.all.len(), self.edges),
                "worst_ratio": self.stretched.value,
                "worst_frame": self.stretched.frame,
                "worst_vertices": self.stretched.vertices,
            },
            "cloth_in_bodies": deep(&self.sunk),
            "worst_edge": self.worst_edge,
            "held_frames": self.held,
            "crossing_frames": self.tangled,
            "most_crossings": self.crossings,
            "recoveries": self.recoveries,
        })
    }
}

/// The first vertex of the mesh that a particle moves.
fn vertex_of(shape: &RestShape, particle: usize) -> u32 {
    let at = shape.particle_of_vertex.iter().position(|&p| p as usize == particle);
    at.and_then(|vertex| u32::try_from(vertex).ok()).unwrap_or(u32::MAX)
}
