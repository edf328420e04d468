//! One case of the attack: a number, or the line that plays it again.
//!
//! ```text
//! app 1234 frames 60 keep 0,3,17
//! ```

use std::fmt;
use std::str::FromStr;

use super::files;
use super::headless::Options;
use super::plan::Plan;
use super::play::{self, Failure, Tally};
use super::watch;

/// What is attacked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An app, by everything that can be done to it.
    App,
    /// The plugin, by a mesh.
    Mesh,
    /// The plugin, by a file.
    File,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::App, Self::Mesh, Self::File];

    /// As it is written.
    pub const fn name(self) -> &'static str {
        match self {
            Self::App => "app",
            Self::Mesh => "mesh",
            Self::File => "file",
        }
    }

    /// Frames, if nothing is said.
    pub const fn frames(self) -> u32 {
        match self {
            Self::App => 100,
            Self::Mesh => 12,
            Self::File => 6,
        }
    }
}

/// A case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// What is attacked.
    pub kind: Kind,
    /// With what.
    pub seed: u64,
    /// For how long.
    pub frames: u32,
    /// Numbers of what is done; everything, if none.
    pub keep: Option<Vec<usize>>,
}

impl Case {
    /// Everything of a seed.
    pub fn new(kind: Kind, seed: u64) -> Self {
        Self { kind, seed, frames: kind.frames(), keep: None }
    }

    /// How many things are done if all are.
    pub fn count(&self) -> usize {
        match self.kind {
            Kind::App => Plan::app(self.seed, self.frames).steps.len(),
            Kind::Mesh => Plan::mesh(self.seed, self.frames).steps.len(),
            Kind::File => files::plan(self.seed).len(),
        }
    }

    /// Plays it once.
    ///
    /// # Errors
    /// What does not hold.
    pub fn play(&self, options: &Options) -> Result<Tally, Failure> {
        watch::at(Some(self.to_string()));
        let keep = self.keep.as_deref();
        let result = match self.kind {
            Kind::App => play::play(&Plan::app(self.seed, self.frames), keep, options),
            Kind::Mesh => play::play(&Plan::mesh(self.seed, self.frames), keep, options),
            Kind::File => files::play(self.seed, keep, self.frames, options),
        };
        watch::at(None);
        result
    }

    /// Plays it twice: the second time every position has to be the same.
    ///
    /// # Errors
    /// What does not hold.
    pub fn play_twice(&self, options: &Options) -> Result<Tally, Failure> {
        let [once, again] = [self.play(options)?, self.play(options)?];
        if once.hash != again.hash && !once.by_clock {
            return Err(Failure::broken(("other positions the second time".into(), String::new()), self.frames));
        }
        Ok(Tally { frames: once.frames + again.frames, slowest: once.slowest.max(again.slowest), ..once })
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} frames {}", self.kind.name(), self.seed, self.frames)?;
        match &self.keep {
            Some(keep) if keep.is_empty() => write!(f, " keep none"),
            Some(keep) => write!(f, " keep {}", keep.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")),
            None => Ok(()),
        }
    }
}

impl FromStr for Case {
    type Err = String;

    fn from_str(line: &str) -> Result<Self, String> {
        let mut words = line.split_whitespace();
        let kind = words.next().and_then(|word| Kind::ALL.into_iter().find(|kind| kind.name() == word));
        let kind = kind.ok_or("begins with app, mesh or file")?;
        let seed = words.next().and_then(|word| word.parse().ok()).ok_or("has a number as its second word")?;
        let mut case = Self::new(kind, seed);
        while let Some(word) = words.next() {
            let value = words.next().ok_or_else(|| format!("has something behind `{word}`"))?;
            match word {
                "frames" => case.frames = value.parse().map_err(|_| "has a number of frames")?,
                "keep" if value == "none" => case.keep = Some(Vec::new()),
                "keep" => {
                    let numbers: Result<Vec<usize>, _> = value.split(',').map(str::parse).collect();
                    case.keep = Some(numbers.map_err(|_| "keeps numbers with commas between them")?);
                }
                _ => return Err(format!("has no `{word}`")),
            }
        }
        Ok(case)
    }
}
