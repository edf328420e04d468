//! A frame of 1/60 s of the scenes that tests and programs share.

#![expect(missing_docs, reason = "criterion's macro writes a public function")]

use std::hint::black_box;

use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::rest::RestShape;
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use drape_scenes::{self as scenes, Scene, Tangle, grid};
use glam::vec3;

/// Frames before timing starts: the cloth is in motion and buffers are warm.
const WARM: usize = 120;

fn frames(c: &mut Criterion, name: &str, sizes: &[u32], scene: impl Fn(u32) -> Scene) {
    let mut island = c.benchmark_group(name);
    island.sample_size(20);
    for &n in sizes {
        let mut scene = scene(n);
        (0..WARM).for_each(|_| scene.step(1.0 / 60.0));
        let work: usize = scene.cloths.iter().map(|c| c.rest.constraints() * c.report.substeps as usize).sum();
        island.throughput(Throughput::Elements(work as u64));
        island.bench_function(BenchmarkId::from_parameter(n), |b| b.iter(|| scene.step(1.0 / 60.0)));
    }
    island.finish();
}

fn hang(c: &mut Criterion) {
    frames(c, "hang", &[30, 64, 128, 256], scenes::hang);
}

fn ball(c: &mut Criterion) {
    frames(c, "ball", &[30, 64, 128], scenes::ball);
}

fn flags(c: &mut Criterion) {
    frames(c, "flags of 30 x 30", &[1, 10], |k| scenes::flags(k, 30));
}

/// Half a second of two sheets of 30 x 30 from their tangled start: what `paper_tables` averages.
fn tangles(c: &mut Criterion) {
    let mut island = c.benchmark_group("30 frames of two sheets of 30 x 30");
    island.sample_size(10);
    for tangle in Tangle::ALL {
        let scene = scenes::tangle(tangle, 30).untangled(UntangleSettings::default(), EvaluateSettings::default(), false);
        let Ok(scene) = scene else { continue };
        island.bench_function(tangle.name(), |b| {
            b.iter_batched(|| scene.clone(), |mut scene| (0..30).for_each(|_| scene.step(1.0 / 60.0)), BatchSize::LargeInput);
        });
    }
    island.finish();
}

/// Binding: weld, clean, renumber, batches.
fn bind(c: &mut Criterion) {
    let mut island = c.benchmark_group("bind");
    island.sample_size(10);
    for n in [64, 256] {
        let mesh = grid(n, n, |u, v| vec3(u, 0.0, v));
        island.throughput(Throughput::Elements(u64::from(n * n)));
        island.bench_function(BenchmarkId::from_parameter(n), |b| b.iter(|| RestShape::build(black_box(&mesh))));
    }
    island.finish();
}

criterion_group!(benches, hang, ball, flags, tangles, bind);
criterion_main!(benches);
