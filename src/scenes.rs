//! Scenes to measure on, shared by tests, benchmarks and programs. Free of the engine: each is stepped by [`crate::solver::step`].

use std::sync::Arc;

use glam::{Quat, Vec3, vec3};

use crate::solver::body::{Body, Pose, shape};
use crate::solver::rest::{RestShape, SourceMesh};
use crate::solver::settings::{Fabric, Stepping};
use crate::solver::state::ClothState;
use crate::solver::step::{self, Anchors, FrameInput, Scratch, StepReport};
use crate::solver::wind::{Turbulence, Wind};

/// Standard gravity [m/s²].
pub const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// Areal density of the cloths in these scenes [kg/m²].
pub const DENSITY: f32 = 0.3;

/// A rectangle of `columns` x `rows` vertices at `point(u, v)`, `u` and `v` from 0 to 1; vertex `(i, j)` has index `i * rows + j`.
///
/// The diagonals alternate, so that the mesh prefers no direction.
#[must_use]
pub fn grid(columns: u32, rows: u32, point: impl Fn(f32, f32) -> Vec3) -> SourceMesh {
    let (columns, rows) = (columns.max(2), rows.max(2));
    let mut mesh = SourceMesh::default();
    for i in 0..columns {
        for j in 0..rows {
            mesh.positions.push(point(i as f32 / (columns - 1) as f32, j as f32 / (rows - 1) as f32));
        }
    }
    for i in 0..columns - 1 {
        for j in 0..rows - 1 {
            let (a, b) = (i * rows + j, i * rows + j + 1);
            let (c, d) = (a + rows, b + rows);
            mesh.triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] });
        }
    }
    mesh
}

/// One cloth of a scene.
#[derive(Clone, Debug)]
pub struct SceneCloth {
    /// Rest shape, shared by equal cloths.
    pub rest: Arc<RestShape>,
    /// Material.
    pub fabric: Fabric,
    /// Substeps.
    pub stepping: Stepping,
    /// Pins.
    pub anchors: Anchors,
    /// Particles.
    pub state: ClothState,
    /// Buffers of the solver.
    pub scratch: Scratch,
    /// The last frame.
    pub report: StepReport,
}

impl SceneCloth {
    /// A cloth with the shape of `rest` moved by `at` [m], held rigidly at the render vertices `pins`.
    #[must_use]
    pub fn new(rest: Arc<RestShape>, fabric: Fabric, at: Vec3, pins: &[u32]) -> Self {
        let mut particles: Vec<u32> = pins.iter().filter_map(|&v| rest.particle_of_vertex.get(v as usize).copied()).collect();
        particles.sort_unstable();
        particles.dedup();
        let targets: Vec<Vec3> = particles.iter().map(|&p| rest.positions[p as usize] + at).collect();
        let weights = vec![1.0; particles.len()];
        let anchors = Anchors { particles, weights, from: targets.clone(), to: targets };
        let mut state = ClothState::default();
        state.positions.extend(rest.positions.iter().map(|p| (*p + at).extend(0.0)));
        state.previous.clone_from(&state.positions);
        let mut cloth = Self {
            rest,
            fabric,
            stepping: Stepping::default(),
            anchors,
            state,
            scratch: Scratch::default(),
            report: StepReport::default(),
        };
        cloth.prepare();
        cloth
    }

    /// Must follow a change of `fabric` or of the set of pins.
    pub fn prepare(&mut self) {
        step::prepare(&self.rest, &self.fabric, &self.anchors, &mut self.state, &mut self.scratch);
    }

    /// Advances by one frame.
    pub fn step(&mut self, input: &FrameInput<'_>) {
        self.report =
            step::step(&self.rest, &self.fabric, &self.stepping, &self.anchors, input, &mut self.state, &mut self.scratch);
        self.anchors.from.clone_from(&self.anchors.to);
    }

    /// Kinetic energy plus potential energy against the origin [J]; what the springs store is not counted.
    #[must_use]
    pub fn energy(&self, gravity: Vec3) -> f64 {
        let mut energy = 0.0;
        for (i, area) in self.rest.areas.iter().enumerate() {
            let mass = f64::from(self.fabric.density * area);
            let x = self.state.positions[i].truncate();
            energy += mass * (0.5 * f64::from(self.state.velocity(i).length_squared()) - f64::from(gravity.dot(x)));
        }
        energy
    }

    /// Lowest particle [m].
    #[must_use]
    pub fn lowest(&self) -> f32 {
        self.state.positions.iter().map(|x| x.y).fold(f32::INFINITY, f32::min)
    }
}

/// Cloths, bodies and weather.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Independent cloths.
    pub cloths: Vec<SceneCloth>,
    /// Bodies; `from` is where they were, `to` where they are.
    pub bodies: Vec<Body>,
    /// Wind.
    pub wind: Wind,
    /// Gravity [m/s²].
    pub gravity: Vec3,
}

impl Scene {
    /// Advances every cloth by `dt` [s], one after the other.
    pub fn step(&mut self, dt: f32) {
        let input = FrameInput { dt, gravity: self.gravity, bodies: &self.bodies, wind: &self.wind };
        for cloth in &mut self.cloths {
            cloth.step(&input);
        }
        self.wind.advance(dt);
    }
}

/// Material of the scenes: the default with [`DENSITY`].
#[must_use]
pub fn fabric() -> Fabric {
    Fabric { density: DENSITY, ..Fabric::default() }
}

fn sheet(n: u32) -> Arc<RestShape> {
    let mesh = grid(n, n, |u, v| vec3(u - 0.5, 0.0, v - 0.5));
    Arc::new(RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default())
}

fn scene(cloths: Vec<SceneCloth>) -> Scene {
    Scene { cloths, bodies: Vec::new(), wind: Wind::STILL, gravity: GRAVITY }
}

/// A 1 m sheet of `n` x `n` vertices pinned at two corners, starting flat.
#[must_use]
pub fn hang(n: u32) -> Scene {
    scene(vec![SceneCloth::new(sheet(n), fabric(), Vec3::ZERO, &[0, n.max(2) - 1])])
}

/// A 1 m sheet dropped from 0.5 m above the centre of a ball of radius 0.3 m.
#[must_use]
pub fn ball(n: u32) -> Scene {
    let mut scene = scene(vec![SceneCloth::new(sheet(n), fabric(), vec3(0.0, 0.5, 0.0), &[])]);
    scene.bodies.extend(shape::ball(0.3).ok().map(|ball| Body::at_rest(ball, Pose::IDENTITY)));
    scene
}

/// `k` flags of 1 m x 0.7 m, held along one side, in a gusty wind of 8 m/s.
#[must_use]
pub fn flags(k: u32, n: u32) -> Scene {
    let n = n.max(2);
    let mesh = grid(n, n, |u, v| vec3(u, -0.7 * v, 0.0));
    let rest = Arc::new(RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default());
    let pole: Vec<u32> = (0..n).collect();
    let mut scene =
        scene((0..k).map(|i| SceneCloth::new(rest.clone(), fabric(), vec3(0.0, 2.0, 1.5 * i as f32), &pole)).collect());
    scene.wind = Wind {
        velocity: Quat::from_rotation_y(0.2) * vec3(8.0, 0.0, 0.0),
        turbulence: Turbulence { intensity: 0.2, length: 2.0, seed: 7, ..Turbulence::NONE },
        ..Wind::STILL
    };
    scene
}
