//! What transport wants to know of a placed mesh that holds a medium.

use super::{MeshDescription, PunctualKind, Scene};
use crate::geometry::{Aabb, DistanceBound, MeshGeometry, Topology};
use crate::light::EmissiveTriangle;
use glam::{Mat3, Vec3};
use std::sync::Arc;

/// An instance, as the tracer sees it.
#[derive(Clone, Debug, Default)]
pub struct Object {
    /// Whether any of its triangles bounds a medium.
    pub has_medium: bool,
    /// Whether its mesh is closed, every component of it.
    pub closed: bool,
    /// Place in the total order by (priority, smaller volume, index); the highest rank around a point fills it.
    pub rank: u32,
    /// Provably contains nothing else: no foreign triangle reaches into its bounds, so a walk inside needs only its
    /// own mesh.
    pub isolated: bool,
    /// Light sources may be inside, so paths in the medium must be connected to them.
    pub lit_inside: bool,
    /// Light beyond the boundary can be aimed at from inside: there are beacons, and nothing is in the way that light
    /// passes without being bent (alpha, other media).
    pub aimable: bool,
    /// Lower bounds of the distance to the boundary, in the instance's local space; for closed isolated media.
    pub distance: Option<Arc<DistanceBound>>,
}

impl Scene {
    pub(super) fn compile_objects(&mut self, holds_medium: &[bool], emitters: &[EmissiveTriangle]) {
        let mut order: Vec<(i32, f64, u32)> = Vec::new();
        for (i, instance) in self.description.instances.iter().enumerate() {
            if !holds_medium[instance.mesh] {
                continue;
            }
            let mesh = &self.description.meshes[instance.mesh];
            let materials =
                mesh.triangle_materials.iter().filter_map(|&m| self.media.get(m as usize)?.as_ref());
            let priority = materials.map(|m| m.priority).max().unwrap_or(0);
            let volume = volume(mesh) * f64::from(Mat3::from(instance.transform.matrix3).determinant().abs());
            order.push((priority, -volume, i as u32));
        }
        order.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut bounds_of_mesh: Vec<(*const MeshGeometry, Arc<DistanceBound>)> = Vec::new();
        for (rank, &(_, _, instance)) in order.iter().enumerate() {
            let bounds = self.instance_bounds(instance);
            let closed = self.topologies[self.description.instances[instance as usize].mesh]
                .as_ref()
                .is_some_and(Topology::is_closed);
            let isolated = closed && !self.anything_else_within(instance, &bounds);
            let inside = |p: Vec3| bounds.min.cmple(p).all() && bounds.max.cmpge(p).all();
            let lit_inside = emitters.iter().any(|e| {
                let (min, max) =
                    e.vertices.iter().fold((e.vertices[0], e.vertices[0]), |(a, b), &v| (a.min(v), b.max(v)));
                min.cmple(bounds.max).all() && max.cmpge(bounds.min).all()
            }) || self
                .description
                .lights
                .iter()
                .any(|l| l.kind != PunctualKind::Directional && inside(l.position));
            let scatters = self
                .mesh(instance)
                .triangle_materials
                .iter()
                .any(|&m| self.medium(m).is_some_and(|m| m.sigma_s.max_element() > 0.0));
            let distance = (isolated && scatters).then(|| {
                let mesh = self.geometry.mesh_of(instance);
                let key = std::ptr::from_ref(mesh);
                match bounds_of_mesh.iter().find(|(k, _)| *k == key) {
                    Some((_, d)) => d.clone(),
                    None => {
                        let d = Arc::new(DistanceBound::new(mesh));
                        bounds_of_mesh.push((key, d.clone()));
                        d
                    }
                }
            });
            self.objects[instance as usize] = Object {
                has_medium: true,
                closed,
                rank: rank as u32 + 1,
                isolated,
                lit_inside,
                aimable: false,
                distance,
            };
        }
    }

    fn instance_bounds(&self, instance: u32) -> Aabb {
        let local = self.geometry.mesh_of(instance).bounds();
        let transform = self.geometry.transform(instance);
        let mut bounds = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };
        for i in 0..8 {
            let pick = |bit, a: f32, b: f32| if i & bit == 0 { a } else { b };
            let corner = Vec3::new(
                pick(1, local.min.x, local.max.x),
                pick(2, local.min.y, local.max.y),
                pick(4, local.min.z, local.max.z),
            );
            let p = transform.point(corner);
            bounds = Aabb { min: bounds.min.min(p), max: bounds.max.max(p) };
        }
        bounds
    }

    /// Whether a triangle of another instance reaches into `bounds`.
    fn anything_else_within(&self, instance: u32, bounds: &Aabb) -> bool {
        (0..self.description.instances.len() as u32).any(|other| {
            let b = self.instance_bounds(other);
            if other == instance || b.min.cmpgt(bounds.max).any() || b.max.cmplt(bounds.min).any() {
                return false;
            }
            let (mesh, transform) = (self.geometry.mesh_of(other), self.geometry.transform(other));
            (0..self.mesh(other).triangles.len() as u32).any(|t| {
                let v = mesh.triangle(t).map(|p| transform.point(p));
                let (min, max) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
                min.cmple(bounds.max).all() && max.cmpge(bounds.min).all()
            })
        })
    }
}

fn volume(mesh: &MeshDescription) -> f64 {
    let corner = |i: u32| mesh.positions[i as usize].as_dvec3();
    let tetrahedron = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2])));
    (mesh.triangles.iter().map(tetrahedron).sum::<f64>() / 6.0).abs()
}
