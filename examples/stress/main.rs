//! Steps a scene without a window and prints what it cost, one line of JSON.
//!
//! ```text
//! cargo run --release --example stress -- --scene hang --size 64 --json
//! ```
//!
//! Where cloths can meet, crossings are looked for in every frame, between cloths and with `--self-collision` in each;
//! elsewhere once at the end, untimed, of everything with everything, and what would have needed a look at every frame is null.
//!
//! That is what the detector says of the shapes that are simulated. `--check` counts what every frame *shows*, with code that
//! shares nothing with the detector:
//!
//! ```text
//! for seed in $(seq 10); do
//!     cargo run --release --example stress -- --scene twist --size 28 --seed $seed --check --json
//! done
//! ```
//!
//! `--replay` steps a frame again that `ClothRecorderPlugin` wrote, and prints whether it had the same bits.
//!
//! The scenes `character` and `crowd` dress the woman of `assets/character.glb`, through the plugin in an app:
//!
//! ```text
//! cargo run --release --example stress -- --scene character --outfit Cape --clip Run --method none --json
//! cargo run --release --example stress -- --scene crowd --characters 100 --outfit Cape --budget 2 --json
//! ```
#![expect(clippy::print_stdout, reason = "a program speaks on its terminal")]

mod arguments;
mod character;
#[path = "../cli/mod.rs"]
mod cli;
mod crowd;
mod figure;
mod replay;
mod sheets;
mod stages;
mod table;
mod worn;

use std::process::ExitCode;

use arguments::{Arguments, SceneName};

fn main() -> ExitCode {
    let arguments: Arguments = cli::parse("stress");
    if let Some(path) = &arguments.replay {
        return replay::replay(path);
    }
    let line = arguments.fit().and_then(|()| match arguments.scene {
        SceneName::Character => character::run(&arguments),
        SceneName::Crowd => crowd::run(&arguments),
        _ => sheets::run(&arguments),
    });
    match line {
        Ok(line) => {
            table::print(&line, arguments.json);
            ExitCode::SUCCESS
        }
        Err(reason) => {
            cli::complain("stress", &reason);
            ExitCode::from(2)
        }
    }
}
