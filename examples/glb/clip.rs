//! Animations with names: rotations and translations of nodes, sampled at common times.

use glam::{Quat, Vec3};
use serde_json::json;

use super::Glb;

/// How one node moves; an empty list leaves that part still.
pub struct Channel {
    /// The node.
    pub node: usize,
    /// Local rotations, one per time.
    pub rotations: Vec<Quat>,
    /// Local translations [m], one per time.
    pub translations: Vec<Vec3>,
}

impl Glb {
    /// An animation with a name, sampled at times [s].
    pub fn clip(&mut self, name: &str, times: &[f32], channels: &[Channel]) {
        let input = self.floats(times, "SCALAR");
        self.accessors[input]["min"] = json!([times.first()]);
        self.accessors[input]["max"] = json!([times.last()]);
        let (mut written, mut samplers) = (Vec::new(), Vec::new());
        for channel in channels {
            let rotations: Vec<f32> = channel.rotations.iter().flat_map(|q| q.to_array()).collect();
            let translations: Vec<f32> = channel.translations.iter().flat_map(Vec3::to_array).collect();
            for (path, values, kind) in [("rotation", rotations, "VEC4"), ("translation", translations, "VEC3")] {
                if values.is_empty() {
                    continue;
                }
                let output = self.floats(&values, kind);
                samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
                written.push(json!({ "sampler": samplers.len() - 1, "target": { "node": channel.node, "path": path } }));
            }
        }
        self.clips.push(json!({ "name": name, "channels": written, "samplers": samplers }));
    }
}
