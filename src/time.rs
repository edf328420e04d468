//! The clock that cloth goes by: that of its schedule, in frames that are long enough to be simulated.

use core::time::Duration;

use bevy::prelude::*;

/// Shortest frame that is simulated by itself. One pass leaves springs longer than at rest, the more the longer a substep is. A
/// substep much shorter than the last sets free the energy in them.
const SHORTEST_FRAME: Duration = Duration::from_millis(1);

/// By how much cloth moves in a frame.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct ClothTime {
    delta: Duration,
    /// Time of frames that were too short.
    owed: Duration,
}

impl ClothTime {
    /// By how much cloth moves in this frame `[s]`; 0: not at all.
    pub(crate) fn delta_secs(&self) -> f32 {
        self.delta.as_secs_f32()
    }

    /// As [`Self::delta_secs`].
    pub(crate) fn delta_secs_f64(&self) -> f64 {
        self.delta.as_secs_f64()
    }

    /// Takes over a frame of the clock of the schedule. What shorter frames take, as those of slow motion, is owed until it
    /// adds up.
    pub(crate) fn advance_by(&mut self, delta: Duration) {
        let sum = self.owed + delta;
        let due = !delta.is_zero() && sum >= SHORTEST_FRAME;
        (self.delta, self.owed) = if due { (sum, Duration::ZERO) } else { (Duration::ZERO, sum) };
    }
}

/// Takes over the clock of the schedule.
pub(crate) fn tick(clock: Res<Time>, mut time: ResMut<ClothTime>) {
    time.advance_by(clock.delta());
}

/// Whether cloth moves in this frame.
pub(crate) fn flows(time: Res<ClothTime>) -> bool {
    !time.delta.is_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_time_is_lost_and_no_frame_is_shorter_than_the_shortest() {
        let mut time = ClothTime::default();
        let mut sum = Duration::ZERO;
        for micros in [16_667, 0, 10, 16_667, 1, 400, 400, 0, 400, 999, 1, 1000, 300] {
            let frame = Duration::from_micros(micros);
            time.advance_by(frame);
            assert!(time.delta.is_zero() || time.delta >= SHORTEST_FRAME.max(frame), "{time:?}");
            assert!(micros > 0 || time.delta.is_zero(), "it moved while time stood still");
            sum += time.delta;
        }
        assert_eq!(sum + time.owed, Duration::from_micros(16_667 * 2 + 10 + 1 + 1200 + 1000 + 1000 + 300));
        assert_eq!(time.owed, Duration::from_micros(300));
    }
}
