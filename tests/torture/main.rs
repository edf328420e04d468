//! A few dozen cases of the random attack, always the same: apps, meshes and files. The example `torture` goes on with others,
//! for a night if asked to.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use drape_tests::attack::case::{Case, Kind};
use drape_tests::attack::headless::Options;
use drape_tests::attack::shrink::shrink;

/// Plays cases one after another, because they share the log and the pool of threads; what fails is shrunk.
fn attack(cases: impl IntoIterator<Item = Case>, twice: bool) {
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let options = Options::default();
    for case in cases {
        let result = if twice { case.play_twice(&options) } else { case.play(&options) };
        let Err(failure) = result else { continue };
        let (case, failure) = shrink(&case, &failure, &options, Duration::from_secs(30));
        panic!("{case}\n{}: {}\n{}", failure.kind, failure.what, failure.told.join("\n"));
    }
}

#[test]
fn apps_survive_whatever_is_done_to_them_and_do_the_same_again() {
    attack((0..24).map(|seed| Case { frames: 60, ..Case::new(Kind::App, seed) }), true);
}

#[test]
fn any_mesh_is_simulated_or_refused() {
    attack((0..120).map(|seed| Case::new(Kind::Mesh, seed)), false);
}

#[test]
fn any_bytes_are_read_or_refused() {
    attack((0..360).map(|seed| Case::new(Kind::File, seed)), false);
}

#[test]
fn a_line_is_the_case_that_wrote_it() {
    for keep in [None, Some(vec![]), Some(vec![0, 3, 17])] {
        let case = Case { kind: Kind::App, seed: 7, frames: 12, keep };
        assert_eq!(case.to_string().parse(), Ok(case));
    }
    for line in ["", "map 3", "app", "app 3 frames", "app 3 keep 1,x", "app 3 times 9"] {
        assert!(line.parse::<Case>().is_err(), "{line}");
    }
}
