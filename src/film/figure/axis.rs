//! Axes: ranges, the mapping onto \[0, 1\], and ticks.

use super::FigureError;

/// Larger magnitudes, and on logarithmic axes smaller ones than the inverse, count as infinite.
const LARGEST: f64 = 1e300;
/// Smaller magnitudes are zero on linear axes.
const SMALLEST: f64 = 1.0 / LARGEST;
/// Positions end here, many pictures away, so that they stay finite.
const FARTHEST: f64 = 1e9;
/// Room between the data and the ends of an automatic range, over the range.
const MARGIN: f64 = 0.04;
/// Decades below the largest value that an automatic logarithmic range shows at most.
const MAX_DECADES: f64 = 12.0;
/// Linear ranges that are narrower than this, over their magnitude, count as one value.
const NARROWEST: f64 = 1e-9;

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm. Values that are not above zero are left out.
    Log,
}

/// One axis of a plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub title: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// First and last value, ascending; without, all that can be shown of the data with a small margin (a linear axis
    /// starts at zero if the data come close, a logarithmic one ends twelve decades below the largest value).
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// A linear axis with an automatic range.
    pub fn linear(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// A logarithmic axis with an automatic range.
    pub fn log(title: impl Into<String>) -> Self {
        Self { title: title.into(), scale: Scale::Log, range: None }
    }

    /// The axis with that range.
    pub fn with_range(self, first: f64, last: f64) -> Self {
        Self { range: Some([first, last]), ..self }
    }

    /// The mapping of an axis that has to show these values.
    pub(super) fn mapping(&self, values: impl Iterator<Item = f64>) -> Result<Mapping, FigureError> {
        let scale = self.scale;
        if let Some(range @ [min, max]) = self.range {
            let narrow = match scale {
                Scale::Linear => max - min <= (NARROWEST * min.abs().max(max.abs())).max(SMALLEST),
                Scale::Log => max / min <= 1.0 + NARROWEST,
            };
            if !scale.shows(min) || !scale.shows(max) || min >= max || narrow {
                return Err(FigureError::Range { axis: self.title.clone(), range });
            }
            return Ok(Mapping { scale, min, max });
        }
        let (min, max) = values
            .map(|v| if scale == Scale::Linear && v.abs() < SMALLEST { 0.0 } else { v })
            .filter(|v| scale.shows(*v))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)));
        let (min, max) = match scale {
            _ if min > max => [(0.0, 1.0), (0.1, 10.0)][scale as usize],
            Scale::Linear if max - min <= NARROWEST * max.abs().max(min.abs()) => {
                let half = if max == 0.0 { 1.0 } else { 0.1 * max.abs() };
                (min - half, max + half)
            }
            Scale::Linear => {
                let margin = MARGIN * (max - min);
                let first = if min >= 0.0 && min < 0.2 * max { 0.0 } else { min - margin };
                (first, max + margin)
            }
            Scale::Log => {
                let max_log = max.log10();
                let min_log = min.log10().max(max_log - MAX_DECADES);
                let margin = if max_log - min_log < 1e-3 { 0.5 } else { MARGIN * (max_log - min_log) };
                (10_f64.powf(min_log - margin), 10_f64.powf(max_log + margin))
            }
        };
        Ok(Mapping { scale, min, max })
    }
}

impl Scale {
    fn shows(self, v: f64) -> bool {
        v.abs() < LARGEST && (self == Self::Linear || v > SMALLEST)
    }
}

/// Values to positions along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mapping {
    pub scale: Scale,
    pub min: f64,
    pub max: f64,
}

/// A mark on an axis; minor ones have no label.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    pub label: Option<String>,
}

/// The marks of an axis, and the factor that all labels are to be multiplied by.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ticks {
    pub ticks: Vec<Tick>,
    pub factor: Option<String>,
}

impl Mapping {
    /// 0 at the first value of the axis, 1 at the last one; nothing for values that cannot be shown at all.
    pub(super) fn position(&self, v: f64) -> Option<f64> {
        let position = match self.scale {
            Scale::Linear => (v - self.min) / (self.max - self.min),
            Scale::Log => (v.log10() - self.min.log10()) / (self.max.log10() - self.min.log10()),
        };
        self.scale.shows(v).then(|| position.clamp(-FARTHEST, FARTHEST))
    }

    /// At most about `target` labelled ticks.
    pub(super) fn ticks(&self, target: usize) -> Ticks {
        let target = target.max(2);
        match self.scale {
            Scale::Linear => self.linear_ticks(target),
            Scale::Log => self.log_ticks(target),
        }
    }

    fn linear_ticks(&self, target: usize) -> Ticks {
        let rough = (self.max - self.min) / target as f64;
        let decade = rough.log10().floor() as i32;
        let mut exponent = decade;
        let mut digit = 1;
        while f64::from(digit) * power_of_ten(exponent) < rough * (1.0 - 1e-9) {
            (digit, exponent) = match digit {
                1 => (2, exponent),
                2 => (5, exponent),
                _ => (1, exponent + 1),
            };
        }
        let largest = self.min.abs().max(self.max.abs());
        let shift = if (1e-3..1e5).contains(&largest) { 0 } else { largest.log10().floor() as i32 };
        let step = f64::from(digit) * power_of_ten(exponent);
        let decimals = usize::try_from(shift - exponent).unwrap_or(0);
        let first = (self.min / step - 1e-6).ceil() as i64;
        let last = (self.max / step + 1e-6).floor() as i64;
        let label = |i: i64| {
            let digits = i as f64 * f64::from(digit) * power_of_ten(exponent - shift);
            format!("{digits:.decimals$}").replace('-', "−")
        };
        let ticks = (first..=last).map(|i| Tick { value: i as f64 * step, label: Some(label(i)) });
        Ticks { ticks: ticks.collect(), factor: (shift != 0).then(|| format!("×10{}", superscript(shift))) }
    }

    fn log_ticks(&self, target: usize) -> Ticks {
        let first = (self.min.log10() - 1e-9).ceil() as i32;
        let last = (self.max.log10() + 1e-9).floor() as i32;
        let decades = (last - first + 1).max(0) as usize;
        let stride = decades.div_ceil(target).max(1) as i32;
        let inside = |v: f64| v >= self.min * (1.0 - 1e-9) && v <= self.max * (1.0 + 1e-9);
        let digits = |digits: &'static [i32]| {
            let of_decade = move |k| digits.iter().map(move |d| (*d, k));
            let all = (first - 1..=last).flat_map(of_decade);
            all.filter(move |(d, k)| inside(f64::from(*d) * power_of_ten(*k)))
        };
        let tick = |(digit, k): (i32, i32), label: Option<String>| Tick {
            value: f64::from(digit) * power_of_ten(k),
            label,
        };
        let ticks = if decades >= 2 {
            digits(&[1, 2, 3, 4, 5, 6, 7, 8, 9])
                .filter(|(digit, _)| *digit == 1 || stride == 1)
                .map(|(digit, k)| {
                    let labelled = digit == 1 && k.rem_euclid(stride) == 0;
                    tick((digit, k), labelled.then(|| format!("10{}", superscript(k))))
                })
                .collect()
        } else if digits(&[1, 2, 5]).count() >= 3 {
            digits(&[1, 2, 3, 4, 5, 6, 7, 8, 9])
                .map(|(digit, k)| tick((digit, k), matches!(digit, 1 | 2 | 5).then(|| plain(digit, k))))
                .collect()
        } else {
            return self.linear_ticks(target.min(6));
        };
        Ticks { ticks, factor: None }
    }
}

/// `digit` × 10^`k` as one reads it.
fn plain(digit: i32, k: i32) -> String {
    match k {
        0..=4 => format!("{}", i64::from(digit) * 10_i64.pow(k as u32)),
        -3..0 => format!("{:.*}", k.unsigned_abs() as usize, f64::from(digit) * power_of_ten(k)),
        _ if digit == 1 => format!("10{}", superscript(k)),
        _ => format!("{digit}×10{}", superscript(k)),
    }
}

/// The number nearest to 10^`k`, which `powi` is not.
fn power_of_ten(k: i32) -> f64 {
    format!("1e{k}").parse().unwrap_or(f64::NAN)
}

pub(super) fn superscript(k: i32) -> String {
    let raise = |c: char| match c.to_digit(10) {
        Some(d) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][d as usize],
        None => '⁻',
    };
    k.to_string().chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, min: f64, max: f64, target: usize) -> Vec<String> {
        let ticks = Mapping { scale, min, max }.ticks(target);
        assert!(
            ticks.ticks.iter().all(|t| t.value >= min - 1e-9 * max.abs() && t.value <= max * (1.0 + 1e-9))
        );
        ticks.ticks.into_iter().filter_map(|t| t.label).collect()
    }

    #[test]
    fn log_axes_are_labelled_at_powers_of_ten() {
        assert_eq!(labels(Scale::Log, 0.01, 100.0, 10), ["10⁻²", "10⁻¹", "10⁰", "10¹", "10²"]);
        assert_eq!(labels(Scale::Log, 0.011, 99.0, 10), ["10⁻¹", "10⁰", "10¹"]);
        assert_eq!(labels(Scale::Log, 1e-12, 1.0, 5), ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"]);
        let decades = Mapping { scale: Scale::Log, min: 1.0, max: 100.0 }.ticks(10).ticks;
        let values: Vec<f64> = decades.iter().map(|t| t.value).collect();
        let expected = (1..10).map(f64::from).chain((1..10).map(|i| f64::from(10 * i))).chain([100.0]);
        assert_eq!(values, expected.collect::<Vec<_>>());
    }

    #[test]
    fn short_log_axes_are_labelled_between_powers_of_ten() {
        assert_eq!(labels(Scale::Log, 0.3, 7.0, 10), ["0.5", "1", "2", "5"]);
        assert_eq!(labels(Scale::Log, 1.5e-7, 6e-7, 10), ["2", "3", "4", "5", "6"]);
        assert_eq!(labels(Scale::Log, 0.9e-6, 6e-6, 10), ["10⁻⁶", "2×10⁻⁶", "5×10⁻⁶"]);
        assert_eq!(labels(Scale::Log, 31.0, 38.0, 4), ["32", "34", "36", "38"]);
    }

    #[test]
    fn linear_axes_have_round_numbers() {
        assert_eq!(labels(Scale::Linear, 0.0, 1.0, 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(Scale::Linear, -13.0, 31.0, 5), ["−10", "0", "10", "20", "30"]);
        assert_eq!(labels(Scale::Linear, 0.0, 5e-5, 5), ["0", "1", "2", "3", "4", "5"]);
        let tiny = Mapping { scale: Scale::Linear, min: 0.0, max: 5e-5 }.ticks(5);
        assert_eq!(tiny.factor.as_deref(), Some("×10⁻⁵"));
        assert!((tiny.ticks[3].value - 3e-5).abs() < 1e-18);
    }

    #[test]
    fn ranges_leave_out_what_cannot_be_shown() {
        let values = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-3, 10.0];
        let log = Axis::log("r").mapping(values.into_iter()).unwrap();
        assert!(log.min < 1e-3 && log.min > 1e-4 && log.max > 10.0 && log.max < 100.0, "{log:?}");
        let linear = Axis::linear("r").mapping(values.into_iter()).unwrap();
        assert!(linear.min < -1.0 && linear.max > 10.0 && linear.max < 11.0);
        assert_eq!(Axis::linear("r").mapping([1.0, 20.0].into_iter()).unwrap().min, 0.0);
        let deep = Axis::log("r").mapping([1e-200, 1.0].into_iter()).unwrap();
        assert!(deep.min > 1e-13);
        for values in [
            vec![],
            vec![f64::NAN],
            vec![0.0],
            vec![5.0; 3],
            vec![-1e299, 1e299],
            vec![1e-299],
            vec![0.0, 5e-324],
        ] {
            for axis in [Axis::linear(""), Axis::log("")] {
                let mapping = axis.mapping(values.iter().copied()).unwrap();
                assert!(mapping.min < mapping.max && mapping.min.is_finite() && mapping.max.is_finite());
                let count = mapping.ticks(8).ticks.len();
                assert!((2..120).contains(&count), "{count} ticks for {values:?} on {mapping:?}");
            }
        }
    }

    #[test]
    fn impossible_ranges_are_refused() {
        for [a, b] in
            [[1.0, 1.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [1.0, 1.0 + 1e-15], [0.0, 1e-310]]
        {
            assert!(Axis::linear("x").with_range(a, b).mapping([].into_iter()).is_err(), "{a} to {b}");
        }
        let refused = Axis::log("R(r)").with_range(0.0, 1.0).mapping([].into_iter());
        assert_eq!(refused.unwrap_err().to_string(), "the axis `R(r)` cannot go from 0 to 1");
    }
}
