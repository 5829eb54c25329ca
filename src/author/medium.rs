//! The medium of a material as a file describes it, whichever way it does.
//!
//! The order is that of the specification of `NEPHRITE_materials_subsurface` ("Interaction with other properties and
//! extensions"), with OpenPBR parameters in `extras` (which no glTF reader takes for a medium) after the first.

use serde_json::Value;

use super::{khronos, nephrite, openpbr};

/// Index of refraction where nothing states one.
pub const DEFAULT_IOR: f64 = 1.5;

/// What conversions keep coefficients to, relatively.
pub const KEPT: f64 = 1e-4;

/// A homogeneous medium and the index of its boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Absorption coefficient σa, 1/m, ≥ 0, density multiplied in.
    pub sigma_a: [f64; 3],
    /// Scattering coefficient σs, 1/m, ≥ 0, density multiplied in.
    pub sigma_s: [f64; 3],
    /// Mean cosine of Henyey–Greenstein, in (−1, 1).
    pub g: f64,
    /// Index of refraction, ≥ 1.
    pub ior: f64,
}

/// A way to describe a medium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `NEPHRITE_materials_subsurface`: coefficients.
    Nephrite,
    /// `KHR_materials_volume` with `KHR_materials_scatter`: extinction by colour and distance, multi-scatter albedo.
    KhrScatter,
    /// The parameters of OpenPBR, as an object `openpbr` in the `extras` of the material.
    OpenPbr,
}

/// What a material says of its medium.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The medium.
    pub medium: Medium,
    /// Which description it was taken from.
    pub form: Form,
    /// Properties of that description that a [`Medium`] does not hold, each with why.
    pub beyond: Vec<String>,
}

impl Medium {
    /// Extinction coefficient σt, 1/m.
    pub fn sigma_t(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| self.sigma_a[i] + self.sigma_s[i])
    }

    /// Whether anything scatters.
    pub fn scatters(&self) -> bool {
        self.sigma_s.iter().any(|&s| s > 0.0)
    }

    /// Where `other`, which should be the same medium, is not: more than `relative` of a coefficient (and 1e-9 of the
    /// extinction) away.
    pub fn differences(&self, other: &Self, relative: f64) -> Vec<String> {
        const OF_EXTINCTION: f64 = 1e-9;
        let mut found = Vec::new();
        for (name, from, to) in
            [("absorption", self.sigma_a, other.sigma_a), ("scattering", self.sigma_s, other.sigma_s)]
        {
            for (i, channel) in ["red", "green", "blue"].into_iter().enumerate() {
                let tolerance = relative * from[i] + OF_EXTINCTION * self.sigma_t()[i];
                if (from[i] - to[i]).abs() > tolerance {
                    found
                        .push(format!("the {channel} {name} of {:.6} 1/m becomes {:.6} 1/m", from[i], to[i]));
                }
            }
        }
        for (name, from, to) in [("anisotropy", self.g, other.g), ("index", self.ior, other.ior)] {
            if (from - to).abs() > relative * from.abs() {
                found.push(format!("the {name} of {from} becomes {to}"));
            }
        }
        found
    }
}

/// The medium of a material, from the description that wins; `None` if it has none, or one that lets no light in.
pub fn read(material: &Value) -> Option<Reading> {
    nephrite::read(material).or_else(|| openpbr::read(material)).or_else(|| khronos::read(material))
}

/// The index that a material has without an extension of ours: that of `KHR_materials_ior`, else 1.5.
pub fn surface_ior(material: &Value) -> f64 {
    let own = material.pointer("/extensions/KHR_materials_ior/ior").and_then(Value::as_f64);
    own.filter(|ior| *ior >= 1.0).unwrap_or(DEFAULT_IOR)
}

/// Property `key` of an object as a number.
pub(super) fn number(object: &Value, key: &str) -> Option<f64> {
    object.get(key).and_then(Value::as_f64)
}

/// Property `key` of an object as three numbers.
pub(super) fn triple(object: &Value, key: &str) -> Option<[f64; 3]> {
    match object.get(key)?.as_array()?.as_slice() {
        [r, g, b] => Some([r.as_f64()?, g.as_f64()?, b.as_f64()?]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::author::text::Tree;
    use serde_json::json;

    /// Every way there and back over a grid, through the written text.
    #[test]
    fn coefficients_survive_every_conversion_or_the_loss_is_told() {
        let mut told = 0;
        for extinction in [[1e-2, 3.0, 40.0], [2192.1, 2624.1, 3007.1], [1e6, 1e6, 2e6]] {
            for albedo in [0.0, 1e-3, 0.3, 0.9, 0.999, 0.999_999, 1.0] {
                for g in [-0.7, 0.0, 0.4, 0.95] {
                    for ior in [1.0, 1.33, 1.5, 2.4] {
                        let sigma_s = extinction.map(|t| t * albedo);
                        let sigma_a = extinction.map(|t| t * (1.0 - albedo));
                        let g = if albedo == 0.0 { 0.0 } else { g };
                        let medium = Medium { sigma_a, sigma_s, g, ior };
                        for form in [Form::Nephrite, Form::KhrScatter, Form::OpenPbr] {
                            let mut tree = Tree::parse("{}").unwrap();
                            match form {
                                Form::Nephrite => nephrite::write(tree.root_mut(), &medium),
                                Form::KhrScatter => khronos::write(tree.root_mut(), &medium, 0.1, false),
                                Form::OpenPbr => openpbr::write(tree.root_mut(), &medium),
                            }
                            let material: Value = serde_json::from_str(&tree.to_string()).unwrap();
                            let back = read(&material).unwrap();
                            assert_eq!(back.form, form);
                            let lost = medium.differences(&back.medium, KEPT);
                            // The printed constants of the drafts give a ρ of 0 an albedo of 6e-6.
                            assert!(lost.is_empty(), "{medium:?} {form:?}: {lost:?} in {tree}");
                            told += 1;
                        }
                    }
                }
            }
        }
        assert_eq!(told, 3 * 7 * 4 * 4 * 3);
        let one_clear = Medium { sigma_a: [1.0, 1.0, 1.0], sigma_s: [0.0, 5.0, 5.0], g: 0.0, ior: 1.5 };
        let mut tree = Tree::parse("{}").unwrap();
        khronos::write(tree.root_mut(), &one_clear, 0.1, false);
        let back = read(&tree.root().value().unwrap()).unwrap().medium;
        assert!(one_clear.differences(&back, KEPT)[0].contains("red scattering"), "{back:?}");
    }

    #[test]
    fn the_strongest_description_wins() {
        let khr = json!({ "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 1, "attenuationColor": [0.5, 0.5, 0.5] },
            "KHR_materials_volume_scatter": { "multiscatterColor": [0.5, 0.5, 0.5], "scatterAnisotropy": 0.5 } } });
        let first = read(&khr).unwrap();
        assert_eq!(first.form, Form::KhrScatter);
        // Without g: ρ = 0.5 is σs/σt = 0.9117088547 whatever the anisotropy (table of closed forms).
        assert!((first.medium.sigma_s[0] / 2f64.ln() - 0.911_708_854_7).abs() < 1e-9, "{first:?}");
        let mut both = khr.clone();
        both["extensions"]["KHR_materials_scatter"] = json!({ "scatterStrengthFactor": 1, "multiscatterColorFactor": [0.5, 0.5, 0.5], "scatterAnisotropy": 0.8 });
        // With g = 0.8 it is 0.9809997.
        let newer = read(&both).unwrap().medium;
        assert!((newer.sigma_s[1] / 2f64.ln() - 0.980_999_702_5).abs() < 1e-6, "{newer:?}");
        both["extensions"]["NEPHRITE_materials_subsurface"] =
            json!({ "absorptionCoefficient": [1, 2, 3], "densityFactor": 2 });
        let ours = read(&both).unwrap();
        assert_eq!((ours.form, ours.medium.sigma_a), (Form::Nephrite, [2.0, 4.0, 6.0]));
        let mut thin = khr;
        thin["extensions"]["KHR_materials_volume"]["thicknessFactor"] = json!(0);
        assert!(read(&thin).is_none() && read(&json!({})).is_none());
    }
}
