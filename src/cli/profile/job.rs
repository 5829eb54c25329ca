//! What is to be measured, and where it goes.

use crate::cli::Failure;
use crate::cli::args::ProfileArgs;
use crate::cli::job::{check_distinct, check_output};
use crate::cli::names;
use crate::cli::pipeline::Registry;
use crate::cli::values::{ChannelArg, LengthUnit, MediumArg};
use crate::optics::diffusion::Coefficients;
use std::path::{Path, PathBuf};

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Png,
    Csv,
    Json,
}

/// One channel of the medium.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    /// Its colour; none if the medium was given by numbers.
    pub color: Option<&'static str>,
    /// Name of the medium, and the colour.
    pub title: String,
    pub coefficients: Coefficients,
}

/// A measurement that makes sense.
pub(super) struct ProfileJob {
    pub args: ProfileArgs,
    pub outputs: Vec<(PathBuf, Kind)>,
    pub channels: Vec<Channel>,
    /// Names of the models, each once.
    pub models: Vec<String>,
}

impl ProfileJob {
    /// Checks what was typed as a whole, and whether the files could be written.
    pub fn new(args: ProfileArgs, models: &Registry) -> Result<Self, Failure> {
        let mut outputs: Vec<(PathBuf, Kind)> = Vec::new();
        for path in &args.output {
            outputs.push((path.clone(), kind(path)?));
        }
        check_distinct(&outputs.iter().map(|(path, _)| path.as_path()).collect::<Vec<_>>())?;
        let channels = channels(&args)?;
        let asked = args.models.iter().map(String::as_str);
        let all = models.iter().map(|model| model.name());
        let mut chosen: Vec<String> = Vec::new();
        for name in asked.chain(all.filter(|_| args.models.is_empty())) {
            if !chosen.iter().any(|other| other == name) {
                chosen.push(name.to_owned());
            }
        }
        outputs.iter().try_for_each(|(path, _)| check_output(path))?;
        Ok(Self { args, outputs, channels, models: chosen })
    }
}

fn kind(path: &Path) -> Result<Kind, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("png") => Ok(Kind::Png),
        Some("csv") => Ok(Kind::Csv),
        Some("json") => Ok(Kind::Json),
        other => {
            let unknown = names::unknown("kind of file", other.unwrap_or(""), ["png", "csv", "json"]);
            Err(Failure::Usage(format!("{}: {unknown}", path.display())))
        }
    }
}

fn channels(args: &ProfileArgs) -> Result<Vec<Channel>, Failure> {
    const COLORS: [&str; 3] = ["red", "green", "blue"];
    match (&args.medium, args.channel) {
        (MediumArg::Numbers(_), Some(_)) => {
            Err(Failure::Usage("a medium given by numbers has one channel: leave --channel out".to_owned()))
        }
        (MediumArg::Numbers(c), None) => {
            let per_m = match args.unit {
                LengthUnit::Metre => 1.0,
                LengthUnit::Centimetre => 100.0,
                LengthUnit::Millimetre => 1000.0,
            };
            let (sigma_a, sigma_s) = (per_m * c.sigma_a, per_m * c.sigma_s);
            let coefficients = Coefficients { sigma_a, sigma_s, ..*c };
            Ok(vec![Channel { color: None, title: "medium".to_owned(), coefficients }])
        }
        (MediumArg::Preset(_), _) if args.unit != LengthUnit::Metre => {
            Err(Failure::Usage("--unit is for a medium given by numbers".to_owned()))
        }
        (MediumArg::Preset(preset), channel) => {
            let chosen = match channel.unwrap_or(ChannelArg::Green) {
                ChannelArg::Red => 0..1,
                ChannelArg::Green => 1..2,
                ChannelArg::Blue => 2..3,
                ChannelArg::All => 0..3,
            };
            let of = |i: usize| Channel {
                color: Some(COLORS[i]),
                title: format!("{}, {}", preset.name, COLORS[i]),
                coefficients: preset.coefficients(i),
            };
            Ok(chosen.map(of).collect())
        }
    }
}
