//! Reports: read-only for users.

use std::borrow::Cow;

use bevy::prelude::*;

use super::ClothDetail;
use crate::solver::rest::BuildReport;

/// Report of the last simulated frame, and totals since the start.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothReport {
    /// Substeps taken in the last frame.
    pub substeps: u32,
    /// Inner steps in each of them: more than one where the edges of the mesh are short (see
    /// [`ClothSolver::inner_rate`](crate::ClothSolver::inner_rate)).
    pub inner_steps: u32,
    /// Steps per second `[Hz]` from which this mesh drapes as its fabric does, within three points of its drape coefficient. It
    /// is 11 m/s over the mean edge. With fewer any fabric hangs limper, since one pass over the membrane cannot carry tension
    /// through a fine mesh. Substeps and inner steps count.
    pub drape_rate: f32,
    /// Share of the bending stiffness that the substeps of the last frame held (dimensionless). It is below 1 where the mesh is
    /// very fine for them, or the fabric very stiff. A higher [`substep_rate`](crate::ClothSolver::substep_rate) holds more.
    pub bend_held: f32,
    /// Largest edge length over rest length (dimensionless).
    pub worst_edge: f32,
    /// Mean edge length over rest length (dimensionless).
    pub mean_edge: f32,
    /// Whether it sleeps: see [`ClothSleep`](crate::ClothSleep). Everything else is as of the last frame before, and its times
    /// are 0.
    pub asleep: bool,
    /// How much of its work was done, by [`ClothLod`](crate::ClothLod).
    pub detail: ClothDetail,
    /// The most that [`ClothBudget`](crate::ClothBudget) leaves of it.
    pub by_budget: ClothDetail,
    /// Whether its frames run in the background, by [`ClothBudget`](crate::ClothBudget): one takes longer, or nobody knows yet.
    /// Then what a frame did, and the times of its stages, are those of the last frame that is done there.
    pub in_background: bool,
    /// Particles, and faces held by what is finer than the mesh, that touched a body at the end of the frame.
    pub body_contacts: u32,
    /// Bodies that could touch the cloth.
    pub bodies: u32,
    /// Particles that are pinned.
    pub pinned: u32,
    /// Simulated time since the start `[s]`.
    pub time: f32,
    /// Time that was too much to simulate, since the start `[s]`.
    pub lost_time: f32,
    /// Times the cloth was taken back to its last good state.
    pub restores: u32,
    /// Times the cloth was taken back to its pose at rest.
    pub resets: u32,
    /// Edges that cross faces, of this cloth with itself and with others, in the live shape. While [`held`](Self::held),
    /// another shape is shown. 0 while an error stops the cloth.
    pub crossings: u32,
    /// Edges that cross faces as they were made: pins hold all of it, or its skin goes through itself and holds it. Nothing can
    /// be done about those, and no frame is held for them. The cure is in the pins, or in the weights and the clip of the skin.
    pub authored: u32,
    /// Intersection curves.
    pub contours: u32,
    /// Length of all curves `[m]`.
    pub contour_length: f32,
    /// Curves that cut a piece off a cloth.
    pub regions: u32,
    /// Iterations of untangling in the last frame.
    pub iterations: u32,
    /// Whether the last frame put work off to the next one, because it was too much: see
    /// [`ClothUntangling::effort`](crate::ClothUntangling::effort). The work is of this cloth, or of another that it can meet.
    pub deferred: bool,
    /// Time since the cloth was last clean `[s]`.
    pub tangled_for: f32,
    /// Whether the last clean shape is shown where the cloth is tangled.
    pub held: bool,
    /// Frames held in a row, this one included.
    pub held_frames: u32,
    /// Time spent on integrating this cloth in the last frame `[ms]`.
    pub integrate_ms: f32,
    /// Its share, by particles, of the time of detection among the cloths it can meet `[ms]`. Detection finds crossings, and
    /// pairs that may touch in the next frame.
    pub detect_ms: f32,
    /// Its share of the time spent on untangling them `[ms]`.
    pub resolve_ms: f32,
    /// Its share of the time spent on looking again, and the time spent on deciding what to show `[ms]`.
    pub evaluate_ms: f32,
    /// Its share of the time spent on looking for what may touch again, where something was untangled `[ms]`.
    pub respond_ms: f32,
    /// Time spent on the vertices, normals, tangents and bounds of its mesh when it last moved `[ms]`.
    pub sync_ms: f32,
    /// Pairs of particles and faces, or of edges, of the cloths it can meet that touched in the last substep.
    pub contacts: u32,
    /// Settings that are out of range and used clamped.
    pub clamped: Vec<Cow<'static, str>>,
}

impl ClothReport {
    /// Nothing is done for the cloth, and costs nothing.
    pub(crate) fn idle(&mut self) {
        (self.substeps, self.iterations) = (0, 0);
        (self.integrate_ms, self.detect_ms, self.resolve_ms) = (0.0, 0.0, 0.0);
        (self.evaluate_ms, self.respond_ms) = (0.0, 0.0);
    }
}

/// How the mesh became a cloth, and what had to be repaired on the way.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothBuildReport {
    /// Vertices of the mesh.
    pub vertices: u32,
    /// Particles left after welding vertices at one position.
    pub particles: u32,
    /// Triangles simulated.
    pub faces: u32,
    /// Triangles dropped because an index was past the end of the vertices.
    pub out_of_range: u32,
    /// Triangles dropped because they had no area.
    pub degenerate: u32,
    /// Triangles dropped because another had the same corners.
    pub duplicate: u32,
    /// Vertices that no simulated triangle uses; they ride on the nearest particle.
    pub isolated: u32,
    /// Triangles simulated whose texture coordinates tell no direction of the threads: all of them without coordinates.
    pub without_warp: u32,
    /// Pins that name a vertex the mesh does not have; ignored.
    pub bad_pins: Vec<u32>,
}

impl ClothBuildReport {
    pub(crate) fn new(report: &BuildReport) -> Self {
        let BuildReport { vertices, particles, faces, out_of_range, degenerate, duplicate, isolated, without_warp } = *report;
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        Self {
            vertices: count(vertices),
            particles: count(particles),
            faces: count(faces),
            out_of_range: count(out_of_range),
            degenerate: count(degenerate),
            duplicate: count(duplicate),
            isolated: count(isolated),
            without_warp: count(without_warp),
            bad_pins: Vec::new(),
        }
    }
}
