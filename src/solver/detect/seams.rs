//! Where normals that agree do not tell that cloth lies flat: at seams, slits and holes.

use glam::Vec3;

use super::Surface;

/// Smallest and largest corner `[m]` of the box around particles at rest.
pub(crate) fn rest_box(surface: &Surface, particles: impl Iterator<Item = u32>) -> [Vec3; 2] {
    particles.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], v| {
        let x = surface.rest[v as usize];
        [low.min(x), high.max(x)]
    })
}

/// Edges at which normals do not tell whether cloth lies on itself. More than two faces meet there, or the fronts of two faces
/// are on different sides.
pub(crate) fn seams(surface: &Surface) -> Vec<bool> {
    let topology = &surface.topology;
    let mut seams = vec![false; topology.edges.len()];
    // Two faces with one front run along their edge in opposite ways.
    let mut taken = vec![[false; 2]; topology.edges.len()];
    for (t, edges) in topology.faces.iter().zip(&topology.face_edges) {
        for (k, &e) in edges.iter().enumerate() {
            let way = usize::from(t[k] > t[(k + 1) % 3]);
            seams[e as usize] |= core::mem::replace(&mut taken[e as usize][way], true);
        }
    }
    seams
}

/// Whether a border lies in one side of a box and its face does not, along an axis in which the box is not flat.
pub(crate) fn runs_along_a_side(surface: &Surface, [low, high]: [Vec3; 2], border: u32) -> bool {
    let topology = &surface.topology;
    let at = |v: u32| surface.rest[v as usize];
    let [a, b] = topology.edges[border as usize].map(at);
    let inner = at(topology.opposite(border, topology.edge_faces[border as usize][0]));
    let size = high - low;
    let slack = 1.0e-3 * size.max_element();
    (0..3).any(|k| {
        let on = |x: Vec3, side: f32| (x[k] - side).abs() <= slack;
        let along = |side: f32| on(a, side) && on(b, side) && !on(inner, side);
        size[k] > 100.0 * slack && (along(low[k]) || along(high[k]))
    })
}

/// Particles around which cloth may lie over itself although normals agree. They are at `seams`, and at borders of the mesh
/// except those along the sides of its box at rest.
pub(crate) fn loose(surface: &Surface, seams: &[bool]) -> Vec<bool> {
    let topology = &surface.topology;
    let wholes: Vec<[Vec3; 2]> = surface.parts.iter().map(|part| rest_box(surface, part.particles.clone())).collect();
    let mut loose = vec![false; surface.len()];
    for (e, ends) in (0..).zip(&topology.edges) {
        let whole = wholes[usize::from(surface.part_of_edge(e))];
        if seams[e as usize] || (topology.is_border(e) && !runs_along_a_side(surface, whole, e)) {
            ends.iter().for_each(|&v| loose[v as usize] = true);
        }
    }
    loose
}
