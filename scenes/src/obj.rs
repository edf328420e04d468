//! Meshes from Wavefront OBJ files: vertices and faces, nothing else.

use glam::Vec3;

use bevy_drape::solver::rest::SourceMesh;

/// Reads the vertices and faces of a file's text; faces of more than three corners are fans. Lines it cannot read are left out.
#[must_use]
pub fn obj(text: &str) -> SourceMesh {
    let mut mesh = SourceMesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f32> = words.filter_map(|w| w.parse().ok()).collect();
                mesh.positions.extend(numbers.get(..3).map(Vec3::from_slice));
            }
            Some("f") => {
                let count = mesh.positions.len() as i64;
                let index = |w: &str| {
                    let i: i64 = w.split('/').next()?.parse().ok()?;
                    // Negative numbers count from the end.
                    u32::try_from(if i < 0 { count + i } else { i - 1 }).ok()
                };
                let corners: Vec<u32> = words.filter_map(index).collect();
                mesh.triangles.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_four_corners_are_fans_and_other_lines_are_left_out() {
        let text = "# a square\no square\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\nf -4 -3 -2\nf what\n";
        let SourceMesh { positions, triangles, .. } = obj(text);
        assert_eq!(positions.len(), 4, "{positions:?}");
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    }
}
