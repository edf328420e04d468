//! How far two sheets have come apart, in the three states of the paper.

use std::fmt;

use bevy::prelude::*;
use bevy_drape::prelude::*;

/// The three states of the paper's figures 4 and 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    /// More than a third is left of the most that crossed.
    Tangled,
    /// A third is left, or less: where the method of 2006 stops.
    MostlySeparated,
    /// Nothing crosses.
    Separated,
}

impl State {
    /// The state with so many crossings now, and so many at the worst.
    pub fn of(crossings: u32, most: u32) -> Self {
        match crossings {
            0 => Self::Separated,
            n if 3 * n <= most => Self::MostlySeparated,
            _ => Self::Tangled,
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tangled => "tangled",
            Self::MostlySeparated => "mostly separated",
            Self::Separated => "fully separated",
        })
    }
}

/// The most that ever crossed.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Most(pub u32);

/// Keeps count.
pub fn remember(cloths: Query<(&ClothReport, &mut Most)>) {
    for (report, mut most) in cloths {
        most.0 = most.0.max(report.crossings);
    }
}
