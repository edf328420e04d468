//! The piece that a contour cuts off goes back through it.

use glam::{DVec3, Vec3, Vec4};

use super::contour::{ContourGraph, ContourKind};
use super::mass_split::{Load, load, shares};
use super::region::{Flood, Region};
use super::separation::largest_area;
use super::view::View;
use super::{ResolveSettings, Resolver, tracked};
use crate::solver::detect::{Crossing, Surface};
use crate::solver::topology::NONE;

impl Resolver {
    /// The region to push on a side, smaller first.
    pub(super) fn region(&mut self, view: View<'_>, contour: usize, side: u8, seed: u32) -> Option<Region> {
        region(&self.graph, &mut self.flood, view, contour, side, seed)
    }

    /// Calls `found` with the number of each contour analysed last that cuts a piece off, and with the particles of that piece.
    pub fn regions(
        &self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        flood: &mut Flood,
        mut found: impl FnMut(usize, &[u32]),
    ) {
        let view = View { surface, crossings, positions };
        for (k, contour) in self.graph.contours.iter().enumerate().filter(|(_, c)| c.kind.separates()) {
            for side in match contour.kind {
                ContourKind::Bbii | ContourKind::Cross => contour.border_side..=contour.border_side,
                ContourKind::Ll => 0..=0,
                _ => 0..=1,
            } {
                if region(&self.graph, flood, view, k, side, NONE).is_some() {
                    found(k, flood.region());
                }
            }
        }
    }

    /// Pushes the smaller region that a contour cuts off back through it; `false` when there is none.
    pub(super) fn push_region(&mut self, view: View<'_>, contour: usize, step: f32, settings: &ResolveSettings) -> bool {
        let c = self.graph.contours[contour];
        let tracked::TrackedContour { side: known, seed, .. } = self.tracked.now[contour];
        let side = match c.kind {
            ContourKind::Bbii | ContourKind::Cross => c.border_side,
            ContourKind::Bli | ContourKind::Unknown => return false,
            ContourKind::Ll => 0,
            _ if known < 2 => known,
            _ => {
                let sizes = [0, 1].map(|side| self.region(view, contour, side, seed).map(|r| (r.pinned, r.area)));
                match sizes {
                    [Some(a), Some(b)] => u8::from(b < a),
                    [None, Some(_)] => 1,
                    _ => 0,
                }
            }
        };
        let Some(region) = self.region(view, contour, side, seed) else { return false };
        self.tracked.now[contour].side = side;
        self.tracked.now[contour].progress(region.area);
        let nodes = self.graph.nodes_of(contour);
        let mut sum = DVec3::ZERO;
        for &i in nodes {
            let e = view.crossings[i as usize].edge;
            if (self.graph.side[i as usize] != side && c.kind != ContourKind::Ll) || !self.flood.is_cut(e) {
                continue;
            }
            let [a, b] = view.surface.topology.edges[e as usize];
            let inside = match (self.flood.contains(a), self.flood.contains(b)) {
                (true, false) => a,
                (false, true) => b,
                _ => continue,
            };
            let terms = &self.terms[i as usize];
            let depth = (view.positions[inside as usize].truncate().as_dvec3() - terms.point).dot(terms.normal);
            sum += depth.signum() * terms.normal;
        }
        let direction = -sum.normalize_or_zero().as_vec3();
        if direction == Vec3::ZERO {
            return false;
        }
        // The particle that comes through last marks the region.
        let along = |v: &u32| view.positions[*v as usize].truncate().dot(direction);
        let deepest = self.flood.region().iter().min_by(|a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
        self.tracked.now[contour].seed = deepest.copied().unwrap_or(NONE);
        let lowest = deepest.map_or(0.0, along);
        let tracked = &mut self.tracked.now[contour];
        tracked.depth = tracked.depth.max(c.centre.dot(direction) - lowest);
        if region.area > largest_area(tracked.longest, c.edge, tracked.depth) {
            return false;
        }
        let motion = step * tracked.steer(direction, settings.pace, 0.0);
        let moved = Load { pinned: region.pinned, ..load(view.positions, self.flood.region().iter().copied()) };
        // The other cloth gives way as a whole.
        let on = self.flood.region().first().map_or(0, |&v| view.surface.part(v));
        let other = nodes.first().map_or(on, |&i| {
            let Crossing { edge, face, .. } = view.crossings[i as usize];
            let is_mine = self.graph.side[i as usize] == side;
            if is_mine { view.surface.part_of_face(face) } else { view.surface.part_of_edge(edge) }
        });
        let others = view.surface.parts[usize::from(other)].particles.clone();
        let theirs = if on == other { Load::default() } else { load(view.positions, others.clone()) };
        let share = shares([moved, theirs]).map(|s| 0.5 * s);
        if share[0] > 0.0 {
            for &v in self.flood.region() {
                self.displacements.add(v, share[0] * motion, motion.length());
            }
        }
        if share[1] > 0.0 {
            self.patch.visits += others.len();
            for v in others {
                self.displacements.add(v, -share[1] * motion, motion.length());
            }
        }
        true
    }
}

/// Cuts a sheet along a contour: edges of odd parity on `side`, and loop vertices. Where the contour ends inside the sheet, a
/// prolongation to the nearest border is cut, too. `None` when there is no way to close the cut.
fn cut(graph: &ContourGraph, flood: &mut Flood, view: View<'_>, contour: usize, side: u8) -> Option<()> {
    let c = graph.contours[contour];
    let both = c.kind == ContourKind::Ll;
    flood.begin(view.surface);
    for &i in graph.nodes_of(contour) {
        if both || graph.side[i as usize] == side {
            flood.toggle(view.crossings[i as usize].edge);
        }
    }
    c.loops.into_iter().for_each(|v| flood.cut_at(v));
    if c.kind == ContourKind::Bibi {
        let end = c.border_ends.into_iter().find(|&n| n != NONE && graph.side[n as usize] != side)?;
        // By no more than its own length.
        let most = (c.length / c.edge) as usize + 2;
        flood.prolong(view.surface, view.crossings[end as usize].face, most)?;
    }
    Some(())
}

/// See [`Resolver::region`].
fn region(graph: &ContourGraph, flood: &mut Flood, view: View<'_>, contour: usize, side: u8, seed: u32) -> Option<Region> {
    cut(graph, flood, view, contour, side)?;
    let mut edges = graph.nodes_of(contour).iter().map(|&i| view.crossings[i as usize].edge);
    let start = edges.find(|&e| flood.can_start(view.surface, e))?;
    flood.smaller(view.surface, view.positions, start, (seed != NONE).then_some(seed))
}
