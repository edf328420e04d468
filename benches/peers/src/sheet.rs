//! What is read off a sheet, the same on every engine.

/// Lengths of pairs of vertices over their lengths at rest (dimensionless).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// Largest; infinite when a position is not finite.
    pub worst: f64,
    /// Mean.
    pub mean: f64,
}

/// Edges of the grid, along its two directions: the ones that every engine holds.
pub fn grid_edges(size: u32) -> Vec<[u32; 2]> {
    let along = |i: u32, j: u32| i * size + j;
    let mut edges = Vec::new();
    for i in 0..size {
        for j in 1..size {
            edges.push([along(i, j - 1), along(i, j)]);
            edges.push([along(j - 1, i), along(j, i)]);
        }
    }
    edges
}

/// Strain of `edges` between a sheet at rest and now.
pub fn strain(edges: &[[u32; 2]], rest: &[[f32; 3]], now: &[[f32; 3]]) -> Strain {
    let mut strain = Strain { worst: 0.0, mean: 0.0 };
    for edge in edges {
        let ratio = length(edge, now) / length(edge, rest);
        if !ratio.is_finite() {
            return Strain { worst: f64::INFINITY, mean: f64::INFINITY };
        }
        strain.worst = strain.worst.max(ratio);
        strain.mean += ratio / edges.len() as f64;
    }
    strain
}

/// How far the lowest vertex is below the first one at rest [m].
pub fn drop(rest: &[[f32; 3]], now: &[[f32; 3]]) -> f64 {
    let start = rest.first().map_or(0.0, |p| f64::from(p[1]));
    start - now.iter().map(|p| f64::from(p[1])).fold(f64::INFINITY, f64::min)
}

/// Distance of the closest vertex to the surface of a ball of `radius` [m] at the origin [m]; negative inside.
pub fn gap(radius: f32, now: &[[f32; 3]]) -> f64 {
    let nearest = now.iter().map(|p| p.map(f64::from)).map(|[x, y, z]| (x * x + y * y + z * z).sqrt());
    nearest.fold(f64::INFINITY, f64::min) - f64::from(radius)
}

fn length([a, b]: &[u32; 2], points: &[[f32; 3]]) -> f64 {
    let (Some(a), Some(b)) = (points.get(*a as usize), points.get(*b as usize)) else { return f64::NAN };
    a.iter().zip(b).map(|(a, b)| (f64::from(*b) - f64::from(*a)).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat square of 1 m.
    fn flat(size: u32) -> Vec<[f32; 3]> {
        let step = 1.0 / (size - 1) as f32;
        (0..size * size).map(|v| [(v / size) as f32 * step, 0.0, (v % size) as f32 * step]).collect()
    }

    #[test]
    fn grid_edges_are_as_many_and_as_long_as_they_should_be() {
        let (edges, sheet) = (grid_edges(5), flat(5));
        assert_eq!(edges.len(), 2 * 5 * 4);
        for edge in &edges {
            assert!((length(edge, &sheet) - 0.25).abs() < 1.0e-6, "{edge:?} is {} m long", length(edge, &sheet));
        }
    }

    #[test]
    fn a_sheet_stretched_twofold_along_one_side_has_worst_2_and_mean_one_and_a_half() {
        let rest = flat(4);
        let now: Vec<[f32; 3]> = rest.iter().map(|[x, y, z]| [2.0 * x, *y, *z]).collect();
        let Strain { worst, mean } = strain(&grid_edges(4), &rest, &now);
        assert!((worst - 2.0).abs() < 1.0e-6 && (mean - 1.5).abs() < 1.0e-6, "worst {worst}, mean {mean}");
    }

    #[test]
    fn a_position_that_is_not_finite_is_an_infinite_strain() {
        let rest = flat(3);
        let mut now = rest.clone();
        now[4][1] = f32::NAN;
        assert_eq!(strain(&grid_edges(3), &rest, &now).worst, f64::INFINITY);
    }
}
