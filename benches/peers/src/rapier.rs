//! `rapier3d`: `SoftBodyBuilder::cloth` in a `PhysicsWorld`, both with their defaults.

use rapier3d::prelude::*;

use crate::peer::{BALL_RADIUS, DENSITY, FALL_FROM, FRAME, Peer, Scene, Solved};

/// A world with one cloth.
pub struct Rapier {
    world: PhysicsWorld,
    cloth: SoftBodyHandle,
    /// Edges against stretch and shear; the others are for bending.
    springs: u64,
}

impl Rapier {
    /// The scene on the default solver. Only sleep is switched off: a sheet that slept would cost nothing.
    pub fn new(scene: Scene, size: u32) -> Self {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = FRAME;
        let height = if scene.has_ball() { FALL_FROM } else { 0.0 };
        let step = 1.0 / (size - 1) as Real;
        let n = size as usize;
        let origin = Vector::new(-0.5, height, -0.5);
        let mut cloth = SoftBodyBuilder::cloth(origin, Vector::X * step, Vector::Z * step, n, n).mass(DENSITY).can_sleep(false);
        if scene.has_ball() {
            world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::ball(BALL_RADIUS));
        } else {
            cloth = cloth.pinned_particles([0, size - 1]);
        }
        cloth = cloth.self_contacts(scene.meets_itself());
        let springs = cloth.edges.len() as u64;
        let cloth = world.insert_soft_body(cloth);
        Self { world, cloth, springs }
    }

    fn cloth(&self) -> Option<&SoftBody> {
        self.world.soft_bodies.get(self.cloth)
    }

    /// Sweeps over all edges in the next frame. Edges stretched by more than three quarters are swept twice as often, which is
    /// not counted.
    fn sweeps(&self) -> u64 {
        let parameters = &self.world.integration_parameters;
        let extra = self.cloth().and_then(|cloth| {
            // Bodies that are hit fast get more substeps.
            let substeps = self.world.bodies.get(cloth.root_body())?.additional_solver_iterations();
            Some((substeps, cloth.particle_settings().additional_pgs_iterations))
        });
        let (substeps, iterations) = extra.unwrap_or_default();
        let per_substep =
            parameters.num_internal_pgs_iterations + iterations + parameters.num_internal_stabilization_iterations;
        ((parameters.num_solver_iterations + substeps) * per_substep) as u64
    }
}

impl Peer for Rapier {
    fn step(&mut self) -> Solved {
        let sweeps = self.sweeps();
        self.world.step();
        let edges = self.cloth().map_or(0, |cloth| cloth.edges().len() as u64);
        Solved { springs: self.springs * sweeps, all: edges * sweeps }
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        self.cloth().map_or_else(Vec::new, |cloth| cloth.particle_positions().map(|p| [p.x, p.y, p.z]).collect())
    }

    fn springs(&self) -> Vec<[u32; 2]> {
        let edges = self.cloth().map_or(&[][..], SoftBody::edges);
        edges.iter().filter(|edge| edge.kind == SoftBodyEdgeKind::Structural).map(|edge| edge.vertices).collect()
    }
}
