//! The contact sheet of a comparison.

use super::{Entry, Results, input_name};
use crate::cli::Failure;
use crate::cli::args::CompareArgs;
use crate::cli::setup::Prepared;
use crate::film::compare::{Comparison, Measured};
use crate::film::figure::{Arrangement, Cell, ColorBar, Raster, Sheet, false_color};

/// A sheet and what its colours mean.
pub(super) struct Drawn {
    pub picture: Raster,
    /// The difference that has the full colour.
    pub full_scale: f32,
}

/// Draws the reference and all models.
pub(super) fn draw(args: &CompareArgs, prepared: &Prepared, results: &Results) -> Result<Drawn, Failure> {
    let reference = &results.reference;
    let differences: Vec<Vec<f32>> = results
        .models
        .iter()
        .map(|(entry, _)| false_color::luminance_difference(&entry.picture.pixels, &reference.picture.pixels))
        .collect();
    let full_scale = common_scale(&differences);
    let noise = results.models.first().map(|(_, found)| found.reference_noise);
    let mut cells = vec![Cell {
        picture: picture(args, reference)?,
        difference: None,
        name: "reference".to_owned(),
        lines: vec![
            format!("{}, {} samples a pixel", reference.name, results.reference_spp),
            times(reference),
            format!("noise {}", noise.map(digits).unwrap_or_default()),
        ],
    }];
    for ((entry, found), difference) in results.models.iter().zip(&differences) {
        let shown = false_color::signed(prepared.width, prepared.height, difference, full_scale);
        cells.push(Cell {
            picture: picture(args, entry)?,
            difference: Some(shown.map_err(Failure::cannot)?),
            name: entry.name.clone(),
            lines: lines(entry, found),
        });
    }
    let threads = match prepared.options(&args.scene, results.spp, "").thread_count() {
        1 => "1 thread".to_owned(),
        n => format!("{n} threads"),
    };
    let sheet = Sheet {
        title: format!("{}: subsurface models, {} samples a pixel", input_name(args), results.spp),
        cells,
        arrangement: Arrangement::Below,
        columns: None,
        color_bar: Some(ColorBar {
            full_scale,
            label: "luminance minus that of the reference (linear)".to_owned(),
        }),
        footer: format!(
            "Seconds: wall clock on {threads}, and of all cores. relMSE: mean of (picture − reference)² / (squared \
             reference, smoothed, + 1 % of its mean) without the worst 0.1 % of the pixels; it is the sum of squared \
             bias, noise, and noise of the reference, which two independent halves of each picture tell apart. \
             Mean: red, green, blue over those of the reference."
        ),
    };
    Ok(Drawn { picture: sheet.draw().map_err(Failure::cannot)?, full_scale })
}

/// A scale that shows most of the differences of most of the models; the farthest may be cut off.
fn common_scale(differences: &[Vec<f32>]) -> f32 {
    let mut scales: Vec<f32> = differences.iter().map(false_color::full_scale).collect();
    scales.sort_by(f32::total_cmp);
    scales.get(scales.len() / 2).copied().unwrap_or(1.0)
}

fn picture(args: &CompareArgs, entry: &Entry) -> Result<Raster, Failure> {
    let (map, exposure) = (args.scene.tonemap, args.scene.exposure.exp2());
    let picture = &entry.picture;
    Raster::from_linear(picture.width, picture.height, &picture.pixels, |p| map.apply(p * exposure))
        .map_err(Failure::cannot)
}

fn lines(entry: &Entry, found: &Comparison) -> Vec<String> {
    let Measured { value, standard_error } = found.bias;
    let ratios =
        found.mean_ratio.map(|m| if m.value.is_finite() { format!("{:.3}", m.value) } else { "–".into() });
    vec![
        times(entry),
        format!("relMSE {}", digits(found.rel_mse)),
        format!("bias² {} ± {}", digits(value), digits(standard_error)),
        format!("noise {}, 99.9 % of the pixels below {}", digits(found.noise), digits(found.noise_p999)),
        format!("mean / reference: {}", ratios.join(" ")),
    ]
}

fn times(entry: &Entry) -> String {
    let wall = format!("{} s", digits(entry.work.seconds));
    match entry.work.cpu_seconds {
        Some(cpu) => format!("{wall}, {} s of CPU", digits(cpu)),
        None => wall,
    }
}

/// A number with three digits, with fewer below 0.001.
fn digits(v: f64) -> String {
    let magnitude = v.abs();
    let text = if v == 0.0 || !v.is_finite() {
        format!("{v}")
    } else if magnitude < 1e-4 {
        format!("{v:.1e}")
    } else {
        let decimals = (2 - magnitude.log10().floor() as i32).clamp(0, 5) as usize;
        format!("{v:.decimals$}")
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (0.012_34, "0.0123"),
            (-0.5, "−0.500"),
            (12.345, "12.3"),
            (1234.5, "1234"),
            (0.000_123, "0.00012"),
            (0.000_012, "1.2e−5"),
            (0.001, "0.00100"),
        ];
        for (value, text) in cases {
            assert_eq!(digits(value), text);
        }
    }

    #[test]
    fn one_model_that_is_far_off_does_not_hide_the_others() {
        let differences = [0.01, 0.02, 50.0].map(|d| vec![d; 100]);
        assert_eq!(common_scale(&differences), 0.02);
        assert_eq!(common_scale(&[]), 1.0);
    }
}
