//! The table of all settings: one line each drives its row in the panel, its tests, and what differs between A and B.

mod air;
mod contact;
mod material;
mod solver;

use super::setting::{Part, Setting};

/// The settings of a part, in the order of its fields. Those of the pins depend on the cloth and are not in the table.
#[must_use]
pub const fn settings_of(part: Part) -> &'static [Setting] {
    match part {
        Part::Material => &material::MATERIAL,
        Part::Solver => &solver::SOLVER,
        Part::Collision => &contact::COLLISION,
        Part::Untangle => &contact::UNTANGLE,
        Part::Skip => &contact::SKIP,
        Part::OwnWind => &air::OWN_WIND,
        Part::Pins => &[],
        Part::Wind => &air::WIND,
        Part::Gravity => &air::GRAVITY,
    }
}

/// Every setting, in the order of the panel.
pub fn settings() -> impl Iterator<Item = &'static Setting> {
    Part::ALL.into_iter().flat_map(settings_of)
}
