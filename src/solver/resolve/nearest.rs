//! The nearest of many points, in a tree that is halved along one axis after the other (Bentley 1975).
//!
//! ```text
//!   order: [ …  left half … | middle | … right half … ]      each half is halved again along the next axis
//! ```

use glam::Vec3;

/// Points to be asked for the nearest. Buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Nearest {
    /// Each point `[m]` with its number.
    order: Vec<(Vec3, u32)>,
    is_sorted: bool,
}

impl Nearest {
    /// Takes in other points `[m]`; they are sorted when the first is asked for.
    pub(super) fn take_in(&mut self, points: impl Iterator<Item = Vec3>) {
        self.order.clear();
        self.order.extend(points.zip(0..));
        self.is_sorted = false;
    }

    /// The number of the nearest point within `reach` `[m]` of another; of two as near the first.
    pub(super) fn find(&mut self, at: Vec3, reach: f32) -> Option<u32> {
        if !core::mem::replace(&mut self.is_sorted, true) {
            sort(&mut self.order, 0);
        }
        let mut best = (reach * reach, u32::MAX);
        search(&self.order, 0, at, &mut best);
        (best.1 < u32::MAX).then_some(best.1)
    }
}

fn sort(points: &mut [(Vec3, u32)], axis: usize) {
    if points.len() < 2 {
        return;
    }
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (left, right) = points.split_at_mut(middle);
    sort(left, (axis + 1) % 3);
    sort(&mut right[1..], (axis + 1) % 3);
}

/// Improves on the `best` squared distance `[m²]` and number so far.
fn search(points: &[(Vec3, u32)], axis: usize, at: Vec3, best: &mut (f32, u32)) {
    let middle = points.len() / 2;
    let Some(&(point, number)) = points.get(middle) else { return };
    let square = point.distance_squared(at);
    if square < best.0 || (square == best.0 && number < best.1 && best.1 < u32::MAX) {
        *best = (square, number);
    }
    let beyond = at[axis] - point[axis];
    let (left, right) = (&points[..middle], &points[middle + 1..]);
    let (near, far) = if beyond < 0.0 { (left, right) } else { (right, left) };
    search(near, (axis + 1) % 3, at, best);
    if beyond * beyond <= best.0 {
        search(far, (axis + 1) % 3, at, best);
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    #[test]
    fn the_nearest_is_that_of_a_look_at_all() {
        let mut rng = fastrand::Rng::with_seed(1);
        // On a lattice, so that many are as near as each other.
        let mut place = || vec3(rng.u8(0..6).into(), rng.u8(0..6).into(), rng.u8(0..3).into());
        let points: Vec<Vec3> = (0..200).map(|_| place()).collect();
        let mut nearest = Nearest::default();
        nearest.take_in(points.iter().copied());
        for _ in 0..200 {
            let at = place() + 0.5 * Vec3::X;
            let square = |p: &Vec3| p.distance_squared(at);
            let all = (0..).zip(&points).filter(|(_, p)| square(p) < 1.5 * 1.5);
            let expected = all.min_by(|a, b| square(a.1).total_cmp(&square(b.1))).map(|(i, _)| i);
            assert_eq!(nearest.find(at, 1.5), expected, "at {at}");
        }
    }
}
