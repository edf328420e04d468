//! What cloth costs and how it fares, as Bevy's diagnostics.

use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::prelude::*;

use crate::components::{Cloth, ClothDetail, ClothReport};
use crate::islands::{ClothIsland, ClothIslands};
use crate::schedule;
use crate::simulation::{ClothParticles, ClothRest};

/// Measures all cloths together, once for every frame that is shown.
///
/// Times are those of the last simulated frame, summed over cloths that are not stepped in the background. With several threads
/// the frame takes less. [`ClothReport`] has them for each cloth.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{prelude::*, ClothDiagnosticsPlugin};
/// # fn add(app: &mut App) {
/// app.add_plugins(ClothDiagnosticsPlugin);
/// // With Bevy's `dev_tools`: `commands.spawn(DiagnosticsOverlay::new("Cloth", ClothDiagnosticsPlugin::TIMES.map(Into::into).into()))`
/// # }
/// ```
///
/// # Panics
/// Without [`ClothPlugin`](crate::ClothPlugin).
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothDiagnosticsPlugin;

impl ClothDiagnosticsPlugin {
    /// Time of Integrate `[ms]`.
    pub const INTEGRATE: DiagnosticPath = DiagnosticPath::const_new("cloth/integrate");
    /// Time of Detect `[ms]`.
    pub const DETECT: DiagnosticPath = DiagnosticPath::const_new("cloth/detect");
    /// Time of Resolve `[ms]`.
    pub const RESOLVE: DiagnosticPath = DiagnosticPath::const_new("cloth/resolve");
    /// Time of Evaluate `[ms]`.
    pub const EVALUATE: DiagnosticPath = DiagnosticPath::const_new("cloth/evaluate");
    /// Time of Respond `[ms]`.
    pub const RESPOND: DiagnosticPath = DiagnosticPath::const_new("cloth/respond");
    /// Time of Sync `[ms]`.
    pub const SYNC: DiagnosticPath = DiagnosticPath::const_new("cloth/sync");
    /// Particles of all cloths.
    pub const PARTICLES: DiagnosticPath = DiagnosticPath::const_new("cloth/particles");
    /// Springs of all cloths.
    pub const SPRINGS: DiagnosticPath = DiagnosticPath::const_new("cloth/springs");
    /// Pairs of cloth that touch, and particles that touch a body.
    pub const CONTACTS: DiagnosticPath = DiagnosticPath::const_new("cloth/contacts");
    /// Edges that cross faces.
    pub const CROSSINGS: DiagnosticPath = DiagnosticPath::const_new("cloth/crossings");
    /// Intersection curves.
    pub const CONTOURS: DiagnosticPath = DiagnosticPath::const_new("cloth/contours");
    /// Cloths of which the last frame put work off.
    pub const DEFERRED: DiagnosticPath = DiagnosticPath::const_new("cloth/deferred");
    /// Frames held in a row by the cloth that is held for longest.
    pub const HELD_FRAMES: DiagnosticPath = DiagnosticPath::const_new("cloth/held_frames");
    /// Cloths that [`ClothBudget`](crate::ClothBudget) leaves less than all detail.
    pub const LOWERED: DiagnosticPath = DiagnosticPath::const_new("cloth/lowered");
    /// Cloths whose frames run in the background, since one takes longer than [`ClothBudget`](crate::ClothBudget).
    pub const IN_BACKGROUND: DiagnosticPath = DiagnosticPath::const_new("cloth/in_background");
    /// Cloths that sleep.
    pub const SLEEPING: DiagnosticPath = DiagnosticPath::const_new("cloth/sleeping");

    /// The times, in the order of the frame.
    pub const TIMES: [DiagnosticPath; 6] =
        [Self::INTEGRATE, Self::DETECT, Self::RESOLVE, Self::EVALUATE, Self::RESPOND, Self::SYNC];
    /// The counts.
    pub const COUNTS: [DiagnosticPath; 10] = [
        Self::PARTICLES,
        Self::SPRINGS,
        Self::CONTACTS,
        Self::CROSSINGS,
        Self::CONTOURS,
        Self::DEFERRED,
        Self::HELD_FRAMES,
        Self::LOWERED,
        Self::IN_BACKGROUND,
        Self::SLEEPING,
    ];
}

impl Plugin for ClothDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        for path in Self::TIMES {
            app.register_diagnostic(Diagnostic::new(path).with_suffix(" ms"));
        }
        for path in Self::COUNTS {
            // A count is what it is, not a mean.
            app.register_diagnostic(Diagnostic::new(path).with_smoothing_factor(0.0));
        }
    }

    fn finish(&self, app: &mut App) {
        schedule::after_sync(app, measure);
    }
}

fn measure(
    mut diagnostics: Diagnostics,
    islands: Res<ClothIslands>,
    cloths: Query<(&ClothReport, &ClothRest, &ClothParticles), With<Cloth>>,
) {
    type Plugin = ClothDiagnosticsPlugin;
    let times: [fn(&ClothReport) -> f32; 6] =
        [|r| r.integrate_ms, |r| r.detect_ms, |r| r.resolve_ms, |r| r.evaluate_ms, |r| r.respond_ms, |r| r.sync_ms];
    for (path, of) in Plugin::TIMES.into_iter().zip(times) {
        let in_frame = cloths.iter().map(|(report, ..)| report).filter(|report| !report.in_background);
        diagnostics.add_measurement(&path, || in_frame.map(|report| f64::from(of(report))).sum());
    }
    let sum = |of: fn((&ClothReport, &ClothRest, &ClothParticles)) -> usize| cloths.iter().map(of).sum::<usize>() as f64;
    diagnostics.add_measurement(&Plugin::PARTICLES, || sum(|(_, _, particles)| particles.len()));
    diagnostics.add_measurement(&Plugin::SPRINGS, || sum(|(_, rest, _)| rest.shape().springs.count));
    // What two cloths share is counted once.
    let total = |of: fn(&ClothIsland) -> u32| islands.list.iter().map(of).sum::<u32>();
    diagnostics.add_measurement(&Plugin::CONTACTS, || {
        sum(|(report, ..)| report.body_contacts as usize) + f64::from(total(ClothIsland::touching))
    });
    diagnostics.add_measurement(&Plugin::CROSSINGS, || f64::from(total(|island| island.total().all_crossings())));
    diagnostics.add_measurement(&Plugin::CONTOURS, || f64::from(total(|island| island.total().contours)));
    diagnostics.add_measurement(&Plugin::DEFERRED, || sum(|(report, ..)| usize::from(report.deferred)));
    diagnostics.add_measurement(&Plugin::HELD_FRAMES, || {
        f64::from(cloths.iter().map(|(report, ..)| report.held_frames).max().unwrap_or(0))
    });
    diagnostics.add_measurement(&Plugin::LOWERED, || sum(|(report, ..)| usize::from(report.by_budget > ClothDetail::Full)));
    diagnostics.add_measurement(&Plugin::IN_BACKGROUND, || sum(|(report, ..)| usize::from(report.in_background)));
    diagnostics.add_measurement(&Plugin::SLEEPING, || sum(|(report, ..)| usize::from(report.asleep)));
}
