//! The panel in a harness, over a headless app.

use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy_drape::inspector::{ClothInspector, ClothInspectorPlugin, ClothSettings, cloth_inspector};
use bevy_drape::prelude::*;
use bevy_egui::egui::accesskit::Role;
use bevy_egui::egui::{Key, Modifiers, OutputCommand};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::common::*;

/// An app with two cloths under the panel.
pub struct Panel {
    pub harness: Harness<'static, App>,
    pub cloth: Entity,
    pub other: Entity,
    /// What was copied last.
    pub copied: Option<String>,
}

/// An app with the panel but without a window.
pub fn app_with_panel() -> App {
    let panel = ClothInspectorPlugin { window: false, open: true, key: None, ..default() };
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, ClothPlugin::default(), panel));
    frame_length(&mut app, FRAME);
    app.finish();
    app.cleanup();
    // The first update of a manual clock has no length.
    app.update();
    app
}

impl Panel {
    /// A hanging cloth and another far away, every section of the panel open.
    pub fn new() -> Self {
        let mut app = app_with_panel();
        let cloth = spawn(&mut app, sheet(8), (Name::new("first"), border(), Transform::from_xyz(0.0, 2.0, 0.0)));
        let other = spawn(&mut app, sheet(8), (Name::new("second"), border(), Transform::from_xyz(5.0, 2.0, 0.0)));
        run(&mut app, 3);
        Self::over(app, cloth, other)
    }

    /// The panel of an app, with `cloth` picked.
    pub fn over(mut app: App, cloth: Entity, other: Entity) -> Self {
        app.world_mut().resource_mut::<ClothInspector>().selected = Some(cloth);
        // So high that nothing has to be scrolled into view.
        let harness = Harness::builder()
            .with_size([520.0, 6000.0])
            .build_ui_state(|ui, app: &mut App| cloth_inspector(ui, app.world_mut()), app);
        let mut panel = Self { harness, cloth, other, copied: None };
        panel.steps(3);
        panel
    }

    /// Opens every section.
    pub fn opened(mut self) -> Self {
        let headings = bevy_drape::inspector::Part::ALL.map(bevy_drape::inspector::Part::heading);
        for heading in headings {
            if heading != "Material" {
                self.harness.get_by_label(heading).click();
                self.steps(2);
            }
        }
        self.steps(6);
        self
    }

    pub fn app(&mut self) -> &mut App {
        self.harness.state_mut()
    }

    /// Settings of the picked cloth.
    pub fn settings(&mut self) -> ClothSettings {
        let cloth = self.cloth;
        ClothSettings::read(self.app().world(), cloth).expect("a cloth")
    }

    /// Settings of the other one.
    pub fn others(&mut self) -> ClothSettings {
        let other = self.other;
        ClothSettings::read(self.app().world(), other).expect("a cloth")
    }

    /// Frames of the panel; what they copy is kept.
    pub fn steps(&mut self, steps: usize) {
        for _ in 0..steps {
            self.harness.step();
            for command in &self.harness.output().platform_output.commands {
                if let OutputCommand::CopyText(text) = command {
                    self.copied = Some(text.clone());
                }
            }
        }
    }

    /// Clicks what is called so.
    pub fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.steps(3);
    }

    /// Types into the field that is called so, in place of what is there, and ends it with Enter.
    pub fn type_into(&mut self, label: &str, text: &str) {
        self.begin_typing(label, text);
        self.harness.key_press(Key::Enter);
        self.steps(2);
    }

    /// Types into the field that is called so, in place of what is there, and stays in it.
    pub fn begin_typing(&mut self, label: &str, text: &str) {
        self.harness.get_by_role_and_label(Role::TextInput, label).click();
        self.steps(2);
        self.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
        self.steps(1);
        self.harness.get_by_role_and_label(Role::TextInput, label).type_text(text);
        self.steps(1);
    }

    /// The first text with these words that is shown.
    pub fn text(&self, words: &str) -> Option<String> {
        let node = self.harness.query_all_by_label_contains(words).next()?.accesskit_node();
        node.label().or_else(|| node.value())
    }

    /// Whether a text with these words is shown.
    pub fn shows(&self, words: &str) -> bool {
        self.harness.query_all_by_label_contains(words).next().is_some()
    }
}
