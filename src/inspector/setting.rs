//! A setting as the panel knows it: what it is called, in which unit, over which range, what it does, and where it lies.

use super::part::Part;
use super::settings::ClothSettings;

/// Range of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// What may be typed: the documented range.
    pub limits: (f64, f64),
    /// What the slider covers: where the setting is of use.
    pub slider: (f64, f64),
    /// Whether the slider is logarithmic.
    pub log: bool,
    /// Whether only whole numbers make sense.
    pub integer: bool,
    /// Whether infinity switches it off.
    pub endless: bool,
}

impl Scale {
    /// Real numbers from `low` to `high`.
    #[must_use]
    pub const fn real(low: f64, high: f64) -> Self {
        Self { limits: (low, high), slider: (low, high), log: false, integer: false, endless: false }
    }

    /// Whole numbers from `low` to `high`.
    #[must_use]
    pub const fn whole(low: f64, high: f64) -> Self {
        Self { integer: true, ..Self::real(low, high) }
    }

    /// With a slider that covers only a part.
    #[must_use]
    pub const fn slider(self, low: f64, high: f64) -> Self {
        Self { slider: (low, high), ..self }
    }

    /// With a logarithmic slider, which must not begin at 0.
    #[must_use]
    pub const fn log(self) -> Self {
        Self { log: true, ..self }
    }

    /// With infinity for "off".
    #[must_use]
    pub const fn endless(self) -> Self {
        Self { endless: true, ..self }
    }

    /// Whether a component that holds this number uses it as it is.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        let (low, high) = self.limits;
        let within =
            if self.integer { (low..=high).contains(&value) } else { (low as f32..=high as f32).contains(&(value as f32)) };
        within || self.endless && value == f64::INFINITY
    }

    /// Where a value lies on the slider, from 0 to 1.
    #[must_use]
    pub fn share(&self, value: f64) -> f64 {
        let (low, high) = self.slider;
        let (v, low, high) = if self.log { (value.max(low).ln(), low.ln(), high.ln()) } else { (value, low, high) };
        ((v - low) / (high - low)).clamp(0.0, 1.0)
    }
}

/// Where a number lies. None when it does not exist now, as the wind of a cloth without its own, or the distances of its level
/// of detail.
pub type Field<T> = fn(&mut ClothSettings) -> Option<&mut T>;

/// What kind of value a setting has, and where it lies.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A real number.
    Number(Scale, Field<f32>),
    /// A whole number that is not negative.
    Count(Scale, Field<u32>),
    /// A whole number.
    Layer(Scale, Field<i32>),
    /// On or off.
    Switch {
        /// Whether it is on.
        get: fn(&ClothSettings) -> bool,
        /// Switches it.
        set: fn(&mut ClothSettings, bool),
    },
    /// One of several.
    Choice {
        /// Names of the options, as they are called in code.
        options: &'static [&'static str],
        /// Which one is chosen.
        get: fn(&ClothSettings) -> Option<usize>,
        /// Chooses one.
        set: fn(&mut ClothSettings, usize),
    },
}

/// Description of a setting.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// What it belongs to.
    pub part: Part,
    /// Name of the field.
    pub name: &'static str,
    /// Unit; empty when dimensionless.
    pub unit: &'static str,
    /// What it does.
    pub does: &'static str,
    /// What goes wrong when it is too low, or off.
    pub low: &'static str,
    /// What goes wrong when it is too high, or on.
    pub high: &'static str,
    /// Kind and place of its value.
    pub kind: Kind,
    /// What a setting that exists only beside some option begins with: no default component has it.
    pub start: Option<f64>,
}

impl Setting {
    /// A setting; `tips` are what it does, and what goes wrong at the low and at the high end.
    /// A number, which begins at `start` where there was none.
    pub(super) const fn number(
        part: Part,
        name: &'static str,
        unit: &'static str,
        (scale, field): (Scale, Field<f32>),
        tips: [&'static str; 3],
        start: f64,
    ) -> Self {
        Self::new(part, name, unit, Kind::Number(scale, field), tips).starts(start)
    }

    pub(super) const fn new(part: Part, name: &'static str, unit: &'static str, kind: Kind, tips: [&'static str; 3]) -> Self {
        let [does, low, high] = tips;
        Self { part, name, unit, does, low, high, kind, start: None }
    }

    /// With what it begins with when the option beside which it exists is chosen.
    pub(super) const fn starts(self, start: f64) -> Self {
        Self { start: Some(start), ..self }
    }

    /// What it is called among all settings, such as `material density`: also its name for screen readers and tests.
    #[must_use]
    pub fn label(&self) -> String {
        format!("{} {}", self.part.name(), self.name)
    }

    /// Its range, when it is a number.
    #[must_use]
    pub const fn scale(&self) -> Option<Scale> {
        match self.kind {
            Kind::Number(scale, _) | Kind::Count(scale, _) | Kind::Layer(scale, _) => Some(scale),
            Kind::Switch { .. } | Kind::Choice { .. } => None,
        }
    }

    /// Its value as a number: 0 and 1 for off and on, the place of an option. None when it does not exist now.
    #[must_use]
    pub fn get(&self, settings: &mut ClothSettings) -> Option<f64> {
        match self.kind {
            Kind::Number(_, field) => field(settings).map(|v| f64::from(*v)),
            Kind::Count(_, field) => field(settings).map(|v| f64::from(*v)),
            Kind::Layer(_, field) => field(settings).map(|v| f64::from(*v)),
            Kind::Switch { get, .. } => Some(f64::from(u8::from(get(settings)))),
            Kind::Choice { get, .. } => get(settings).map(|i| i as f64),
        }
    }

    /// Its default, as [`Self::get`] gives it.
    #[must_use]
    pub fn default_value(&self) -> Option<f64> {
        self.get(&mut ClothSettings::defaults()).or(self.start)
    }

    /// Whether the component uses its value as it is; else it is clamped.
    #[must_use]
    pub fn in_range(&self, settings: &mut ClothSettings) -> bool {
        self.scale().zip(self.get(settings)).is_none_or(|(scale, value)| scale.holds(value))
    }

    /// Sets its value, as [`Self::get`] gives it. Nothing happens when it does not exist now.
    pub fn set(&self, settings: &mut ClothSettings, value: f64) {
        match self.kind {
            Kind::Number(_, field) => put(field(settings), value as f32),
            Kind::Count(_, field) => put(field(settings), value as u32),
            Kind::Layer(_, field) => put(field(settings), value as i32),
            Kind::Switch { set, .. } => set(settings, value != 0.0),
            Kind::Choice { set, .. } => set(settings, value as usize),
        }
    }
}

fn put<T>(field: Option<&mut T>, value: T) {
    if let Some(field) = field {
        *field = value;
    }
}
