//! How tangled cloth is, and how strong the means are that are used against it.

/// How tangled a surface is; of what is not held as it is, by pins or by the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Verdict {
    /// Edges that cross faces.
    pub crossings: u32,
    /// Intersection curves.
    pub contours: u32,
    /// Length of all curves `[m]`.
    pub contour_length: f32,
    /// Contours that cut a piece off a sheet.
    pub regions: u32,
    /// Edges that crossed faces elsewhere, where so much may cross that each look is at a part of the cloth. They are counted
    /// when that part was looked at.
    pub elsewhere: u32,
}

impl Verdict {
    /// Edges that cross faces, where they were looked at last.
    #[must_use]
    pub(crate) fn all_crossings(&self) -> u32 {
        self.crossings.saturating_add(self.elsewhere)
    }

    /// Whether nothing crosses.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.crossings == 0 && self.elsewhere == 0
    }
}

/// Stronger and stronger means against a tangle that stays, in the order in which they are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum Escalation {
    /// None: by end type.
    #[default]
    None,
    /// Regions and ways apart for all contours, whatever their ends.
    Regions,
    /// More directions in which sides can go apart.
    Candidates,
    /// The tangled part is drawn to the shape at rest, or to the animated pose.
    Blend,
}

impl Escalation {
    /// What to use after so much time tangled `[s]`: each stands for as long as the first waited.
    #[must_use]
    pub fn after(tangled_for: f32, first: f32) -> Self {
        if tangled_for < first {
            Self::None
        } else if tangled_for < 2.0 * first {
            Self::Regions
        } else if tangled_for < 3.0 * first {
            Self::Candidates
        } else {
            Self::Blend
        }
    }
}
