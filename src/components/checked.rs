//! Numbers that users set, made safe at the moment of use.
//!
//! A setting is never rewritten: the inspector keeps showing what the user typed, [`crate::ClothReport::clamped`] names what
//! was not usable, and the solver sees the clamped number.

use std::borrow::Cow;

use bevy::math::Vec3;

/// Clamps settings and remembers the names of those that were out of range.
#[derive(Debug, Default)]
pub(crate) struct Checked {
    /// Names of the settings that were changed, in the order of the checks.
    pub clamped: Vec<Cow<'static, str>>,
}

impl Checked {
    /// Forgets all names but keeps the memory.
    pub fn clear(&mut self) {
        self.clamped.clear();
    }

    /// `value` if it lies in `low..=high`; the nearer end if it lies outside; `default` if it is not a number.
    pub fn within(&mut self, name: &'static str, value: f32, default: f32, low: f32, high: f32) -> f32 {
        if value >= low && value <= high {
            return value;
        }
        self.clamped.push(Cow::Borrowed(name));
        if value.is_nan() { default } else { value.clamp(low, high) }
    }

    /// `value` if it lies in `low..=high`, else the nearer end.
    pub fn count(&mut self, name: &'static str, value: u32, low: u32, high: u32) -> u32 {
        if !(low..=high).contains(&value) {
            self.clamped.push(Cow::Borrowed(name));
        }
        value.clamp(low, high)
    }

    /// As [`Self::within`], where infinity switches a limit off.
    pub fn within_or_off(&mut self, name: &'static str, value: f32, default: f32, low: f32, high: f32) -> f32 {
        if value == f32::INFINITY { value } else { self.within(name, value, default, low, high) }
    }

    /// `value` if it is finite and no longer than `longest`; shortened if it is longer; `default` if it is not finite.
    pub fn vector(&mut self, name: &'static str, value: Vec3, default: Vec3, longest: f32) -> Vec3 {
        if value.is_finite() && value.length() <= longest {
            return value;
        }
        self.clamped.push(Cow::Borrowed(name));
        // A long vector may overflow its own length: shrink before measuring.
        let largest = value.abs().max_element();
        if value.is_finite() && largest > 0.0 { (value / largest).normalize_or_zero() * longest } else { default }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_in_range_is_left_alone_and_others_are_clamped_and_named() {
        let mut checked = Checked::default();
        assert_eq!(checked.within("a", 2.0, 1.0, 0.0, 3.0), 2.0);
        assert!(checked.clamped.is_empty());
        assert_eq!(checked.within("b", -2.0, 1.0, 0.0, 3.0), 0.0);
        assert_eq!(checked.within("c", f32::NAN, 1.0, 0.0, 3.0), 1.0);
        assert_eq!(checked.within("d", f32::INFINITY, 1.0, 0.0, 3.0), 3.0);
        assert_eq!(checked.within_or_off("e", f32::INFINITY, 1.0, 0.0, 3.0), f32::INFINITY);
        assert_eq!(checked.clamped, ["b", "c", "d"]);
    }

    #[test]
    fn a_vector_is_shortened_when_too_long_and_replaced_when_not_finite() {
        let mut checked = Checked::default();
        let long = checked.vector("v", Vec3::splat(3.0e38), Vec3::ZERO, 10.0);
        assert!((long.length() - 10.0).abs() < 1.0e-3, "{long}");
        assert_eq!(checked.vector("v", Vec3::new(f32::NAN, 0.0, 0.0), Vec3::Y, 10.0), Vec3::Y);
    }
}
