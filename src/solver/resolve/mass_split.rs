//! Who gives way: two bodies move apart in inverse proportion to their masses.

use glam::Vec4;

/// How much each of two bodies moves, sum 2, from their masses. The lighter one moves more, and one that holds pins only when
/// the other does too.
pub(super) fn shares(masses: [Load; 2]) -> [f32; 2] {
    let yields = |l: Load| l.mass > 0.0;
    match (yields(masses[0]), yields(masses[1])) {
        (false, false) => [0.0, 0.0],
        (true, false) => [2.0, 0.0],
        (false, true) => [0.0, 2.0],
        (true, true) => match (masses[0].pinned, masses[1].pinned) {
            (false, true) => [2.0, 0.0],
            (true, false) => [0.0, 2.0],
            _ => {
                let sum = masses[0].mass + masses[1].mass;
                [2.0 * masses[1].mass / sum, 2.0 * masses[0].mass / sum]
            }
        },
    }
}

/// Mass `[kg]` of the free particles of a body, and whether some are pinned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Load {
    pub mass: f32,
    pub pinned: bool,
}

pub(super) fn load(positions: &[Vec4], particles: impl IntoIterator<Item = u32>) -> Load {
    let mut sum = Load::default();
    for v in particles {
        let w = positions[v as usize].w;
        if w > 0.0 {
            sum.mass += w.recip();
        } else {
            sum.pinned = true;
        }
    }
    sum
}
