//! Converged pictures of the random walk, for cases that have no closed form: `reference.exr`, half floats with where
//! it comes from in its header, and `reference.toml`, the same with the mean of each region in full precision and its
//! error.

use super::{ConformanceError, MAX_PIXELS};
use crate::film::{Picture, WriteOptions, atomic, read_exr, write};
use serde::{Deserialize, Serialize};
use std::path::Path;

const PICTURE: &str = "reference.exr";
const NUMBERS: &str = "reference.toml";

/// A converged picture and where it comes from.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The picture, rounded to half floats.
    pub picture: Picture,
    /// Version of nephrite.
    pub version: String,
    /// Samples a pixel, over all batches.
    pub spp: u32,
    /// Seed of the first batch; others follow.
    pub seed: u32,
    /// Independent renders.
    pub batches: u32,
    /// Means of the case's regions.
    pub regions: Vec<RegionMean>,
}

/// The mean of a region.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RegionMean {
    /// Name of the expectation.
    pub name: String,
    /// Mean radiance.
    pub mean: [f64; 3],
    /// Its standard error.
    pub standard_error: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Numbers {
    version: String,
    spp: u32,
    seed: u32,
    batches: u32,
    region: Vec<RegionMean>,
}

impl Reference {
    /// The mean of an expectation's region.
    pub fn region(&self, name: &str) -> Option<&RegionMean> {
        self.regions.iter().find(|region| region.name == name)
    }

    /// Reads the reference of a case; `None` if there is none.
    pub(super) fn load(folder: &Path) -> Result<Option<Self>, ConformanceError> {
        let path = folder.join(NUMBERS);
        if !path.is_file() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(&path)
            .map_err(|source| ConformanceError::Io { path: path.clone(), source })?;
        let read: Numbers = toml::from_str(&text)
            .map_err(|e| ConformanceError::Invalid { path: path.clone(), message: e.to_string() })?;
        let picture = folder.join(PICTURE);
        let picture = read_exr(&picture, MAX_PIXELS).map_err(|e| {
            let message = e.to_string();
            ConformanceError::Invalid { path: picture.clone(), message }
        })?;
        let Numbers { version, spp, seed, batches, region } = read;
        Ok(Some(Self { picture, version, spp, seed, batches, regions: region }))
    }

    /// Writes both files into the folder of a case.
    pub(super) fn save(&self, folder: &Path, case: &str) -> Result<(), ConformanceError> {
        let picture = folder.join(PICTURE);
        let mut attributes = vec![
            ("nephrite:scene".to_owned(), case.to_owned()),
            ("nephrite:model".to_owned(), "random-walk".to_owned()),
            ("nephrite:version".to_owned(), self.version.clone()),
            ("nephrite:spp".to_owned(), self.spp.to_string()),
            ("nephrite:seed".to_owned(), self.seed.to_string()),
            ("nephrite:batches".to_owned(), self.batches.to_string()),
        ];
        for region in &self.regions {
            let error = region.standard_error.map(|e| format!("{e:.3e}")).join(" ");
            attributes.push((format!("nephrite:standard_error {}", region.name), error));
        }
        let options = WriteOptions { attributes, ..WriteOptions::default() };
        write(&picture, &self.picture, &options)
            .map_err(|e| ConformanceError::Invalid { path: picture.clone(), message: e.to_string() })?;
        let path = folder.join(NUMBERS);
        atomic::write_atomically(&path, |out| out.write_all(self.numbers().as_bytes()))
            .map_err(|source| ConformanceError::Io { path: path.clone(), source })
    }

    /// The text of `reference.toml`.
    fn numbers(&self) -> String {
        let mut text = format!(
            "# Made by `nephrite conformance --update-references`.\nversion = {:?}\nspp = {}\nseed = {}\nbatches = {}\n",
            self.version, self.spp, self.seed, self.batches
        );
        for region in &self.regions {
            let list = |values: [f64; 3]| values.map(|v| format!("{v:.6e}")).join(", ");
            text += &format!(
                "\n[[region]]\nname = {:?}\nmean = [{}]\nstandard_error = [{}]\n",
                region.name,
                list(region.mean),
                list(region.standard_error)
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn what_is_saved_is_loaded() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        assert!(Reference::load(folder.path()).expect("nothing wrong").is_none());
        let picture =
            Picture { width: 2, height: 1, pixels: vec![Vec3::ONE, Vec3::splat(0.1)], ..Picture::default() };
        let region =
            RegionMean { name: "all \"there\"".into(), mean: [0.55, 0.5, 1e-7], standard_error: [1e-3; 3] };
        let reference = Reference {
            picture,
            version: "1.2.3".into(),
            spp: 64,
            seed: 5,
            batches: 8,
            regions: vec![region],
        };
        reference.save(folder.path(), "a case").expect("saved");
        let found = Reference::load(folder.path()).expect("read").expect("there");
        assert_eq!((found.spp, found.seed, found.batches, found.version.as_str()), (64, 5, 8, "1.2.3"));
        let region = found.region("all \"there\"").expect("the region");
        assert_eq!((region.mean, region.standard_error), ([0.55, 0.5, 1e-7], [1e-3; 3]));
        assert_eq!(found.picture.pixels[0], Vec3::ONE);
    }
}
