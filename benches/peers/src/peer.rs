//! What every engine is asked for.

use std::fmt;

use clap::ValueEnum;

/// Length of a frame [s].
pub const FRAME: f32 = 1.0 / 60.0;

/// Areal density of the sheet [kg/m²]; its side is 1 m.
pub const DENSITY: f32 = 0.3;

/// Radius of the ball [m]; its centre is the origin.
pub const BALL_RADIUS: f32 = 0.3;

/// Height from which the sheet falls on the ball [m].
pub const FALL_FROM: f32 = 0.5;

/// Engines, in the order of the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    /// `bevy_drape`.
    Ours,
    /// `bevy_silk` 0.10.
    Silk,
    /// `rapier3d` 0.36.1.
    Rapier,
}

impl Engine {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Ours, Self::Silk, Self::Rapier];
}

impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ours => "ours",
            Self::Silk => "silk",
            Self::Rapier => "rapier",
        })
    }
}

/// Scenes, in the order of the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// The sheet starts flat and level, pinned at two corners.
    Hang,
    /// The sheet falls on a ball; it does not collide with itself.
    Ball,
    /// As [`Self::Hang`], and it collides with itself.
    HangSelf,
    /// As [`Self::Ball`], and it collides with itself.
    BallSelf,
}

impl Scene {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Hang, Self::Ball, Self::HangSelf, Self::BallSelf];

    /// Whether the sheet falls on a ball; else it hangs.
    pub fn has_ball(self) -> bool {
        matches!(self, Self::Ball | Self::BallSelf)
    }

    /// Whether the sheet collides with itself.
    pub fn meets_itself(self) -> bool {
        matches!(self, Self::HangSelf | Self::BallSelf)
    }
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Hang => "hang",
            Self::Ball => "ball",
            Self::HangSelf => "hang, self-collision",
            Self::BallSelf => "ball, self-collision",
        })
    }
}

/// Constraints solved in a frame, each as often as it was swept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Solved {
    /// Distance constraints against stretch and shear.
    pub springs: u64,
    /// All that hold the cloth together: springs, bending, tethers. Contacts are not counted.
    pub all: u64,
}

/// A sheet on one engine. Vertex `(i, j)` has index `i * size + j`; where it hangs `(0, 0)` and `(0, size - 1)` are pinned.
pub trait Peer {
    /// Advances by one [`FRAME`].
    fn step(&mut self) -> Solved;

    /// Where the vertices are [m].
    fn positions(&self) -> Vec<[f32; 3]>;

    /// Pairs of vertices that the engine itself holds at their distance: stretch and shear, not bending.
    fn springs(&self) -> Vec<[u32; 2]>;

    /// What a frame costs without a cloth [s]; taken off each measured frame.
    fn overhead(&self) -> f64 {
        0.0
    }
}
