//! The first example, without its window.

use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;

#[path = "../../examples/hello_cloth.rs"]
#[allow(dead_code, reason = "its main opens a window")]
mod hello_cloth;

#[test]
fn the_readme_shows_the_first_example() {
    let read = |file: &str| std::fs::read_to_string(drape_tests::root().join(file)).expect(file);
    let example = read("examples/hello_cloth.rs");
    // Without its documentation, and what the test calls is public.
    let code: Vec<_> = example.lines().filter(|line| !line.starts_with("//")).collect();
    let code = code.join("\n").replace("pub fn setup", "fn setup");
    assert!(read("README.md").contains(code.trim()), "the README shows another app than `examples/hello_cloth.rs`");
}

#[test]
fn the_first_example_has_a_cloth_that_lies_over_its_ball() {
    let mut app = app();
    app.init_asset::<StandardMaterial>().insert_resource(ClothGlobalWind::new(Vec3::new(0.5, 0.0, -1.0)));
    app.add_systems(Startup, hello_cloth::setup);
    // What starts up was over before it was added.
    app.world_mut().run_schedule(Startup);
    run(&mut app, 1);
    let cloth = app.world_mut().query_filtered::<Entity, With<Cloth>>().single(app.world()).expect("one cloth");
    let mut touches = 0;
    for _ in 0..120 {
        run(&mut app, 1);
        touches += report(&app, cloth).body_contacts;
    }
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    let low = lowest(&world_positions(&app, cloth));
    assert!(finite(&app, cloth) && low < 1.5 && report(&app, cloth).worst_edge < 1.2, "{low}");
    assert!(touches > 0);
}
