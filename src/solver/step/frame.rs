//! A frame under way.

use super::StepReport;

/// A frame under way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Frame {
    /// Length of the frame that is simulated `[s]`.
    pub(super) dt: f32,
    /// Length of a substep `[s]`.
    pub(super) h: f32,
    /// Substeps begun.
    pub(super) begun: u32,
    /// How often wind forces are evaluated in it.
    pub(super) gusts: u32,
    /// Inner steps in a substep.
    pub(super) steps: u32,
    /// What the cloth was when the frame began.
    pub(super) strained: bool,
    pub(super) taut: bool,
    pub(super) settling: bool,
    /// Drag `[1/s]`.
    pub(super) drag: f32,
    pub(super) report: StepReport,
}

impl Frame {
    /// Begins the next substep, if there is one: the frame as it is in that.
    pub(super) fn next_substep(&mut self) -> Option<Self> {
        if self.begun == self.report.substeps {
            return None;
        }
        self.begun += 1;
        Some(*self)
    }

    /// Whether the wind is evaluated in the current substep.
    pub(super) fn is_gusty(&self) -> bool {
        let (n, count) = (self.begun - 1, self.report.substeps);
        n == 0 || n * self.gusts / count > (n - 1) * self.gusts / count
    }

    /// What of a way over the last step, of `last` `[s]`, is taken over a step of `h` `[s]` where `motion` is without drag
    /// (dimensionless). Then what an acceleration is multiplied by for that step `[s²]`.
    pub(super) fn forces(&self, h: f32, motion: f32, last: f32) -> (f32, f32) {
        (motion * (-self.drag * h).exp(), 0.5 * h * (last + h))
    }

    /// Shares of the frame that have passed at the start and at the end of the current substep.
    pub(super) fn span(&self) -> (f32, f32) {
        let n = self.report.substeps as f32;
        ((self.begun - 1) as f32 / n, self.begun as f32 / n)
    }
}
