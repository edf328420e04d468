//! Numbers that users set, made safe at the moment of use.
//!
//! A setting is never rewritten: the inspector keeps showing what the user typed, and the solver sees the clamped number.
//! [`crate::ClothReport::clamped`] names the settings that were not usable.

use std::borrow::Cow;

use bevy::math::Vec3;

/// A number that was given, and that which is used in its place, in the unit of the setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Values {
    pub given: f32,
    pub used: f32,
    /// What it has to be, at least and at most.
    pub range: (f32, f32),
    /// Whether the setting is a vector, of which these are lengths.
    pub of_length: bool,
}

/// Clamps settings and remembers the names of those that were out of range.
#[derive(Clone, Debug, Default)]
pub(crate) struct Checked {
    /// Names of the settings that were changed, in the order of the checks; only read elsewhere, as their values go with them.
    pub clamped: Vec<Cow<'static, str>>,
    /// Of each, what was given and what is used, in its own unit, if these are numbers.
    values: Vec<Option<Values>>,
}

impl Checked {
    /// Forgets all names, and keeps the allocation.
    pub(crate) fn clear(&mut self) {
        self.clamped.clear();
        self.values.clear();
    }

    /// Names a setting that cannot be used.
    pub(crate) fn refuse(&mut self, name: &'static str) {
        self.clamped.push(Cow::Borrowed(name));
        self.values.push(None);
    }

    fn note(&mut self, name: &'static str, values: Values) {
        self.clamped.push(Cow::Borrowed(name));
        self.values.push(Some(values));
    }

    /// The settings that were changed, each with what was given and what is used.
    pub(crate) fn changes(&self) -> impl Iterator<Item = (&Cow<'static, str>, Option<Values>)> {
        self.clamped.iter().zip(self.values.iter().copied())
    }

    /// `value` if it lies in `low..=high`; the nearer end if it lies outside; `default` if it is not a number.
    pub(crate) fn within(&mut self, name: &'static str, value: f32, default: f32, low: f32, high: f32) -> f32 {
        if value >= low && value <= high {
            // Zero has no sign: what is divided by it would have.
            return value + 0.0;
        }
        let used = if value.is_nan() { default } else { value.clamp(low, high) };
        self.note(name, Values { given: value, used, range: (low, high), of_length: false });
        used
    }

    /// `value` if it lies in `low..=high`, else the nearer end.
    pub(crate) fn count(&mut self, name: &'static str, value: u32, low: u32, high: u32) -> u32 {
        let used = value.clamp(low, high);
        if used != value {
            let range = (low as f32, high as f32);
            self.note(name, Values { given: value as f32, used: used as f32, range, of_length: false });
        }
        used
    }

    /// As [`Self::within`], where infinity switches a limit off.
    pub(crate) fn within_or_off(&mut self, name: &'static str, value: f32, default: f32, low: f32, high: f32) -> f32 {
        if value == f32::INFINITY { value } else { self.within(name, value, default, low, high) }
    }

    /// `value` if it is finite and no longer than `longest`; shortened if it is longer; `default` if it is not finite.
    pub(crate) fn vector(&mut self, name: &'static str, value: Vec3, default: Vec3, longest: f32) -> Vec3 {
        if value.is_finite() && value.length() <= longest {
            return value;
        }
        // A long vector may overflow its own length: shrink before measuring.
        let largest = value.abs().max_element();
        let shortened = value.is_finite() && largest > 0.0;
        let used = if shortened { (value / largest).normalize_or_zero() * longest } else { default };
        self.note(name, Values { given: value.length(), used: used.length(), range: (0.0, longest), of_length: true });
        used
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_in_range_is_left_alone_and_others_are_clamped_and_named() {
        let mut checked = Checked::default();
        assert_eq!(checked.within("a", 2.0, 1.0, 0.0, 3.0), 2.0);
        assert!(checked.within("a", -0.0, 1.0, 0.0, 3.0).is_sign_positive());
        assert!(checked.clamped.is_empty());
        assert_eq!(checked.within("b", -2.0, 1.0, 0.0, 3.0), 0.0);
        assert_eq!(checked.within("c", f32::NAN, 1.0, 0.0, 3.0), 1.0);
        assert_eq!(checked.within("d", f32::INFINITY, 1.0, 0.0, 3.0), 3.0);
        assert_eq!(checked.within_or_off("e", f32::INFINITY, 1.0, 0.0, 3.0), f32::INFINITY);
        assert_eq!(checked.count("f", 9, 1, 4), 4);
        checked.refuse("g");
        assert_eq!(checked.clamped, ["b", "c", "d", "f", "g"]);
        let values: Vec<_> = checked.changes().map(|(_, values)| values).collect();
        assert!(matches!(values[1], Some(Values { given, used: 1.0, .. }) if given.is_nan()), "{values:?}");
        let of = |given: f32, used: f32, range: (f32, f32)| Some(Values { given, used, range, of_length: false });
        assert_eq!([values[0], values[3], values[4]], [of(-2.0, 0.0, (0.0, 3.0)), of(9.0, 4.0, (1.0, 4.0)), None]);
    }

    #[test]
    fn a_vector_is_shortened_when_too_long_and_replaced_when_not_finite() {
        let mut checked = Checked::default();
        let long = checked.vector("v", Vec3::splat(3.0e38), Vec3::ZERO, 10.0);
        assert!((long.length() - 10.0).abs() < 1.0e-3, "{long}");
        assert_eq!(checked.vector("v", Vec3::new(f32::NAN, 0.0, 0.0), Vec3::Y, 10.0), Vec3::Y);
    }
}
