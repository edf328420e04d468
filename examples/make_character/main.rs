//! Makes `assets/character.glb`: a human figure with a skeleton, clips and garments, all of it computed.
//!
//! ```text
//! cargo run --example make_character
//! cargo run --example make_character -- --out figure.glb
//! ```
//!
//! It takes some ten seconds in a release build, and minutes without optimizations. The same code writes the same bytes.
//!
//! Solids melt into a body; a mesh is spun around it and gets weights. Garments are surfaces at a distance from the
//! body, or turned around it. Clips are poses of a rig over time, with feet that stay where they are put.

mod anatomy;
mod asset;
mod body;
mod clips;
mod cut;
mod eyes;
mod field;
mod garments;
mod head;
mod ik;
mod measures;
mod mesh;
mod nets;
mod remesh;
mod rig;
mod skeleton;
mod tint;
mod weights;

#[path = "../cli/mod.rs"]
mod cli;
#[path = "../glb/mod.rs"]
mod glb;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

/// Makes a dressed, animated figure.
#[derive(Parser)]
struct Arguments {
    /// The file to write.
    #[arg(long, default_value = "assets/character.glb")]
    out: PathBuf,
}

fn main() -> ExitCode {
    let arguments: Arguments = cli::parse("make_character");
    match std::fs::write(&arguments.out, asset::make()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            cli::complain("make_character", &format!("{} cannot be written: {error}", arguments.out.display()));
            ExitCode::from(2)
        }
    }
}
