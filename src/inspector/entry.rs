//! Numbers that are typed: taken, or refused with the reason.

use super::setting::Scale;

/// How a number is shown: short, and so that typing it again gives the same number.
#[must_use]
pub fn show(value: f64, integer: bool) -> String {
    let single = value as f32;
    if integer {
        format!("{value:.0}")
    } else if single.is_infinite() {
        "off".into()
    } else if single != 0.0 && !(1.0e-3..1.0e6).contains(&single.abs()) {
        format!("{single:e}")
    } else {
        format!("{single}")
    }
}

/// The number that was typed for a setting in `unit`.
///
/// # Errors
/// Why it is refused, as a sentence for the user: not a number, negative, out of range, or not whole.
pub fn parse(text: &str, unit: &str, scale: &Scale) -> Result<f64, String> {
    let text = text.trim();
    let bare = text.strip_suffix(unit).filter(|_| !unit.is_empty()).unwrap_or(text).trim();
    let range = || {
        let ends = format!("{} to {}", show(scale.limits.0, scale.integer), show(scale.limits.1, scale.integer));
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        format!("{ends}{unit}{}", if scale.endless { ", or off" } else { "" })
    };
    if bare.is_empty() {
        return Err(format!("nothing was typed; the range is {}", range()));
    }
    if scale.endless && bare.eq_ignore_ascii_case("off") {
        return Ok(f64::INFINITY);
    }
    let value = match bare.parse::<f64>() {
        Ok(value) => value,
        Err(_) if bare.contains(',') => return Err(format!("`{bare}` is not a number: write a point instead of the comma")),
        Err(_) => return Err(format!("`{bare}` is not a number; the range is {}", range())),
    };
    if value.is_nan() {
        Err(format!("`{bare}` is not a number; the range is {}", range()))
    } else if value < 0.0 && scale.limits.0 >= 0.0 {
        Err(format!("it must not be negative; the range is {}", range()))
    } else if !scale.holds(value) {
        Err(format!("{bare} is out of range, which is {}", range()))
    } else if scale.integer && value.fract() != 0.0 {
        Err(format!("{bare} is not a whole number"))
    } else {
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STIFFNESS: Scale = Scale::real(0.0, 1.0e7);

    #[test]
    fn what_is_shown_can_be_typed_again_and_gives_the_same_number() {
        for value in [0.0_f32, 1.0e-5, 3.3e-6, 0.05, 0.1, 2000.0, 12_345.678, 9.0e6, f32::INFINITY] {
            let text = show(f64::from(value), false);
            let back = parse(&text, "N/m", &STIFFNESS.endless()).expect(&text);
            assert_eq!(back as f32, value, "shown as {text}");
        }
    }

    #[test]
    fn units_and_blanks_may_be_typed_along() {
        assert_eq!(parse(" 250 N/m ", "N/m", &STIFFNESS), Ok(250.0));
        assert_eq!(parse("3", "", &Scale::whole(0.0, 64.0)), Ok(3.0));
    }

    #[test]
    fn what_is_no_number_is_refused_and_the_reason_names_it() {
        for (text, reason) in [
            ("NaN", "is not a number"),
            ("stiff", "`stiff` is not a number"),
            ("", "nothing was typed"),
            ("0,5", "a point instead of the comma"),
            ("-1", "must not be negative"),
            ("inf", "out of range"),
            ("1e9", "out of range"),
        ] {
            let refused = parse(text, "N/m", &STIFFNESS).expect_err(text);
            assert!(refused.contains(reason), "{text}: {refused}");
        }
        let refused = parse("2.5", "", &Scale::whole(0.0, 64.0)).expect_err("a fraction");
        assert!(refused.contains("whole"), "{refused}");
    }
}
