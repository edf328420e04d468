//! How much is solved of a cloth, its level of detail: its border, or every edge of a cloth that has none.
//!
//! ```text
//! awake ─ slow for 0.25 s ─► settling ─ within a few millimetres for 0.5 s, and so its island ─► asleep
//!   ▲                           │                                                                 │
//!   └───────────────────────────┴──────────────────── anything that moves it ─────────────────────┘
//! ```
//!
//! One with an edge far beyond the strain limit is strained: a coarse level over it is solved, too.
//! [`ClothLod`](crate::ClothLod) takes substeps off what is far away or unseen.

use bevy::prelude::*;

use super::{ClothGizmos, border, place};
use crate::components::{Cloth, ClothDetail, ClothReport};
use crate::simulation::{ClothParticles, ClothRest};

/// How a cloth is stepped: what it is at in full, and what it costs less for being far away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rest {
    Strained,
    Awake,
    Settling,
    Asleep,
    Half,
    Quarter,
    Still,
}

impl Rest {
    pub(super) const ALL: [Self; 7] =
        [Self::Strained, Self::Awake, Self::Settling, Self::Asleep, Self::Half, Self::Quarter, Self::Still];

    pub(super) fn label(self) -> &'static str {
        match self {
            Self::Strained => "strained: a coarse level is solved, too",
            Self::Awake => "awake",
            Self::Settling => "settling: slow for a while",
            Self::Asleep => "asleep: costs nothing",
            Self::Half => "half of the substeps",
            Self::Quarter => "a quarter of the substeps",
            Self::Still => "far away: carried along",
        }
    }

    pub(super) fn color(self) -> Color {
        match self {
            Self::Strained => Color::srgb_u8(204, 121, 167),
            Self::Awake => Color::srgb_u8(213, 94, 0),
            Self::Settling => Color::srgb_u8(240, 228, 66),
            Self::Asleep => Color::srgb_u8(86, 180, 233),
            Self::Half => Color::srgb_u8(0, 158, 115),
            Self::Quarter => Color::srgb_u8(0, 114, 178),
            Self::Still => Color::srgb_u8(153, 153, 153),
        }
    }

    fn of(report: &ClothReport, particles: &ClothParticles) -> Self {
        let memory = &particles.sim.memory;
        match report.detail {
            _ if report.asleep => Self::Asleep,
            ClothDetail::Half => Self::Half,
            ClothDetail::Quarter => Self::Quarter,
            ClothDetail::Still => Self::Still,
            ClothDetail::Full if memory.is_strained() => Self::Strained,
            ClothDetail::Full if memory.is_settling() => Self::Settling,
            ClothDetail::Full => Self::Awake,
        }
    }
}

pub(super) fn draw(mut gizmos: Gizmos<ClothGizmos>, cloths: Query<(&ClothRest, &ClothParticles, &ClothReport), With<Cloth>>) {
    for (rest, particles, report) in &cloths {
        let x = &particles.state().positions;
        let color = Rest::of(report, particles).color();
        for edge in border(rest.shape()) {
            let [Some(a), Some(b)] = edge.map(|v| x.get(v as usize).map(|x| place(particles.origin(), x.truncate()))) else {
                continue;
            };
            gizmos.line(a, b, color);
        }
    }
}
