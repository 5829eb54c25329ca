//! Light that goes through: thin walls, slabs and prisms, against closed forms.

use crate::formula::{color_matching, direction, f0, fresnel, rec709, schlick};
use crate::lab::{cuboid, measure, options, ortho, single, sky_above};
use crate::scenes::{material, picture, same, seen_from, square};
use glam::{DVec3, Vec3};
use nephrite::optics::Microfacet;
use nephrite::scene::*;
use serde_json::{Value, json};

fn glass(roughness: f64, color: [f64; 3], extensions: Value) -> Value {
    let [r, g, b] = color;
    let mut all = json!({"KHR_materials_transmission": {"transmissionFactor": 1}});
    for (name, own) in extensions.as_object().expect("an object") {
        all[name] = own.clone();
    }
    json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1], "metallicFactor": 0, "roughnessFactor": roughness,
        },
        "extensions": all,
    })
}

/// A thin wall lets through (1 − F) base, straight on: the background is seen through it, without a volume or with one
/// of no thickness.
#[test]
fn thin_walls_transmit_straight() {
    let color = [0.9, 0.6, 0.3];
    for extensions in [
        json!({}),
        json!({"KHR_materials_volume": {"attenuationDistance": 0.01, "attenuationColor": [0, 0, 0]}}),
    ] {
        let json = glass(0.0, color, extensions);
        for theta in [0.0, 50.0, 75.0] {
            // The sky above y = 0 is what lies behind the square for an eye that looks up.
            let v = direction(theta, 0.0);
            let turn = Vec3::new(v.x as f32, -v.z as f32, 0.0);
            let mut scene = single(square(), material(&json), sky_above(1.0));
            scene.instances[0].transform = glam::Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
            let view = options(ortho(-turn, 10.0, 0.05), 8, 400);
            let found = measure(&Scene::build(scene).expect("builds"), &view);
            let f = schlick(0.04, 1.0, v.z);
            found.assert_matches(color.map(|c| c * (1.0 - f)), [0.0; 3], &format!("thin wall at {theta}°"));
        }
    }
    let white = glass(0.0, [1.0; 3], json!({}));
    let scene = single(square(), material(&white), EnvironmentDescription::Constant(Vec3::ONE));
    let view = seen_from(direction(60.0, 0.0), 2, 64, Microfacet::Multiple);
    same(picture(scene, &view), [1.0; 3], 5e-2, "reflected and transmitted");
}

/// A slab of thickness t at normal incidence, all reflections between its faces added up: with a = c^(t/d) and the base
/// colour b at each crossing, T = (1 − F)² b² a/(1 − F² a²) and R = F + (1 − F)² b² F a²/(1 − F² a²).
#[test]
fn volumes_attenuate_as_beer_says_between_faces_that_reflect_as_fresnel_says() {
    let (t, distance, attenuation, base) = (0.02, 0.03, [0.9, 0.4, 0.05], [1.0, 0.8, 0.9]);
    for ior in [1.0, 1.33, 1.5, 2.4] {
        let json = glass(
            0.0,
            base,
            json!({
                "KHR_materials_ior": {"ior": ior},
                "KHR_materials_volume": {
                    "thicknessFactor": 0.5, "attenuationDistance": distance, "attenuationColor": attenuation,
                },
            }),
        );
        let slab = cuboid(Vec3::new(2.0, t as f32, 2.0));
        let scene = single(slab, material(&json), sky_above(1.0));
        let scene = Scene::build(scene).expect("builds");
        let f = f0(ior);
        let a: [f64; 3] = attenuation.map(|c: f64| c.powf(t / distance));
        let bounced = |c: usize| (1.0 - f).powi(2) * base[c] * base[c] / (1.0 - (f * a[c]).powi(2));
        // From below, what comes through; from above, what comes back.
        let through: [f64; 3] = std::array::from_fn(|c| bounced(c) * a[c]);
        let back: [f64; 3] = std::array::from_fn(|c| f + bounced(c) * f * a[c] * a[c]);
        for (up, expected, what) in [(1.0, through, "transmitted"), (-1.0, back, "reflected")] {
            if expected.iter().all(|e: &f64| *e < 1e-9) {
                continue;
            }
            let view = options(ortho(Vec3::Y * up, 10.0, 0.05), 16, 4096);
            let found = measure(&scene, &view);
            for c in 0..3 {
                // Single precision of sums of 4096 samples.
                let error = 4.0 * found.se[c] + 1e-5;
                let (mean, expected): (f64, f64) = (found.mean[c], expected[c]);
                println!("{what}, ior {ior} [{c}]: {mean:.6} ± {:.6}, expected {expected:.6}", found.se[c]);
                assert!((mean - expected).abs() < error, "{what}, ior {ior} [{c}]: {mean} for {expected}");
                assert!(found.se[c] < 0.01 * expected.max(0.02));
            }
        }
    }
}

/// Refraction by a prism whose rear face is tilted by A = 20°: light that enters at a right angle turns by
/// asin(n sin A) − A, with n(λ) = n_d + (n_d − 1)/V (523655/λ² − 1.5168). The sky behind is a ramp in that angle, so each
/// channel shows where its wavelengths went, ∫ r(λ) T(λ) L(turn(λ)) dλ/∫ r(λ) dλ.
#[test]
fn prisms_turn_wavelengths_as_cauchy_says() {
    let (ior, dispersion, tilt) = (1.5f64, 2.0, 20f64.to_radians());
    let json = glass(
        0.0,
        [1.0; 3],
        json!({
            "KHR_materials_ior": {"ior": ior}, "KHR_materials_dispersion": {"dispersion": dispersion},
            "KHR_materials_volume": {"thicknessFactor": 1},
        }),
    );
    // Light meets z = −1 first; the rear face has the normal (sin A, 0, cos A).
    let mut prism = cuboid(Vec3::splat(2.0));
    for p in &mut prism.positions {
        if p.z > 0.0 {
            p.z = 1.0 - p.x * (tilt.tan() as f32);
        }
    }
    // u = atan2(z, x)/2π + ½ grows with the angle from +z towards −x, to which the light is turned.
    const WIDTH: usize = 7200;
    let (first, last) = (8.0, 16.0);
    let turn_at = |x: usize| ((x as f64 + 0.5) / WIDTH as f64 - 0.5) * 360.0 - 90.0;
    let ramp = |degrees: f64| ((degrees - first) / (last - first)).clamp(0.0, 1.0);
    let row: Vec<Vec3> = (0..WIDTH)
        .map(turn_at)
        .map(|turn| Vec3::splat(if turn < last + 1.0 && turn > 0.0 { ramp(turn) as f32 } else { 0.0 }))
        .collect();
    let pixels = row.repeat(4);
    let sky =
        EnvironmentDescription::Map { width: WIDTH, height: 4, pixels, scale: Vec3::ONE, rotation: 0.0 };
    let scene = Scene::build(single(prism, material(&json), sky)).expect("builds");

    let (mut seen, mut white, mut turns) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for tenth in 3800..7200 {
        let nm = 0.1 * (f64::from(tenth) + 0.5);
        let response = rec709(color_matching(nm)).max(DVec3::ZERO);
        let n = ior + (ior - 1.0) * dispersion / 20.0 * (523_655.0 / (nm * nm) - 1.5168);
        let turn = ((n * tilt.sin()).asin() - tilt).to_degrees();
        let leaving = fresnel((n * tilt.sin()).asin().cos(), n);
        seen += response * (1.0 - f0(n)) * (1.0 - leaving) * ramp(turn);
        turns += response * turn;
        white += response;
    }
    println!("mean turns: {:.3}°", turns / white);
    let view = options(ortho(Vec3::Z, 10.0, 0.2), 16, 4096);
    let found = measure(&scene, &view);
    let expected = (seen / white).to_array();
    found.assert_matches(expected, [0.0; 3], "prism");
    assert!(expected[2] > 1.2 * expected[0], "blue is turned more");
}
