//! Values that the authoring commands take.

use super::names;
use super::values::{LengthUnit, length_unit, without_unit};
use crate::author::Form;
use crate::optics::presets::Preset;

/// A texture, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TextureArg {
    Index(u32),
    None,
}

/// Three numbers of at least 0, or one for all three.
pub(super) fn channels(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let numbers = match numbers.as_deref() {
        Ok([one]) => [*one; 3],
        Ok([r, g, b]) => [*r, *g, *b],
        _ => {
            let unit =
                text.split(',').find_map(unit_of).map(|unit| format!("; the unit is given by --unit {unit}"));
            let expected = "three numbers red,green,blue are expected, or one for all";
            return Err(format!("{expected}{}", unit.unwrap_or_default()));
        }
    };
    match numbers.iter().all(|v| v.is_finite() && *v >= 0.0) {
        true => Ok(numbers),
        false => Err("numbers of at least 0 are expected".to_owned()),
    }
}

/// The unit that a number is followed by, as in `1mm`.
fn unit_of(part: &str) -> Option<&str> {
    let part = part.trim();
    let unit = part.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+'));
    (unit.len() < part.len() && length_unit(unit.trim()).is_ok()).then_some(unit.trim())
}

/// A colour of a paint program, `#3fa060` or `#3a6`: sRGB, made linear.
pub(super) fn hexadecimal(digits: &str) -> Result<[f64; 3], String> {
    parsed(digits).ok_or_else(|| "a colour after # has 6 hexadecimal digits: #rrggbb".to_owned())
}

fn parsed(digits: &str) -> Option<[f64; 3]> {
    let value = |range: std::ops::Range<usize>, most: f64| {
        let part = digits.get(range)?;
        let digits = part.bytes().all(|b| b.is_ascii_hexdigit());
        Some(f64::from(u8::from_str_radix(part, 16).ok().filter(|_| digits)?) / most)
    };
    let encoded = match digits.len() {
        6 => [value(0..2, 255.0)?, value(2..4, 255.0)?, value(4..6, 255.0)?],
        3 => [value(0..1, 15.0)?, value(1..2, 15.0)?, value(2..3, 15.0)?],
        _ => return None,
    };
    let linear = |c: f64| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    Some(encoded.map(linear))
}

pub(super) fn color(text: &str) -> Result<[f64; 3], String> {
    if let Some(digits) = text.strip_prefix('#') {
        return hexadecimal(digits);
    }
    let color = channels(text)?;
    match color.iter().all(|v| *v <= 1.0) {
        true => Ok(color),
        false => Err("a colour is between 0 and 1, in linear Rec. 709".to_owned()),
    }
}

pub(super) fn lengths(text: &str) -> Result<[f64; 3], String> {
    let lengths = channels(text)?;
    match lengths.iter().all(|v| *v > 0.0) {
        true => Ok(lengths),
        false => Err("lengths are above 0".to_owned()),
    }
}

pub(super) fn anisotropy(text: &str) -> Result<f64, String> {
    let g = text.parse::<f64>().ok().filter(|g| *g > -1.0 && *g < 1.0);
    g.ok_or_else(|| format!("a number above -1 and below 1 is expected{}", without_unit(text)))
}

pub(super) fn ior(text: &str) -> Result<f64, String> {
    let ior = text.parse::<f64>().ok().filter(|ior| ior.is_finite() && *ior >= 1.0);
    ior.ok_or_else(|| format!("a number of at least 1 is expected{}", without_unit(text)))
}

pub(super) fn density(text: &str) -> Result<f64, String> {
    let density = text.parse::<f64>().ok().filter(|d| d.is_finite() && *d >= 0.0);
    density.ok_or_else(|| format!("a number of at least 0 is expected{}", without_unit(text)))
}

pub(super) fn texture(text: &str) -> Result<TextureArg, String> {
    match text {
        "none" => Ok(TextureArg::None),
        _ => text
            .parse()
            .map(TextureArg::Index)
            .map_err(|_| "the index of a texture, or none, is expected".to_owned()),
    }
}

pub(super) fn preset(text: &str) -> Result<&'static Preset, String> {
    Preset::named(text).ok_or_else(|| unknown_preset(text))
}

/// What is said of a preset that is not there.
pub(super) fn unknown_preset(text: &str) -> String {
    let unknown = names::unknown("preset", text, Preset::all_names());
    format!("{unknown}; `nephrite presets` lists them all")
}

pub(super) fn form(text: &str) -> Result<Form, String> {
    match text {
        "nephrite" => Ok(Form::Nephrite),
        "khr-scatter" => Ok(Form::KhrScatter),
        "openpbr" => Ok(Form::OpenPbr),
        _ => Err(names::unknown("description of media", text, ["khr-scatter", "nephrite", "openpbr"])),
    }
}

impl LengthUnit {
    /// A coefficient per this unit, in 1/m: the decimal point is moved, so that 0.07 per millimetre is 70 exactly.
    pub fn per_metre(self, coefficient: f64) -> f64 {
        self.shifted(coefficient, 3)
    }

    /// A length in this unit, in metres.
    pub fn metres(self, length: f64) -> f64 {
        self.shifted(length, -3)
    }

    fn shifted(self, value: f64, places: i32) -> f64 {
        let places = match self {
            Self::Metre => 0,
            Self::Centimetre => places - places.signum(),
            Self::Millimetre => places,
        };
        let text = format!("{value:e}");
        let shifted = text.split_once('e').and_then(|(digits, exponent)| {
            format!("{digits}e{}", exponent.parse::<i32>().ok()? + places).parse().ok()
        });
        shifted.unwrap_or(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_move_the_decimal_point() {
        for (mm, m) in [(0.07, 70.0), (0.0021, 2.1), (2.19, 2190.0), (1e-9, 1e-6), (0.0, 0.0), (0.013, 13.0)]
        {
            assert_eq!(LengthUnit::Millimetre.per_metre(mm), m);
            assert_eq!(LengthUnit::Metre.per_metre(mm), mm);
        }
        assert_eq!(LengthUnit::Millimetre.metres(0.3), 0.0003);
        assert_eq!(LengthUnit::Centimetre.metres(0.3), 0.003);
        assert_eq!(LengthUnit::Centimetre.per_metre(0.07), 7.0);
    }

    #[test]
    fn colours_of_paint_programs_are_made_linear() {
        // 0x3f, 0xa0 and 0x60 by the formula of sRGB (IEC 61966-2-1).
        let linear = [0.049_707, 0.351_533, 0.116_971];
        let found = color("#3fa060").unwrap();
        assert!(found.iter().zip(linear).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
        assert_eq!(color("#f0f"), Ok([1.0, 0.0, 1.0]));
        for wrong in ["#", "#12345", "#+1+1+1", "#gggggg", "#ääa"] {
            assert!(color(wrong).unwrap_err().contains("#rrggbb"), "{wrong}");
        }
        assert!(lengths("1mm").unwrap_err().contains("--unit mm"));
        assert!(lengths("1,0.5cm,2").unwrap_err().contains("--unit cm"));
    }

    #[test]
    fn nonsense_is_refused() {
        assert_eq!(channels("1, 2,3"), Ok([1.0, 2.0, 3.0]));
        assert_eq!(channels("0.5"), Ok([0.5; 3]));
        for wrong in ["1,2", "", "a,b,c", "1,2,3,4", "1,-2,3", "1,nan,2", "inf"] {
            assert!(channels(wrong).is_err(), "{wrong}");
        }
        assert!(color("0.2,0.3,1.1").is_err() && lengths("1,0,1").is_err());
        assert!(anisotropy("1").is_err() && anisotropy("-0.9").is_ok());
        assert!(ior("0.9").is_err() && density("-1").is_err() && texture("x").is_err());
        let unknown = preset("marbel").unwrap_err();
        assert!(
            unknown.contains("did you mean marble") && unknown.contains("`nephrite presets`"),
            "{unknown}"
        );
        assert!(preset("candel").unwrap_err().contains("did you mean candle"));
        assert!(form("openpr").unwrap_err().contains("did you mean openpbr"));
    }
}
