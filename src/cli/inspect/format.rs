//! Numbers for people: three significant digits, lengths in a unit that suits them, equal channels once.

/// Three significant digits.
pub(super) fn number(x: f32) -> String {
    let magnitude = x.abs();
    if x == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&magnitude) {
        return format!("{x:.2e}");
    }
    let decimals = 2 - (magnitude.log10().floor() as i32);
    let text = format!("{x:.*}", decimals.max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A red, green, blue triple; one number where all are equal, `–` for what is not there.
pub(super) fn triple(values: [Option<f32>; 3]) -> String {
    let text = values.map(|value| value.map_or("–".to_owned(), number));
    if text[0] == text[1] && text[1] == text[2] { text[0].clone() } else { text.join("  ") }
}

/// Lengths in metres, all in the unit that suits the smallest.
pub(super) fn lengths(values: [Option<f32>; 3]) -> String {
    let smallest = values.into_iter().flatten().fold(f32::INFINITY, f32::min);
    if !smallest.is_finite() {
        return "unlimited".to_owned();
    }
    let (unit, metres) = unit(smallest);
    format!("{} {unit}", triple(values.map(|value| value.map(|v| v / metres))))
}

/// A length in metres.
pub(super) fn length(value: f32) -> String {
    let (unit, metres) = unit(value);
    format!("{} {unit}", number(value / metres))
}

fn unit(length: f32) -> (&'static str, f32) {
    const UNITS: [(&str, f32); 5] = [("km", 1e3), ("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9)];
    UNITS.into_iter().find(|(_, metres)| length >= *metres).unwrap_or(("m", 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (1.5, "1.5"),
            (0.012_345, "0.0123"),
            (123.4, "123"),
            (123_456.0, "123456"),
            (1e-5, "1.00e-5"),
            (2.5e7, "2.50e7"),
            (-0.25, "-0.25"),
        ] {
            assert_eq!(number(x), text);
        }
    }

    #[test]
    fn lengths_have_fitting_units() {
        assert_eq!(length(0.0123), "12.3 mm");
        assert_eq!(length(4e-7), "400 nm");
        assert_eq!(length(0.0), "0 m");
        assert_eq!(lengths([Some(0.001), Some(0.25), None]), "1  250  – mm");
        assert_eq!(lengths([None; 3]), "unlimited");
        assert_eq!(triple([Some(1.0); 3]), "1");
    }
}
