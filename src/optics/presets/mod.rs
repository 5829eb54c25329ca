//! Media by name, each with where its numbers are from: published ones, and our own estimates of what nobody measured.
//!
//! | file | source |
//! | --- | --- |
//! | [`jensen`] | measured: Jensen et al. 2001 |
//! | [`narasimhan`] | measured: Narasimhan et al. 2006 |
//! | [`openpbr`] | made by eye, some from measurements: the examples of OpenPBR |
//! | [`estimates`] | ours: made by eye, or from what is said beside each |
//! | [`aliases`] | what else people call them |

pub mod aliases;
pub mod estimates;
pub mod jensen;
pub mod narasimhan;
pub mod openpbr;

pub use aliases::ALIASES;
pub use estimates::ESTIMATES;
pub use jensen::JENSEN_2001;
pub use narasimhan::NARASIMHAN_2006;
pub use openpbr::OPENPBR_EXAMPLES;

use super::diffusion::Coefficients;

/// Where numbers are from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// Jensen, Marschner, Levoy, Hanrahan 2001, figure 5.
    Jensen2001,
    /// Narasimhan et al. 2006.
    Narasimhan2006,
    /// The example materials of OpenPBR.
    OpenPbr,
    /// Estimates of this program: nobody measured them.
    Estimate,
}

impl Source {
    /// The source in a few words.
    pub fn citation(self) -> &'static str {
        match self {
            Self::Jensen2001 => "Jensen, Marschner, Levoy, Hanrahan 2001, figure 5",
            Self::Narasimhan2006 => "Narasimhan, Gupta, Donner, Ramamoorthi, Nayar, Jensen 2006",
            Self::OpenPbr => "example materials of OpenPBR (Academy Software Foundation)",
            Self::Estimate => "estimates of ours, not measured",
        }
    }

    /// A letter for where there is no room.
    pub fn letter(self) -> char {
        match self {
            Self::Jensen2001 => 'J',
            Self::Narasimhan2006 => 'N',
            Self::OpenPbr => 'O',
            Self::Estimate => 'E',
        }
    }

    /// All of them, in the order of [`Preset::all`].
    pub const ALL: [Self; 4] = [Self::Jensen2001, Self::Narasimhan2006, Self::OpenPbr, Self::Estimate];
}

/// A medium and its boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Name on the command line.
    pub name: &'static str,
    /// Where its numbers are from.
    pub source: Source,
    /// Absorption coefficient σa, 1/mm.
    pub sigma_a_per_mm: [f64; 3],
    /// Scattering coefficient σs, 1/mm.
    pub sigma_s_per_mm: [f64; 3],
    /// Mean cosine of Henyey–Greenstein for each channel.
    pub g: [f64; 3],
    /// Index of refraction.
    pub eta: f64,
    /// Of an estimate: what it is, and what it was derived from. Empty where the source says all.
    pub note: &'static str,
}

/// A medium whose three channels share one mean cosine, as files have it. Coefficients in 1/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneAnisotropy {
    /// Absorption coefficient, 1/m.
    pub sigma_a: [f64; 3],
    /// Scattering coefficient, 1/m.
    pub sigma_s: [f64; 3],
    /// Mean cosine.
    pub g: f64,
    /// Index of refraction.
    pub eta: f64,
}

impl Preset {
    /// All of them.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        JENSEN_2001.iter().chain(&NARASIMHAN_2006).chain(&OPENPBR_EXAMPLES).chain(&ESTIMATES)
    }

    /// The preset of that name, of that other name, or of those words in another order, whatever their case: `jade-white`
    /// is also `White Jade`, and `skin-iv` also `skin type 4` and `fitzpatrick-iv`.
    pub fn named(name: &str) -> Option<&'static Self> {
        let exact = |name: &str| Self::all().find(|preset| preset.name == name);
        exact(name).or_else(|| {
            let wanted = aliases::key(name);
            let other = ALIASES.iter().find(|(other, _)| aliases::key(other) == wanted);
            let own = || Self::all().find(|preset| aliases::key(preset.name) == wanted);
            other.and_then(|(_, name)| exact(name)).or_else(own)
        })
    }

    /// What else it is called.
    pub fn other_names(&self) -> impl Iterator<Item = &'static str> {
        ALIASES.iter().filter(|(_, name)| *name == self.name).map(|(other, _)| *other)
    }

    /// Every name that [`Preset::named`] knows.
    pub fn all_names() -> impl Iterator<Item = &'static str> {
        Self::all().map(|preset| preset.name).chain(ALIASES.iter().map(|(other, _)| *other))
    }

    /// Whether one of its names begins with the words of `text`, or has them all.
    pub fn matches(&self, text: &str) -> bool {
        let wanted = aliases::key(text);
        let has = |name: &str| {
            let key = aliases::key(name);
            let words: Vec<&str> = key.split('-').collect();
            wanted
                .split('-')
                .all(|w| words.iter().any(|word| *word == w || (w.len() > 2 && word.starts_with(w))))
        };
        !wanted.is_empty() && (has(self.name) || self.other_names().any(has))
    }

    /// One channel (0, 1 or 2) in 1/m.
    pub fn coefficients(&self, channel: usize) -> Coefficients {
        Coefficients {
            sigma_a: 1000.0 * self.sigma_a_per_mm[channel],
            sigma_s: 1000.0 * self.sigma_s_per_mm[channel],
            g: self.g[channel],
            eta: self.eta,
        }
    }

    /// The same with one mean cosine for all channels: that of all scattering together, rounded to 0.001. A channel's σs is
    /// changed so that its σs(1 − g) stays (similarity; van de Hulst 1980), which looks the same wherever light is
    /// scattered many times.
    pub fn with_one_anisotropy(&self) -> OneAnisotropy {
        let total: f64 = self.sigma_s_per_mm.iter().sum();
        let mean: f64 = (0..3).map(|i| self.sigma_s_per_mm[i] * self.g[i]).sum();
        let g = if total > 0.0 { (1000.0 * mean / total).round() / 1000.0 } else { 0.0 };
        let digits = |v: f64| format!("{v:.6e}").parse().unwrap_or(v);
        let scattering = |i: usize| {
            let per_mm = self.sigma_s_per_mm[i];
            digits(1000.0 * if self.g[i] == g { per_mm } else { per_mm * (1.0 - self.g[i]) / (1.0 - g) })
        };
        OneAnisotropy {
            sigma_a: self.sigma_a_per_mm.map(|v| digits(1000.0 * v)),
            sigma_s: [0, 1, 2].map(scattering),
            g,
            eta: self.eta,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_numbers_make_sense() {
        let mut names = std::collections::HashSet::new();
        for preset in Preset::all() {
            assert!(names.insert(preset.name), "{}", preset.name);
            assert!(preset.name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-'));
            for i in 0..3 {
                let c = preset.coefficients(i);
                assert!(
                    c.sigma_a >= 0.0 && c.sigma_s >= 0.0 && (0.0..1.0).contains(&c.g) && c.sigma_t() > 0.0
                );
            }
            assert!((1.3..1.7).contains(&preset.eta), "{}", preset.name);
            assert_eq!(preset.note.is_empty(), preset.source != Source::Estimate, "{}", preset.name);
        }
        assert_eq!(names.len(), 12 + 35 + 15 + ESTIMATES.len());
    }

    #[test]
    fn every_other_name_leads_to_one_preset() {
        let mut keys: std::collections::HashMap<String, &str> =
            Preset::all().map(|preset| (aliases::key(preset.name), preset.name)).collect();
        for (other, name) in ALIASES {
            assert_eq!(Preset::named(other).map(|preset| preset.name), Some(name), "{other}");
            assert_eq!(keys.insert(aliases::key(other), name), None, "{other} is there twice");
        }
        for (typed, name) in [
            ("White Jade", "jade-white"),
            ("GREEN_MARBLE", "marble-green"),
            ("skin type 4", "skin-iv"),
            ("fitzpatrick-vi", "skin-vi"),
            ("Fitzpatrick 1", "skin-i"),
            ("skin1", "skin1"),
            ("marble", "marble"),
            ("milk", "whole-milk"),
        ] {
            assert_eq!(Preset::named(typed).map(|preset| preset.name), Some(name), "{typed}");
        }
        assert!(
            Preset::named("").is_none() && Preset::named("-").is_none() && Preset::named("jad").is_none()
        );
        let found =
            |text: &str| Preset::all().filter(|p| p.matches(text)).map(|p| p.name).collect::<Vec<_>>();
        assert_eq!(found("lavender jade"), ["jade-lavender"]);
        assert!(found("jade").len() >= 4 && found("skin").len() >= 14 && found("").is_empty());
        assert_eq!(found("jadei"), ["jade-imperial"]);
    }

    #[test]
    fn one_anisotropy_keeps_reduced_scattering_and_measured_numbers() {
        let milk = Preset::named("lowfat-milk").unwrap().with_one_anisotropy();
        assert_eq!(milk.sigma_a, [2.875, 5.75, 11.5]);
        // (13.1157 · 0.932 + 15.4445 · 0.902 + 17.9572 · 0.859) / 46.5174
        assert_eq!(milk.g, 0.894);
        for (found, expected) in milk.sigma_s.into_iter().zip([891.8676, 1513.561, 2531.9652]) {
            assert!((found * (1.0 - milk.g) / expected - 1.0).abs() < 1e-5, "{found} {expected}");
        }
        let marble = Preset::named("marble").unwrap().with_one_anisotropy();
        assert_eq!((marble.sigma_s, marble.g), ([2190.0, 2620.0, 3000.0], 0.0));
    }
}
