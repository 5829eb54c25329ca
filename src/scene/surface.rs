//! A point on a surface with everything shading reads: frame, texture coordinates, vertex colour.

use super::{Scene, description::TextureRef};
use crate::geometry::{Hit, SurfacePoint};
use glam::{Vec2, Vec3, Vec4};

/// A point on a triangle, in world space. Normals point to the front of the triangle.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// World position.
    pub position: Vec3,
    /// Bound of the rounding error of `position`.
    pub error: Vec3,
    /// Unit normal of the triangle, to the front.
    pub geometric_normal: Vec3,
    /// Unit interpolated and normal-mapped normal, on the same side as `geometric_normal`.
    pub normal: Vec3,
    /// The instance.
    pub instance: u32,
    /// The triangle of its mesh.
    pub triangle: u32,
    /// Barycentric coordinates of vertices 1 and 2.
    pub barycentric: Vec2,
    /// Material index, [`super::NO_MATERIAL`] for none.
    pub material: u32,
    /// Width over which colour textures are averaged, metres across the ray; 0: points. See [`super::Footprint`].
    pub footprint: f32,
}

impl Surface {
    /// The surface at a hit.
    pub fn new(scene: &Scene, hit: &Hit) -> Self {
        let point = scene.geometry.surface(hit);
        let instance = &scene.description.instances[hit.instance as usize];
        let mesh = &scene.description.meshes[instance.mesh];
        let mut surface = Self {
            position: point.position,
            error: point.error,
            geometric_normal: point.geometric_normal,
            normal: point.geometric_normal,
            instance: hit.instance,
            triangle: hit.triangle,
            barycentric: Vec2::new(hit.u, hit.v),
            material: mesh.triangle_materials[hit.triangle as usize],
            footprint: 0.0,
        };
        if !mesh.normals.is_empty() {
            let local = surface.interpolate(mesh.triangles[hit.triangle as usize], &mesh.normals, |n| *n);
            let normal = (scene.normal_matrices[hit.instance as usize] * local).normalize_or(surface.normal);
            surface.normal = keep_side(normal, surface.geometric_normal);
        }
        surface
    }

    /// The point in space.
    pub fn point(&self) -> SurfacePoint {
        let &Self { position, error, geometric_normal, .. } = self;
        SurfacePoint { position, error, geometric_normal }
    }

    /// Takes the back for the front.
    pub fn turn(&mut self) {
        self.geometric_normal = -self.geometric_normal;
        self.normal = -self.normal;
    }

    /// Where the smooth surface that the normals of the vertices tell of lies above this point, on the side of the unit
    /// vector `side`; `None` where it does not.
    ///
    /// The mean of the tangent planes of the vertices, as barycentric coordinates weigh them, is twice as far above a
    /// triangle as a surface of the second order with those tangents: half of that is on the surface. Planes that lie below
    /// count as none (Hanika 2021, "Hacking the Shadow Terminator", which takes the whole).
    pub fn smooth_position(&self, scene: &Scene, side: Vec3) -> Option<Vec3> {
        let mesh = scene.mesh(self.instance);
        if mesh.normals.is_empty() || self.normal == self.geometric_normal {
            return None;
        }
        let triangle = mesh.triangles[self.triangle as usize];
        let transform = &scene.description.instances[self.instance as usize].transform;
        let normals = &scene.normal_matrices[self.instance as usize];
        let facing = if side.dot(self.geometric_normal) < 0.0 { -1.0 } else { 1.0 };
        let weights = [1.0 - self.barycentric.x - self.barycentric.y, self.barycentric.x, self.barycentric.y];
        let mut lift = Vec3::ZERO;
        for (i, weight) in triangle.into_iter().zip(weights) {
            let normal = (*normals * mesh.normals[i as usize]).try_normalize()?;
            if normal.dot(self.geometric_normal) <= 0.0 {
                return None;
            }
            let normal = facing * normal;
            let vertex = transform.transform_point3(mesh.positions[i as usize]);
            lift -= normal * ((self.position - vertex).dot(normal).min(0.0) * weight * 0.5);
        }
        // Less than what rays are moved by to leave the surface is none.
        let least = 4.0 * self.geometric_normal.abs().dot(self.error);
        (facing * lift.dot(self.geometric_normal) > least).then_some(self.position + lift)
    }

    fn interpolate<T, V>(&self, triangle: [u32; 3], values: &[T], get: impl Fn(&T) -> V) -> V
    where
        V: std::ops::Mul<f32, Output = V> + std::ops::Add<Output = V>,
    {
        let [a, b, c] = triangle.map(|i| get(&values[i as usize]));
        a * (1.0 - self.barycentric.x - self.barycentric.y) + b * self.barycentric.x + c * self.barycentric.y
    }

    /// Texture coordinates of a set; zero where the mesh lacks it.
    pub fn uv(&self, scene: &Scene, set: usize) -> Vec2 {
        let mesh = scene.mesh(self.instance);
        match mesh.uvs.get(set) {
            Some(uvs) if !uvs.is_empty() => {
                self.interpolate(mesh.triangles[self.triangle as usize], uvs, |uv| *uv)
            }
            _ => Vec2::ZERO,
        }
    }

    /// Linear vertex colour; white where the mesh has none.
    pub fn color(&self, scene: &Scene) -> Vec4 {
        let mesh = scene.mesh(self.instance);
        if mesh.colors.is_empty() {
            Vec4::ONE
        } else {
            self.interpolate(mesh.triangles[self.triangle as usize], &mesh.colors, |c| *c)
        }
    }

    /// A texture at this point.
    pub fn texture(&self, scene: &Scene, texture: &TextureRef) -> Vec4 {
        scene.texel(texture, self.uv(scene, texture.uv_set))
    }

    /// Unit tangent and bitangent perpendicular to a unit `normal`; `None` where the mesh has none.
    pub fn tangents(&self, scene: &Scene, normal: Vec3) -> Option<(Vec3, Vec3)> {
        let mesh = scene.mesh(self.instance);
        if mesh.tangents.is_empty() {
            return None;
        }
        let tangent = self.interpolate(mesh.triangles[self.triangle as usize], &mesh.tangents, |t| *t);
        let instance = &scene.description.instances[self.instance as usize];
        let world = instance.transform.transform_vector3(tangent.truncate());
        let along = (world - normal * normal.dot(world)).try_normalize()?;
        let mirrored = if scene.mirrored[self.instance as usize] { -1.0 } else { 1.0 };
        let sign = if tangent.w < 0.0 { -mirrored } else { mirrored };
        Some((along, normal.cross(along) * sign))
    }

    /// The shading normal bent by the material's normal map, on the side of the geometric normal.
    ///
    /// Normal maps are baked for vectors that are interpolated and used as they are, neither normalized nor made
    /// perpendicular (MikkTSpace: n = normalize(x t + y w n × t + z n), in the space of the mesh). On coarse meshes anything
    /// else bends reflections visibly.
    pub fn mapped_normal(&self, scene: &Scene, texture: &TextureRef, scale: f32) -> Vec3 {
        let mesh = scene.mesh(self.instance);
        if mesh.tangents.is_empty() || mesh.normals.is_empty() {
            return self.normal;
        }
        let triangle = mesh.triangles[self.triangle as usize];
        let tangent = self.interpolate(triangle, &mesh.tangents, |t| *t);
        let normal = self.interpolate(triangle, &mesh.normals, |n| *n);
        let (along, sign) = (tangent.truncate(), if tangent.w < 0.0 { -1.0 } else { 1.0 });
        if along.reject_from(normal) == Vec3::ZERO {
            return self.normal;
        }
        let texel = self.texture(scene, texture).truncate() * 2.0 - Vec3::ONE;
        let across = normal.cross(along) * sign;
        let mapped = along * (texel.x * scale) + across * (texel.y * scale) + normal * texel.z;
        let world = scene.normal_matrices[self.instance as usize] * mapped;
        keep_side(world.normalize_or(self.normal), self.geometric_normal)
    }
}

/// Turns a shading normal that points behind its triangle to the grazing direction in front of it.
fn keep_side(normal: Vec3, geometric: Vec3) -> Vec3 {
    /// Smallest cosine between shading and geometric normal: shading normals beyond it come from bad data.
    const MIN_COSINE: f32 = 0.02;
    let cosine = normal.dot(geometric);
    if cosine >= MIN_COSINE {
        normal
    } else {
        (normal + geometric * (MIN_COSINE - cosine)).normalize_or(geometric)
    }
}
