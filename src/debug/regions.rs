//! The pieces that contours cut off, edge by edge.

use bevy::prelude::*;

use super::{ClothGizmos, place, scale};
use crate::islands::ClothIslands;
use crate::solver::resolve::region::Flood;

pub(super) fn draw(
    mut gizmos: Gizmos<ClothGizmos>,
    islands: Res<ClothIslands>,
    mut flood: Local<Flood>,
    mut inside: Local<Vec<bool>>,
) {
    for island in islands.list.iter().filter(|island| !island.solver.contours().is_empty()) {
        let (topology, x, contours) = (&island.solver.surface().topology, island.solver.particles(), island.solver.contours());
        // Stamps of another island mean nothing.
        *flood = Flood::default();
        island.solver.regions(&mut flood, |contour, particles| {
            inside.clear();
            inside.resize(x.len(), false);
            particles.iter().for_each(|&v| inside[v as usize] = true);
            let color = scale::contour(contours[contour].kind);
            for &v in particles {
                for &(u, _) in topology.around(v).iter().filter(|&&(u, _)| inside[u as usize] && v < u) {
                    let [a, b] = [v, u].map(|v| place(island.origin, x[v as usize].truncate()));
                    gizmos.line(a, b, color);
                }
            }
        });
    }
}
