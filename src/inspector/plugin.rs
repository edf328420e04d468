//! The plugin: a window that a key opens, and a click that picks a cloth. Input over the panel is kept from the game.

use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseMotion};
use bevy::prelude::*;
use bevy_egui::{
    EguiContext, EguiGlobalSettings, EguiPlugin, EguiPreUpdateSet, EguiPrimaryContextPass, PrimaryEguiContext, egui,
    input::EguiWantsInput,
};

use super::actions::act;
use super::panel::cloth_inspector;
use super::pick::pick;
use super::state::{ClothInspector, record};
#[cfg(feature = "debug")]
use crate::schedule::after_sync;

/// The panel in a window of its own.
///
/// Adds the `EguiPlugin` of `bevy_egui` unless it is there: an app that adds it itself does so before this one. The panel shows
/// on the first camera, as all of `bevy_egui` does; mark another one with `PrimaryEguiContext`.
#[derive(Clone, Debug)]
pub struct ClothInspectorPlugin {
    /// Key that opens and closes the window. Default `I`; none leaves that to [`ClothInspector::open`].
    pub key: Option<KeyCode>,
    /// Whether the window is open at the start. Default false.
    pub open: bool,
    /// Whether keys and mouse over the panel are kept from the game. Default true. They are taken from `ButtonInput` and from
    /// the messages and sums of the mouse. `CursorMoved` goes on. Without the feature `picking` so do `Pointer` events, whose
    /// listeners ask `EguiWantsInput`.
    pub absorbs_input: bool,
    /// Whether there is a window. Default true. Without it, the app calls [`cloth_inspector`] in a window of its own, and egui
    /// is up to the app. The plugin does what the buttons ask for, and keeps the history while the panel is drawn.
    pub window: bool,
}

impl Default for ClothInspectorPlugin {
    fn default() -> Self {
        Self { key: Some(KeyCode::KeyI), open: false, absorbs_input: true, window: true }
    }
}

impl Plugin for ClothInspectorPlugin {
    fn build(&self, app: &mut App) {
        let &Self { key, open, absorbs_input, window } = self;
        app.insert_resource(ClothInspector { open, ..default() }).add_systems(PreUpdate, act).add_systems(Last, record);
        if let Some(key) = key {
            let pressed = move |keys: Option<Res<ButtonInput<KeyCode>>>, egui: Option<Res<EguiWantsInput>>| {
                let typing = egui.is_some_and(|egui| egui.wants_any_keyboard_input());
                !typing && keys.is_some_and(|keys| keys.just_pressed(key))
            };
            app.add_systems(Update, toggle.run_if(pressed));
        }
        if !window {
            return;
        }
        if !app.is_plugin_added::<EguiPlugin>() {
            app.add_plugins(EguiPlugin::default());
        }
        if absorbs_input {
            app.world_mut().get_resource_or_init::<EguiGlobalSettings>().enable_absorb_bevy_input_system = true;
            app.add_systems(PreUpdate, absorb.after(EguiPreUpdateSet::ProcessInput));
        }
        app.add_systems(EguiPrimaryContextPass, show);
    }

    #[cfg(feature = "debug")]
    fn finish(&self, app: &mut App) {
        if self.window {
            after_sync(app, super::mark::mark.run_if(resource_exists::<Assets<GizmoAsset>>));
        }
    }
}

fn toggle(mut inspector: ResMut<ClothInspector>) {
    inspector.open = !inspector.open;
}

/// Takes what `bevy_egui` leaves: motion of the mouse, and motion and wheel that were summed up before egui looked.
fn absorb(
    wants: Res<EguiWantsInput>,
    messages: Option<ResMut<Messages<MouseMotion>>>,
    motion: Option<ResMut<AccumulatedMouseMotion>>,
    scroll: Option<ResMut<AccumulatedMouseScroll>>,
) {
    if wants.wants_any_pointer_input() {
        if let Some(mut messages) = messages {
            messages.clear();
        }
        if let Some(mut motion) = motion {
            *motion = default();
        }
        if let Some(mut scroll) = scroll {
            scroll.delta = Vec2::ZERO;
        }
    }
}

/// Draws the window, and picks the cloth that is clicked beside it.
fn show(world: &mut World) {
    if !world.get_resource::<ClothInspector>().is_some_and(|inspector| inspector.open) {
        return;
    }
    let mut contexts = world.query_filtered::<(&mut EguiContext, &Camera, &GlobalTransform), With<PrimaryEguiContext>>();
    let Ok((mut context, camera, global)) = contexts.single_mut(world) else { return };
    let context = context.get_mut().clone();
    let clicked = context.input(|input| input.pointer.interact_pos().filter(|_| input.pointer.primary_clicked()));
    let ray = clicked.filter(|_| !context.is_pointer_over_egui()).and_then(|at| {
        let at = Vec2::new(at.x, at.y) * context.zoom_factor();
        camera.viewport_to_world(global, at).ok()
    });
    if let Some(cloth) = ray.and_then(|ray| pick(world, ray)).map(|(cloth, _)| cloth)
        && let Some(mut inspector) = world.get_resource_mut::<ClothInspector>()
    {
        inspector.selected = Some(cloth);
    }
    let mut open = true;
    let area = context.content_rect();
    let (at, height) = ([area.right() - WIDTH - 3.0 * GAP, area.top() + GAP], (area.height() - 2.0 * GAP - TITLE).max(0.0));
    let window = egui::Window::new("Cloth").open(&mut open);
    // Where and how large the user made it, until there is another room for it.
    let last =
        context.data_mut(|data| core::mem::replace(data.get_temp_mut_or(egui::Id::new("cloth inspector area"), area), area));
    let window = if last == area {
        window.default_pos(at).default_size([WIDTH, height]).max_height(height).resizable(true)
    } else {
        window.current_pos(at).fixed_size([WIDTH, height])
    };
    window.show(&context, |ui| cloth_inspector(ui, world));
    if !open && let Some(mut inspector) = world.get_resource_mut::<ClothInspector>() {
        inspector.open = false;
    }
}

/// Width of the window, and its distance from the border `[points]`.
const WIDTH: f32 = 440.0;
const GAP: f32 = 10.0;
/// Height of its title and margins `[points]`.
const TITLE: f32 = 40.0;
