//! What a scene shows, and how often that crosses: every cloth with every other and with itself, pinned cloth included.

use bevy_drape::scenes::Scene;
use glam::Vec3;

use crate::checker;

/// The positions that a frame shows of all cloths [m].
#[derive(Clone, Debug, Default)]
pub struct Picture {
    pub positions: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
}

impl Picture {
    pub fn of(scene: &Scene) -> Self {
        let mut picture = Self::default();
        for cloth in &scene.cloths {
            let first = picture.positions.len() as u32;
            match cloth.display.held() {
                Some(held) => picture.positions.extend_from_slice(held),
                None => picture.positions.extend(cloth.state.positions.iter().map(|x| x.truncate())),
            }
            picture.faces.extend(cloth.rest.topology.faces.iter().map(|t| t.map(|v| v + first)));
        }
        picture
    }

    /// Edges that cross faces.
    pub fn crossings(&self) -> usize {
        checker::crossings(&self.positions, &self.faces).len()
    }

    /// How deep the middle of an edge or of a face lies in a body [m]: what is seen poking through. Surfaces without an inside are not asked.
    pub fn poke(&self, scene: &Scene) -> f32 {
        let at = |v: u32| self.positions[v as usize];
        let mut deepest = 0.0f32;
        for body in &scene.bodies {
            if body.shape.as_trimesh().is_some() {
                continue;
            }
            for &[a, b, c] in &self.faces {
                let (a, b, c) = (at(a), at(b), at(c));
                for point in [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5, (a + b + c) / 3.0] {
                    let near = body.shape.project_point(&body.to, point, false);
                    if near.is_inside {
                        deepest = deepest.max(near.point.distance(point));
                    }
                }
            }
        }
        deepest
    }
}
