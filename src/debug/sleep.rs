//! How much is solved of a cloth, its level of detail: its border, or every edge of a cloth that has none.
//!
//! ```text
//! awake ─ slow for 0.25 s ─► calm ─ within a few millimetres for 0.5 s, and so its group ─► asleep
//!   ▲                         │                                                               │
//!   └─────────────────────────┴────────────────────── anything that moves it ─────────────────┘
//! ```
//!
//! One with an edge far beyond the strain limit is strained: a coarse net over it is solved, too.

use bevy::prelude::*;

use super::{ClothGizmos, place};
use crate::components::{Cloth, ClothReport};
use crate::simulation::{ClothParticles, ClothRest, ClothScratch};
use crate::solver::rest::NONE;

/// What a cloth costs and how it is stepped, dearest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rest {
    Strained,
    Awake,
    Calm,
    Asleep,
}

impl Rest {
    pub(super) const ALL: [Self; 4] = [Self::Strained, Self::Awake, Self::Calm, Self::Asleep];

    pub(super) fn label(self) -> &'static str {
        match self {
            Self::Strained => "strained: a coarse net is solved, too",
            Self::Awake => "awake",
            Self::Calm => "calm: slow for a while",
            Self::Asleep => "asleep: costs nothing",
        }
    }

    pub(super) fn color(self) -> Color {
        match self {
            Self::Strained => Color::srgb_u8(204, 121, 167),
            Self::Awake => Color::srgb_u8(213, 94, 0),
            Self::Calm => Color::srgb_u8(240, 228, 66),
            Self::Asleep => Color::srgb_u8(86, 180, 233),
        }
    }

    fn of(report: &ClothReport, scratch: &ClothScratch) -> Self {
        let solver = &scratch.solver;
        match (report.asleep, solver.is_strained(), solver.is_calm()) {
            (true, ..) => Self::Asleep,
            (false, true, _) => Self::Strained,
            (false, false, true) => Self::Calm,
            (false, false, false) => Self::Awake,
        }
    }
}

pub(super) fn draw(
    mut gizmos: Gizmos<ClothGizmos>,
    cloths: Query<(&ClothRest, &ClothParticles, &ClothScratch, &ClothReport), With<Cloth>>,
) {
    for (rest, particles, scratch, report) in &cloths {
        let (topology, x) = (&rest.shape().topology, &particles.state().positions);
        let closed = !topology.edge_faces.iter().any(|faces| faces.contains(&NONE));
        let color = Rest::of(report, scratch).color();
        for (edge, _) in topology.edges.iter().zip(&topology.edge_faces).filter(|(_, faces)| closed || faces.contains(&NONE)) {
            let [Some(a), Some(b)] = edge.map(|v| x.get(v as usize).map(|x| place(particles.origin(), x.truncate()))) else {
                continue;
            };
            gizmos.line(a, b, color);
        }
    }
}
