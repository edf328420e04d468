//! A panel that tunes the settings of a cloth while it moves (feature `inspector`).
//!
//! ```no_run
//! # use bevy::prelude::*;
//! # use bevy_drape::prelude::*;
//! # use bevy_drape::inspector::ClothInspectorPlugin;
//! App::new().add_plugins((DefaultPlugins, ClothPlugin::default(), ClothInspectorPlugin::default())).run();
//! ```
//!
//! `I` opens and closes it. Pick a cloth in the list or click it in the scene. Every setting has its unit, a range, a mark
//! where the default is, and a button that leads back to it. Input that makes no sense is refused with the reason. Changes take
//! effect at once and without a jump: a fabric ramps to its new stiffness over a quarter of a second. An app that has windows
//! of its own calls [`cloth_inspector`] in one of them.
//!
//! "Copy" shows the text in the panel, and with the feature `clipboard` puts it on the clipboard of the system.
//!
//! One table of descriptions ([`settings()`]) drives rows, tests and the comparison of A and B.

mod actions;
mod air;
mod compare;
#[cfg(feature = "debug")]
mod drawing;
mod entry;
mod export;
mod history;
#[cfg(feature = "debug")]
mod mark;
mod panel;
mod part;
mod pick;
mod pins;
mod plots;
mod plugin;
mod row;
mod setting;
mod settings;
mod specimen;
mod state;
mod table;
mod tangle;
mod wearer;
mod widgets;

pub use actions::STEP;
pub use compare::{differences, load, save};
pub use entry::{parse, show};
pub use export::{as_ron, as_rust, from_ron, material_as_rust};
pub use history::{History, SPAN, STAGES, Sample, Verdict};
pub use panel::cloth_inspector;
pub use part::Part;
pub use pick::pick;
pub use plugin::ClothInspectorPlugin;
pub use setting::{Field, Kind, Scale, Setting};
pub use settings::ClothSettings;
pub use state::ClothInspector;
pub use table::{settings, settings_of};
