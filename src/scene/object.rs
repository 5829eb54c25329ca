//! What transport wants to know of a placed mesh that holds a medium.

use super::intruders::Intruders;
use super::mesh_facts::MeshFacts;
use super::{AlphaMode, MediumDescription, PunctualKind, Scene, Surface};
use crate::geometry::{Aabb, BoxTree, DistanceBound, NO_COMPONENT, Topology};
use crate::light::EmissiveTriangle;
use glam::{Mat3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Boundaries of a smaller GGX width count as nearly smooth: beyond them light is rather found by going on than sampled.
pub const NEARLY_SMOOTH: f32 = 0.02;

/// Least of [`Object::returned`] in a channel: even black media are looked into now and then.
const LEAST_RETURNED: f32 = 0.05;

/// What a sample of a pixel costs beside its walk, in scattering events. Measured: four times as much is no better.
const REST_OF_A_SAMPLE: f32 = 64.0;
/// Most walks a sample.
const MOST_WALKS: u32 = 4;

/// An instance, as the tracer sees it.
#[derive(Clone, Debug, Default)]
pub struct Object {
    /// Whether any of its triangles bounds a medium.
    pub has_medium: bool,
    /// Whether its mesh is closed, every component of it.
    pub closed: bool,
    /// Whether its mesh is closed and has more than one part: parts may overlap.
    pub in_parts: bool,
    /// Whether some of its solids are wound the other way, and cannot be told from the others.
    pub wound_both_ways: bool,
    /// Place in the total order by (priority, smaller volume, index); the highest rank around a point fills it.
    pub rank: u32,
    /// Closed, and provably contains nothing else: no foreign triangle reaches into its bounds.
    pub isolated: bool,
    /// What reaches into its bounds, and may be inside.
    pub intruders: Intruders,
    /// Whether another medium is among the intruders: then straight lines may lead through its boundary.
    pub overlapped: bool,
    /// Light sources may be inside, so paths in the medium must be connected to them.
    pub lit_inside: bool,
    /// Light beyond the boundary can be aimed at from inside: it is concentrated, and what is in the way of it cannot be
    /// passed unbent (alpha, other media), or the boundary is rough, where aiming copes with that.
    pub aimable: bool,
    /// About how much of the light that crosses into it comes out again ([`crate::optics::Medium::returned`]), the
    /// harmonic mean over the channels, since each is looked at by itself; `None` where that varies.
    pub returned: Option<f32>,
    /// Walks that are worth one sample of a pixel, at least 1: more where they are short.
    pub walks: u32,
    /// Lower bounds of the distance to the boundary, in the instance's local space; for closed media that scatter.
    pub distance: Option<Arc<DistanceBound>>,
}

impl Scene {
    pub(super) fn compile_objects(&mut self, holds_medium: &[bool], emitters: &[EmissiveTriangle]) {
        let mut order: Vec<(i32, f64, u32)> = Vec::new();
        for (i, instance) in self.description.instances.iter().enumerate() {
            if !holds_medium[instance.mesh] {
                continue;
            }
            let facts = &self.facts[instance.mesh];
            let priority = facts.materials.iter().filter_map(|&m| self.medium(m)).map(|m| m.priority).max();
            let priority = priority.unwrap_or(0);
            let volume = facts.volume * f64::from(Mat3::from(instance.transform.matrix3).determinant().abs());
            order.push((priority, -volume, i as u32));
        }
        order.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        if order.is_empty() {
            return;
        }
        let mut distances: HashMap<usize, Arc<DistanceBound>> = HashMap::new();
        let instances = 0..self.description.instances.len() as u32;
        let all = BoxTree::build(instances.map(|i| self.geometry.instance_bounds(i)).collect());
        let placed = self.description.lights.iter().filter(|l| l.kind != PunctualKind::Directional);
        let lights = placed.map(|l| Aabb { min: l.position, max: l.position });
        let lamps = emitters.iter().map(|e| Aabb::from_points(&e.vertices));
        let lights = BoxTree::build(lights.chain(lamps).collect());
        for (rank, &(_, _, instance)) in order.iter().enumerate() {
            let bounds = self.geometry.instance_bounds(instance);
            let topology = self.topologies[self.description.instances[instance as usize].mesh].as_ref();
            let closed = topology.is_some_and(Topology::is_closed);
            let in_parts = closed
                && topology.is_some_and(|t| {
                    t.components.len() > 1 || t.components.iter().any(|c| c.non_manifold_edges > 0)
                });
            let intruders = self.intruders(instance, &bounds, &all);
            let holds_medium = |i: u32| holds_medium[self.description.instances[i as usize].mesh];
            let overlapped = match &intruders {
                Intruders::Few(list) => list.iter().any(|i| holds_medium(i.instance)),
                Intruders::Many => true,
            };
            let media = self.facts_of(instance).materials.iter().filter_map(|&m| self.medium(m));
            let scatters = media.into_iter().any(|m| m.sigma_s.max_element() > 0.0);
            let chord = self.mean_chord(instance);
            let distance = (closed && scatters).then(|| {
                let mesh = self.geometry.mesh_of(instance);
                let distance = || Arc::new(DistanceBound::new(mesh));
                distances.entry(self.geometry.geometry_index(instance)).or_insert_with(distance).clone()
            });
            self.objects[instance as usize] = Object {
                has_medium: true,
                closed,
                in_parts,
                wound_both_ways: topology.is_some_and(|t| t.components.iter().any(|c| c.repeated)),
                rank: rank as u32 + 1,
                isolated: closed && intruders.is_empty(),
                intruders,
                overlapped,
                lit_inside: lights.any(&bounds),
                aimable: false,
                returned: self.returned(instance, chord),
                walks: self.walks(instance, chord),
                distance,
            };
        }
    }

    /// Whether the triangle of a surface is another one's repetition, which does not count for what is inside.
    pub fn is_repetition(&self, surface: &Surface) -> bool {
        let mesh = self.description.instances[surface.instance as usize].mesh;
        let topology = self.topologies[mesh].as_ref();
        topology.is_some_and(|t| t.component_of[surface.triangle as usize] == NO_COMPONENT)
    }

    fn facts_of(&self, instance: u32) -> &MeshFacts {
        &self.facts[self.description.instances[instance as usize].mesh]
    }

    /// [`Object::returned`] of an instance.
    fn returned(&self, instance: u32, chord: f32) -> Option<f32> {
        let &[index] = &self.facts_of(instance).materials[..] else { return None };
        let uniform = !self.material(index).medium.as_ref().is_some_and(MediumDescription::is_textured);
        let medium = self.medium(index).filter(|_| uniform)?;
        let returned = medium.returned(chord).max(Vec3::splat(LEAST_RETURNED));
        Some(3.0 / returned.recip().element_sum()).filter(|r| r.is_finite())
    }

    /// [`Object::walks`] of an instance.
    fn walks(&self, instance: u32, chord: f32) -> u32 {
        let media = self.facts_of(instance).materials.iter().filter_map(|&m| self.medium(m));
        let longest = media.map(|m| m.events(chord)).fold(1.0, f32::max);
        ((REST_OF_A_SAMPLE / longest).sqrt() as u32).clamp(1, MOST_WALKS)
    }

    /// Four volumes over the area, m.
    fn mean_chord(&self, instance: u32) -> f32 {
        let facts = self.facts_of(instance);
        (4.0 * facts.volume / facts.area) as f32 * self.geometry.transform(instance).scale
    }

    /// Whether all triangles of an instance are opaque to straight lines: no alpha.
    pub(super) fn is_covered(&self, instance: u32) -> bool {
        let mut materials = self.facts_of(instance).materials.iter().map(|&m| self.material(m));
        materials.all(|m| m.alpha_mode == AlphaMode::Opaque)
    }

    /// Whether all boundaries of media of an instance are those of plain dielectrics.
    pub(super) fn has_bare_boundary(&self, instance: u32) -> bool {
        let mut materials = self.facts_of(instance).materials.iter().map(|&m| self.material(m));
        materials.all(|m| {
            let treated = m.specular != 1.0
                || m.specular_color != Vec3::ONE
                || m.specular_texture.is_some()
                || m.specular_color_texture.is_some();
            m.medium.is_none() || !(treated || m.layers.is_some())
        })
    }

    /// Whether all boundaries of media of an instance are rough.
    pub(super) fn boundary_is_rough(&self, instance: u32) -> bool {
        let mut materials = self.facts_of(instance).materials.iter().map(|&m| self.material(m));
        materials.all(|m| m.medium.is_none() || m.roughness * m.roughness >= NEARLY_SMOOTH)
    }
}
