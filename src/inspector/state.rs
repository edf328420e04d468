//! What the panel remembers.

use bevy::prelude::*;

use super::history::{History, Sample};
use super::plots::Curves;
use super::settings::ClothSettings;
use super::specimen::Specimen;
use crate::components::{Cloth, ClothReport, ClothSkipFrame};
use crate::simulation::ClothParticles;

/// What the panel shows and remembers.
#[derive(Resource, Default)]
pub struct ClothInspector {
    /// Whether the window is open.
    pub open: bool,
    /// The cloth that is shown. The first one when it is none, or gone.
    pub selected: Option<Entity>,
    /// The cloth whose rows were drawn last: what was typed there is taken before another one is shown.
    pub(super) shown: Option<Entity>,
    /// Settings kept to be compared.
    pub(super) kept: [Option<ClothSettings>; 2],
    /// Name of the file to save to and load from.
    pub(super) file: String,
    /// The last that was copied.
    pub(super) copied: String,
    /// What the last action led to, or why it failed.
    pub(super) note: Option<Result<String, String>>,
    pub(super) actions: Vec<Action>,
    pub(super) history: History,
    /// Whether it was drawn in this frame.
    pub(super) drawn: bool,
    /// The cloth that the history is of.
    pub(super) recorded: Option<Entity>,
    pub(super) curves: Curves,
    pub(super) specimen: Specimen,
}

impl ClothInspector {
    /// What the selected cloth did in the last ten seconds.
    #[must_use]
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Shows what an action led to.
    pub(super) fn say(&mut self, note: Result<String, String>) {
        self.note = Some(note);
    }
}

/// What was asked for, until `actions` does it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// One frame.
    Step,
    /// Back to the pose at rest, without speed.
    Reset(Entity),
    /// Folded through itself.
    Fold(Entity),
    /// Pushed through the nearest other cloth.
    Push(Entity),
    /// Its next frame written to a file.
    #[cfg(feature = "record")]
    Record(Entity),
}

/// Keeps what the selected cloth did, while the panel is open or drawn and time flows.
pub(super) fn record(
    time: Res<Time>,
    mut inspector: ResMut<ClothInspector>,
    cloths: Query<(Entity, &ClothReport, &ClothSkipFrame, Option<&ClothParticles>), With<Cloth>>,
) {
    let inspector = &mut *inspector;
    let drawn = core::mem::take(&mut inspector.drawn);
    if !(inspector.open || drawn) {
        return;
    }
    if inspector.selected.is_none_or(|cloth| !cloths.contains(cloth)) {
        inspector.selected = cloths.iter().map(|(entity, ..)| entity).min();
    }
    if inspector.recorded != inspector.selected {
        inspector.recorded = inspector.selected;
        inspector.history.clear();
    }
    if time.delta_secs() > 0.0
        && let Some((_, report, skip, Some(particles))) = inspector.selected.and_then(|cloth| cloths.get(cloth).ok())
    {
        inspector.history.record(Sample::of(time.elapsed_secs_f64(), report, particles, skip));
    }
}
