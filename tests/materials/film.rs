//! KHR_materials_iridescence: what a smooth surface with a film mirrors, against the specification's formula, and against
//! that of Airy, which adds up all orders of interference, wavelength by wavelength.

use crate::formula::{color_matching, direction, f0, rec709, schlick};
use crate::lab::single;
use crate::scenes::{material, picture, same, seen_from, square};
use glam::{DVec3, Vec3};
use nephrite::optics::Microfacet;
use nephrite::scene::EnvironmentDescription;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// A film of some index and thickness in nanometres on a base of some reflectance at normal incidence.
struct Film {
    ior: f64,
    thickness: f64,
    base_f0: [f64; 3],
}

/// Reflectances of the two interfaces, the difference of optical paths, and whether the second turns the phase.
struct Interfaces {
    r12: f64,
    r23: f64,
    path: f64,
    base_is_rarer: bool,
}

impl Film {
    fn interfaces(&self, cos: f64, base_f0: f64) -> Interfaces {
        let inside = (1.0 - (1.0 - cos * cos) / (self.ior * self.ior)).sqrt();
        // The specification adds 10⁻⁴.
        let root = (base_f0 + 1e-4).min(0.9999).sqrt();
        let base = (1.0 + root) / (1.0 - root);
        Interfaces {
            r12: schlick(f0(self.ior), 1.0, cos),
            r23: schlick(f0(base / self.ior), 1.0, inside),
            path: 2.0 * self.ior * self.thickness * inside,
            base_is_rarer: base < self.ior,
        }
    }

    /// The specification: two orders, and Gaussians for the eye. The phases of red, green and blue go with X, Y and Z.
    fn specification(&self, cos: f64) -> [f64; 3] {
        let channels = self.base_f0.map(|f0| self.interfaces(cos, f0));
        let shift = channels.each_ref().map(|i| PI + if i.base_is_rarer { PI } else { 0.0 });
        let sensitivity = |path: f64, shift: [f64; 3]| {
            let phase = TAU * path * 1e-9;
            let lobe = |value: f64, place: f64, variance: f64, shift: f64| {
                let wave = (place * phase + shift).cos() * (-phase * phase * variance).exp();
                value * (TAU * variance).sqrt() * wave / 1.0685e-7
            };
            let [x, y, z] = shift;
            rec709(DVec3::new(
                lobe(5.4856e-13, 1.6810e6, 4.3278e9, x) + lobe(9.7470e-14, 2.2399e6, 4.5282e9, x),
                lobe(4.4201e-13, 1.7953e6, 9.3046e9, y),
                lobe(5.2481e-13, 2.2084e6, 6.6121e9, z),
            ))
        };
        std::array::from_fn(|c| {
            let Interfaces { r12, r23, path, .. } = channels[c];
            let t121 = 1.0 - r12;
            let r123 = (r12 * r23).clamp(1e-5, 0.9999);
            let rs = t121 * t121 * r23 / (1.0 - r123);
            let mut sum = r12 + rs;
            let mut amplitude = rs - t121;
            for m in [1.0, 2.0] {
                amplitude *= r123.sqrt();
                sum += amplitude * 2.0 * sensitivity(m * path, shift.map(|s| m * s))[c];
            }
            sum.max(0.0)
        })
    }

    /// |r12 + r23 e^iδ|²/|1 + r12 r23 e^iδ|², its mean plus how it varies with the wavelength.
    fn airy(&self, cos: f64) -> [f64; 3] {
        std::array::from_fn(|c| {
            let i = self.interfaces(cos, self.base_f0[c]);
            let mean = i.r12 + (1.0 - i.r12).powi(2) * i.r23 / (1.0 - i.r12 * i.r23);
            let product = (i.r12 * i.r23).sqrt() * if i.base_is_rarer { -1.0 } else { 1.0 };
            let (mut sum, mut white) = (DVec3::ZERO, DVec3::ZERO);
            for nm in 360..=830 {
                let wave = 2.0 * product * (TAU * i.path / f64::from(nm)).cos();
                let reflectance = (i.r12 + i.r23 + wave) / (1.0 + i.r12 * i.r23 + wave);
                let response = color_matching(f64::from(nm));
                sum += (reflectance - mean) * response;
                white += response;
            }
            (mean + rec709(sum / white)[c]).max(0.0)
        })
    }
}

fn mirrored(json: &Value, cos: f64) -> [f64; 3] {
    let scene = single(square(), material(json), EnvironmentDescription::Constant(Vec3::ONE));
    picture(scene, &seen_from(direction(cos.acos().to_degrees(), 0.0), 2, 4, Microfacet::Single))
}

fn iridescent(base: [f64; 3], metallic: f64, film: &Film, more: &[(&str, Value)]) -> Value {
    let [r, g, b] = base;
    let mut json = json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1], "metallicFactor": metallic, "roughnessFactor": 0,
        },
        "extensions": {"KHR_materials_iridescence": {
            "iridescenceFactor": 1, "iridescenceIor": film.ior,
            "iridescenceThicknessMinimum": 0, "iridescenceThicknessMaximum": film.thickness,
        }},
    });
    for (name, own) in more {
        json["extensions"][name] = own.clone();
    }
    json
}

#[test]
fn films_reflect_what_the_specification_and_airy_say() {
    let (mut worst, mut worst_metal) = (0.0f64, 0.0f64);
    for ior in [1.3, 1.8] {
        for thickness in [200.0, 400.0, 600.0] {
            for cos in [1.0, 0.7, 0.4] {
                for (base, metallic) in [([0.0; 3], 0.0), ([0.5; 3], 1.0), ([0.9, 0.6, 0.3], 1.0)] {
                    let base_f0 = if metallic > 0.0 { base } else { [0.04; 3] };
                    let film = Film { ior, thickness, base_f0 };
                    let found = mirrored(&iridescent(base, metallic, &film, &[]), cos);
                    let what = format!("film {ior} {thickness} nm on {base_f0:?}, cos {cos}");
                    // What a metal reflects is limited to 1; 10⁻⁴ is added to the reflectance of its base.
                    let expected = film.specification(cos).map(|r| r.min(1.0));
                    for (a, b) in found.into_iter().zip(expected) {
                        assert!((a - b).abs() < 1e-3, "{what}: {found:?} is not {expected:?}");
                    }
                    let airy = film.airy(cos);
                    let off = found.iter().zip(airy).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    let worst = if metallic > 0.0 { &mut worst_metal } else { &mut worst };
                    *worst = worst.max(off);
                }
            }
        }
    }
    println!("largest difference to Airy: {worst:.4} on a dielectric, {worst_metal:.4} on metals");
    // The third order, r12 r23 to the power of 3/2 times 2 (1 − r12), is below 0.001 on a dielectric and up to 0.06 on
    // metals; Gaussians stand for the colour matching functions in both.
    assert!(worst < 0.01 && worst_metal < 0.06);
}

/// With KHR_materials_specular the base below the film reflects specular · f0 · color.
#[test]
fn films_lie_on_the_weakened_reflection() {
    let specular = json!({"specularFactor": 0.5, "specularColorFactor": [1, 4, 0.2]});
    let film = Film { ior: 1.4, thickness: 350.0, base_f0: [0.02, 0.08, 0.004] };
    let json = iridescent([0.0; 3], 0.0, &film, &[("KHR_materials_specular", specular)]);
    for cos in [1.0, 0.6] {
        let (found, expected) = (mirrored(&json, cos), film.specification(cos));
        for (a, b) in found.into_iter().zip(expected) {
            assert!((a - b).abs() < 1e-3, "cos {cos}: {found:?} is not {expected:?}");
        }
    }
    // Blended with what there is without a film.
    let half = {
        let mut json = json.clone();
        json["extensions"]["KHR_materials_iridescence"]["iridescenceFactor"] = json!(0.25);
        json
    };
    let plain = film.base_f0.map(|f0| schlick(f0, 0.5, 0.6));
    let expected = std::array::from_fn(|c| 0.75 * plain[c] + 0.25 * film.specification(0.6)[c]);
    same(mirrored(&half, 0.6), expected, 5e-3, "a quarter of a film");
}
