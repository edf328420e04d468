//! Less and less is done for as long as the same fails (delta debugging, Zeller 1999).

use std::time::{Duration, Instant};

use super::case::{Case, Kind};
use super::headless::Options;
use super::play::Failure;

/// The smallest case that was found within a time, and how it fails.
pub fn shrink(case: &Case, failure: &Failure, options: &Options, within: Duration) -> (Case, Failure) {
    let mut shrinking = Shrinking { options, end: Instant::now() + within, best: (case.clone(), failure.clone()) };
    let all: Vec<usize> = case.keep.clone().unwrap_or_else(|| (0..case.count()).collect());
    shrinking.shorten();
    shrinking.halve(all);
    shrinking.shorten();
    shrinking.best
}

struct Shrinking<'a> {
    options: &'a Options,
    end: Instant,
    best: (Case, Failure),
}

impl Shrinking<'_> {
    /// Whether a case fails in the same way; it is the best one then.
    fn fails(&mut self, case: Case) -> bool {
        if Instant::now() > self.end {
            return false;
        }
        let twice = self.best.1.kind.starts_with("other positions");
        let result = if twice { case.play_twice(self.options) } else { case.play(self.options) };
        let Err(failure) = result else { return false };
        let same = failure.kind == self.best.1.kind;
        if same {
            self.best = (case, failure);
        }
        same
    }

    /// Leaves out halves of what is done, then quarters, at last each alone.
    fn halve(&mut self, mut all: Vec<usize>) {
        let mut size = all.len().div_ceil(2);
        while size > 0 && !all.is_empty() {
            let mut start = 0;
            let mut less = false;
            while start < all.len() {
                let mut rest = all.clone();
                rest.drain(start..(start + size).min(all.len()));
                if self.fails(Case { keep: Some(rest.clone()), ..self.best.0.clone() }) {
                    (all, less) = (rest, true);
                } else {
                    start += size;
                }
            }
            if size == 1 && !less {
                return;
            }
            size = if size == 1 { 1 } else { size / 2 };
        }
    }

    /// Leaves out frames at the end.
    fn shorten(&mut self) {
        let (case, failure) = self.best.clone();
        // Steps of an app do not depend on how many frames there are; what happens to a mesh does.
        if case.kind == Kind::Mesh {
            return;
        }
        for frames in [failure.frame + 1, case.frames / 8, case.frames / 4, case.frames / 2, case.frames * 3 / 4] {
            if frames < self.best.0.frames && self.fails(Case { frames, ..self.best.0.clone() }) {
                return;
            }
        }
    }
}
