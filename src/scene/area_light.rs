//! Lights with an area that are no mesh (EXT_lights_area): rectangles and disks that shine to one side.
//!
//! Compiling a scene makes them triangles of a material of their own, so that they are chosen, met by chance and weighed as
//! all emissive triangles are. A disk is a regular polygon of the same area: its power is exactly that of the disk, and
//! its irradiance on the axis is off by 10⁻⁷.
//!
//! The material differs from that of an emissive mesh in two things ([`area_light`](super::MaterialDescription::area_light)).
//! *From behind it is not there*: nothing is said of a back, and one that absorbed would darken a furnace. From the front
//! it is as black as an emitter has to be for a furnace of its own radiance not to notice it. *The camera does not see it
//! straight*, as it sees no other light; mirrors, glass and media do.

use super::{InstanceDescription, MaterialDescription, MeshDescription, SceneDescription};
use glam::{Affine3A, Vec2, Vec3};
use std::collections::HashMap;
use std::f32::consts::PI;

/// Sides of the polygon that stands for a disk: its edge is within 0.1 % of the radius.
const SIDES: u32 = 64;

/// The shape of an area light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AreaShape {
    /// Width along the X axis, height along the Y axis.
    Rectangle,
    /// An ellipse in general, of these diameters along the X and Y axes.
    Disk,
}

/// A light with an area, which shines along −Z of its own frame by Lambert's law.
#[derive(Clone, Debug)]
pub struct AreaLight {
    /// Name for messages (the light's, else the node's).
    pub name: String,
    /// JSON pointer of the node.
    pub pointer: String,
    /// Linear colour × luminance, nits (cd/m²).
    pub radiance: Vec3,
    /// Its outline.
    pub shape: AreaShape,
    /// Width and height, metres in the world.
    pub size: Vec2,
    /// Its frame to the world: a rotation, and where its middle is.
    pub transform: Affine3A,
}

impl AreaShape {
    /// Corners and triangles of the shape with width and height 1, which show their fronts towards −Z.
    fn triangles(self) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        match self {
            Self::Rectangle => {
                let corners = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)];
                (corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
            }
            Self::Disk => {
                let step = std::f64::consts::TAU / f64::from(SIDES);
                // n/2 ρ² sin 2π/n = π/4.
                let radius = (std::f64::consts::PI / (2.0 * f64::from(SIDES) * step.sin())).sqrt();
                let corner = |i: u32| {
                    let (sin, cos) = (step * f64::from(i)).sin_cos();
                    Vec3::new((radius * cos) as f32, (radius * sin) as f32, 0.0)
                };
                let positions = std::iter::once(Vec3::ZERO).chain((0..SIDES).map(corner)).collect();
                (positions, (0..SIDES).map(|i| [0, (i + 1) % SIDES + 1, i + 1]).collect())
            }
        }
    }

    /// How many vertices and triangles it becomes.
    pub fn counts(self) -> (usize, usize) {
        match self {
            Self::Rectangle => (4, 2),
            Self::Disk => (SIDES as usize + 1, SIDES as usize),
        }
    }
}

impl AreaLight {
    /// Area, m².
    pub fn area(&self) -> f32 {
        let box_area = self.size.x * self.size.y;
        match self.shape {
            AreaShape::Rectangle => box_area,
            AreaShape::Disk => 0.25 * PI * box_area,
        }
    }

    /// Luminous flux of each channel, lumens: luminance × area × π.
    pub fn lumens(&self) -> Vec3 {
        self.radiance * (self.area() * PI)
    }
}

impl SceneDescription {
    /// Puts the area lights into the scene as meshes, one for each shape and radiance, after all others: where one lies on a
    /// ceiling, it is on top.
    pub(super) fn make_area_lights(&mut self) {
        let mut made = HashMap::new();
        for light in std::mem::take(&mut self.area_lights) {
            if !(light.area() > 0.0 && light.area().is_finite()) {
                continue;
            }
            let key = (light.shape, light.radiance.to_array().map(f32::to_bits));
            let mesh = *made.entry(key).or_insert_with(|| self.area_light_mesh(&light));
            let transform = light.transform * Affine3A::from_scale(light.size.extend(1.0));
            let AreaLight { name, pointer, .. } = light;
            self.instances.push(InstanceDescription { name, pointer, mesh, transform });
        }
    }

    fn area_light_mesh(&mut self, light: &AreaLight) -> usize {
        let (positions, triangles) = light.shape.triangles();
        let material = self.materials.len() as u32;
        self.materials.push(MaterialDescription {
            name: light.name.clone(),
            pointer: light.pointer.clone(),
            base_color: Vec3::ZERO.extend(1.0),
            metallic: 0.0,
            specular: 0.0,
            emission: light.radiance,
            area_light: true,
            ..MaterialDescription::default()
        });
        self.meshes.push(MeshDescription {
            name: light.name.clone(),
            pointer: light.pointer.clone(),
            triangle_materials: vec![material; triangles.len()],
            positions,
            triangles,
            ..MeshDescription::default()
        });
        self.meshes.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_have_their_area_and_face_along_minus_z() {
        for (shape, area) in [(AreaShape::Rectangle, 1.0), (AreaShape::Disk, std::f64::consts::FRAC_PI_4)] {
            let (positions, triangles) = shape.triangles();
            assert_eq!(shape.counts(), (positions.len(), triangles.len()));
            let mut sum = 0.0;
            for t in &triangles {
                let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
                let cross = (b - a).cross(c - a);
                assert!(cross.z < 0.0 && cross.x == 0.0 && cross.y == 0.0, "{shape:?}");
                sum -= 0.5 * cross.z;
            }
            // Single precision of the corners.
            assert!((sum - area).abs() < 3e-7 * area, "{shape:?}: {sum}");
        }
    }

    #[test]
    fn lights_of_one_kind_share_a_mesh() {
        let light = |shape, radiance: f32, x: f32| AreaLight {
            name: String::new(),
            pointer: String::new(),
            radiance: Vec3::splat(radiance),
            shape,
            size: Vec2::new(2.0, 3.0),
            transform: Affine3A::from_translation(x * Vec3::X),
        };
        let mut scene = SceneDescription {
            area_lights: vec![
                light(AreaShape::Disk, 1.0, 0.0),
                light(AreaShape::Disk, 1.0, 5.0),
                light(AreaShape::Disk, 2.0, 9.0),
                light(AreaShape::Rectangle, 1.0, 0.0),
                AreaLight { size: Vec2::ZERO, ..light(AreaShape::Disk, 3.0, 0.0) },
            ],
            ..SceneDescription::default()
        };
        assert!((scene.area_lights[0].lumens().x - 1.5 * PI * PI).abs() < 1e-5);
        assert_eq!(scene.area_lights[3].lumens(), Vec3::splat(6.0 * PI));
        scene.make_area_lights();
        assert_eq!((scene.meshes.len(), scene.materials.len(), scene.instances.len()), (3, 3, 4));
        assert_eq!((scene.instances[1].mesh, scene.instances[2].mesh), (0, 1));
        scene.make_area_lights();
        assert_eq!(scene.instances.len(), 4);
    }
}
