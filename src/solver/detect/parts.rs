//! Looks at a part of the cloth each, where one look at all of it would be too much work.
//!
//! ```text
//!   round:   │ part │ part │ part │      each goes on where the one before stopped; at the end of a round nothing crosses
//!            └──────┴──────┴──────┘      if none of its looks found anything
//! ```

use crate::solver::effort::Effort;

/// How much a look may be at, and what looks at other parts of the cloth found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Parts {
    /// Work that one look may be.
    pub most: Effort,
    /// Whether the last look was at all of the cloth.
    pub is_whole: bool,
    /// Crossings elsewhere, when a look was there; at least 1 before the first one.
    pub elsewhere: u32,
    /// Crossings found in this round, and in all of the round before, if there was one.
    round: u32,
    before: Option<u32>,
}

impl Default for Parts {
    fn default() -> Self {
        Self { most: Effort::UNBOUNDED, is_whole: true, elsewhere: 0, round: 0, before: None }
    }
}

impl Parts {
    /// Notes how many crossings a look found, and whether it was at the first part of a round, and at the last.
    pub(super) fn note(&mut self, found: u32, [is_first, is_last]: [bool; 2]) {
        self.is_whole = is_first && is_last;
        let so_far = if is_first { 0 } else { self.round };
        self.round = so_far + found;
        self.elsewhere = match (is_last, self.before) {
            (true, _) => so_far,
            (false, Some(before)) => so_far.max(before.saturating_sub(found)),
            // What was not looked at may cross.
            (false, None) => so_far.max(1),
        };
        if is_last {
            self.before = (!self.is_whole).then_some(self.round);
        }
    }

    /// Notes that a look was at all that can cross.
    pub(super) fn note_whole(&mut self) {
        (self.is_whole, self.elsewhere) = (true, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cloth_is_clean_when_all_looks_of_a_round_found_nothing() {
        const FIRST: [bool; 2] = [true, false];
        const NEXT: [bool; 2] = [false, false];
        const LAST: [bool; 2] = [false, true];
        let mut parts = Parts::default();
        let mut elsewhere = |looks: &[(u32, [bool; 2])]| -> Vec<u32> {
            let look = |&(found, part): &(u32, [bool; 2])| {
                parts.note(found, part);
                parts.elsewhere
            };
            looks.iter().map(look).collect()
        };
        assert_eq!(elsewhere(&[(0, FIRST), (2, NEXT), (0, LAST)]), [1, 1, 2], "nobody had looked at all of it");
        assert_eq!(elsewhere(&[(0, FIRST), (0, NEXT), (0, LAST)]), [2, 2, 0], "two crossed in the round before");
        assert_eq!(elsewhere(&[(0, FIRST), (3, NEXT), (0, NEXT), (0, LAST)]), [0, 0, 3, 3], "new ones");
        assert_eq!(elsewhere(&[(5, [true; 2]), (0, FIRST)]), [0, 1], "all of it at once, and of parts nothing is known");
    }
}
