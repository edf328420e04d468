//! Pointers over cloth, and cloth that they drag.

use bevy::camera::visibility::RenderLayers;
use bevy::camera::{ComputedCameraValues, NormalizedRenderTarget, RenderTargetInfo};
use bevy::mesh::MeshPlugin;
use bevy::picking::PickingSettings;
use bevy::picking::backend::{HitData, PointerHits};
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::{Location, PointerAction, PointerId, PointerInput};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::window::{PrimaryWindow, WindowRef};
use bevy_drape::prelude::*;

use crate::common::*;

/// Width and height of the picture [px].
const SCREEN: u32 = 200;
/// The pixel in the middle.
const MIDDLE: Vec2 = Vec2::splat(0.5 * SCREEN as f32);
/// Field of view of the camera [rad], and its near plane [m].
const LENS: (f32, f32) = (1.0, 0.1);
/// Height of the camera, which looks straight down [m].
const HEIGHT: f32 = 2.0;

const PRESS: PointerAction = PointerAction::Press(PointerButton::Primary);
const RELEASE: PointerAction = PointerAction::Release(PointerButton::Primary);

/// An app with a window that nobody sees, a camera above the origin with +X to the right of its picture and +Z to the bottom,
/// and a mouse.
fn picking() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin));
    app.add_plugins((PickingPlugin, InteractionPlugin, ClothPlugin::default(), ClothPickingPlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f32(FRAME)));
    app.finish();
    app.cleanup();
    let (fov, near) = LENS;
    let camera = Camera {
        order: 3,
        computed: ComputedCameraValues {
            clip_from_view: Mat4::perspective_infinite_reverse_rh(fov, 1.0, near),
            target_info: Some(RenderTargetInfo { physical_size: UVec2::splat(SCREEN), scale_factor: 1.0 }),
            ..default()
        },
        ..default()
    };
    app.world_mut().spawn((camera, Transform::from_xyz(0.0, HEIGHT, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z)));
    app.world_mut().spawn((Window::default(), PrimaryWindow));
    app.world_mut().spawn(PointerId::Mouse);
    // The first update of a manual clock has no length.
    app.update();
    app
}

/// The one entity with a component.
fn only<C: Component>(app: &mut App) -> Entity {
    let mut entities = app.world_mut().query_filtered::<Entity, With<C>>();
    entities.single(app.world()).expect("one entity")
}

/// What the mouse does at a pixel, to be seen in the next frame.
fn input(app: &mut App, position: Vec2, action: PointerAction) {
    let window = WindowRef::Entity(only::<PrimaryWindow>(app)).normalize(None).expect("a window");
    let location = Location { target: NormalizedRenderTarget::Window(window), position };
    app.world_mut().write_message(PointerInput::new(PointerId::Mouse, location, action));
}

/// Moves the mouse to a pixel and runs a frame.
fn point(app: &mut App, position: Vec2) {
    input(app, position, PointerAction::Move { delta: Vec2::X });
    app.update();
}

/// Presses the left button at a pixel.
fn press(app: &mut App, position: Vec2) {
    point(app, position);
    input(app, position, PRESS);
    app.update();
}

/// Where a pixel is at some height in the world [m].
fn at(pixel: Vec2, height: f32) -> Vec3 {
    let from_middle = (pixel - MIDDLE) / MIDDLE.x * (0.5 * LENS.0).tan() * (HEIGHT - height);
    Vec3::new(from_middle.x, height, from_middle.y)
}

/// What was found in the last frame but for the window, which is behind everything.
fn hits(app: &App) -> Vec<(Entity, HitData, f32)> {
    let messages = app.world().resource::<Messages<PointerHits>>();
    let found = messages.iter_current_update_messages().filter(|hits| hits.order.is_finite());
    found.flat_map(|hits| hits.picks.iter().map(move |(entity, hit)| (*entity, hit.clone(), hits.order))).collect()
}

/// The cloths that were found in the last frame.
fn found(app: &App) -> Vec<Entity> {
    hits(app).into_iter().map(|(entity, ..)| entity).collect()
}

/// What holds cloth.
fn grips(app: &mut App) -> Vec<ClothGrab> {
    let mut grips = app.world_mut().query::<&ClothGrab>();
    grips.iter(app.world()).cloned().collect()
}

/// A flat cloth that stays where it is, at some height.
fn board(app: &mut App, height: f32) -> Entity {
    spawn(app, sheet(9), (ClothPins::where_position(|_| true), Transform::from_xyz(0.0, height, 0.0)))
}

#[test]
#[should_panic(expected = "PickingPlugin, InteractionPlugin")]
fn an_app_without_picking_panics_with_the_line_to_write() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin));
    app.add_plugins((ClothPlugin::default(), ClothPickingPlugin));
    app.finish();
}

#[test]
fn a_pointer_finds_a_cloth_with_its_place_and_normal() {
    let mut app = picking();
    record::<Pointer<Over>>(&mut app);
    let cloth = board(&mut app, 0.5);
    run(&mut app, 2);
    let pixel = MIDDLE + Vec2::new(20.0, -10.0);
    point(&mut app, pixel);
    let hits = hits(&app);
    let [(entity, hit, order)] = hits.as_slice() else { panic!("{hits:?}") };
    assert_eq!((*entity, *order), (cloth, 3.0));
    assert_eq!(hit.camera, only::<Camera>(&mut app));
    let (place, normal) = (hit.position.expect("a place"), hit.normal.expect("a normal"));
    assert!(place.distance(at(pixel, 0.5)) < 1.0e-3, "{place} for {}", at(pixel, 0.5));
    assert!(normal.dot(Vec3::Y) > 0.999, "{normal}");
    // From the near plane.
    let slant = place.distance(Vec3::Y * HEIGHT);
    let depth = slant * (1.0 - LENS.1 / (HEIGHT - 0.5));
    assert!((hit.depth - depth).abs() < 1.0e-3, "{} m for {depth}", hit.depth);
    let detail = hit.extra_as::<ClothHit>().expect("a point of the cloth");
    assert_eq!((detail.entity, detail.point), (cloth, place));
    assert!(seen::<Pointer<Over>>(&app).iter().any(|over| over.entity == cloth));
    point(&mut app, Vec2::splat(3.0));
    assert!(found(&app).is_empty(), "beside it");
}

#[test]
fn a_cloth_is_found_where_it_is_shown_not_where_it_was_authored() {
    let mut app = picking();
    let cloth = spawn(&mut app, sheet(12), ());
    // It falls.
    run(&mut app, 20);
    let shown = world_positions(&app, cloth);
    point(&mut app, MIDDLE);
    let hits = hits(&app);
    let [(_, hit, _)] = hits.as_slice() else { panic!("{hits:?}") };
    let place = hit.position.expect("a place");
    let nearest = shown.iter().map(|p| p.distance(place)).fold(f32::INFINITY, f32::min);
    assert!(place.y < -0.1 && nearest < 0.09, "{place} is {nearest} m from what is drawn");
}

#[test]
fn what_is_not_to_be_picked_is_passed() {
    let ways: [(&str, fn(&mut EntityWorldMut)); 3] = [
        ("ignored", |cloth| {
            cloth.insert(Pickable::IGNORE);
        }),
        ("in a layer that the camera does not see", |cloth| {
            cloth.insert(RenderLayers::layer(1));
        }),
        ("hidden", |cloth| {
            cloth.insert(ViewVisibility::HIDDEN);
        }),
    ];
    for (how, hide) in ways {
        let mut app = picking();
        let [low, high] = [0.0, 0.5].map(|height| board(&mut app, height));
        run(&mut app, 2);
        point(&mut app, MIDDLE);
        assert_eq!(found(&app), [high], "both are to be picked");
        hide(&mut app.world_mut().entity_mut(high));
        point(&mut app, MIDDLE);
        assert_eq!(found(&app), [low], "the upper one is {how}");
        hide(&mut app.world_mut().entity_mut(low));
        point(&mut app, MIDDLE);
        assert!(found(&app).is_empty(), "both are {how}");
    }
}

#[test]
fn a_cloth_covers_what_is_behind_it_as_it_says() {
    let mut app = picking();
    let [low, high] = [0.0, 0.5].map(|height| board(&mut app, height));
    run(&mut app, 2);
    let hovered = |app: &App| {
        let under = app.world().resource::<HoverMap>().get(&PointerId::Mouse);
        [high, low].map(|cloth| under.is_some_and(|under| under.contains_key(&cloth)))
    };
    app.world_mut().entity_mut(high).insert(Pickable { should_block_lower: false, is_hoverable: true });
    point(&mut app, MIDDLE);
    assert_eq!((found(&app), hovered(&app)), (vec![high, low], [true, true]));
    app.world_mut().entity_mut(high).insert(Pickable { should_block_lower: true, is_hoverable: false });
    point(&mut app, MIDDLE);
    assert_eq!((found(&app), hovered(&app)), (vec![high], [false, false]));
    // Only those that are marked.
    app.insert_resource(ClothPickingSettings { require_markers: true });
    app.world_mut().entity_mut(high).remove::<Pickable>();
    point(&mut app, MIDDLE);
    assert!(found(&app).is_empty());
    app.world_mut().entity_mut(low).insert(Pickable::default());
    point(&mut app, MIDDLE);
    assert_eq!(found(&app), [low]);
}

#[test]
fn a_pointer_drags_a_cloth_and_lets_it_go() {
    let mut app = picking();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let settings = ClothDraggable { radius: 0.1, compliance: 0.002, max_force: 15.0 };
    let cloth = spawn(&mut app, sheet(12), settings);
    run(&mut app, 2);
    press(&mut app, MIDDLE);
    let held = grips(&mut app);
    let [grip] = held.as_slice() else { panic!("{held:?}") };
    assert_eq!((grip.cloth, grip.radius, grip.compliance, grip.max_force), (cloth, 0.1, 0.002, 15.0));
    assert!(grip.target.length() < 1.0e-3, "{grip:?}");
    let (corners, weights) = (grip.particles, grip.weights.to_array());
    let point_of = move |app: &App| -> Vec3 {
        let places = particles(app, cloth);
        corners.iter().zip(weights).map(|(&p, weight)| places[p as usize] * weight).sum()
    };
    for step in 1..=30_u8 {
        point(&mut app, MIDDLE + Vec2::X * f32::from(step));
    }
    let aim = at(MIDDLE + Vec2::X * 30.0, 0.0);
    let target = grips(&mut app)[0].target;
    assert!(target.distance(aim) < 1.0e-3, "{target} for {aim}");
    // It holds the weight, too.
    app.insert_resource(ClothGravity::default());
    run(&mut app, 120);
    assert!(point_of(&app).distance(aim) < 0.1, "{} for {aim}", point_of(&app));
    // Beside the picture it stays where it is.
    point(&mut app, Vec2::new(500.0, 100.0));
    assert_eq!(grips(&mut app)[0].target, target);
    point(&mut app, MIDDLE + Vec2::X * 30.0);
    // The pointer rests, and the camera moves.
    let camera = only::<Camera>(&mut app);
    app.world_mut().get_mut::<Transform>(camera).expect("a camera").translation += Vec3::new(0.2, 0.3, 0.0);
    run(&mut app, 2);
    let target = grips(&mut app)[0].target;
    assert!(target.distance(aim + Vec3::new(0.2, 0.3, 0.0)) < 1.0e-3, "{target}");
    input(&mut app, MIDDLE, RELEASE);
    app.update();
    assert!(grips(&mut app).is_empty());
    run(&mut app, 90);
    assert!(point_of(&app).y < -0.5, "{} after 1.5 s of falling", point_of(&app));
}

#[test]
fn only_a_draggable_cloth_and_only_the_first_button_grips() {
    let mut app = picking();
    let cloth = board(&mut app, 0.0);
    run(&mut app, 2);
    press(&mut app, MIDDLE);
    assert!(grips(&mut app).is_empty());
    input(&mut app, MIDDLE, RELEASE);
    app.world_mut().entity_mut(cloth).insert(ClothDraggable::default());
    app.update();
    input(&mut app, MIDDLE, PointerAction::Press(PointerButton::Secondary));
    app.update();
    assert!(grips(&mut app).is_empty());
    input(&mut app, MIDDLE, PRESS);
    app.update();
    assert_eq!(grips(&mut app).len(), 1);
    // The other button does not let go.
    input(&mut app, MIDDLE, PointerAction::Release(PointerButton::Secondary));
    app.update();
    assert_eq!(grips(&mut app).len(), 1);
    input(&mut app, MIDDLE, RELEASE);
    app.update();
    assert!(grips(&mut app).is_empty());
    // Both in one frame.
    input(&mut app, MIDDLE, PRESS);
    input(&mut app, MIDDLE, RELEASE);
    run(&mut app, 2);
    assert!(grips(&mut app).is_empty());
}

#[test]
fn a_cloth_is_let_go_however_the_drag_ends() {
    let ends: [(&str, fn(&mut App, Entity)); 7] = [
        ("the button is released beside the cloth", |app, _| {
            point(app, Vec2::splat(3.0));
            input(app, Vec2::splat(3.0), RELEASE);
        }),
        ("the pointer is cancelled", |app, _| input(app, MIDDLE, PointerAction::Cancel)),
        ("the pointer is gone", |app, _| {
            let pointer = only::<PointerId>(app);
            app.world_mut().despawn(pointer);
        }),
        ("the cloth is gone", |app, cloth| {
            app.world_mut().despawn(cloth);
        }),
        ("the cloth is none any more", |app, cloth| {
            app.world_mut().entity_mut(cloth).remove::<Cloth>();
        }),
        ("it is not draggable any more", |app, cloth| {
            app.world_mut().entity_mut(cloth).remove::<ClothDraggable>();
        }),
        ("picking is switched off", |app, _| app.world_mut().resource_mut::<PickingSettings>().is_enabled = false),
    ];
    for (how, end) in ends {
        let mut app = picking();
        let cloth = board(&mut app, 0.0);
        app.world_mut().entity_mut(cloth).insert(ClothDraggable::default());
        run(&mut app, 2);
        press(&mut app, MIDDLE);
        point(&mut app, MIDDLE + Vec2::X);
        assert_eq!(grips(&mut app).len(), 1, "{how}");
        end(&mut app, cloth);
        run(&mut app, 2);
        assert!(grips(&mut app).is_empty(), "{how}");
        // What comes late does no harm.
        point(&mut app, MIDDLE + 2.0 * Vec2::X);
        input(&mut app, MIDDLE, RELEASE);
        run(&mut app, 2);
        assert!(grips(&mut app).is_empty(), "{how}");
    }
}
