//! The command line.

use std::path::PathBuf;

use bevy_drape::ClothUntanglingMethod;
use clap::{Parser, ValueEnum};

use crate::cli;

/// What is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SceneName {
    /// A 1 m sheet pinned at two corners.
    Hang,
    /// A 1 m sheet dropped on a ball of radius 0.3 m.
    Ball,
    /// Flags in a gusty wind; `--cloths` says how many.
    Flags,
    /// Two 1 m sheets dropped crosswise on each other over a ball.
    Sheets,
    /// A stack of sheets dropped on a ball, each turned against the one below; `--cloths` says how many.
    Layers,
    /// A stack of sheets dropped on a ball, one above the other; `--cloths` says how many [default: 10].
    Stack,
    /// Two strips that fall crosswise on each other.
    Crosswise,
    /// A strip whose ends are turned against each other.
    Twist,
    /// A tube whose ends are turned against each other.
    TwistedTube,
    /// Two ribbons in a reef knot that is pulled tight.
    ReefKnot,
    /// A sheet that falls through a funnel.
    Funnel,
    /// A curtain into which a ball swings.
    Curtain,
    /// A skirt on a body that walks.
    Skirt,
    /// A corner pinched between two balls.
    Pinch,
    /// A stack of sheets that a ball presses on the floor.
    Pressed,
    /// A sheet dropped on twenty needles.
    Needles,
    /// A sheet that hangs from a corner and is let go: a heap.
    Heap,
    /// A skirt on a body that spins; `--garment` puts another one on it.
    Spin,
    /// A sheet on a ball that begins to turn.
    TurningBall,
    /// A cloth that is pulled off a table.
    Tablecloth,
    /// Two sheets tangled: a shallow dent.
    Dent,
    /// A deep dent.
    DeepDent,
    /// A corner through the middle.
    Corner,
    /// Two sheets that overlap at their borders.
    BorderOverlap,
    /// A strip stabbed through a sheet.
    StripStab,
    /// The same at an angle.
    TiltedStrip,
    /// A sheet that cuts another in two.
    FullCut,
    /// Two wavy sheets.
    Waves,
    /// A woman in clothes, in an app.
    Character,
    /// Many of her in a grid, before a camera; `--characters` says how many.
    Crowd,
}

/// How crossing cloths are taken apart; none: nothing is looked for.
#[derive(Clone, Copy, Debug)]
pub struct MethodChoice(pub Option<ClothUntanglingMethod>);

fn method_choice(text: &str) -> Result<MethodChoice, String> {
    if text == "none" {
        return Ok(MethodChoice(None));
    }
    let known = cli::method(text).map(|method| MethodChoice(Some(method)));
    known.map_err(|line| line.replace(" or ", ", ") + " or none")
}

fn budget(text: &str) -> Result<f32, String> {
    let ms: f32 = text.parse().map_err(|_| "not a number".to_string())?;
    if (0.01..=1000.0).contains(&ms) { Ok(ms) } else { Err("must be between 0.01 and 1000".into()) }
}

/// Steps a scene without a window and prints what it cost.
#[derive(Parser)]
pub struct Arguments {
    /// What to step.
    #[arg(long, value_enum, default_value_t = SceneName::Hang)]
    pub scene: SceneName,
    /// Vertices along each side of a cloth.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=1024))]
    pub size: u32,
    /// Number of cloths in `hang`, `flags`, `layers` and `stack` [default: 1; stack: 10].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub cloths: Option<u32>,
    /// Wavefront OBJ file of a garment around the y axis [m], for `spin`; `--size` does not change it.
    #[arg(long, value_name = "FILE")]
    pub garment: Option<PathBuf>,
    /// What a character wears: nodes of `assets/character.glb`.
    #[arg(long, value_delimiter = ',', default_values_t = ["Cape".to_string(), "Skirt".to_string()])]
    pub outfit: Vec<String>,
    /// What a character does: clips of the file, one after another in a crowd.
    #[arg(long, value_delimiter = ',', default_values_t = ["Run".to_string()])]
    pub clip: Vec<String>,
    /// Number of characters in `crowd`.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub characters: u32,
    /// Time that all cloths of a crowd together may take in a frame, as `ClothBudget` [ms].
    #[arg(long, value_parser = budget)]
    pub budget: Option<f32>,
    /// Frames of 1/60 s that are timed, after a tenth as many to warm up, and at least 60 with characters.
    #[arg(long, default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Threads that step cloths that do not touch, and that share the work of those that do.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub threads: u32,
    /// How crossing cloths are taken apart: history, local-gradient, global-gradient, by-end-type, or none to look for nothing
    /// [default: by-end-type where cloths can meet, none elsewhere].
    #[arg(long, value_parser = method_choice)]
    pub method: Option<MethodChoice>,
    /// Cloths keep off themselves, too; they do in the scenes from `stack` to `spin`, and as the file says on characters.
    #[arg(long)]
    pub self_collision: bool,
    /// Cloths pass through each other and are untangled afterwards, instead of resting on each other.
    #[arg(long)]
    pub no_contact: bool,
    /// Moves every free particle of the start by up to a thousandth of an edge, another way for every number but 0.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Counts what crosses in what every frame shows, warming up included, without the detector. Frames are a little slower for
    /// it.
    #[arg(long)]
    pub check: bool,
    /// Steps this frame again, which `ClothRecorderPlugin` recorded, in place of a scene.
    #[arg(long, value_name = "FILE", exclusive = true)]
    pub replay: Option<PathBuf>,
    /// Prints one line of JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

impl Arguments {
    /// Whether all of them are for the scene.
    pub fn fit(&self) -> Result<(), String> {
        use SceneName::{Character, Crowd, Flags, Hang, Layers, Stack};
        let worn = matches!(self.scene, Character | Crowd);
        if self.cloths.is_some_and(|k| k > 1) && !matches!(self.scene, Hang | Flags | Layers | Stack) {
            return Err("--cloths is for the scenes hang, flags, layers and stack".into());
        }
        if worn && (self.check || self.seed != 0 || self.garment.is_some()) {
            return Err("--check, --seed and --garment are not for characters".into());
        }
        if self.budget.is_some() && self.scene != Crowd {
            return Err("--budget is for the scene crowd".into());
        }
        Ok(())
    }

    /// Frames before those that are timed.
    pub fn warm_up(&self) -> u32 {
        self.frames / 10
    }
}
