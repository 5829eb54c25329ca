//! What every scene and picture must keep, whatever the file said.

use nephrite::film::Picture;
use nephrite::scene::{EnvironmentDescription, ImagePixels, NO_MATERIAL, SceneDescription};

/// Panics unless all indices point somewhere, all lists have the length they must have, and all numbers are in range.
pub fn check(scene: &SceneDescription) {
    meshes(scene);
    materials(scene);
    for light in &scene.lights {
        assert!(light.intensity.is_finite() && light.intensity.min_element() >= 0.0, "{}", light.intensity);
        assert!(light.position.is_finite() && light.direction.is_normalized());
    }
    for camera in &scene.cameras {
        assert!(camera.transform.is_finite(), "{:?}", camera.transform);
    }
    for image in &scene.images {
        let numbers = match &image.pixels {
            ImagePixels::Rgba8(p) => p.len(),
            ImagePixels::Rgba16(p) => p.len(),
            ImagePixels::Rgba32F(p) => p.len(),
        };
        assert_eq!(numbers, 4 * image.width as usize * image.height as usize);
    }
    check_environment(&scene.environment);
}

fn meshes(scene: &SceneDescription) {
    let materials = scene.materials.len() as u32;
    for mesh in &scene.meshes {
        let n = mesh.positions.len();
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < n));
        let lengths = [mesh.normals.len(), mesh.tangents.len(), mesh.colors.len()];
        assert!(lengths.iter().all(|&l| l == 0 || l == n), "{lengths:?} for {n} vertices");
        assert!(mesh.uvs.iter().all(|set| set.len() == n));
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.normals.iter().all(|v| v.is_finite()));
        assert!(mesh.tangents.iter().all(|v| v.is_finite()));
        assert!(mesh.colors.iter().all(|v| v.is_finite()));
        assert_eq!(mesh.triangles.len(), mesh.triangle_materials.len());
        assert!(mesh.triangle_materials.iter().all(|&m| m < materials || m == NO_MATERIAL));
    }
    for instance in &scene.instances {
        assert!(instance.mesh < scene.meshes.len());
        assert!(instance.transform.is_finite() && instance.transform.inverse().is_finite());
    }
}

fn materials(scene: &SceneDescription) {
    for material in &scene.materials {
        assert!(material.base_color.is_finite() && material.emission.is_finite());
        let factors = [material.metallic, material.roughness, material.transmission, material.specular];
        assert!(factors.iter().all(|f| (0.0..=1.0).contains(f)), "{factors:?}");
        assert!(material.ior.is_finite() && material.ior >= 1.0, "{}", material.ior);
        for texture in material.textures() {
            assert!(scene.textures[texture.texture].image < scene.images.len());
            assert!(texture.transform.is_finite());
        }
        if let Some(m) = &material.medium {
            for sigma in [m.sigma_a, m.sigma_s] {
                assert!(sigma.is_finite() && sigma.min_element() >= 0.0, "{sigma}");
            }
            assert!(m.anisotropy.abs() < 1.0 && m.ior >= 1.0 && m.ior.is_finite());
        }
    }
}

/// Panics unless all radiance is finite and none is negative.
pub fn check_environment(environment: &EnvironmentDescription) {
    match environment {
        EnvironmentDescription::Constant(c) => assert!(c.is_finite() && c.min_element() >= 0.0, "{c}"),
        EnvironmentDescription::Map { width, height, pixels, scale, .. } => {
            assert_eq!(pixels.len(), width * height);
            assert!(scale.is_finite() && pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
        }
    }
}

/// Panics unless all pixels are finite and none is negative.
pub fn check_film(picture: &Picture) {
    for pixel in &picture.pixels {
        assert!(pixel.is_finite() && pixel.min_element() >= 0.0, "{pixel}");
    }
}
