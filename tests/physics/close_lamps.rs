//! Lamps close to a surface: what they light does not depend on how close they are.

use crate::lab::*;
use glam::{Vec2, Vec3, Vec4};
use nephrite::scene::*;

/// A slab, and how walks go in it.
#[derive(Clone, Copy)]
struct Slab {
    name: &'static str,
    thickness: f32,
    sigma_s: f32,
    roughness: f32,
    textured: bool,
    /// Times as many samples as the first ones need for the same noise.
    noisy: u32,
}

/// Four mean free paths thick, so that walks are guided through it; fifteen, so that they are not; and with textures.
const SLABS: [Slab; 4] = [
    Slab {
        name: "guided rough",
        thickness: 0.002,
        sigma_s: 2000.0,
        roughness: 0.4,
        textured: false,
        noisy: 1,
    },
    Slab {
        name: "guided smooth",
        thickness: 0.002,
        sigma_s: 2000.0,
        roughness: 0.0,
        textured: false,
        noisy: 1,
    },
    Slab { name: "plain rough", thickness: 0.01, sigma_s: 1500.0, roughness: 0.4, textured: false, noisy: 4 },
    Slab {
        name: "textured rough",
        thickness: 0.002,
        sigma_s: 4000.0,
        roughness: 0.4,
        textured: true,
        noisy: 2,
    },
];

/// Standard error that a comparison may have at most.
const MOST_NOISE: f64 = 0.01;

impl Slab {
    fn scene(&self, environment: EnvironmentDescription) -> SceneDescription {
        let material = subsurface(Vec3::splat(10.0), Vec3::splat(self.sigma_s), 0.0, 1.5, self.roughness);
        let width = 12.0 * self.thickness;
        let mut scene = single(cuboid(Vec3::new(width, self.thickness, width)), material, environment);
        if self.textured {
            let corners = &scene.meshes[0].positions;
            scene.meshes[0].uvs = vec![corners.iter().map(|p| Vec2::new(p.x, p.z) / width).collect()];
            let texels = [0.4, 1.0, 0.7, 0.5].map(Vec3::splat);
            let texture = add_texture(&mut scene, 2, &texels);
            if let Some(medium) = &mut scene.materials[0].medium {
                medium.scattering_texture = Some(texture);
            }
        }
        scene
    }

    /// With a black panel above it that shines down.
    fn below_panel(&self, gap: f32, half: f32) -> SceneDescription {
        let mut scene = self.scene(EnvironmentDescription::default());
        let panel = MaterialDescription {
            base_color: Vec4::ZERO,
            metallic: 0.0,
            roughness: 1.0,
            specular: 0.0,
            emission: Vec3::ONE,
            ..Default::default()
        };
        add_panel(&mut scene, Vec3::Y * (0.5 * self.thickness + gap), Vec3::NEG_Y, half, panel);
        scene
    }

    /// From below.
    fn measure(&self, scene: SceneDescription, aim: bool, spp: u32, case: &str) -> Estimate {
        let scene = Scene::build(scene).expect("builds");
        let camera = ortho(Vec3::Y, 0.5, 0.2 * self.thickness);
        let spp = spp * self.noisy;
        measure(
            &scene,
            &options(camera, 24, spp).with(|o| {
                o.settings.aim = aim;
                o.settings.seed = seed_of(case);
            }),
        )
    }
}

/// From very near a panel of 2 m is the upper half of the sky. (From 1 cm it lacks a ten thousandth of it.)
#[test]
fn light_through_a_slab_does_not_depend_on_the_gap_to_a_panel() {
    for slab in SLABS {
        let sky = slab.measure(slab.scene(sky_above(1.0)), true, 128, slab.name);
        for gap in [1e-6, 1e-5, 1e-4, 5e-4, 1e-2] {
            let case = format!("{} slab {gap} m from a panel", slab.name);
            let found = slab.measure(slab.below_panel(gap, 1.0), true, 64, &case);
            found.assert_same_within(MOST_NOISE, &sky, &case);
        }
    }
}

/// A lamp of about the size of the slab, from where it nearly touches it to where it is far.
#[test]
fn aiming_does_not_change_the_light_of_a_lamp_at_any_gap() {
    for slab in SLABS {
        for (gap, spp) in [(1e-6, 64), (1e-5, 64), (1e-4, 64), (1e-3, 64), (1e-2, 128), (1.0, 256)] {
            // Farther away it is larger, so that chance finds it often enough to compare with.
            let half = f32::max(2.0 * slab.thickness, 0.3 * gap);
            let case = format!("{} slab {gap} m from a lamp", slab.name);
            let aimed = slab.measure(slab.below_panel(gap, half), true, spp, &case);
            let plain = slab.measure(slab.below_panel(gap, half), false, 2 * spp, &format!("{case} again"));
            aimed.assert_same_within(MOST_NOISE, &plain, &case);
        }
    }
}

/// Under the edge of a panel a floor sees half a hemisphere of it, under a corner a quarter, under its middle all.
#[test]
fn a_floor_has_its_configuration_factor_at_every_gap() {
    for (at, share) in [(Vec3::ZERO, 1.0), (Vec3::X, 0.5), (Vec3::new(1.0, 0.0, 1.0), 0.25)] {
        for gap in [1e-7, 1e-6, 1e-5, 1e-4, 1e-3] {
            let half = 0.3;
            let mut scene = SceneDescription::default();
            add_panel(&mut scene, Vec3::ZERO, Vec3::Y, 1.0, matte(0.5));
            let lamp = MaterialDescription { emission: Vec3::ONE, base_color: Vec4::ZERO, ..matte(0.5) };
            let (x, z) = Vec3::NEG_Y.any_orthonormal_pair();
            let center = Vec3::Y * gap - half * (at.x * x + at.z * z);
            add_panel(&mut scene, center, Vec3::NEG_Y, half, lamp);
            let scene = Scene::build(scene).expect("builds");
            // From between the two; the picture is of a thousandth of the gap around the point.
            let (spp, case) = (256, format!("share {share} of a panel {gap} m above"));
            let camera = ortho(Vec3::new(0.3, -0.5, 0.2), 0.4 * gap, 1e-3 * gap);
            let found = measure(&scene, &options(camera, 24, spp).with(|o| o.settings.seed = seed_of(&case)));
            // The rim of the panel that is lacking is as wide as the gap; pictures reach 0.002 gaps to either side.
            found.assert_matches([0.5 * share; 3], [0.5 * share * (1e-3 + f64::from(gap)); 3], &case);
        }
    }
}
