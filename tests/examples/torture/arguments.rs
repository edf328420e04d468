//! What is asked for.

use std::time::Duration;

use clap::Parser;

use drape_tests::attack::case::{Case, Kind};

#[derive(Parser)]
#[command(about = "Attacks the plugin at random; what fails is made small, and a line plays it again.")]
pub struct Arguments {
    /// Apps; with neither this nor meshes, files or a time: a minute.
    #[arg(long)]
    apps: Option<u64>,
    /// Meshes.
    #[arg(long)]
    meshes: Option<u64>,
    /// Files.
    #[arg(long)]
    files: Option<u64>,
    /// Of all kinds for so long [s].
    #[arg(long)]
    seconds: Option<u64>,
    /// Of all kinds for so long [h].
    #[arg(long)]
    hours: Option<f64>,
    /// The first seed.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Frames of an app.
    #[arg(long, default_value_t = Kind::App.frames(), value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// A line to play again.
    #[arg(long)]
    pub replay: Option<String>,
    /// What a frame may take beyond what its work explains [s].
    #[arg(long, default_value_t = 5.0)]
    pub patience: f32,
    /// Failures after which it ends.
    #[arg(long, default_value_t = 20)]
    pub most: usize,
    /// Prints what some apps come to with so many threads: the program asks itself.
    #[arg(long, hide = true)]
    pub threads: Option<usize>,
}

impl Arguments {
    /// How long it goes on.
    pub fn time(&self) -> Duration {
        let counted = self.apps.is_some() || self.meshes.is_some() || self.files.is_some();
        match (self.seconds, self.hours) {
            (Some(seconds), _) => Duration::from_secs(seconds),
            (None, Some(hours)) => Duration::from_secs_f64(3600.0 * hours.clamp(0.0, 1.0e4)),
            (None, None) if counted => Duration::MAX,
            (None, None) => Duration::from_secs(60),
        }
    }

    /// Every case, kinds in turn; without end if only a time is given.
    pub fn cases(&self) -> impl Iterator<Item = Case> + use<> {
        let counted = self.apps.is_some() || self.meshes.is_some() || self.files.is_some();
        // An app takes as long as some ten meshes.
        let per_round = [1, 4, 4];
        let most = [self.apps, self.meshes, self.files].map(|most| if counted { most.unwrap_or(0) } else { u64::MAX });
        let (first, frames) = (self.seed, self.frames);
        let rounds = (0..u64::MAX).take_while(move |round| (0..3).any(|k| round * per_round[k] < most[k]));
        rounds.flat_map(move |round| {
            let numbers = move |k: usize| (round * per_round[k]..(round + 1) * per_round[k]).take_while(move |n| *n < most[k]);
            (0..3).flat_map(move |k| {
                let kind = Kind::ALL[k];
                numbers(k).map(move |number| {
                    let case = Case::new(kind, first.wrapping_add(number));
                    if kind == Kind::App { Case { frames, ..case } } else { case }
                })
            })
        })
    }
}
