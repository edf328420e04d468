//! Vertices at one position become one particle: UV seams and hard edges split render vertices, never cloth.

use glam::Vec3;

/// Vertices closer than this fraction of the mesh's diagonal are one (dimensionless).
pub(super) const WELD_FRACTION: f32 = 1.0e-5;

/// Maps each vertex to the smallest index among the vertices within `tolerance` `[m]` of it, transitively.
///
/// Vertices are sorted along a direction no modelling grid is aligned with, so each is compared with few others.
#[must_use]
pub(super) fn weld(positions: &[Vec3], tolerance: f32) -> Vec<u32> {
    let direction = Vec3::new(0.6124, 0.3536, 0.7077);
    let mut order: Vec<(f32, u32)> = positions.iter().enumerate().map(|(i, p)| (p.dot(direction), i as u32)).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));

    let mut leader: Vec<u32> = (0..positions.len() as u32).collect();
    for (k, &(key, i)) in order.iter().enumerate() {
        for &(other, j) in order[k + 1..].iter().take_while(|o| o.0 - key <= tolerance) {
            debug_assert!(other >= key);
            if positions[i as usize].distance_squared(positions[j as usize]) <= tolerance * tolerance {
                let (a, b) = (find(&mut leader, i), find(&mut leader, j));
                leader[a.max(b) as usize] = a.min(b);
                if positions[i as usize] == positions[j as usize] {
                    // The other looks at the same neighbours: a thousand vertices at one place cost a thousand comparisons.
                    break;
                }
            }
        }
    }
    (0..positions.len() as u32).map(|i| find(&mut leader, i)).collect()
}

fn find(leader: &mut [u32], mut i: u32) -> u32 {
    while leader[i as usize] != i {
        leader[i as usize] = leader[leader[i as usize] as usize];
        i = leader[i as usize];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_within_the_tolerance_become_one_and_others_stay() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::splat(1.0e-6), Vec3::Y, Vec3::new(1.0, 0.0, 1.0e-6)];
        assert_eq!(weld(&points, 1.0e-5), [0, 1, 0, 3, 1]);
    }
}
