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
