//! Which animations play and when: `--animation`, `--at` and `--shutter`.

use super::Failure;
use super::message::Reporter;
use super::names;
use super::pipeline::{Asset, Moment, Shutter};
use super::values::without_unit;

/// Which animations play, and when.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct PlayArgs {
    /// Animation of the file to play, or all of them; may be repeated, and where two change the same property the last
    /// one counts [default: none; with --at the first]
    #[arg(long, value_name = "NAME|INDEX|all")]
    pub animation: Vec<String>,

    /// Moment of the animations in seconds [default: 0]; before their first keyframe and after their last one they
    /// stand still
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub at: Option<f64>,
}

impl PlayArgs {
    /// The moment that was asked for; `moving` says that something was asked for that needs an animation.
    pub fn moment(&self, asset: &Asset, moving: bool, reporter: &Reporter) -> Result<Moment, Failure> {
        let names = asset.animation_names();
        let mut animations = self.chosen(&names)?;
        let asked = match (self.at.is_some(), moving) {
            (true, _) => Some("--at"),
            (false, true) => Some("--shutter"),
            (false, false) => None,
        };
        if let Some(option) = asked.filter(|_| animations.is_empty()) {
            if let Some(first) = names.first() {
                let first = first.map_or("without a name".to_owned(), |name| format!("{name:?}"));
                let others = match names.len() {
                    1 => String::new(),
                    n => format!("; there are {n}, choose with --animation"),
                };
                reporter.note(format!("{option} plays the first animation, {first}{others}"));
                animations.push(0);
            } else {
                reporter.note(format!("{option} does nothing: the file has no animations"));
            }
        }
        Ok(Moment { animations, time: self.at.unwrap_or(0.0) })
    }

    /// Indices of the animations that were asked for, by name or else by index.
    fn chosen(&self, names: &[Option<&str>]) -> Result<Vec<usize>, Failure> {
        let mut chosen = Vec::new();
        for wanted in &self.animation {
            let by_name = names.iter().position(|name| *name == Some(wanted));
            let by_index = || wanted.parse().ok().filter(|&index: &usize| index < names.len());
            match by_name.or_else(by_index) {
                Some(index) => chosen.push(index),
                None if wanted == "all" => chosen.extend(0..names.len()),
                None if names.is_empty() => {
                    let message = format!("there is no animation {wanted:?}: the file has none");
                    return Err(Failure::advise(message, "leave --animation out"));
                }
                None => {
                    let known = names.iter().copied().flatten();
                    let advice = format!("give a name, an index from 0 to {}, or all", names.len() - 1);
                    return Err(Failure::advise(names::unknown("animation", wanted, known), advice));
                }
            }
        }
        // The last place counts, as in the documentation of the option.
        let mut last = Vec::new();
        for index in chosen.into_iter().rev() {
            if !last.contains(&index) {
                last.push(index);
            }
        }
        last.reverse();
        Ok(last)
    }
}

/// Whether what moves is blurred.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct ShutterArgs {
    /// Leave the shutter open, so that what moves is blurred: from --at on for so many seconds, or from OPEN to CLOSE
    /// seconds after it
    #[arg(long, value_name = "SECONDS|OPEN,CLOSE", value_parser = shutter)]
    pub shutter: Option<[f64; 2]>,

    /// Moments that an open shutter sees, at most one a sample; each is a scene to build
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    pub shutter_slices: u32,
}

impl ShutterArgs {
    /// The shutter, if it is open while something may move; times of the moment count from its opening.
    pub fn at(&self, moment: &Moment) -> Option<Shutter> {
        let [open, close] = self.shutter.filter(|_| !moment.animations.is_empty())?;
        let close = moment.time + (close - open);
        Some(Shutter { open: moment.time, close, slices: self.shutter_slices })
    }
}

/// A time in seconds.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|t| t.is_finite())
        .ok_or_else(|| format!("a time in seconds is expected{}", without_unit(text)))
}

/// When a shutter opens and closes, in seconds after the moment of the picture.
fn shutter(text: &str) -> Result<[f64; 2], String> {
    let times = text.split(',').map(|part| seconds(part.trim())).collect::<Result<Vec<f64>, _>>();
    match times.ok().as_deref() {
        Some(&[duration]) if duration >= 0.0 => Ok([0.0, duration]),
        Some(&[open, close]) if open <= close => Ok([open, close]),
        _ => {
            let write = "write how long it is open, such as 0.02, or from when to when, such as -0.01,0.01";
            Err(format!("{write}{}", without_unit(text)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(wanted: &[&str], names: &[Option<&str>]) -> Result<Vec<usize>, String> {
        let args = PlayArgs { animation: wanted.iter().map(|w| (*w).to_owned()).collect(), at: None };
        args.chosen(names).map_err(|failure| match failure {
            Failure::Cannot { message, advice } => format!("{message} {advice:?}"),
            _ => "something else".to_owned(),
        })
    }

    #[test]
    fn animations_are_found_by_name_before_index() {
        let names = [Some("walk"), None, Some("0"), Some("run")];
        assert_eq!(chosen(&["walk", "1"], &names), Ok(vec![0, 1]));
        assert_eq!(chosen(&["0"], &names), Ok(vec![2]));
        assert_eq!(chosen(&["all", "walk"], &names), Ok(vec![1, 2, 3, 0]), "the last one counts");
        assert_eq!(chosen(&["all"], &[Some("all"), Some("b")]), Ok(vec![0]));
        let error = chosen(&["wlak"], &names).unwrap_err();
        assert!(error.contains("did you mean walk") && error.contains("0 to 3"), "{error}");
        assert!(chosen(&["4"], &names).is_err());
        assert!(chosen(&["walk"], &[]).unwrap_err().contains("has none"));
    }

    #[test]
    fn shutters_are_times_in_order() {
        assert_eq!(shutter("0.02"), Ok([0.0, 0.02]));
        assert_eq!(shutter("-0.01, 0.01"), Ok([-0.01, 0.01]));
        for wrong in ["-1", "2,1", "", "1,2,3", "nan", "x"] {
            assert!(shutter(wrong).unwrap_err().contains("0.02"), "{wrong}");
        }
    }
}
