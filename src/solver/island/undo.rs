//! Reverts a step of untangling that makes contours much longer than their shortest length since the cloth was clean. Cloth
//! that is pressed from all sides, as in a knot, or that is pinned crossed, crosses more wherever it goes. It waits until there
//! is room, or for the last resort. A step that makes contours shorter is never reverted. Contours that something else made
//! much longer may only get shorter.

use glam::Vec4;

use crate::solver::detect::Surface;
use crate::solver::resolve::Contour;

/// Contours are much longer at more than `WORSE_TIMES` times their least length (dimensionless), and more than `WORSE_EDGES`
/// mean edges over it. On its way apart a tangle may get somewhat longer. Less would stop steps that work; much more lets the
/// tangle get hopeless.
const WORSE_TIMES: f32 = 1.7;
const WORSE_EDGES: f32 = 8.0;

/// How everything was before a frame took crossings apart, and how little of them there has been.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Undo {
    /// Where all particles were `[m]`; empty while nothing is undone.
    begun: Vec<Vec4>,
    /// Length of the contours of each cloth, then and now `[m]`; of two that cross each other, half for each.
    lengths: Vec<[f32; 2]>,
    /// The least that was since it was clean, of those that are tangled with each other shared out by what each has `[m]`.
    least: Vec<f32>,
    /// Another cloth that each is tangled with, or itself: those that are tangled with each other are led to the same.
    tied: Vec<u16>,
    /// Of each cloth to which others are led: lengths then and now, and the least, of all of them `[m]`.
    knots: Vec<[f32; 3]>,
    undone: Vec<bool>,
}

impl Undo {
    /// Nothing will be undone.
    pub(super) fn forget(&mut self) {
        self.begun.clear();
    }

    /// Nothing crosses any more: the next tangle is another.
    pub(super) fn forget_least(&mut self) {
        self.least.clear();
    }

    /// Whether something may be undone.
    pub(super) fn is_due(&self) -> bool {
        !self.begun.is_empty()
    }

    /// Notes how everything is.
    pub(super) fn begin<'a>(
        &mut self,
        surface: &Surface,
        positions: &[Vec4],
        contours: impl Iterator<Item = (&'a Contour, [u16; 2])>,
    ) {
        let parts = surface.parts.len();
        self.begun.clear();
        self.begun.extend_from_slice(positions);
        self.tied.clear();
        self.tied.extend(0..parts as u16);
        self.lengths.clear();
        self.lengths.resize(parts, [0.0; 2]);
        self.take_in(0, contours);
        self.least.resize(parts, 0.0);
        for (least, [length, _]) in self.least.iter_mut().zip(&self.lengths) {
            *least = if *least > 0.0 { *least } else { *length };
        }
    }

    /// Puts cloths whose contours got much longer back where they were, without a change of velocity. All that are tangled with
    /// each other are put back at once. Returns whether there were any.
    pub(super) fn end<'a>(
        &mut self,
        surface: &Surface,
        contours: impl Iterator<Item = (&'a Contour, [u16; 2])>,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
    ) -> bool {
        self.take_in(1, contours);
        let parts = self.tied.len();
        self.knots.clear();
        self.knots.resize(parts, [0.0; 3]);
        for part in 0..parts {
            let ([before, after], least, knot) = (self.lengths[part], self.least[part], self.knot(part));
            self.knots[knot].iter_mut().zip([before, after, least]).for_each(|(sum, length)| *sum += length);
        }
        self.undone.clear();
        for part in 0..parts {
            let [before, after, least] = self.knots[self.knot(part)];
            let least = least.min(before);
            let most = (WORSE_TIMES * least).max(least + WORSE_EDGES * surface.mean_edge);
            let is_worse = after > most.max(before);
            let (time, length) = if is_worse { (0, before) } else { (1, after) };
            self.least[part] = if length > 0.0 { self.lengths[part][time] * least.min(length) / length } else { 0.0 };
            self.undone.push(is_worse);
            if is_worse {
                self.put_back(surface, part, positions, previous);
            }
        }
        self.undone.contains(&true)
    }

    /// Puts back cloths that cross one that was put back, as they did not before; whether there were any.
    pub(super) fn follow<'a>(
        &mut self,
        surface: &Surface,
        contours: impl Iterator<Item = (&'a Contour, [u16; 2])>,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
    ) -> bool {
        let mut any = false;
        for (_, parts) in contours {
            let [a, b] = parts.map(usize::from);
            if self.undone[a] != self.undone[b] {
                let other = if self.undone[a] { b } else { a };
                self.undone[other] = true;
                self.put_back(surface, other, positions, previous);
                any = true;
            }
        }
        any
    }

    fn put_back(&self, surface: &Surface, part: usize, positions: &mut [Vec4], previous: &mut [Vec4]) {
        let range = surface.parts[part].range();
        let all = positions[range.clone()].iter_mut().zip(&mut previous[range.clone()]);
        for ((x, previous), &begun) in all.zip(&self.begun[range]) {
            *previous += begun - *x;
            *x = begun;
        }
    }

    /// Whether a cloth was put back since the last [end](Self::end).
    pub(super) fn has_undone(&self, part: u16) -> bool {
        self.undone[usize::from(part)]
    }

    fn take_in<'a>(&mut self, time: usize, contours: impl Iterator<Item = (&'a Contour, [u16; 2])>) {
        for (contour, [a, b]) in contours {
            [a, b].iter().for_each(|&part| self.lengths[usize::from(part)][time] += 0.5 * contour.length);
            let [a, b] = [a, b].map(|part| self.knot(usize::from(part)));
            self.tied[a.max(b)] = a.min(b) as u16;
        }
    }

    /// The first of the cloths that one is tangled with, by way of others too.
    fn knot(&self, mut part: usize) -> usize {
        while usize::from(self.tied[part]) != part {
            part = usize::from(self.tied[part]);
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::solver::detect::PartRef;
    use crate::solver::topology::Topology;
    use glam::{Vec3, vec3};

    /// Five single triangles.
    fn surface() -> Surface {
        let topology = Arc::new(Topology::new(3, vec![[0, 1, 2]]));
        let rest = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let part = PartRef { topology: &topology, rest: &rest, garment_layer: 0, self_collision: true, thickness: 0.01 };
        Surface::new(&[part; 5]).expect("five cloths")
    }

    fn of_lengths<'a>(contours: &'a [(Contour, [u16; 2])]) -> impl Iterator<Item = (&'a Contour, [u16; 2])> {
        contours.iter().map(|(contour, parts)| (contour, *parts))
    }

    #[test]
    fn cloths_that_are_tangled_with_each_other_are_put_back_and_others_are_not() {
        let surface = surface();
        let contour = |length: f32, parts: [u16; 2]| (Contour { length, ..Contour::default() }, parts);
        // 1 and 3 are tangled by way of 4, with 100 m in place of 10; 0 and 2 come apart.
        let before = [contour(8.0, [4, 1]), contour(2.0, [3, 4]), contour(9.0, [0, 2])];
        let after = [contour(50.0, [1, 4]), contour(50.0, [3, 3]), contour(4.0, [2, 0])];
        let start: Vec<Vec4> = (0..15).map(|i| vec3(i as f32, 0.0, 0.0).extend(1.0)).collect();
        let (mut positions, mut previous) = (start.clone(), start.clone());
        let mut undo = Undo::default();
        undo.begin(&surface, &positions, of_lengths(&before));
        positions.iter_mut().for_each(|x| x.y += 1.0);
        previous.iter_mut().for_each(|x| x.y += 0.5);
        assert!(undo.end(&surface, of_lengths(&after), &mut positions, &mut previous));
        for part in 0..5u16 {
            let is_back = [1, 3, 4].contains(&part);
            assert_eq!(undo.has_undone(part), is_back, "{part}");
            for v in surface.parts[usize::from(part)].particles.clone() {
                let (x, old, start) = (positions[v as usize], previous[v as usize], start[v as usize]);
                assert_eq!(x, if is_back { start } else { start + Vec4::Y });
                assert_eq!(x - old, 0.5 * Vec4::Y, "velocity");
            }
        }
        // Put back, 4 crosses 2, which crossed nothing of that knot; 0 is left alone.
        let crossing = [contour(1.0, [2, 4]), contour(1.0, [1, 3])];
        assert!(undo.follow(&surface, of_lengths(&crossing), &mut positions, &mut previous));
        assert!(undo.has_undone(2) && !undo.has_undone(0));
        assert_eq!(positions[6..9], start[6..9]);
        assert!(!undo.follow(&surface, of_lengths(&crossing), &mut positions, &mut previous));
        undo.forget();
        assert!(!undo.is_due());
    }

    #[test]
    fn what_grows_a_little_in_every_frame_is_put_back_too_and_what_gets_shorter_never_is() {
        let surface = surface();
        let mut undo = Undo::default();
        // Whether a frame that begins and ends with such lengths [m] is undone.
        let frame = |undo: &mut Undo, before: f32, after: f32| {
            let of = |length: f32| [(Contour { length, ..Contour::default() }, [0u16, 1u16])];
            let (mut positions, mut previous) = (vec![Vec4::ONE; 15], vec![Vec4::ONE; 15]);
            undo.begin(&surface, &positions, of_lengths(&of(before)));
            undo.end(&surface, of_lengths(&of(after)), &mut positions, &mut previous)
        };
        assert!(!frame(&mut undo, 100.0, 140.0) && frame(&mut undo, 140.0, 180.0), "1.4 times as long, then 1.8");
        assert!(!frame(&mut undo, 300.0, 290.0), "made longer by something else, then shorter");
        assert!(!frame(&mut undo, 290.0, 40.0) && frame(&mut undo, 40.0, 70.0), "the least counts");
        assert!(!frame(&mut undo, 40.0, 0.0) && !frame(&mut undo, 100.0, 140.0), "apart, then another tangle");
        undo.forget_least();
        assert!(!frame(&mut undo, 300.0, 400.0), "another tangle after nothing crossed at all");
    }
}
