//! Recordings: a frame that was written to a file has the same bits when it is stepped again.

use std::fs::File;
use std::path::PathBuf;

use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;
use bevy_drape::solver::recording::{Recording, RecordingError};

use crate::common::*;
use crate::snapshot::{Played, played};

/// A folder that is empty and nobody else's.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("bevy_drape_record_{}_{name}", std::process::id()));
    std::fs::remove_dir_all(&folder).ok();
    folder
}

/// Records into an app that is under way.
fn record(app: &mut App, folder: PathBuf) {
    app.insert_resource(ClothRecorder { folder, most: 1000, ..default() });
    let recorder = ClothRecorderPlugin;
    recorder.build(app);
    recorder.finish(app);
}

fn read(path: &PathBuf) -> Recording {
    Recording::read(File::open(path).expect("a file")).expect("a recording")
}

fn ask(app: &mut App) {
    let mut cloths = app.world_mut().query_filtered::<Entity, With<ClothParticles>>();
    let cloths: Vec<Entity> = cloths.iter(app.world()).collect();
    app.world_mut().resource_mut::<ClothRecorder>().next = cloths;
}

#[test]
fn a_recorded_frame_has_the_same_bits_when_it_is_stepped_again() {
    for (name, Played { mut app, happen }) in played() {
        record(&mut app, folder(&name.replace(' ', "_")));
        for frame in 0..140 {
            happen(&mut app, frame);
            if [1, 2, 5, 17, 40, 64, 70, 71, 90, 133].contains(&frame) {
                ask(&mut app);
            }
            app.update();
        }
        let recordings = app.world().resource::<ClothRecordings>();
        // What sleeps waits until it moves.
        let least = if name == "asleep" { 0 } else { 8 };
        assert!(recordings.written.len() >= least, "{name}: {} were written", recordings.written.len());
        for path in &recordings.written {
            let replay = read(path).replay();
            assert_eq!((replay.differ, replay.recovered), (0, false), "{name}: {}: {replay:?}", path.display());
        }
        if let Some(path) = recordings.written.last() {
            assert_eq!(differ_elsewhere(path), Some(0), "{name}: {}", path.display());
        }
        forget(&app);
    }
}

#[test]
#[ignore = "started by the test above in a process of its own"]
#[expect(clippy::print_stdout, reason = "tells its parent")]
fn prints_how_many_particles_differ() {
    if let Some(path) = std::env::var_os("CLOTH_RECORDING") {
        println!("elsewhere: {}", read(&path.into()).replay().differ);
    }
}

/// Particles that are elsewhere when another process steps the frame again.
fn differ_elsewhere(path: &PathBuf) -> Option<usize> {
    let output = std::process::Command::new(std::env::current_exe().expect("this test"))
        .args(["--exact", "record::prints_how_many_particles_differ", "--ignored", "--nocapture"])
        .env("CLOTH_RECORDING", path)
        .output()
        .expect("this test runs again");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text.split("elsewhere: ").nth(1)?.split_whitespace().next()?.parse().ok()
}

/// Removes the files.
fn forget(app: &App) {
    std::fs::remove_dir_all(&app.world().resource::<ClothRecorder>().folder).ok();
}

/// The files that were written.
fn written(app: &App) -> &[PathBuf] {
    &app.world().resource::<ClothRecordings>().written
}

#[test]
fn a_frame_in_which_the_scale_of_a_cloth_changed_is_left_out() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), border());
    record(&mut app, folder("scale"));
    run(&mut app, 5);
    for frame in 0..12 {
        ask(&mut app);
        if frame % 2 == 0 {
            app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale = Vec3::splat(1.01 + 0.01 * frame as f32);
        }
        app.update();
    }
    assert_eq!(written(&app).len(), 6, "a frame of two");
    for path in written(&app) {
        let replay = read(path).replay();
        assert_eq!((replay.differ, replay.recovered), (0, false), "{}: {replay:?}", path.display());
    }
    forget(&app);
}

#[test]
fn a_frame_that_is_held_or_blows_up_is_recorded() {
    let mut app = app();
    record(&mut app, folder("held"));
    // One falls through the other, and is not untangled.
    let through = (ClothCollision { contact: false, ..default() }, ClothUntangling { iterations: 0, ..default() });
    spawn(&mut app, sheet(14), (border(), through));
    let tilted = Transform::from_xyz(0.0, 0.1, 0.0).with_rotation(Quat::from_rotation_x(0.1));
    spawn(&mut app, sheet(14), (tilted, through));
    let wild = spawn(&mut app, sheet(8), (border(), Transform::from_xyz(9.0, 0.0, 0.0)));
    run(&mut app, 40);
    app.world_mut().get_mut::<ClothParticles>(wild).expect("a cloth").state_mut().positions[50].y += 40.0;
    run(&mut app, 20);
    let recordings: Vec<Recording> = written(&app).iter().map(read).collect();
    let of = |reason: &str| recordings.iter().find(|recording| recording.reason == reason).cloned();
    let recovered = of("recovered").expect("it blew up").replay();
    assert_eq!((recovered.differ, recovered.recovered), (0, true), "{recovered:?}");
    let held = of("held").expect("a tangle that is not untangled is held").replay();
    assert_eq!((held.differ, held.held), (0, true), "{held:?}");
    forget(&app);
}

#[test]
fn what_is_no_recording_is_refused() {
    let error = Recording::read(&b"PK\x03\x04 something else"[..]).expect_err("another file");
    assert!(matches!(error, RecordingError::Form), "{error}");
    let error = Recording::read(&b"dr"[..]).expect_err("too short");
    assert!(matches!(error, RecordingError::Form), "{error}");
    let mut app = app();
    spawn(&mut app, sheet(4), border());
    record(&mut app, folder("damaged"));
    run(&mut app, 3);
    ask(&mut app);
    run(&mut app, 3);
    let whole = std::fs::read(&written(&app)[0]).expect("a file");
    assert!(Recording::read(&whole[..]).is_ok());
    for cut in (8..whole.len()).step_by(97) {
        let error = Recording::read(&whole[..cut]).expect_err("cut");
        assert!(matches!(error, RecordingError::Damaged(_)), "{cut}: {error}");
        let mut changed = whole.clone();
        changed[cut] ^= 0x40;
        let error = Recording::read(&changed[..]).expect_err("changed");
        assert!(matches!(error, RecordingError::Damaged(_)), "{cut}: {error}");
    }
    forget(&app);
}

#[test]
fn files_of_earlier_runs_stay_and_cloths_that_meet_are_one_file() {
    let folder = folder("again");
    for times in 1..=2 {
        let mut app = app();
        for y in [0.0, 0.01] {
            spawn(&mut app, sheet(6), (border(), Transform::from_xyz(0.0, y, 0.0)));
        }
        record(&mut app, folder.clone());
        run(&mut app, 5);
        ask(&mut app);
        run(&mut app, 5);
        let files = std::fs::read_dir(&folder).expect("a folder").count();
        assert_eq!((written(&app).len(), files), (1, times));
    }
    std::fs::remove_dir_all(&folder).ok();
}

#[test]
fn a_folder_that_cannot_be_made_ends_recording_and_nothing_else() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), border());
    let file = folder("file");
    std::fs::write(&file, "in the way").expect("a file");
    record(&mut app, file.join("below"));
    ask(&mut app);
    run(&mut app, 5);
    ask(&mut app);
    run(&mut app, 5);
    let recordings = app.world().resource::<ClothRecordings>();
    assert!(recordings.written.is_empty() && recordings.error.is_some(), "{recordings:?}");
    assert!(finite(&app, cloth));
    std::fs::remove_file(file).ok();
}
