//! False colours for signed differences: blue (darker than the reference), white (equal), red (brighter).
//!
//! Colours lie on two straight lines in Oklab (Ottosson, *A perceptual color space for image processing*, 2020), from
//! white to a blue and a red of the same lightness and chroma. So equal steps of the difference are equal steps for
//! the eye, on both sides, and a grey print still shows the magnitude.

use super::{FigureError, Raster, Rgb, check_length, check_size, to_byte};
use crate::film::tonemap::encode_srgb;
use glam::{Mat3, Vec3, vec3};

/// What shows where the difference is NaN: a green that the scale does not have.
pub const INVALID: Rgb = [0, 158, 60];

/// Lightness and chroma of both ends, in Oklab.
const END_LIGHTNESS: f32 = 0.47;
const END_CHROMA: f32 = 0.16;
/// Hues of the ends as (cos, sin), 262° and 26°.
const BLUE: [f32; 2] = [-0.139_173, -0.990_268];
const RED: [f32; 2] = [0.898_794, 0.438_371];

/// The colour of a difference: 0 is white, +1 and above the full red, −1 and below the full blue.
pub fn diverging(t: f32) -> Rgb {
    if t.is_nan() {
        return INVALID;
    }
    let amount = t.abs().min(1.0);
    let hue = if t > 0.0 { RED } else { BLUE };
    let chroma = END_CHROMA * amount;
    let lab = vec3(1.0 + (END_LIGHTNESS - 1.0) * amount, hue[0] * chroma, hue[1] * chroma);
    from_oklab(lab).to_array().map(|c| to_byte(encode_srgb(c.clamp(0.0, 1.0))))
}

/// Signed values in false colour, row by row; ±`full_scale` are the ends of the scale ([`diverging`]). Infinite values
/// show as the ends, NaN as [`INVALID`], and so does everything if `full_scale` is not positive.
pub fn signed(width: u32, height: u32, values: &[f32], full_scale: f32) -> Result<Raster, FigureError> {
    check_length(check_size(width.into(), height.into())?, values.len())?;
    let scale = if full_scale > 0.0 { full_scale } else { f32::NAN };
    let color = |v: &f32| diverging(if v.is_infinite() { *v * scale } else { v / scale });
    Raster::from_rgb(width, height, values.iter().flat_map(color).collect())
}

/// Luminance of `image` minus that of `reference` (Rec. 709, linear), pixel by pixel.
pub fn luminance_difference(image: &[Vec3], reference: &[Vec3]) -> Vec<f32> {
    const LUMINANCE: Vec3 = vec3(0.2126, 0.7152, 0.0722);
    image.iter().zip(reference).map(|(a, b)| (*a - *b).dot(LUMINANCE)).collect()
}

/// A full scale for values of that size: the smallest 1, 2 or 5 times a power of ten that at most one percent of the
/// finite magnitudes exceed; 1 if none of them is above zero.
pub fn full_scale<'a>(values: impl IntoIterator<Item = &'a f32>) -> f32 {
    let mut magnitudes: Vec<f32> =
        values.into_iter().map(|v| v.abs()).filter(|v| v.is_finite() && *v > 0.0).collect();
    if magnitudes.is_empty() {
        return 1.0;
    }
    let rank = (magnitudes.len() - 1) * 99 / 100;
    let (_, &mut typical, _) = magnitudes.select_nth_unstable_by(rank, f32::total_cmp);
    let decade = 10.0_f64.powf(f64::from(typical).log10().floor());
    let step = [1.0, 2.0, 5.0].into_iter().find(|s| s * decade >= f64::from(typical) * (1.0 - 1e-6));
    ((step.unwrap_or(10.0) * decade) as f32).clamp(f32::MIN_POSITIVE, f32::MAX)
}

/// Oklab to linear Rec. 709.
fn from_oklab(lab: Vec3) -> Vec3 {
    const TO_CONES: Mat3 = Mat3::from_cols(
        vec3(1.0, 1.0, 1.0),
        vec3(0.396_337_78, -0.105_561_346, -0.089_484_18),
        vec3(0.215_803_76, -0.063_854_17, -1.291_485_5),
    );
    const TO_RGB: Mat3 = Mat3::from_cols(
        vec3(4.076_741_7, -1.268_438, -0.004_196_086),
        vec3(-3.307_711_6, 2.609_757_4, -0.703_418_6),
        vec3(0.230_969_94, -0.341_319_4, 1.707_614_7),
    );
    let cones = TO_CONES * lab;
    TO_RGB * (cones * cones * cones)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sRGB to Oklab by the forward matrices, which the code above does not have.
    fn to_oklab(color: Rgb) -> Vec3 {
        let [r, g, b] = color.map(|c| {
            let c = f32::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let l = (0.412_221_47 * r + 0.536_332_54 * g + 0.051_445_993 * b).cbrt();
        let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).cbrt();
        let s = (0.088_302_46 * r + 0.281_718_84 * g + 0.629_978_7 * b).cbrt();
        vec3(
            0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
            1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
            0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
        )
    }

    #[test]
    fn white_at_zero_and_red_where_brighter() {
        assert_eq!(diverging(0.0), [255; 3]);
        assert_eq!(diverging(-0.0), [255; 3]);
        let ([r, _, b], [r2, _, b2]) = (diverging(0.7), diverging(-0.7));
        assert!(r > b && b2 > r2);
        assert_eq!(diverging(f32::NAN), INVALID);
        assert_eq!(diverging(f32::INFINITY), diverging(1.0));
    }

    #[test]
    fn steps_are_even_and_the_same_on_both_sides() {
        let white = to_oklab([255; 3]);
        let full = (1.0 - END_LIGHTNESS).hypot(END_CHROMA);
        for i in 1..=50 {
            let t = i as f32 / 50.0;
            for side in [t, -t] {
                let lab = to_oklab(diverging(side));
                let distance = (lab - white).length();
                // Eight bits are worth about 0.002 here; clipping by the gamut would be seen as more.
                assert!((distance - full * t).abs() < 0.004, "at {side}: {distance}, not {}", full * t);
                assert!((lab.x - (1.0 + (END_LIGHTNESS - 1.0) * t)).abs() < 0.004, "lightness at {side}");
            }
        }
    }

    #[test]
    fn every_step_is_darker_than_the_one_before() {
        let lightness = |t: f32| to_oklab(diverging(t)).x;
        for i in 0..100 {
            for sign in [1.0, -1.0] {
                let (near, far) = (sign * i as f32 / 100.0, sign * (i + 1) as f32 / 100.0);
                assert!(lightness(far) < lightness(near), "from {near} to {far}");
            }
        }
    }

    #[test]
    fn pictures_of_odd_values() {
        let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, 1e30, -2.0];
        let picture = signed(3, 2, &values, 2.0).unwrap();
        let expected = [INVALID, diverging(1.0), diverging(-1.0), [255; 3], diverging(1.0), diverging(-1.0)];
        assert_eq!(picture.rgb(), expected.as_flattened());
        assert_eq!(signed(3, 2, &values, 0.0).unwrap().rgb(), [INVALID; 6].as_flattened());
        assert_eq!(signed(2, 2, &values, 1.0), Err(FigureError::Length { expected: 4, found: 6 }));
    }

    #[test]
    fn full_scales_are_round_and_ignore_outliers() {
        assert_eq!(full_scale(&[]), 1.0);
        assert_eq!(full_scale(&[f32::NAN, f32::INFINITY, 0.0]), 1.0);
        assert_eq!(full_scale(&[0.1]), 0.1);
        assert_eq!(full_scale(&[-0.3, 0.2]), 0.2);
        let mut values = vec![0.013; 1000];
        values[..5].fill(1e6);
        assert_eq!(full_scale(&values), 0.02);
        for v in [f32::MAX, f32::MIN_POSITIVE, 1e-45] {
            assert!(full_scale(&[v]).is_normal(), "{v}");
        }
    }
}
