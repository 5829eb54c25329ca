//! Scenes far from their origin: what is near each other keeps its places to the last digits.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DVec3, Vec3};

use super::*;

/// A place on the globe, in no round numbers.
const PLACE: [f64; 3] = [4_161_012.347, 853_447.618, -4_743_990.272];

/// The world position of a point of an instance's mesh.
fn at(loaded: &Loaded, instance: usize, p: Vec3) -> DVec3 {
    let transform = &loaded.scene.instances[instance].transform;
    transform.transform_point3(p).as_dvec3() + loaded.scene.origin
}

/// Whether the scene is counted from near `place`, by round numbers.
fn rebased(loaded: &Loaded, place: [f64; 3]) -> bool {
    let origin = loaded.scene.origin;
    origin.distance(DVec3::from(place)) < 20.0 && (origin * 1024.0).fract() == DVec3::ZERO
}

#[test]
fn a_root_on_the_globe_keeps_sizes_and_distances() {
    let mut b = Builder::triangle();
    b.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    b.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    b.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    b.json["nodes"] = json!([
        {"translation": PLACE, "children": [1, 2, 3, 4, 5]},
        {"mesh": 0},
        {"mesh": 0, "translation": [0, 0, 0.001]},
        {"camera": 0, "translation": [0, 0, 3.125]},
        {"translation": [0.1, 0.2, 0.3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"mesh": 0, "translation": [0, 0, 0.002], "scale": [1, 1, 0]},
    ]);
    let loaded = b.loaded();
    assert!(rebased(&loaded, PLACE), "{}", loaded.scene.origin);
    let near = |found: DVec3, by: [f64; 3]| {
        let expected = DVec3::from(PLACE) + DVec3::from(by);
        assert!(found.distance(expected) < 1e-6, "{found} is not {expected}");
    };
    let x = at(&loaded, 0, Vec3::X);
    near(x, [1.0, 0.0, 0.0]);
    near(at(&loaded, 1, Vec3::ZERO), [0.0, 0.0, 0.001]);
    near(at(&loaded, 2, Vec3::Y), [0.0, 1.0, 0.002]);
    let scene = &loaded.scene;
    near(scene.origin + scene.cameras[0].transform.translation.as_dvec3(), [0.0, 0.0, 3.125]);
    near(scene.origin + scene.lights[0].position.as_dvec3(), [0.1, 0.2, 0.3]);
    // Without a camera everything is framed.
    b.json["nodes"][3] = json!({"name": "nothing"});
    let loaded = b.loaded();
    assert!(rebased(&loaded, PLACE));
    near(at(&loaded, 0, Vec3::X), [1.0, 0.0, 0.0]);
}

#[test]
fn what_is_near_the_origin_for_its_size_stays_as_it_is() {
    let mut b = Builder::triangle();
    b.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    b.json["nodes"] = json!([
        {"mesh": 0, "translation": [0.1, 7.3, 0]}, {"camera": 0, "translation": [0, 0, 5]},
    ]);
    b.json["scenes"] = json!([{"nodes": [0, 1]}]);
    let loaded = b.loaded();
    assert_eq!(loaded.scene.origin, DVec3::ZERO);
    assert_eq!(Vec3::from(loaded.scene.instances[0].transform.translation), Vec3::new(0.1, 7.3, 0.0));
    // Something far away that the camera does not look at changes nothing, nor does a large scale.
    b.json["nodes"] = json!([
        {"mesh": 0, "scale": [1e6, 1e6, 1e6], "translation": [0, 3e6, 0]}, {"camera": 0, "translation": [0, 0, 5]},
    ]);
    assert_eq!(b.loaded().scene.origin, DVec3::ZERO);
}

#[test]
fn the_camera_that_is_looked_through_counts() {
    let mut b = Builder::triangle();
    b.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    b.json["nodes"] = json!([
        {"mesh": 0}, {"camera": 0, "name": "home", "translation": [0, 0, 5]},
        {"mesh": 0, "translation": PLACE},
        {"camera": 0, "name": "away", "translation": [PLACE[0], PLACE[1], PLACE[2] + 5.0]},
    ]);
    b.json["scenes"] = json!([{"nodes": [0, 1, 2, 3]}]);
    assert_eq!(b.loaded().scene.origin, DVec3::ZERO);
    for camera in ["away", "1"] {
        let options = LoadOptions { camera: Some(camera.to_owned()), ..LoadOptions::default() };
        let loaded = b.load_with(&options).expect("it loads");
        assert!(rebased(&loaded, PLACE), "{camera}");
    }
}

#[test]
fn vertices_far_away_lose_nothing_that_the_file_has() {
    // Multiples of 1/2, exact in single precision at four million metres.
    let far = Vec3::new(4_161_012.5, 853_447.5, -4_743_990.0);
    let corners = [far, far + Vec3::X * 1.5, far + Vec3::Y * 2.5];
    let mut b = Builder::new();
    let position = b.floats("VEC3", &corners.map(|c| c.to_array()).concat());
    b.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": position}}]}]);
    // Turned by a quarter about Y, and brought back by doubles.
    let back = [-f64::from(far.z) - 0.123_456_7, -f64::from(far.y), f64::from(far.x)];
    let turn = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
    b.json["nodes"] = json!([{"mesh": 0, "rotation": turn, "translation": back}]);
    let loaded = b.loaded();
    assert_eq!(loaded.scene.origin, DVec3::ZERO, "it is near the origin in the world");
    let p = loaded.scene.meshes[0].positions.clone();
    assert_eq!([p[1] - p[0], p[2] - p[0]], [Vec3::X * 1.5, Vec3::Y * 2.5]);
    let found = at(&loaded, 0, p[0]);
    assert!(found.distance(DVec3::new(-0.123_456_7, 0.0, 0.0)) < 1e-5, "{found}");
    // Left where it is, the scene is counted from there.
    b.json["nodes"] = json!([{"mesh": 0}]);
    let loaded = b.loaded();
    let p = &loaded.scene.meshes[0].positions;
    assert!(loaded.scene.origin.distance(far.as_dvec3()) < 4.0);
    assert_eq!(at(&loaded, 0, p[2]), corners[2].as_dvec3());
}

#[test]
fn skins_and_copies_on_the_globe_keep_their_shape() {
    let mut b = Builder::triangle();
    let joints = b.accessor("VEC4", U8, 3, &[0; 12]);
    let weights = b.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let attributes = &mut b.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    let copies = b.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.125]);
    b.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    b.json["skins"] = json!([{"joints": [1]}]);
    let copies = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": copies}}});
    b.json["nodes"] = json!([
        {"translation": PLACE, "children": [1, 2, 3]},
        {"translation": [0.25, 0, 0]},
        {"mesh": 0, "skin": 0},
        {"mesh": 0, "translation": [0, 0, -0.5], "extensions": copies},
    ]);
    let loaded = b.loaded();
    assert!(rebased(&loaded, PLACE));
    let place = DVec3::from(PLACE);
    let skinned = &loaded.scene.meshes[loaded.scene.instances[0].mesh].positions;
    for (p, expected) in skinned.iter().zip([DVec3::ZERO, DVec3::X, DVec3::Y]) {
        let found = at(&loaded, 0, *p) - place - DVec3::X * 0.25;
        assert!(found.distance(expected) < 1e-6, "{found} is not {expected}");
    }
    for (instance, z) in [(1, -0.5), (2, -0.375)] {
        let found = at(&loaded, instance, Vec3::Y) - place;
        assert!(found.distance(DVec3::new(0.0, 1.0, z)) < 1e-6, "{found}");
    }
}

#[test]
fn all_moments_have_the_origin_of_the_first() {
    let mut b = Builder::triangle();
    b.json["nodes"] = json!([{"mesh": 0, "translation": PLACE}]);
    let times = b.floats("SCALAR", &[0.0, 1.0]);
    let places = b.floats("VEC3", &[4e6, 0.0, 0.0, 4e6, 100.0, 0.0]);
    b.json["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": times, "output": places}],
    }]);
    let bytes = b.document().to_string().into_bytes();
    let mut asset = Asset::from_bytes(bytes, Path::new("/nowhere"), &LoadOptions::default()).expect("a file");
    let mut load = |time| asset.load(&Moment { animations: vec![0], time }).expect("a scene").scene;
    let (first, last) = (load(0.0), load(1.0));
    assert!(first.origin.distance(DVec3::new(4e6, 0.0, 0.0)) < 4.0);
    assert_eq!(first.origin, last.origin);
    let moved = last.instances[0].transform.translation - first.instances[0].transform.translation;
    assert_eq!(Vec3::from(moved), Vec3::Y * 100.0);
}

#[test]
fn a_thin_sheet_with_a_medium_is_far_away_sooner() {
    let mut b = Builder::with_material(json!({
        "extensions": {"NEPHRITE_materials_subsurface": {"absorptionCoefficient": [1, 1, 1]}},
    }));
    b.json["extensionsUsed"] = json!(["NEPHRITE_materials_subsurface"]);
    let position = b.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1e-4]);
    b.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
    b.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    b.json["nodes"] = json!([{"mesh": 0, "translation": [0, 0, 4]}, {"camera": 0, "translation": [0, 0, 5]}]);
    b.json["scenes"] = json!([{"nodes": [0, 1]}]);
    assert_eq!(b.loaded().scene.origin, DVec3::new(0.0, 0.0, 4.0));
    b.json["materials"][0]["extensions"] = json!({});
    assert_eq!(b.loaded().scene.origin, DVec3::ZERO);
}

#[test]
fn copies_that_light_passes_are_kept_and_opaque_ones_are_not() {
    for (material, kept) in [
        (json!({}), 1),
        (json!({"alphaMode": "MASK"}), 1),
        (json!({"alphaMode": "BLEND"}), 2),
        (json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}), 2),
        (json!({"extensions": {"NEPHRITE_materials_subsurface": {}}}), 2),
    ] {
        let mut b = Builder::with_material(material.clone());
        b.json["extensionsUsed"] = json!(["KHR_materials_transmission", "NEPHRITE_materials_subsurface"]);
        b.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0}]);
        b.json["scenes"] = json!([{"nodes": [0, 1]}]);
        assert_eq!(b.loaded().scene.instances.len(), kept, "{material}");
        b.json["nodes"] = json!([{"mesh": 0}]);
        b.json["scenes"] = json!([{"nodes": [0]}]);
        let primitive = b.json["meshes"][0]["primitives"][0].clone();
        b.json["meshes"][0]["primitives"] = json!([primitive, primitive]);
        assert_eq!(b.loaded().scene.meshes[0].triangles.len(), kept, "{material}");
    }
    // Two objects less than a rounding apart, far away, are two.
    let mut b = Builder::triangle();
    let apart = [PLACE[0] + 0.1, PLACE[1], PLACE[2]];
    b.json["nodes"] = json!([{"mesh": 0, "translation": PLACE}, {"mesh": 0, "translation": apart}]);
    b.json["scenes"] = json!([{"nodes": [0, 1]}]);
    assert_eq!(b.loaded().scene.instances.len(), 2);
}
