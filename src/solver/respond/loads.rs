//! What pairs bear, and what those bore that a look forgets: they go on from there where the look finds them again.

use glam::Vec3;

use crate::solver::buffer::keep_room;
use crate::solver::detect::ProximityKind;
use crate::solver::topology::NONE;

/// Loads of pairs, chained by the first of their particles.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Loads {
    /// First entry of each particle, or [`NONE`].
    heads: Vec<u32>,
    entries: Vec<Entry>,
}

/// What a pair bears that touched in the last substep.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Borne {
    /// Which pair it is.
    pub pair: u32,
    pub load: Load,
}

/// What a pair bears.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Load {
    /// Mean push `[m]`.
    pub push: f32,
    /// Mean of what all pushes of a substep do: push over mobility `[kg·m]`; divided by the substep it is an impulse.
    pub drive: f32,
    /// What friction pushed it along the plane in the last substep `[m]`.
    pub tangent_push: Vec3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Entry {
    kind: ProximityKind,
    particles: [u32; 4],
    load: Load,
    next: u32,
}

impl Load {
    /// What it is in a substep of another length, by the `ratio` of their squares: what was pushed in a substep goes with it.
    pub(super) fn scaled(self, ratio: f32) -> Self {
        if ratio == 1.0 {
            return self;
        }
        Self { push: self.push * ratio, drive: self.drive * ratio, tangent_push: self.tangent_push * ratio }
    }
}

impl Loads {
    /// Makes room for `particles`.
    pub(super) fn fit(&mut self, particles: usize) {
        self.heads.resize(particles, NONE);
    }

    /// Makes room for as many pairs as touched.
    pub(super) fn reserve(&mut self, touched: usize) {
        keep_room(&mut self.entries, touched);
    }

    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.heads.fill(NONE);
    }

    /// Notes what a pair bears.
    #[inline]
    pub(super) fn note(&mut self, kind: ProximityKind, particles: [u32; 4], load: Load) {
        if let Some(head) = self.heads.get_mut(particles[0] as usize) {
            let next = core::mem::replace(head, self.entries.len() as u32);
            self.entries.push(Entry { kind, particles, load, next });
        }
    }

    /// What a pair bore; nothing if it was not noted.
    #[inline]
    pub(super) fn of(&self, kind: ProximityKind, particles: [u32; 4]) -> Load {
        let mut next = self.heads.get(particles[0] as usize).copied().unwrap_or(NONE);
        while let Some(entry) = self.entries.get(next as usize) {
            if entry.particles == particles && entry.kind == kind {
                return entry.load;
            }
            next = entry.next;
        }
        Load::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_gets_what_it_bore_and_no_other_does() {
        use ProximityKind::{EdgeEdge, VertexFace};
        let mut loads = Loads::default();
        let load = |push: f32| Load { push, drive: 2.0 * push, tangent_push: Vec3::X * push };
        loads.note(VertexFace, [0, 1, 2, 3], load(1.0));
        assert_eq!(loads.of(VertexFace, [0, 1, 2, 3]), Load::default(), "without room nothing is noted");
        loads.fit(8);
        loads.note(VertexFace, [0, 1, 2, 3], load(1.0));
        loads.note(EdgeEdge, [0, 1, 2, 3], load(3.0));
        loads.note(EdgeEdge, [7, 1, 2, 3], load(5.0));
        assert_eq!(loads.of(VertexFace, [0, 1, 2, 3]), load(1.0));
        assert_eq!(loads.of(EdgeEdge, [0, 1, 2, 3]), load(3.0));
        assert_eq!(loads.of(EdgeEdge, [7, 1, 2, 3]), load(5.0));
        assert_eq!(loads.of(VertexFace, [7, 1, 2, 3]), Load::default());
        assert_eq!(loads.of(EdgeEdge, [0, 1, 3, 2]), Load::default());
        loads.clear();
        assert_eq!(loads.of(EdgeEdge, [7, 1, 2, 3]), Load::default());
    }
}
