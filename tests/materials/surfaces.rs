//! What a surface reflects from one direction into another, as its specification says, with single scattering at the
//! microfacets (`--microfacet single`), which is the specifications' letter.

use crate::formula::{Geometry, albedo, direction, f0, microfacets, schlick, sheen};
use crate::lab::{Estimate, add_texture, measure, options, ortho, place, single};
use crate::scenes::{in_furnace, material, pbr, picture, reflected, same, seen_from, square};
use glam::{Affine3A, DVec3, Vec3, Vec4};
use nephrite::optics::Microfacet::{Multiple, Single};
use nephrite::scene::*;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_PI, PI};

/// Single precision, through the frame of a surface and powers of cosines.
const ROUNDING: f64 = 1e-4;

fn geometries() -> Vec<(DVec3, DVec3)> {
    [
        ((0.0, 0.0), (0.0, 0.0)),
        ((30.0, 0.0), (30.0, 180.0)),
        ((60.0, 20.0), (50.0, 170.0)),
        ((10.0, 0.0), (75.0, 80.0)),
    ]
    .map(|((a, b), (c, d))| (direction(a, b), direction(c, d)))
    .to_vec()
}

/// A surface that reflects nothing by itself.
fn black(extensions: Value) -> Value {
    let mut all = json!({"KHR_materials_specular": {"specularFactor": 0}});
    for (name, own) in extensions.as_object().expect("an object") {
        all[name] = own.clone();
    }
    pbr([0.0; 3], 0.0, 0.5, all)
}

/// Appendix B with KHR_materials_ior and KHR_materials_specular.
fn dielectric(g: &Geometry, base: [f64; 3], alpha: f64, f0: [f64; 3], f90: f64) -> [f64; 3] {
    let fresnel = f0.map(|f0| schlick(f0, f90, g.v.dot(g.h)));
    let strongest = fresnel.into_iter().fold(0.0, f64::max);
    let s = microfacets(g, [alpha; 2]);
    std::array::from_fn(|c| (fresnel[c] * s + (1.0 - strongest) * base[c] * FRAC_1_PI) * g.l.z)
}

#[test]
fn ior_sets_the_reflectance_at_normal_incidence() {
    let base = [0.8, 0.5, 0.2];
    for ior in [1.0, 1.33, 1.5, 2.42] {
        for (v, l) in geometries() {
            let json = pbr(base, 0.0, 0.6, json!({"KHR_materials_ior": {"ior": ior}}));
            let expected = dielectric(&Geometry::new(v, l), base, 0.36, [f0(ior); 3], 1.0);
            same(reflected(&json, v, l, Single), expected, ROUNDING, &format!("ior {ior}"));
        }
    }
    // 0 stands for infinity: nothing gets below. The index that stands for that is 10⁴, of reflectance 0.9996.
    let json = pbr([1.0; 3], 0.0, 0.6, json!({"KHR_materials_ior": {"ior": 0}}));
    let (v, l) = geometries()[1];
    let g = Geometry::new(v, l);
    same(reflected(&json, v, l, Single), [microfacets(&g, [0.36; 2]) * l.z; 3], 1e-3, "ior 0");
}

#[test]
fn specular_scales_and_tints_the_reflection() {
    let base = [0.8, 0.5, 0.2];
    for (factor, color, ior) in [
        (1.0, [1.0, 0.3, 0.0], 1.5),
        (0.4, [1.0; 3], 1.5),
        (0.7, [0.5, 2.0, 40.0], 1.8),
        (0.0, [1.0; 3], 1.5),
    ] {
        let own = json!({"specularFactor": factor, "specularColorFactor": color});
        let json =
            pbr(base, 0.0, 0.6, json!({"KHR_materials_specular": own, "KHR_materials_ior": {"ior": ior}}));
        let tinted = color.map(|c: f64| (f0(ior) * c).min(1.0) * factor);
        for (v, l) in geometries() {
            let expected = dielectric(&Geometry::new(v, l), base, 0.36, tinted, factor);
            same(reflected(&json, v, l, Single), expected, ROUNDING, &format!("specular {factor} {color:?}"));
        }
    }
}

/// (1 − max specular) diffuse/π + F D G/(4 …), which is what we have where light comes from the viewer: elsewhere the
/// diffuse part is dimmed by direction (`docs/materials.md`).
#[test]
fn specular_glossiness_is_its_formula_towards_the_light() {
    let (diffuse, specular) = ([0.6, 0.4, 0.2], [0.3, 0.2, 0.1]);
    let own =
        json!({"diffuseFactor": [0.6, 0.4, 0.2, 1], "specularFactor": specular, "glossinessFactor": 0.5});
    let json = json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": own}});
    for theta in [0.0, 40.0, 70.0] {
        let v = direction(theta, 30.0);
        let g = Geometry::new(v, v);
        let lobe = microfacets(&g, [0.25; 2]);
        let expected = std::array::from_fn(|c| (specular[c] * lobe + 0.7 * diffuse[c] * FRAC_1_PI) * v.z);
        // The infinite index is 10⁴.
        same(reflected(&json, v, v, Single), expected, 1e-3, &format!("specular-glossiness {theta}°"));
    }
}

/// clearcoat · fresnel · D G/(4 …) on black; the specification takes the Fresnel term at N·V, which is V·H where light
/// is mirrored.
#[test]
fn a_clear_coat_is_its_formula_where_light_is_mirrored() {
    let own = json!({"clearcoatFactor": 0.8, "clearcoatRoughnessFactor": 0.3});
    let json = black(json!({"KHR_materials_clearcoat": own}));
    for theta in [0.0, 30.0, 60.0] {
        let g = Geometry::new(direction(theta, 0.0), direction(theta, 180.0));
        let expected = 0.8 * schlick(0.04, 1.0, g.v.z) * microfacets(&g, [0.09; 2]) * g.l.z;
        // Light that several facets reflect, of which the coat keeps at most 0.04² to 0.2².
        same(reflected(&json, g.v, g.l, Single), [expected; 3], 1e-3, &format!("coat {theta}°"));
    }
}

#[test]
fn sheen_is_charlie_and_its_albedo_the_integral() {
    for roughness in [0.3, 0.6, 1.0] {
        let own = json!({"sheenColorFactor": [1, 0.5, 0.1], "sheenRoughnessFactor": roughness});
        let json = black(json!({"KHR_materials_sheen": own}));
        for (v, l) in geometries() {
            let f = sheen(&Geometry::new(v, l), roughness) * l.z;
            // Near the horizon of the half vector the power 1/α of a sine magnifies rounding.
            let expected = [1.0, 0.5, 0.1].map(|c| c * f);
            same(reflected(&json, v, l, Single), expected, 1e-3, &format!("sheen {roughness}"));
        }
        let v = direction(70.0, 0.0);
        let e = albedo(v, 400, |g| sheen(g, roughness));
        in_furnace(&json, v, 2000, Multiple).assert_matches(
            [1.0, 0.5, 0.1].map(|c| c * e),
            [0.0; 3],
            &format!("albedo of sheen {roughness}"),
        );
    }
}

/// Widths mix(α, 1, strength²) along the direction that the rotation turns from the tangent, and α across.
#[test]
fn anisotropy_stretches_the_lobe_along_its_direction() {
    let color = [0.9, 0.6, 0.3];
    for (strength, rotation) in [(0.6, 0.0), (0.6, 40.0f64), (1.0, 90.0)] {
        let own = json!({"anisotropyStrength": strength, "anisotropyRotation": rotation.to_radians()});
        let json = pbr(color, 1.0, 0.5, json!({"KHR_materials_anisotropy": own}));
        let widths = [0.25 + 0.75 * strength * strength, 0.25];
        let turned = |w: DVec3| glam::DMat3::from_rotation_z(-rotation.to_radians()) * w;
        let value = |g: &Geometry| microfacets(g, widths);
        for (v, l) in geometries() {
            let g = Geometry::new(turned(v), turned(l));
            let expected = color.map(|c| schlick(c, 1.0, g.v.dot(g.h)) * value(&g) * l.z);
            same(reflected(&json, v, l, Single), expected, ROUNDING, &format!("anisotropy {strength}"));
        }
        let v = direction(50.0, 10.0);
        let expected = color.map(|c| albedo(turned(v), 400, |g| schlick(c, 1.0, g.v.dot(g.h)) * value(g)));
        in_furnace(&json, v, 400, Single).assert_matches(
            expected,
            [0.0; 3],
            "integral of the stretched lobe",
        );
    }
}

#[test]
fn diffuse_transmission_and_thin_scattering_are_lambertian_beyond_the_surface() {
    let (v, behind) = (direction(30.0, 0.0), direction(140.0, 60.0));
    let front = direction(40.0, 60.0);
    let own = json!({"diffuseTransmissionFactor": 0.7, "diffuseTransmissionColorFactor": [0.9, 0.5, 0.1]});
    let mut leaf = black(json!({"KHR_materials_diffuse_transmission": own}));
    leaf["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.2, 0.4, 0.6, 1]);
    let expected = [0.9, 0.5, 0.1].map(|c| 0.7 * c * FRAC_1_PI * -behind.z);
    same(reflected(&leaf, v, behind, Single), expected, ROUNDING, "leaf, from behind");
    let expected = [0.2, 0.4, 0.6].map(|c| 0.3 * c * FRAC_1_PI * front.z);
    same(reflected(&leaf, v, front, Single), expected, ROUNDING, "leaf, from the front");

    // (1 + g)/2 of what is scattered goes on.
    let own = json!({"scatterStrengthFactor": 0.5, "multiscatterColorFactor": [0.9, 0.5, 0.1], "scatterAnisotropy": 0.2});
    let mut paper = black(
        json!({"KHR_materials_transmission": {"transmissionFactor": 0.8}, "KHR_materials_scatter": own}),
    );
    paper["pbrMetallicRoughness"]["roughnessFactor"] = json!(0);
    let scattered = |share: f64, z: f64| [0.9, 0.5, 0.1].map(|c| 0.8 * 0.5 * share * c * FRAC_1_PI * z);
    same(reflected(&paper, v, behind, Single), scattered(0.6, -behind.z), ROUNDING, "paper, from behind");
    same(reflected(&paper, v, front, Single), scattered(0.4, front.z), ROUNDING, "paper, from the front");
}

/// The color of an unlit surface is its base colour times the texture times the vertex colour, whatever light there is.
#[test]
fn unlit_is_the_base_color_in_any_light() {
    let json = json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.8, 0.2, 1], "metallicFactor": 0},
        "extensions": {"KHR_materials_unlit": {}},
    });
    for environment in [Vec3::ZERO, Vec3::splat(7.0)] {
        let mut mesh = square();
        mesh.colors = vec![Vec4::new(0.5, 1.0, 0.25, 1.0); 4];
        let mut scene = single(mesh, material(&json), EnvironmentDescription::Constant(environment));
        let texture = add_texture(&mut scene, 1, &[Vec3::new(1.0, 0.5, 0.5)]);
        scene.materials[0].base_color_texture = Some(texture);
        let seen = picture(scene, &seen_from(direction(50.0, 0.0), 2, 1, Multiple));
        same(seen, [0.25, 0.4, 0.025], 1e-6, "unlit");
    }
}

/// Radiance is factor × texture × strength, and it lights a plane as the configuration factor of a rectangle has it.
#[test]
fn emissive_strength_multiplies_radiance_and_lights_a_plane() {
    let lamp = json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 1},
        "emissiveFactor": [1, 0.5, 0.25],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 6}},
    });
    let mut scene = single(square(), material(&lamp), EnvironmentDescription::default());
    let texture = add_texture(&mut scene, 1, &[Vec3::new(0.5, 1.0, 1.0)]);
    scene.materials[0].emission_texture = Some(texture);
    same(picture(scene, &seen_from(direction(60.0, 0.0), 2, 1, Multiple)), [3.0, 3.0, 1.5], 1e-6, "a lamp");

    // A rectangle 2a × 2b that faces a plane at distance c: 4 times the factor of a quarter of it.
    let (a, b, c) = (0.5f64, 0.8f64, 1.2f64);
    let corner = |x: f64, y: f64| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    let factor = 4.0 / (2.0 * PI) * (corner(a / c, b / c) + corner(b / c, a / c));
    let mut wall = material(&black(json!({})));
    wall.base_color = Vec4::new(0.8, 0.8, 0.8, 1.0);
    let mut scene = single(square(), wall, EnvironmentDescription::default());
    scene.materials.push(material(&lamp));
    let mut rectangle = square();
    rectangle.triangle_materials = vec![1; 2];
    scene.meshes.push(rectangle);
    let turned = Affine3A::from_rotation_x(std::f32::consts::PI);
    let size = Affine3A::from_scale(Vec3::new(a as f32, b as f32, 1.0));
    scene.instances.push(place(1, Affine3A::from_translation(Vec3::Z * c as f32) * turned * size));
    let scene = Scene::build(scene).expect("builds");
    let view = options(ortho(-direction(60.0, 0.0).as_vec3(), 10.0, 1e-3), 16, 256);
    let expected = [1.0, 0.5, 0.25].map(|e| 0.8 * 6.0 * e * factor);
    let found: Estimate = measure(&scene, &view);
    found.assert_matches(expected, [0.0; 3], "a lamp above a plane");
}
