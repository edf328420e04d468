//! The piece of a sheet that a contour cuts off (Baraff, Witkin and Kass 2003; Wicke et al. 2006).
//!
//! Cut the sheet's edges of odd crossing parity, and loop vertices. Flood both sides alternately, always the one with less
//! area, and stop when the smaller is exhausted. The cost is the small region.
//!
//! ```text
//!   . . . . . .        floods start at the two ends of one cut edge;
//!   . . ┆a·┆. .        where they meet, the contour does not separate the sheet
//!   ┄┄┄┄┘  └┄┄┄  b
//! ```

use glam::Vec4;

use super::mass_split::{Load, load};
use crate::solver::detect::Surface;
use crate::solver::topology::NONE;

/// Two regions whose areas differ by less than this fraction are about as large: the earlier choice stays.
const HYSTERESIS: f32 = 0.5;

/// What a flood found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Region {
    /// Rest area `[m²]`.
    pub area: f32,
    /// Sum of the masses of its free particles `[kg]`.
    pub mass: f32,
    /// Whether it holds a pinned particle.
    pub pinned: bool,
}

/// Floods regions. Buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Flood {
    /// Parity stamps of edges.
    cut: Vec<u32>,
    /// Visit stamps of particles.
    seen: Vec<u32>,
    stamp: u32,
    /// Cut stamps of particles, and from where each was reached on the way to a border.
    wall: Vec<u32>,
    from: Vec<u32>,
    cut_stamp: u32,
    queue: [Vec<u32>; 2],
    head: [usize; 2],
    area: [f32; 2],
    chosen: usize,
    /// Edges looked at.
    pub visits: usize,
}

impl Flood {
    /// Forgets all cuts and makes room for a surface.
    pub fn begin(&mut self, surface: &Surface) {
        self.cut.resize(surface.topology.edges.len(), 0);
        self.seen.resize(surface.len(), 0);
        self.wall.resize(surface.len(), 0);
        self.from.resize(surface.len(), NONE);
        self.cut_stamp = self.cut_stamp.wrapping_add(1);
        if self.cut_stamp == 0 {
            self.cut.fill(0);
            self.wall.fill(0);
            self.cut_stamp = 1;
        }
    }

    /// Cuts an edge, or mends it when it was cut before.
    pub(crate) fn toggle(&mut self, edge: u32) {
        self.visits += 1;
        let cut = &mut self.cut[edge as usize];
        *cut = if *cut == self.cut_stamp { 0 } else { self.cut_stamp };
    }

    /// Whether an edge is cut.
    #[must_use]
    pub(crate) fn is_cut(&self, edge: u32) -> bool {
        self.cut[edge as usize] == self.cut_stamp
    }

    /// Cuts at a particle: no flood passes it.
    pub(crate) fn cut_at(&mut self, particle: u32) {
        if let Some(wall) = self.wall.get_mut(particle as usize) {
            *wall = self.cut_stamp;
        }
    }

    /// Prolongs a cut that ends in `face`, along edges to the nearest border. Returns the edges it took; `None` when there is
    /// no border within `most` edges.
    pub(crate) fn prolong(&mut self, surface: &Surface, face: u32, most: usize) -> Option<usize> {
        self.next_stamp();
        let [queue, _] = &mut self.queue;
        queue.clear();
        queue.extend(surface.topology.faces[face as usize]);
        for &v in queue.iter() {
            self.seen[v as usize] = self.stamp;
            self.from[v as usize] = NONE;
        }
        let (mut head, mut steps) = (0, 0);
        loop {
            let last = queue.len();
            if let Some(&end) = queue[head..last].iter().find(|&&v| surface.on_border[v as usize]) {
                let mut v = end;
                while v != NONE {
                    self.wall[v as usize] = self.cut_stamp;
                    v = self.from[v as usize];
                }
                return Some(steps);
            }
            if steps >= most || head == last {
                return None;
            }
            for k in head..last {
                let v = queue[k];
                let around = surface.topology.around(v);
                self.visits += around.len();
                for &(u, e) in around {
                    if self.cut[e as usize] != self.cut_stamp && self.seen[u as usize] != self.stamp {
                        self.seen[u as usize] = self.stamp;
                        self.from[u as usize] = v;
                        queue.push(u);
                    }
                }
            }
            head = last;
            steps += 1;
        }
    }

    fn next_stamp(&mut self) {
        self.stamp = self.stamp.wrapping_add(2);
        if self.stamp < 2 {
            self.seen.fill(0);
            self.stamp = 2;
        }
    }

    /// Whether a flood can start at an edge: it is cut, and neither of its ends is.
    #[must_use]
    pub(crate) fn can_start(&self, surface: &Surface, edge: u32) -> bool {
        let open = |v: u32| self.wall[v as usize] != self.cut_stamp;
        self.is_cut(edge) && surface.topology.edges[edge as usize].into_iter().all(open)
    }

    /// Particles of the region chosen last.
    #[must_use]
    pub fn region(&self) -> &[u32] {
        &self.queue[self.chosen]
    }

    /// Whether a particle is in the region chosen last.
    #[must_use]
    pub fn contains(&self, particle: u32) -> bool {
        self.seen[particle as usize] == self.stamp + self.chosen as u32
    }

    /// Floods from both ends of a cut edge, around cut particles. Returns the region without pins, if only one has some; else
    /// the smaller by area. Of two about as large, the one that holds the particle `keep` is taken, if given. `None` when the
    /// cut does not separate.
    pub fn smaller(&mut self, surface: &Surface, positions: &[Vec4], edge: u32, keep: Option<u32>) -> Option<Region> {
        self.next_stamp();
        let ends = surface.topology.edges[edge as usize];
        self.head = [0; 2];
        self.area = [0.0; 2];
        for (k, &end) in ends.iter().enumerate() {
            self.queue[k].clear();
            self.queue[k].push(end);
            self.seen[end as usize] = self.stamp + k as u32;
        }
        loop {
            let k = usize::from(self.area[1] < self.area[0]);
            if !self.advance(surface, k)? {
                return self.settle(surface, positions, keep, k);
            }
        }
    }

    /// Visits one particle of flood `k`: `Some(false)` when the flood is exhausted, `None` when it met the other.
    fn advance(&mut self, surface: &Surface, k: usize) -> Option<bool> {
        let Some(&v) = self.queue[k].get(self.head[k]) else { return Some(false) };
        self.head[k] += 1;
        self.area[k] += surface.areas[v as usize];
        let mine = self.stamp + k as u32;
        let other = self.stamp + 1 - k as u32;
        let around = surface.topology.around(v);
        self.visits += around.len();
        for &(u, e) in around {
            if self.cut[e as usize] == self.cut_stamp || self.wall[u as usize] == self.cut_stamp {
                continue;
            }
            let seen = &mut self.seen[u as usize];
            if *seen == other {
                return None;
            }
            if *seen != mine {
                *seen = mine;
                self.queue[k].push(u);
            }
        }
        Some(true)
    }

    /// Flood `k` is exhausted; decides between it and the other.
    fn settle(&mut self, surface: &Surface, positions: &[Vec4], keep: Option<u32>, k: usize) -> Option<Region> {
        let first = self.summary(positions, k);
        let clearly = (1.0 + HYSTERESIS) * self.area[k];
        while self.area[1 - k] <= clearly || first.pinned {
            if !self.advance(surface, 1 - k)? {
                let second = self.summary(positions, 1 - k);
                let kept = keep.map(|p| self.seen[p as usize]).unwrap_or_default();
                let by_size = (second.area, second.mass, self.queue[1 - k][0]) < (first.area, first.mass, self.queue[k][0]);
                let other = if first.pinned != second.pinned {
                    first.pinned
                } else if second.area > clearly || kept < self.stamp {
                    by_size
                } else {
                    kept == self.stamp + 1 - k as u32
                };
                self.chosen = if other { 1 - k } else { k };
                return Some(if other { second } else { first });
            }
        }
        self.chosen = k;
        Some(first)
    }

    fn summary(&self, positions: &[Vec4], k: usize) -> Region {
        let Load { mass, pinned } = load(positions, self.queue[k].iter().copied());
        Region { area: self.area[k], mass, pinned }
    }
}
