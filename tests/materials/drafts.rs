//! The drafts that bring OpenPBR to glTF: diffuse facets, coats, fuzz, against their formulas.

use crate::formula::{Geometry, albedo, direction, eon, f0, fresnel, fuzz, microfacets, schlick};
use crate::lab::{measure, options, ortho, single};
use crate::scenes::{in_furnace, material, reflected, same, square};
use glam::{DMat3, DVec3, Vec3};
use nephrite::optics::Microfacet::{Multiple, Single};
use nephrite::scene::{EnvironmentDescription, Scene};
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_PI;

const COLOR: [f64; 3] = [0.9, 0.5, 0.2];

fn pbr(color: [f64; 3], metallic: f64, roughness: f64, extensions: Value) -> Value {
    let [r, g, b] = color;
    json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1], "metallicFactor": metallic, "roughnessFactor": roughness,
        },
        "extensions": extensions,
    })
}

/// A diffuse surface without a reflection of its own.
fn matte(color: [f64; 3], mut extensions: Value) -> Value {
    extensions["KHR_materials_specular"] = json!({"specularFactor": 0});
    pbr(color, 0.0, 0.5, extensions)
}

fn geometries() -> Vec<(DVec3, DVec3)> {
    [
        ((0.0, 0.0), (0.0, 0.0)),
        ((60.0, 0.0), (60.0, 10.0)),
        ((60.0, 20.0), (50.0, 170.0)),
        ((10.0, 0.0), (75.0, 80.0)),
    ]
    .map(|((a, b), (c, d))| (direction(a, b), direction(c, d)))
    .to_vec()
}

#[test]
fn diffuse_roughness_is_the_energy_preserving_oren_nayar_model() {
    for r in [0.2, 0.7, 1.0] {
        let own = json!({"diffuseRoughnessFactor": r});
        let json = matte(COLOR, json!({"KHR_materials_diffuse_roughness": own}));
        for (v, l) in geometries() {
            let g = Geometry::new(v, l);
            let expected = COLOR.map(|rho| eon(&g, rho, r).0 * l.z);
            // The average albedo is by a quadrature of eight nodes.
            for microfacet in [Single, Multiple] {
                same(reflected(&json, v, l, microfacet), expected, 5e-4, &format!("EON {r}"));
            }
        }
        let v = direction(70.0, 30.0);
        let expected = COLOR.map(|rho| eon(&Geometry::new(v, DVec3::Z), rho, r).1);
        in_furnace(&json, v, 200, Multiple).assert_matches(
            expected,
            [2e-4; 3],
            &format!("albedo of EON {r}"),
        );
    }
}

/// What is transmitted diffusely has the same facets, with the light mirrored at the surface.
#[test]
fn diffuse_transmission_is_rough_too() {
    let leaf = json!({"diffuseTransmissionFactor": 0.7, "diffuseTransmissionColorFactor": COLOR});
    let json = matte(
        [0.2, 0.4, 0.6],
        json!({"KHR_materials_diffuse_transmission": leaf, "KHR_materials_diffuse_roughness": {"diffuseRoughnessFactor": 0.8}}),
    );
    let (v, l) = (direction(50.0, 20.0), direction(60.0, 60.0));
    let g = Geometry::new(v, l);
    let behind = DVec3::new(l.x, l.y, -l.z);
    same(
        reflected(&json, v, behind, Single),
        COLOR.map(|rho| 0.7 * eon(&g, rho, 0.8).0 * l.z),
        5e-4,
        "from behind",
    );
    let expected = [0.2, 0.4, 0.6].map(|rho| 0.3 * eon(&g, rho, 0.8).0 * l.z);
    same(reflected(&json, v, l, Single), expected, 5e-4, "from the front");
}

/// weight · F D G/(4 …) on black where light is mirrored, of the coat's own index, widths and direction.
#[test]
fn a_coat_reflects_by_its_index_and_along_its_brushing() {
    for (ior, strength, rotation) in [(1.2, 0.0, 0.0f64), (1.8, 0.0, 0.0), (1.5, 0.7, 0.0), (1.5, 0.7, 35.0)]
    {
        let own = json!({
            "coatFactor": 0.8, "coatRoughnessFactor": 0.3, "coatIor": ior,
            "coatAnisotropyStrength": strength, "coatAnisotropyRotation": rotation.to_radians(),
        });
        let json = matte([0.0; 3], json!({"KHR_materials_coat": own}));
        let widths = [0.09 + 0.91 * strength * strength, 0.09];
        let turned = |w: DVec3| DMat3::from_rotation_z(-rotation.to_radians()) * w;
        for theta in [0.0, 30.0, 60.0] {
            let (v, l) = (direction(theta, 10.0), direction(theta, 190.0));
            let g = Geometry::new(turned(v), turned(l));
            let expected = 0.8 * schlick(f0(ior), 1.0, g.v.z) * microfacets(&g, widths) * l.z;
            // Light that several facets of the coat reflect.
            let error = if strength > 0.0 { 0.03 } else { 3e-3 };
            same(
                reflected(&json, v, l, Single),
                [expected; 3],
                error,
                &format!("coat {ior} {strength} {theta}"),
            );
        }
    }
}

/// A mirror of colour m below a smooth coat, in an environment of 1: F + (1 − F) m c^(1/cos θ_t) Δ, where
/// Δ = 1 + d ((1 − F)/(1 − m F) − 1), F Schlick's in the layers and exact in Δ. Half a coat is half of that and half bare.
#[test]
fn a_coat_colours_and_darkens_a_mirror_below_it() {
    let metal = [0.95, 0.6, 0.3];
    for (ior, darkening, weight) in [(1.5, 0.0, 1.0), (1.5, 1.0, 1.0), (1.3, 0.5, 1.0), (1.8, 1.0, 0.5)] {
        let own = json!({
            "coatFactor": weight, "coatIor": ior, "coatColorFactor": COLOR, "coatDarkeningFactor": darkening,
        });
        let json = pbr(metal, 1.0, 0.0, json!({"KHR_materials_coat": own}));
        for theta in [0.0, 40.0, 75.0] {
            let v = direction(theta, 0.0);
            let reflected = schlick(f0(ior), 1.0, v.z);
            let path = 1.0 / (1.0 - (1.0 - v.z * v.z) / (ior * ior)).sqrt();
            let inside = fresnel(v.z, ior);
            let expected = std::array::from_fn(|c| {
                let m = schlick(metal[c], 1.0, v.z);
                let left = 1.0 + darkening * ((1.0 - inside) / (1.0 - metal[c] * inside) - 1.0);
                let tint = 1.0 - weight + weight * COLOR[c].powf(path) * left;
                weight * reflected + (1.0 - weight * reflected) * m * tint
            });
            let what = format!("coat {ior} {darkening} {weight} at {theta}°");
            in_furnace(&json, v, 400, Multiple).assert_matches(expected, [5e-4; 3], &what);
        }
    }
}

/// At normal incidence white below a coat without reflections of note has the colour of the coat.
#[test]
fn a_coat_of_index_one_is_a_filter() {
    let own = json!({"coatFactor": 1, "coatIor": 1, "coatColorFactor": COLOR});
    let json = matte([1.0; 3], json!({"KHR_materials_coat": own}));
    let found = reflected(&json, DVec3::Z, DVec3::Z, Single);
    for (found, color) in found.into_iter().zip(COLOR) {
        // Schlick's approximation reflects near the horizon for every index; some of that light comes back.
        assert!((found / (color * FRAC_1_PI) - 1.0).abs() < 0.06, "{found} for {color}/π");
    }
}

#[test]
fn fuzz_is_its_formula_and_takes_its_albedo_from_what_is_below() {
    for y in [0.4, 0.7, 1.0] {
        let own = json!({"fuzzFactor": 0.8, "fuzzColorFactor": COLOR, "fuzzRoughnessFactor": y});
        let json = matte([0.0; 3], json!({"KHR_materials_fuzz": own}));
        for (v, l) in geometries() {
            let f = fuzz(&Geometry::new(v, l), y) * l.z;
            same(reflected(&json, v, l, Single), COLOR.map(|c| 0.8 * c * f), 2e-3, &format!("fuzz {y}"));
        }
        // Black fuzz on a mirror: what is left of the mirror's light.
        let own = json!({"fuzzFactor": 0.8, "fuzzColorFactor": [0, 0, 0], "fuzzRoughnessFactor": y});
        let mirror = pbr([1.0; 3], 1.0, 0.0, json!({"KHR_materials_fuzz": own}));
        for theta in [20.0, 60.0, 80.0] {
            let v = direction(theta, 0.0);
            let expected = 1.0 - 0.8 * albedo(v, 500, |g| fuzz(g, y));
            // Tables over roughness and cosine.
            in_furnace(&mirror, v, 64, Multiple).assert_matches(
                [expected; 3],
                [4e-3; 3],
                &format!("soot {y} {theta}°"),
            );
        }
    }
}

/// An emitter below both: (1 − w + w (1 − F) c^(1/(2 cos θ_t))) (1 − 0.6 E).
#[test]
fn coat_and_fuzz_lie_on_top_of_emission() {
    let y = 0.6;
    for (theta, weight) in [(0.0, 1.0), (60.0, 1.0), (60.0, 0.5)] {
        let mut json = pbr(
            [0.0; 3],
            1.0,
            1.0,
            json!({
                "KHR_materials_coat": {"coatFactor": weight, "coatIor": 1.6, "coatColorFactor": COLOR},
                "KHR_materials_fuzz": {"fuzzFactor": 0.6, "fuzzColorFactor": [0, 0, 0], "fuzzRoughnessFactor": y},
            }),
        );
        json["emissiveFactor"] = json!([1, 1, 1]);
        let scene = single(square(), material(&json), EnvironmentDescription::Constant(Vec3::ZERO));
        let v = direction(theta, 0.0);
        let seen =
            measure(&Scene::build(scene).expect("builds"), &options(ortho(-v.as_vec3(), 3.0, 0.02), 8, 4));
        let below = 1.0 - 0.6 * albedo(v, 400, |g| fuzz(g, y));
        let path = 0.5 / (1.0 - (1.0 - v.z * v.z) / (1.6 * 1.6)).sqrt();
        let crossed = (1.0 - schlick(f0(1.6), 1.0, v.z)) * below;
        for (mean, color) in seen.mean.into_iter().zip(COLOR) {
            let expected = (1.0 - weight) * below + weight * crossed * color.powf(path);
            assert!((mean - expected).abs() < 3e-3, "{theta}° {weight}: {:?} {expected}", seen.mean);
        }
    }
}
