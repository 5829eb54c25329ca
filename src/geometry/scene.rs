//! Placed meshes: a hierarchy of instances above the meshes' own.
//!
//! Every instance maps its mesh by a [`Similarity`], so that directions stay unit vectors, angles are kept and lengths
//! change by one factor: a walk through a medium can run in local space. A transform that shears or stretches has its
//! linear part baked into a mesh of its own, and only its translation is left.
//!
//! A mesh that lies far from its own origin, measured by its size, is moved there: the differences are exact (Sterbenz's
//! lemma), and local space gets back the digits that large coordinates waste.

use super::lanes::Native;
use super::lines::Lined;
use super::mesh::MeshGeometry;
use super::offset::ROUNDING;
use super::ray::{Aabb, MeshHit, Ray};
use super::similarity::{Kind, Similarity};
use super::traversal::traverse;
use super::wide_bvh::{Block, WideBvh};
use glam::{Affine3A, Vec3};
use rayon::prelude::*;

/// Least cosine between ray and emitter for which [`SceneGeometry::band`] is as long as it should be.
const LEAST_COSINE: f32 = 1.0 / 1024.0;

/// Triangles of a piece of work.
const CHUNK: usize = 1 << 14;

/// Why a scene cannot be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GeometryError {
    /// The transform of an instance has no inverse, or is not finite.
    #[error(
        "instance {instance}: the transform cannot be inverted: give every axis a finite, non-zero scale"
    )]
    SingularTransform {
        /// Index of the instance.
        instance: usize,
    },
    /// An instance names a mesh that is not there.
    #[error("instance {instance}: there is no mesh {mesh}, only {count}")]
    NoSuchMesh {
        /// Index of the instance.
        instance: usize,
        /// The index it names.
        mesh: usize,
        /// Number of meshes.
        count: usize,
    },
}

/// Where a ray meets the scene. The point is `(1 - u - v) v0 + u v1 + v v2` of the instance's triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, world metres.
    pub t: f32,
    /// Index of the instance.
    pub instance: u32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Barycentric weight of the second vertex, in \[0, 1\].
    pub u: f32,
    /// Barycentric weight of the third vertex, in \[0, 1\].
    pub v: f32,
    /// Length of the ray before and after `t`, metres, on which another surface counts as in the same place.
    pub band: f32,
    /// Whether the ray meets another surface within the band: then [`SceneGeometry::place`] tells what is there.
    pub crowded: bool,
}

impl Hit {
    /// A point of a triangle, met by no ray.
    pub fn at(instance: u32, triangle: u32, u: f32, v: f32) -> Self {
        Self { t: 0.0, instance, triangle, u, v, band: 0.0, crowded: false }
    }

    /// The closer one of two hits of a ray, crowded where both are in one place.
    #[inline]
    pub fn closer(self, other: Option<Self>) -> Self {
        let Some(other) = other else { return self };
        let (first, second) = if other.t < self.t { (other, self) } else { (self, other) };
        let together = second.t - first.t <= first.band.max(second.band);
        Self { crowded: first.crowded || together, ..first }
    }
}

/// A point of a surface in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position, world metres.
    pub position: Vec3,
    /// Bounds of the position's error on each axis; see [`super::offset_origin`].
    pub error: Vec3,
    /// Unit normal on the front side, as glTF defines it.
    pub geometric_normal: Vec3,
}

struct Instance {
    geometry: u32,
    transform: Similarity,
}

/// A leaf of the hierarchy of instances.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Leaf {
    pub(super) instance: u32,
    _unused: [u32; 15],
}

// SAFETY: numbers alone, one line of them.
unsafe impl Lined for Leaf {}

/// Instances of meshes, and the queries of a path tracer. Immutable.
pub struct SceneGeometry {
    geometries: Vec<MeshGeometry>,
    instances: Vec<Instance>,
    pub(super) bvh: WideBvh<Leaf>,
}

impl SceneGeometry {
    /// Builds meshes (positions and triangles) and the hierarchy of instances (mesh index and mesh-to-world map).
    ///
    /// A mesh that several similar instances share is built once. Deterministic.
    pub fn build(
        meshes: Vec<(Vec<Vec3>, Vec<[u32; 3]>)>,
        instances: &[(usize, Affine3A)],
    ) -> Result<Self, GeometryError> {
        enum Source {
            Shared(usize),
            Baked(usize, Affine3A),
        }
        let mut sources = Vec::new();
        let mut shared = vec![None; meshes.len()];
        let mut placed = Vec::with_capacity(instances.len());
        for (instance, (mesh, transform)) in instances.iter().enumerate() {
            let Some(slot) = shared.get_mut(*mesh) else {
                return Err(GeometryError::NoSuchMesh { instance, mesh: *mesh, count: meshes.len() });
            };
            let (geometry, transform) = match Similarity::classify(transform) {
                Kind::Singular => return Err(GeometryError::SingularTransform { instance }),
                Kind::Similar(similarity) => {
                    let geometry = *slot.get_or_insert_with(|| {
                        sources.push(Source::Shared(*mesh));
                        sources.len() - 1
                    });
                    (geometry, similarity)
                }
                Kind::Affine => {
                    sources.push(Source::Baked(*mesh, *transform));
                    (sources.len() - 1, Similarity::from_translation(transform.translation.into()))
                }
            };
            placed.push(Instance { geometry: geometry as u32, transform });
        }
        let build = |source: &Source| {
            let (mesh, linear) = match source {
                Source::Shared(mesh) => (*mesh, None),
                Source::Baked(mesh, transform) => (*mesh, Some(transform.matrix3)),
            };
            let (positions, triangles) = &meshes[mesh];
            let mut positions = positions.clone();
            if let Some(linear) = linear {
                positions.iter_mut().for_each(|p| *p = linear * *p);
            }
            let center = move_to_origin(&mut positions, triangles);
            let reversed = linear.is_some_and(|linear| linear.determinant() < 0.0);
            (MeshGeometry::build_oriented(&positions, triangles, reversed), center)
        };
        let (geometries, centers): (Vec<MeshGeometry>, Vec<Vec3>) = sources.par_iter().map(build).unzip();
        for instance in &mut placed {
            instance.transform.translation = instance.transform.point(centers[instance.geometry as usize]);
        }
        let bounds_of = |i: &Instance| i.transform.bounds(&geometries[i.geometry as usize].bounds());
        let bounds: Vec<Aabb> = placed.iter().map(bounds_of).collect();
        let kept: Vec<u32> = (0..placed.len() as u32)
            .filter(|&i| !bounds[i as usize].is_empty() && bounds[i as usize].min.is_finite())
            .filter(|&i| bounds[i as usize].max.is_finite())
            .collect();
        let boxes: Vec<Aabb> = kept.iter().map(|&i| bounds[i as usize]).collect();
        let leaf = |block: &Block| Leaf { instance: kept[block[0] as usize], _unused: [0; 15] };
        let bvh = WideBvh::build(&boxes, 1, |_| true, leaf);
        Ok(Self { geometries, instances: placed, bvh })
    }

    /// About how many bytes [`Self::build`] will keep for meshes of so many vertices and triangles, and for what a scene
    /// keeps of each instance. The build takes as much again for a while.
    pub fn bytes_needed<'a>(
        sizes: &[[usize; 2]],
        instances: impl Iterator<Item = (usize, &'a Affine3A)>,
    ) -> u64 {
        // Measured: hierarchies take up to 100 bytes a triangle, in small and bumpy meshes; indices and normals are 24.
        const VERTEX: u64 = 12;
        const TRIANGLE: u64 = 144;
        const INSTANCE: u64 = 512;
        let bytes =
            |[vertices, triangles]: [usize; 2]| VERTEX * vertices as u64 + TRIANGLE * triangles as u64;
        let mut counted = vec![false; sizes.len()];
        let mut needed = 0_u64;
        for (mesh, transform) in instances {
            needed = needed.saturating_add(INSTANCE);
            let Some(&size) = sizes.get(mesh) else { continue };
            let is_shared = matches!(Similarity::classify(transform), Kind::Similar(_));
            if !(is_shared && std::mem::replace(&mut counted[mesh], true)) {
                needed = needed.saturating_add(bytes(size));
            }
        }
        needed
    }

    /// Box around everything that can be hit, world metres; empty for an empty scene.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds
    }

    /// Number of instances given to the build.
    pub fn instance_count(&self) -> usize {
        self.instances.len()
    }

    /// Number of meshes that were built: shared ones, and one for each baked instance.
    pub fn geometry_count(&self) -> usize {
        self.geometries.len()
    }

    /// The mesh of an instance, in the local space of [`Self::transform`].
    #[inline]
    pub fn mesh_of(&self, instance: u32) -> &MeshGeometry {
        &self.geometries[self.instances[instance as usize].geometry as usize]
    }

    /// Index below [`Self::geometry_count`] of an instance's mesh: a key for what is computed once a mesh.
    #[inline]
    pub fn geometry_index(&self, instance: u32) -> usize {
        self.instances[instance as usize].geometry as usize
    }

    /// Local-to-world map of an instance.
    #[inline]
    pub fn transform(&self, instance: u32) -> &Similarity {
        &self.instances[instance as usize].transform
    }

    /// Closest hit.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.closest(ray, |_| true)
    }

    /// Closest hit of all instances but one.
    pub fn intersect_others(&self, instance: u32, ray: &Ray) -> Option<Hit> {
        self.closest(ray, |other| other != instance)
    }

    #[inline(always)]
    fn closest(&self, ray: &Ray, counts: impl Fn(u32) -> bool) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        traverse::<Native, true, _>(&self.bvh, ray, |&Leaf { instance, .. }, t_max| {
            if !counts(instance) {
                return t_max;
            }
            match self.intersect_instance(instance, &Ray { t_max, ..*ray }) {
                Some(hit) if hit.t < t_max => {
                    let hit = hit.closer(closest);
                    closest = Some(hit);
                    t_max.min(hit.t + hit.band)
                }
                _ => t_max,
            }
        });
        closest
    }

    /// Whether anything is hit.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut found = false;
        traverse::<Native, false, _>(&self.bvh, ray, |&Leaf { instance, .. }, t_max| {
            found = self.mesh_of(instance).occluded(&self.transform(instance).inverse_ray(ray));
            if found { -1.0 } else { t_max }
        });
        found
    }

    /// Closest hit of one instance.
    #[inline]
    pub fn intersect_instance(&self, instance: u32, ray: &Ray) -> Option<Hit> {
        let transform = self.transform(instance);
        let local = transform.inverse_ray(ray);
        let mesh = self.mesh_of(instance);
        let hit = mesh.intersect(&local)?;
        // The roundings of both spaces, across the same plane.
        let coordinates = ray.origin.abs().max_element() + transform.translation.abs().max_element();
        let more = transform.inverse_length(coordinates) / mesh.coordinates(&local).max(f32::MIN_POSITIVE);
        Some(to_world(instance, transform, MeshHit { band: hit.band * (1.0 + more), ..hit }))
    }

    /// Visits all hits, in no order that means anything.
    pub fn visit_hits(&self, ray: &Ray, mut visit: impl FnMut(Hit)) {
        traverse::<Native, false, _>(&self.bvh, ray, |&Leaf { instance, .. }, t_max| {
            self.visit_hits_of(instance, ray, &mut visit);
            t_max
        });
    }

    /// Visits all hits of one instance, in no order that means anything.
    #[inline]
    pub fn visit_hits_of(&self, instance: u32, ray: &Ray, mut visit: impl FnMut(Hit)) {
        let transform = self.transform(instance);
        let visit_local = |hit| visit(to_world(instance, transform, hit));
        self.mesh_of(instance).visit_hits(&transform.inverse_ray(ray), visit_local);
    }

    /// Whether anything is in the way to a triangle that emits, at the end of a ray.
    ///
    /// `None`: something else is in the same place as the triangle, and [`Self::place`] has to tell what is on top.
    pub fn occluded_before(&self, ray: &Ray, instance: u32, triangle: u32, band: f32) -> Option<bool> {
        let (mut found, mut crowded) = (false, false);
        let end = ray.t_max - band;
        let reaching = Ray { t_max: ray.t_max + band, ..*ray };
        traverse::<Native, false, _>(&self.bvh, &reaching, |&Leaf { instance: other, .. }, t_max| {
            let transform = self.transform(other);
            found = self.mesh_of(other).any_hit(&transform.inverse_ray(&reaching), |t, id| {
                let before = transform.scale * t < end;
                let itself = other == instance && id == triangle;
                crowded |= !before && !itself;
                before && !itself
            });
            if found { -1.0 } else { t_max }
        });
        if !found && crowded { None } else { Some(found) }
    }

    /// Length of a ray before and after a point of a triangle on which other surfaces are in the same place, by the angle
    /// between them.
    #[inline]
    pub fn band(&self, ray: &Ray, instance: u32, triangle: u32) -> f32 {
        let transform = self.transform(instance);
        let mesh = self.mesh_of(instance);
        let local = transform.inverse_ray(ray);
        let cosine = mesh.geometric_normal(triangle).dot(local.direction).abs().max(LEAST_COSINE);
        let coordinates = ray.origin.abs().max_element() + transform.translation.abs().max_element();
        ROUNDING * (transform.scale * mesh.coordinates(&local) + coordinates) / cosine
    }

    /// The point of a hit in world space.
    #[inline]
    pub fn surface(&self, hit: &Hit) -> SurfacePoint {
        let (mesh, transform) = (self.mesh_of(hit.instance), self.transform(hit.instance));
        let (local, error) = mesh.point(hit.triangle, hit.u, hit.v);
        let (position, error) = transform.point_with_error(local, error);
        let geometric_normal = transform.direction(mesh.geometric_normal(hit.triangle));
        SurfacePoint { position, error, geometric_normal }
    }
}

/// Moves points, of which triangles lie far from the origin, by the returned vector; no corner of a triangle is rounded.
fn move_to_origin(positions: &mut [Vec3], triangles: &[[u32; 3]]) -> Vec3 {
    let corner = |&i: &u32| positions.get(i as usize).copied().filter(|p| super::mesh::is_usable(*p));
    let point = |p: Vec3| Aabb { min: p, max: p };
    let bounds_of = |chunk: &[[u32; 3]]| {
        let corners = chunk.as_flattened().iter().filter_map(corner);
        corners.map(point).fold(Aabb::EMPTY, Aabb::union)
    };
    let bounds = triangles.par_chunks(CHUNK).map(bounds_of).reduce(|| Aabb::EMPTY, Aabb::union);
    if bounds.is_empty() {
        return Vec3::ZERO;
    }
    // Then every coordinate is within a factor of two of the centre's.
    let far = bounds.center().abs().cmpgt(2.0 * bounds.extent());
    let center = Vec3::select(far, bounds.center(), Vec3::ZERO);
    positions.iter_mut().for_each(|p| *p -= center);
    center
}

#[inline(always)]
fn to_world(instance: u32, transform: &Similarity, hit: MeshHit) -> Hit {
    let MeshHit { t, triangle, u, v, band, crowded } = hit;
    Hit { t: transform.scale * t, instance, triangle, u, v, band: transform.scale * band, crowded }
}
