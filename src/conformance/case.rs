//! What a case is, and its description in `expect.toml`.
//!
//! | key | meaning |
//! | --- | --- |
//! | `title`, `tests` | one line, and words for what it depends on |
//! | `width`, `height`, `spp` | size in pixels; samples a pixel at which noise is small enough ([`POWER`](super::POWER)) |
//! | `environment` | uniform radiance, if there is one; the asset says the same by `EXT_lights_image_based` |
//! | `same_as` | the case that must look the same |
//! | `reference` | `reference.exr`: the truth is the converged random walk |
//! | `other_renderers` | what is known of other renderers that differ |
//! | `[sweep]` | name, parameter and its values: one for each channel, or one for the case |
//! | `[[expect]]` | region (x, y, width, height; all if left out), mean, standard_error, source, tolerance (relative), why |
//! | `[[expect.symptom]]` | the mean that a mistake would show, and what it says |

use super::{ConformanceError, Reference};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Pixels a side of the largest picture of a case.
const MAX_SIDE: u32 = 1024;
/// The most samples a pixel.
const MAX_SPP: u32 = 1 << 20;

/// A rectangle of pixels: column and row of its upper left one, columns, rows.
pub type Region = [u32; 4];

/// A case and where it lies.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of its folder and of its asset.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// One line.
    pub title: String,
    /// Words for what it depends on.
    pub tests: Vec<String>,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples a pixel, over all batches.
    pub spp: u32,
    /// Uniform radiance from everywhere, linear Rec. 709.
    pub environment: Option<[f64; 3]>,
    /// The case that must look the same.
    pub same_as: Option<String>,
    /// What is known of other renderers.
    pub other_renderers: Option<String>,
    /// The curve that it is a part of.
    pub sweep: Option<Sweep>,
    /// Whether the truth is a converged picture.
    pub has_reference: bool,
    /// That picture, once it was made.
    pub reference: Option<Reference>,
    /// What must be seen.
    pub expectations: Vec<Expectation>,
}

/// A curve over a parameter, made of several channels or cases.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Cases with the same name share a plot.
    pub name: String,
    /// What is on its horizontal axis.
    pub parameter: String,
    /// Three values, one for each channel, or one for the case.
    pub values: Vec<f64>,
}

/// What must be seen in a region.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// What is there.
    pub name: String,
    /// Where; the whole picture if nothing is said.
    pub region: Option<Region>,
    /// Mean radiance; that of the reference if nothing is said.
    pub mean: Option<[f64; 3]>,
    /// Standard errors of `mean`.
    #[serde(default)]
    pub standard_error: [f64; 3],
    /// Where the mean comes from.
    pub source: String,
    /// How far the measured mean may be off beside noise, relative to `mean`.
    pub tolerance: f64,
    /// Why that far.
    pub why: String,
    /// What mistakes would show.
    #[serde(default, rename = "symptom")]
    pub symptoms: Vec<Symptom>,
}

/// What a mistake would show.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Symptom {
    /// Mean radiance.
    pub mean: [f64; 3],
    /// The mistake.
    pub says: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    title: String,
    tests: Vec<String>,
    width: u32,
    height: u32,
    spp: u32,
    environment: Option<[f64; 3]>,
    same_as: Option<String>,
    reference: Option<String>,
    other_renderers: Option<String>,
    sweep: Option<Sweep>,
    expect: Vec<Expectation>,
}

impl Case {
    /// Reads the case of a folder. Errors name the file and the place in it.
    pub fn load(folder: &Path) -> Result<Self, ConformanceError> {
        let path = folder.join("expect.toml");
        let text = std::fs::read_to_string(&path)
            .map_err(|source| ConformanceError::Io { path: path.clone(), source })?;
        let invalid = |message: String| ConformanceError::Invalid { path: path.clone(), message };
        let name = folder.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let read: Description = toml::from_str(&text).map_err(|e| invalid(e.to_string()))?;
        check(&read).map_err(invalid)?;
        let has_reference = read.reference.is_some();
        let reference = if has_reference { Reference::load(folder)? } else { None };
        Ok(Self {
            name,
            folder: folder.to_owned(),
            title: read.title,
            tests: read.tests,
            width: read.width,
            height: read.height,
            spp: read.spp,
            environment: read.environment,
            same_as: read.same_as,
            other_renderers: read.other_renderers,
            sweep: read.sweep,
            has_reference,
            reference,
            expectations: read.expect,
        })
    }

    /// Its glTF file.
    pub fn asset(&self) -> PathBuf {
        self.folder.join(format!("{}.gltf", self.name))
    }

    /// The region of an expectation.
    pub fn region(&self, expectation: &Expectation) -> Region {
        expectation.region.unwrap_or([0, 0, self.width, self.height])
    }

    /// What is expected: mean and standard error; `None` where the reference has not been made yet.
    pub fn truth(&self, expectation: &Expectation) -> Option<([f64; 3], [f64; 3])> {
        if let Some(mean) = expectation.mean {
            return Some((mean, expectation.standard_error));
        }
        let known = self.reference.as_ref()?.region(&expectation.name)?;
        Some((known.mean, known.standard_error))
    }
}

/// Says what makes no sense in a description whose syntax is right.
fn check(read: &Description) -> Result<(), String> {
    let side = 1..=MAX_SIDE;
    if !side.contains(&read.width) || !side.contains(&read.height) {
        return Err(format!("{} × {} pixels; sides go from 1 to {MAX_SIDE}", read.width, read.height));
    }
    if !(1..=MAX_SPP).contains(&read.spp) {
        return Err(format!("spp = {}; it goes from 1 to {MAX_SPP}", read.spp));
    }
    if read.expect.is_empty() {
        return Err("expects nothing: add an [[expect]]".to_owned());
    }
    if let Some(sweep) = read.sweep.as_ref().filter(|s| !matches!(s.values.len(), 1 | 3)) {
        return Err(format!("sweep {:?} has {} values; 1 or 3 belong there", sweep.name, sweep.values.len()));
    }
    for expect in &read.expect {
        let name = &expect.name;
        if let Some([x, y, w, h]) = expect.region {
            let fits = |from: u32, n: u32, all: u32| n > 0 && from.checked_add(n).is_some_and(|to| to <= all);
            if !fits(x, w, read.width) || !fits(y, h, read.height) {
                return Err(format!("the region of {name:?} is not within the picture"));
            }
        }
        if expect.mean.is_none() && read.reference.is_none() {
            return Err(format!("{name:?} has neither a mean nor a reference"));
        }
        let numbers = expect.mean.iter().flatten().chain(&expect.standard_error);
        if numbers.chain([&expect.tolerance]).any(|v| !v.is_finite() || *v < 0.0) {
            return Err(format!("numbers of {name:?} must be finite and not negative"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
        title = "a slab"
        tests = ["energy"]
        width = 8
        height = 4
        spp = 16
        [[expect]]
        name = "all"
        mean = [1, 0.5, 0.25]
        source = "closed form"
        tolerance = 0.01
        why = "rounding"
        [[expect.symptom]]
        mean = [2.0, 1, 0.5]
        says = "twice"
    "#;

    fn load(text: &str) -> Result<Case, ConformanceError> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("expect.toml"), text).expect("written");
        Case::load(folder.path())
    }

    #[test]
    fn a_description_is_read() {
        let case = load(GOOD).expect("a case");
        let expectation = &case.expectations[0];
        assert_eq!(case.region(expectation), [0, 0, 8, 4]);
        assert_eq!(case.truth(expectation), Some(([1.0, 0.5, 0.25], [0.0; 3])));
        assert_eq!(expectation.symptoms[0].says, "twice");
    }

    #[test]
    fn nonsense_is_an_error_that_says_where() {
        for (from, to, says) in [
            ("width = 8", "width = 0", "sides go from"),
            ("spp = 16", "spp = 0", "spp = 0"),
            ("name = \"all\"", "name = \"all\"\nregion = [7, 0, 2, 4]", "not within"),
            ("name = \"all\"", "name = \"all\"\nregion = [4294967295, 0, 2, 4]", "not within"),
            ("mean = [1, 0.5, 0.25]", "", "neither a mean"),
            ("mean = [1, 0.5, 0.25]", "mean = [1, nan, 0]", "finite"),
            ("mean = [1, 0.5, 0.25]", "maen = [1, 1, 0]", "maen"),
            ("tolerance = 0.01", "tolerance = -1", "not negative"),
            ("[[expect]]", "[sweep]\nname = \"s\"\nparameter = \"p\"\nvalues = [1, 2]\n[[expect]]", "1 or 3"),
        ] {
            let message = load(&GOOD.replacen(from, to, 1)).expect_err(to).to_string();
            assert!(message.contains(says) && message.contains("expect.toml"), "{message}");
        }
        assert!(matches!(Case::load(Path::new("/no/such/folder")), Err(ConformanceError::Io { .. })));
    }
}
