//! Light profiles of EXT_lights_ies from glTF files: the irradiance of what the table says.

use crate::gltf::{DOWN, floor, light};
use crate::lab::*;
use base64::Engine;
use glam::{Quat, Vec3};
use nephrite::scene::*;
use serde_json::{Value, json};

const NAME: &str = "EXT_lights_ies";

/// Candela at 0°, 30°, 60°, 90° from straight ahead, in the planes of 0°, 90°, 180°, 270°.
const CANDELA: [[f64; 4]; 4] =
    [[100.0, 80.0, 30.0, 0.0], [100.0, 60.0, 10.0, 0.0], [100.0, 90.0, 50.0, 5.0], [100.0, 40.0, 20.0, 0.0]];

fn profile() -> Value {
    let planes: Vec<String> = CANDELA.iter().chain(&CANDELA[..1]).map(|row| format!("{row:?}")).collect();
    let candela = planes.join(" ").replace(['[', ']', ','], " ");
    let text = format!(
        "IESNA:LM-63-1995\nTILT=NONE\n1 1 2 4 5 1 2 0 0 0 1 0.5 0\n0 30 60 90\n0 90 180 270 360\n{candela}"
    );
    let data = base64::engine::general_purpose::STANDARD.encode(text);
    json!({NAME: {"lights": [{"uri": format!("data:application/x-ies-lm-63;base64,{data}")}]}})
}

/// Bilinear between the directions of the table; multiplier and photometric factor cancel.
fn candela(direction: Vec3) -> f64 {
    let d = direction.as_dvec3();
    let v = d.x.hypot(d.y).atan2(-d.z).to_degrees();
    let h = d.y.atan2(d.x).to_degrees().rem_euclid(360.0);
    if v > 90.0 {
        return 0.0;
    }
    let (i, s) = ((v / 30.0).floor().min(2.0), (v / 30.0 - (v / 30.0).floor().min(2.0)));
    let (j, t) = ((h / 90.0).floor().min(3.0), (h / 90.0 - (h / 90.0).floor().min(3.0)));
    let at = |j: usize| {
        let row = CANDELA[j % 4];
        row[i as usize] * (1.0 - s) + row[i as usize + 1] * s
    };
    at(j as usize) * (1.0 - t) + at(j as usize + 1) * t
}

/// Radiance of the floor at the origin.
fn seen(scene: SceneDescription, spp: u32) -> Estimate {
    let scene = Scene::build(scene).expect("builds");
    measure(&scene, &options(ortho(Vec3::new(0.2, -1.0, 0.1), 0.3, 1e-4), 8, spp))
}

/// What lights at places turned as given send to the floor at the origin.
fn irradiance(places: &[(Vec3, Quat)]) -> f64 {
    let one = |(p, turn): &(Vec3, Quat)| {
        let direction = -p.normalize();
        candela(turn.inverse() * direction) * f64::from(p.normalize().y) / f64::from(p.length_squared())
    };
    places.iter().map(one).sum()
}

fn nodes(places: &[(Vec3, Quat)]) -> Vec<Value> {
    places.iter().map(|(p, turn)| light(NAME, p.to_array(), turn.to_array())).collect()
}

#[test]
fn a_floor_is_lit_by_the_candela_of_the_table() {
    let down = Quat::from_array(DOWN);
    for (i, place) in
        [Vec3::Y, Vec3::new(0.4, 1.0, 0.3), Vec3::new(-1.0, 1.0, 0.5), Vec3::new(0.2, 0.7, -2.0)]
            .into_iter()
            .enumerate()
    {
        // Turned about the vertical, tilted, and as it is.
        for turn in [down, Quat::from_rotation_y(0.8) * down, Quat::from_rotation_z(0.3) * down] {
            let places = [(place, turn)];
            let found = seen(floor(0.5, 0.0, profile(), &nodes(&places)), 1);
            let expected = 0.5 / std::f64::consts::PI * irradiance(&places);
            assert!(expected > 0.01, "{expected}");
            // Angles of single precision, and a floor of 10⁻⁴ m that is looked at.
            assert!((found.mean[0] / expected - 1.0).abs() < 1e-3, "{i}: {} {expected}", found.mean[0]);
        }
    }
}

#[test]
fn fifty_of_them_give_the_sum_of_theirs() {
    let down = Quat::from_array(DOWN);
    let places: Vec<(Vec3, Quat)> = (0..50)
        .map(|i| {
            let (sin, cos) = (2.4 * i as f32).sin_cos();
            let r = 0.4 * (i as f32).sqrt();
            let turn = Quat::from_rotation_y(0.5 * i as f32) * Quat::from_rotation_x(0.08 * (i % 11) as f32);
            (Vec3::new(r * cos, 1.0 + 0.02 * i as f32, r * sin), turn * down)
        })
        .collect();
    let found = seen(floor(0.5, 0.0, profile(), &nodes(&places)), 512);
    found.assert_matches([0.5 / std::f64::consts::PI * irradiance(&places); 3], [1e-4; 3], "fifty");
}
