//! The eight named tangles of `drape_scenes`: two sheets that start in each other, without gravity.
//!
//! Both engines get the same vertices and triangles, and one judge, the exact crossings of edges with faces, looks at both.

use std::time::Instant;

use drape_scenes::{self as scenes, Scene, Tangle};
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use rapier3d::prelude::*;

use crate::measure::percentile;
use crate::peer::{DENSITY, Engine, FRAME};

/// A line of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Engine.
    pub engine: Engine,
    /// Scene.
    pub tangle: Tangle,
    /// Edges that cross faces at the start.
    pub start: u32,
    /// Steps after which nothing crossed any more; none if something still did at the end.
    pub clean: Option<u32>,
    /// Edges that cross faces at the end.
    pub left: u32,
    /// Mean time of a step [ms].
    pub mean: f64,
    /// Mean time of a step until nothing crossed any more [ms].
    pub tangled: f64,
    /// 95th percentile of the time of a step [ms].
    pub p95: f64,
    /// Time until nothing crossed any more, or of all steps if something still did [ms].
    pub total: f64,
}

/// Two sheets on one engine.
trait Pair {
    /// Advances by one [`FRAME`].
    fn step(&mut self);

    /// Where the vertices of a sheet are [m].
    fn positions(&self, sheet: usize) -> Vec<[f32; 3]>;
}

/// Runs a tangle of about `size` x `size` vertices a sheet for `steps` frames; nothing where the engine has no contacts between
/// cloths.
pub fn row(engine: Engine, tangle: Tangle, size: u32, steps: u32) -> Option<Row> {
    let mut pair: Box<dyn Pair> = match engine {
        Engine::Ours => Box::new(Ours::new(tangle, size)?),
        Engine::Silk => return None,
        Engine::Rapier => Box::new(Rapier::new(tangle, size)),
    };
    let mut judge = Judge::new(tangle, size)?;
    let start = judge.crossings(pair.as_ref());
    let (mut times, mut dirty, mut left) = (Vec::new(), 0, start);
    for step in 1..=steps {
        let clock = Instant::now();
        pair.step();
        times.push(clock.elapsed().as_secs_f64() * 1.0e3);
        left = judge.crossings(pair.as_ref());
        if left > 0 {
            dirty = step;
        }
    }
    let clean = (dirty < steps).then_some(dirty + 1);
    let until = &times[..clean.unwrap_or(steps) as usize];
    let sum = |times: &[f64]| times.iter().sum::<f64>();
    let mean = |times: &[f64]| sum(times) / times.len() as f64;
    let (all, tangled, total) = (mean(&times), mean(until), sum(until));
    Some(Row { engine, tangle, start, clean, left, mean: all, tangled, p95: percentile(times, 95), total })
}

/// Counts crossings of both sheets with each other.
struct Judge(Scene);

impl Judge {
    fn new(tangle: Tangle, size: u32) -> Option<Self> {
        scenes::tangle(tangle, size).untangled(UntangleSettings::default(), EvaluateSettings::default(), false).ok().map(Self)
    }

    fn crossings(&mut self, pair: &dyn Pair) -> u32 {
        for (sheet, cloth) in self.0.cloths.iter_mut().enumerate() {
            for (&particle, [x, y, z]) in cloth.rest.particle_of_vertex.iter().zip(pair.positions(sheet)) {
                let to = &mut cloth.sim.state.positions[particle as usize];
                (to.x, to.y, to.z) = (x, y, z);
            }
        }
        self.0.look().crossings
    }
}

/// The crate's scene, with its defaults.
struct Ours(Scene);

impl Ours {
    fn new(tangle: Tangle, size: u32) -> Option<Self> {
        let scene = scenes::tangle(tangle, size);
        scene.untangled(UntangleSettings::default(), EvaluateSettings::default(), false).ok().map(Self)
    }
}

impl Pair for Ours {
    fn step(&mut self) {
        self.0.step(FRAME);
    }

    fn positions(&self, sheet: usize) -> Vec<[f32; 3]> {
        let cloth = &self.0.cloths[sheet];
        cloth.rest.particle_of_vertex.iter().map(|&p| cloth.sim.state.positions[p as usize].truncate().to_array()).collect()
    }
}

/// Two cloths of `SoftBodyBuilder::cloth`, put where the sheets start, in a world with its defaults. Only sleep is switched
/// off.
struct Rapier {
    world: PhysicsWorld,
    sheets: Vec<SoftBodyHandle>,
}

impl Rapier {
    fn new(tangle: Tangle, size: u32) -> Self {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = FRAME;
        world.gravity = Vector::ZERO;
        let sheet = |mesh: bevy_drape::solver::rest::SourceMesh| {
            let rows = rows(&mesh.triangles);
            let at = |v: usize| {
                let p = mesh.positions[v];
                Vector::new(p.x, p.y, p.z)
            };
            let columns = mesh.positions.len() / rows;
            let mut cloth = SoftBodyBuilder::cloth(at(0), at(rows) - at(0), at(1) - at(0), columns, rows);
            cloth.positions = (0..mesh.positions.len()).map(at).collect();
            let area: f32 = mesh.triangles.iter().map(|t| area(t.map(|v| at(v as usize)))).sum();
            let cloth = cloth.surface(mesh.triangles).mass(DENSITY * area).can_sleep(false);
            world.insert_soft_body(cloth)
        };
        let sheets = tangle.meshes(size).map(sheet).into();
        Self { world, sheets }
    }
}

impl Pair for Rapier {
    fn step(&mut self) {
        self.world.step();
    }

    fn positions(&self, sheet: usize) -> Vec<[f32; 3]> {
        let cloth = self.world.soft_bodies.get(self.sheets[sheet]);
        cloth.map_or_else(Vec::new, |cloth| cloth.particle_positions().map(|p| [p.x, p.y, p.z]).collect())
    }
}

/// Vertices along the second side of a grid whose vertex `(i, j)` has index `i * rows + j`: the first quad tells.
fn rows(triangles: &[[u32; 3]]) -> usize {
    // Its corners are 0, 1, rows and rows + 1.
    triangles.first().map_or(1, |t| t.iter().copied().max().unwrap_or(1) as usize)
}

fn area([a, b, c]: [Vector; 3]) -> f32 {
    0.5 * (b - a).cross(c - a).length()
}
