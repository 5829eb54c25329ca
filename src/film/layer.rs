//! Layers of a film: numbers that every sample has beside its light.

use serde::{Deserialize, Serialize};

/// How the samples of a layer become the numbers of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Averaging {
    /// The sum over all samples of a pixel by their number: shares of the light, coverage.
    Samples,
    /// By the sum of the layer's last channel, which is the weight of a sample and is not shown: albedo or normals, which
    /// a sample that meets nothing does not have. Zero where all weights are. The other channels must have been multiplied
    /// by it.
    Weight,
    /// Not shown: sums that [`Film::develop`](super::Film::develop) makes other things of.
    Hidden,
}

/// Numbers that every sample has beside its light.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilmLayer {
    /// Name of the layer, for example `albedo`.
    pub name: String,
    /// Names of its channels, for example `R`.
    pub channels: Vec<String>,
    /// How it is averaged.
    pub averaging: Averaging,
}

impl FilmLayer {
    /// A layer of those channels.
    pub fn new(name: &str, channels: &[&str], averaging: Averaging) -> Self {
        Self { name: name.to_owned(), channels: channels.iter().map(|&c| c.to_owned()).collect(), averaging }
    }
}
