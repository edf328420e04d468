//! The pieces that contours cut off, edge by edge.

use bevy::prelude::*;

use super::{ClothGizmos, place, scale};
use crate::groups::ClothGroups;
use crate::solver::resolve::region::Flood;

pub(super) fn draw(
    mut gizmos: Gizmos<ClothGizmos>,
    groups: Res<ClothGroups>,
    mut flood: Local<Flood>,
    mut inside: Local<Vec<bool>>,
) {
    for group in groups.list.iter().filter(|group| !group.group.contours().is_empty()) {
        let (topology, x, contours) = (&group.group.surface().topology, group.group.particles(), group.group.contours());
        // Stamps of another group mean nothing.
        *flood = Flood::default();
        group.group.regions(&mut flood, |contour, particles| {
            inside.clear();
            inside.resize(x.len(), false);
            particles.iter().for_each(|&v| inside[v as usize] = true);
            let color = scale::contour(contours[contour].kind);
            for &v in particles {
                for &(u, _) in topology.around(v).iter().filter(|&&(u, _)| inside[u as usize] && v < u) {
                    let [a, b] = [v, u].map(|v| place(group.origin, x[v as usize].truncate()));
                    gizmos.line(a, b, color);
                }
            }
        });
    }
}
