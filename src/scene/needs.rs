//! What is made of a description takes memory too, sometimes far more than the file: it is counted before it is there.

use super::compile::SceneError;
use super::description::*;
use super::pyramid::Pyramid;
use crate::geometry::SceneGeometry;
use crate::light::{EMITTER_BYTES, ENVIRONMENT_TEXEL_BYTES, PUNCTUAL_BYTES};

/// Bytes that each thing derived from a description may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DerivedLimits {
    /// Image pyramids, of images for each colour space in which they are averaged.
    pub pyramid_bytes: u64,
    /// Radiance and sampling tables of the environment.
    pub environment_bytes: u64,
    /// Hierarchies with the triangles in them, of each mesh and once more of each instance that is stretched or sheared, and
    /// what is kept of instances.
    pub hierarchy_bytes: u64,
    /// Emissive triangles of all instances, and the tree of lights.
    pub light_bytes: u64,
}

impl Default for DerivedLimits {
    fn default() -> Self {
        Self {
            pyramid_bytes: 2 << 30,
            environment_bytes: 4 << 30,
            hierarchy_bytes: 8 << 30,
            light_bytes: 4 << 30,
        }
    }
}

impl SceneDescription {
    /// Checks what compiling the scene takes against its limits. Indices must have been checked.
    pub(super) fn check_needs(&self) -> Result<(), SceneError> {
        let limits = &self.limits;
        let [pyramids, environment, hierarchies, lights] =
            [self.pyramid_needs(), self.environment_needs(), self.hierarchy_needs(), self.light_needs()];
        let needs = [
            ("image pyramids", pyramids, limits.pyramid_bytes, "pyramid_bytes"),
            (
                "the environment and its sampling tables",
                environment,
                limits.environment_bytes,
                "environment_bytes",
            ),
            (
                "meshes, instances and their hierarchies",
                hierarchies,
                limits.hierarchy_bytes,
                "hierarchy_bytes",
            ),
            ("emissive triangles and the tree of lights", lights, limits.light_bytes, "light_bytes"),
        ];
        match needs.into_iter().find(|(_, needed, limit, _)| needed > limit) {
            Some((what, needed, limit, field)) => Err(SceneError::Limit { what, needed, limit, field }),
            None => {
                // A build takes as much again for a while.
                let needed = [pyramids, environment, hierarchies.saturating_mul(2), lights]
                    .into_iter()
                    .fold(0, u64::saturating_add);
                if crate::room::is_there(needed) { Ok(()) } else { Err(SceneError::Memory { needed }) }
            }
        }
    }

    fn pyramid_needs(&self) -> u64 {
        let images = self.averaged_images().into_iter().filter_map(|(image, _)| self.images.get(image));
        images.map(|image| Pyramid::bytes_of(image)).fold(0, u64::saturating_add)
    }

    fn environment_needs(&self) -> u64 {
        match &self.environment {
            EnvironmentDescription::Constant(_) => 0,
            EnvironmentDescription::Map { pixels, .. } => pixels.len() as u64 * ENVIRONMENT_TEXEL_BYTES,
        }
    }

    fn hierarchy_needs(&self) -> u64 {
        let sizes: Vec<_> = self.meshes.iter().map(|m| [m.positions.len(), m.triangles.len()]).collect();
        SceneGeometry::bytes_needed(&sizes, self.instances.iter().map(|i| (i.mesh, &i.transform)))
    }

    fn light_needs(&self) -> u64 {
        let shines = |&&material: &&u32| {
            let material = self.materials.get(material as usize);
            material.is_some_and(|m| m.emission.max_element() > 0.0 && !m.unlit)
        };
        let of_mesh = |m: &MeshDescription| m.triangle_materials.iter().filter(shines).count() as u64;
        let emitters: Vec<u64> = self.meshes.iter().map(of_mesh).collect();
        let all = self.instances.iter().map(|i| emitters[i.mesh]).fold(0, u64::saturating_add);
        all.saturating_mul(EMITTER_BYTES).saturating_add(self.lights.len() as u64 * PUNCTUAL_BYTES)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Pyramid, Scene};
    use super::*;
    use glam::{Affine2, Affine3A, Vec3};
    use std::sync::Arc;

    /// `textures` over one image, each in a material of its own and lit, `instances` of one triangle that are stretched.
    fn scene(textures: usize, instances: usize) -> SceneDescription {
        let image = ImageData {
            name: String::new(),
            width: 64,
            height: 32,
            pixels: ImagePixels::Rgba8(vec![100; 4 * 64 * 32]),
        };
        let texture = TextureDescription {
            image: 0,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::ClampToEdge,
            linear_filter: true,
            minify: Minify::Footprint,
        };
        let material = |texture| MaterialDescription {
            base_color_texture: Some(TextureRef {
                texture,
                uv_set: 0,
                transform: Affine2::IDENTITY,
                color_space: ColorSpace::Srgb,
            }),
            emission: Vec3::ONE,
            ..Default::default()
        };
        SceneDescription {
            images: vec![Arc::new(image)],
            textures: vec![texture; textures],
            materials: (0..textures).map(material).collect(),
            meshes: vec![MeshDescription {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                triangles: vec![[0, 1, 2]],
                triangle_materials: vec![0],
                ..Default::default()
            }],
            instances: (0..instances)
                .map(|i| InstanceDescription {
                    name: String::new(),
                    pointer: String::new(),
                    mesh: 0,
                    transform: Affine3A::from_scale(Vec3::new(1.0, 2.0, 1.0 + i as f32)),
                })
                .collect(),
            ..Default::default()
        }
    }

    #[test]
    fn textures_of_one_image_share_a_pyramid_in_each_colour_space() {
        let one = scene(1, 1);
        let mut many = scene(64, 1);
        assert_eq!(many.pyramid_needs(), one.pyramid_needs());
        // 32 × 16 + 16 × 8 + … + 2 × 1 + 1 × 1 texels of 8 bytes.
        assert_eq!(one.pyramid_needs(), 8 * (512 + 128 + 32 + 8 + 2 + 1));
        let compiled = Scene::build(many.clone()).expect("builds");
        let first = compiled.pyramids.pyramid(0, ColorSpace::Srgb).expect("a pyramid");
        assert!(
            (1..64).all(|i| compiled
                .pyramids
                .pyramid(i, ColorSpace::Srgb)
                .is_some_and(|p| std::ptr::eq(p, first)))
        );
        assert!(compiled.pyramids.pyramid(0, ColorSpace::Linear).is_none());
        // One texture that is read as both.
        if let Some(reference) = &mut many.materials[63].base_color_texture {
            (reference.texture, reference.color_space) = (0, ColorSpace::Linear);
        }
        assert_eq!(many.pyramid_needs(), 2 * one.pyramid_needs());
        let compiled = Scene::build(many).expect("builds");
        let of = |space| compiled.pyramids.pyramid(0, space).map(|p: &Pyramid| std::ptr::from_ref(p));
        assert!(of(ColorSpace::Linear).is_some() && of(ColorSpace::Srgb).is_some());
        assert_ne!(of(ColorSpace::Linear), of(ColorSpace::Srgb));
    }

    #[test]
    fn what_is_derived_is_counted_before_it_is_there() {
        let mut description = scene(1, 1000);
        description.environment = EnvironmentDescription::Map {
            width: 4,
            height: 2,
            pixels: vec![Vec3::ONE; 8],
            scale: Vec3::ONE,
            rotation: 0.0,
        };
        // Each stretched instance has triangles of its own.
        assert!(description.hierarchy_needs() > 500 * scene(1, 2).hierarchy_needs() / 2);
        let whole = description.limits;
        for (field, limits) in [
            ("pyramid_bytes", DerivedLimits { pyramid_bytes: 10, ..whole }),
            ("environment_bytes", DerivedLimits { environment_bytes: 10, ..whole }),
            ("hierarchy_bytes", DerivedLimits { hierarchy_bytes: 10, ..whole }),
            ("light_bytes", DerivedLimits { light_bytes: 10, ..whole }),
        ] {
            description.limits = limits;
            match Scene::build(description.clone()) {
                Err(SceneError::Limit { field: found, needed, limit: 10, .. }) => {
                    assert_eq!(found, field);
                    assert!(needed > 10);
                }
                Err(other) => panic!("{field}: {other}"),
                Ok(_) => panic!("{field} is not counted"),
            }
        }
        description.limits = whole;
        assert!(Scene::build(description).is_ok());
    }

    #[test]
    fn hierarchies_take_about_what_they_are_counted_for() {
        // A bumpy sheet of 2 · 100² triangles.
        const N: u32 = 100;
        let mut description = scene(1, 1);
        let mesh = &mut description.meshes[0];
        let place = |i: u32| Vec3::new((i / (N + 1)) as f32, (i % (N + 1)) as f32, (i as f32 * 0.7).sin());
        mesh.positions = (0..(N + 1) * (N + 1)).map(place).collect();
        let corners = (0..N).flat_map(|i| (0..N).map(move |j| i * (N + 1) + j));
        mesh.triangles = corners.flat_map(|a| [[a, a + 1, a + N + 2], [a, a + N + 2, a + N + 1]]).collect();
        mesh.triangle_materials = vec![NO_MATERIAL; mesh.triangles.len()];
        let counted = description.hierarchy_needs();
        let scene = Scene::build(description).expect("builds");
        let taken = scene.geometry.mesh_of(0).memory() as u64;
        println!("{taken} of {counted}: {} a triangle", taken / u64::from(2 * N * N));
        assert!(counted >= taken && counted < 2 * taken, "{taken} of {counted}");
    }
}
