//! What a frame did to all clothes together.

use std::collections::HashSet;

use bevy::prelude::*;
use bevy_drape::ClothIslands;
use bevy_drape::prelude::*;
use bevy_drape::solver::rest::RestShape;
use serde_json::{Map, Value};

use crate::stages::{NAMES, Stages};
use crate::table::percentile;

/// What all timed frames did.
#[derive(Default)]
pub struct Worn {
    frames: Vec<f64>,
    stages: [Vec<f64>; NAMES.len()],
    /// What `ClothBudget` counts of them.
    counted: Vec<f64>,
    held_frames: u32,
    tangled_frames: u32,
    clean_after: u32,
    most_crossings: u32,
    crossings: u32,
    most_substeps: u32,
    substeps: Vec<f64>,
    worst_edge: f32,
    mean_edge: f32,
    recoveries: u32,
}

impl Worn {
    /// Takes in the last frame.
    pub fn note(&mut self, frame: u32, app: &mut App) {
        let ms = app.world().resource::<Stages>().ms;
        self.frames.push(ms.iter().sum());
        self.stages.iter_mut().zip(ms).for_each(|(times, time)| times.push(time));
        let mut cloths = app.world_mut().query_filtered::<&ClothReport, With<Cloth>>();
        let (mut counted, mut crossings, mut is_held, mut recoveries, mut substeps) = (0.0, 0, false, 0, 0);
        for report in cloths.iter(app.world()) {
            let ClothReport { integrate_ms, detect_ms, resolve_ms, evaluate_ms, respond_ms, sync_ms, .. } = report;
            counted += f64::from(integrate_ms + detect_ms + resolve_ms + evaluate_ms + respond_ms + sync_ms);
            crossings += report.crossings;
            is_held |= report.held;
            recoveries += report.restores + report.resets;
            substeps = substeps.max(report.substeps);
            self.worst_edge = self.worst_edge.max(report.worst_edge);
            self.mean_edge = self.mean_edge.max(report.mean_edge);
        }
        self.counted.push(counted);
        self.held_frames += u32::from(is_held);
        (self.crossings, self.recoveries) = (crossings, recoveries);
        self.most_crossings = self.most_crossings.max(crossings);
        self.most_substeps = self.most_substeps.max(substeps);
        self.substeps.push(f64::from(substeps));
        if crossings > 0 {
            self.tangled_frames += 1;
            self.clean_after = frame;
        }
    }

    /// What characters of any number have in common.
    pub fn describe(&mut self, app: &mut App, line: &mut Map<String, Value>) {
        let mut cloths = app.world_mut().query_filtered::<(&ClothParticles, &ClothRest), With<Cloth>>();
        let world = app.world();
        let particles: usize = cloths.iter(world).map(|(particles, _)| particles.len()).sum();
        let springs: usize = cloths.iter(world).map(|(_, rest)| rest.shape().constraints()).sum();
        let shapes: HashSet<*const RestShape> = cloths.iter(world).map(|(_, rest)| core::ptr::from_ref(rest.shape())).collect();
        let p50 = self.stages.each_mut().map(|times| percentile(times, 50));
        let stages: Map<String, Value> = NAMES.iter().zip(p50).map(|(name, ms)| ((*name).to_string(), ms.into())).collect();
        let more = serde_json::json!({
            "cloths": cloths.iter(world).count(),
            "rest_shapes": shapes.len(),
            "islands": world.resource::<ClothIslands>().members().count(),
            "frames": self.frames.len(),
            "particles": particles,
            "springs": springs,
            "substeps": percentile(&mut self.substeps, 50),
            "most_substeps": self.most_substeps,
            "frame_ms_least": percentile(&mut self.frames, 0),
            "frame_ms_p50": percentile(&mut self.frames, 50),
            "frame_ms_p95": percentile(&mut self.frames, 95),
            "counted_ms_p50": percentile(&mut self.counted, 50),
            "counted_ms_p95": percentile(&mut self.counted, 95),
            "stage_ms": stages,
            "skin_and_sync_ms": p50[0] + p50[NAMES.len() - 1],
            "crossings": self.crossings,
            "most_crossings": self.most_crossings,
            "tangled_frames": self.tangled_frames,
            "clean_after": self.clean_after,
            "held_frames": self.held_frames,
            "recoveries": self.recoveries,
            "worst_edge": self.worst_edge,
            "mean_edge": self.mean_edge,
        });
        if let Value::Object(more) = more {
            line.extend(more);
        }
    }
}
