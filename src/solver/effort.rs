//! How much work a frame may do. Work is counted, not timed, so that it is the same on every machine and for any number of
//! threads.
//!
//! A *visit* is what is done about one particle, edge, crossing or pair of faces, some ten nanoseconds of it. The work of a
//! frame that is in proportion to the size of its cloth needs no count. What can grow beyond that is counted, and goes on in
//! the next frame where it is too much.

use core::cell::Cell;

/// Visits that were made and that may be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Effort {
    most: u64,
    spent: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self::UNBOUNDED
    }
}

impl Effort {
    /// Whatever it takes.
    pub const UNBOUNDED: Self = Self { most: u64::MAX, spent: 0 };

    /// `visits` for each of `faces`.
    #[must_use]
    pub(crate) fn per_face(visits: u32, faces: usize) -> Self {
        Self { most: u64::from(visits) * faces as u64, spent: 0 }
    }

    /// The same for `factor` times (dimensionless) as many visits, none of them made.
    #[must_use]
    pub(crate) fn times(&self, factor: f32) -> Self {
        Self { most: (self.most as f64 * f64::from(factor)) as u64, spent: 0 }
    }

    /// Counts visits.
    #[inline]
    pub(crate) fn spend(&mut self, visits: usize) {
        self.spent = self.spent.saturating_add(visits as u64);
    }

    /// Whether so many visits are less than may be made.
    #[must_use]
    pub(crate) const fn allows(&self, visits: usize) -> bool {
        (visits as u64) < self.most
    }

    /// For one walk that may take all of it by itself, whatever was spent before.
    #[must_use]
    pub(crate) const fn meter(&self) -> Meter {
        Meter { most: self.most, spent: Cell::new(0) }
    }

    /// Visits made so far.
    #[must_use]
    pub const fn spent(&self) -> u64 {
        self.spent
    }

    /// Whether no more visits may be made.
    #[inline]
    #[must_use]
    pub(crate) const fn is_spent(&self) -> bool {
        self.spent >= self.most
    }
}

/// Counts the visits of one walk: those of who walks and of who is shown what is found.
#[derive(Clone, Debug)]
pub(crate) struct Meter {
    most: u64,
    spent: Cell<u64>,
}

impl Meter {
    /// Counts visits.
    #[inline]
    pub(crate) fn spend(&self, visits: usize) {
        self.spent.set(self.spent.get() + visits as u64);
    }

    /// Visits made so far.
    #[must_use]
    pub(crate) const fn spent(&self) -> usize {
        self.spent.get() as usize
    }

    /// Lets no more visits be made.
    pub(crate) fn exhaust(&self) {
        self.spent.set(self.spent.get().max(self.most));
    }

    /// Whether the walk is to stop.
    #[inline]
    #[must_use]
    pub(crate) const fn is_spent(&self) -> bool {
        self.spent.get() >= self.most
    }
}
