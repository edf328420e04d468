//! Motion from key poses: cubics that never overshoot, so that a foot that stands between two keys stands still.

use crate::field::hermite;
use crate::rig::{ARMS, CONTROLS, FEET, Rig};

/// How much later than the trunk the arms follow [s].
const ARM_DELAY: f32 = 0.035;
/// Half the time over which everything but the feet is averaged: no corner in the speed is left [s].
const SOFTNESS: f32 = 0.06;

/// Key poses at times [s].
pub struct Keys {
    keys: Vec<(f32, [f32; CONTROLS])>,
}

impl Keys {
    /// Keys in the order of time.
    pub fn new(keys: Vec<(f32, Rig)>) -> Self {
        Self { keys: keys.into_iter().map(|(time, rig)| (time, rig.numbers())).collect() }
    }

    /// The controls at a time: arms late, all but the feet softened.
    pub fn at(&self, time: f32) -> Rig {
        const SAMPLES: i32 = 4;
        let mut numbers = self.raw(time);
        let mut soft = [0.0; CONTROLS];
        for i in -SAMPLES..=SAMPLES {
            let shift = SOFTNESS * i as f32 / SAMPLES as f32;
            let (now, late) = (self.raw(time + shift), self.raw(time + shift - ARM_DELAY));
            for k in 0..FEET {
                soft[k] += if k >= ARMS { late[k] } else { now[k] } / (2 * SAMPLES + 1) as f32;
            }
        }
        numbers[..FEET].copy_from_slice(&soft[..FEET]);
        Rig::from_numbers(&numbers)
    }

    fn raw(&self, time: f32) -> [f32; CONTROLS] {
        let keys = &self.keys;
        let last = keys.len() - 1;
        if last == 0 || time <= keys[0].0 {
            return keys[0].1;
        }
        if time >= keys[last].0 {
            return keys[last].1;
        }
        let i = keys.partition_point(|key| key.0 <= time) - 1;
        let (t0, t1) = (keys[i].0, keys[i + 1].0);
        let s = (time - t0) / (t1 - t0);
        std::array::from_fn(|k| {
            let slope = |j: usize| self.slope(j, k) * (t1 - t0);
            hermite(keys[i].1[k], keys[i + 1].1[k], slope(i), slope(i + 1), s)
        })
    }

    /// The speed of a control at a key: none where it turns back (Fritsch and Carlson 1980).
    fn slope(&self, key: usize, control: usize) -> f32 {
        let keys = &self.keys;
        if key == 0 || key + 1 == keys.len() {
            return 0.0;
        }
        let pace = |a: usize| {
            let span = keys[a + 1].0 - keys[a].0;
            (span, (keys[a + 1].1[control] - keys[a].1[control]) / span)
        };
        let ((h0, d0), (h1, d1)) = (pace(key - 1), pace(key));
        if d0 * d1 <= 0.0 {
            return 0.0;
        }
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        (w0 + w1) / (w0 / d0 + w1 / d1)
    }
}
