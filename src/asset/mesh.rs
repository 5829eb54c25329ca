//! Meshes (glTF 2.0 §3.7): all primitives of a mesh become one description, since one mesh is one object.
//!
//! Positions that cannot be placed are dropped with their triangles. Triangles with two corners at the same place go
//! too: they have no area, and their edges cancel, so a closed mesh stays closed; thin ones stay, since closedness may
//! hang on them. An opaque primitive that repeats another word by
//! word goes, too. Where only some primitives have normals the others get flat ones of their own.

use std::collections::HashSet;

use glam::{DVec3, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::error::{AssetError, count};
use super::json::Json;
use super::loader::Loader;
use super::manifold;
use super::pose::Pose;
use super::primitive::Primitive;
use super::rebase;
use super::tangent;
use crate::scene::{MaterialDescription, MeshDescription, bounds};

/// Coordinates beyond this overflow single precision once they are squared, and squared again.
pub(crate) const FARTHEST: f64 = 1e9;

impl Loader<'_> {
    /// The scene's mesh for mesh `index` of the file in a pose; `None` if it has no triangles.
    pub(crate) fn mesh(
        &mut self,
        index: usize,
        from: &str,
        pose: &Pose,
    ) -> Result<Option<usize>, AssetError> {
        let key = (index, pose.key());
        if let Some(&known) = self.meshes.get(&key) {
            return Ok(known);
        }
        let json = self.entry("meshes", index, from)?;
        let mut primitives = Vec::new();
        let merged = self.merged_vertices(&json)?;
        let list = json.array("primitives")?;
        if list.is_empty() {
            self.invalid(json.pointer(), "has no primitives")?;
        }
        let mut known = HashSet::new();
        let mut read = Vec::new();
        for primitive in &list {
            if !known.insert(primitive.value().to_string()) && self.is_opaque(primitive)? {
                self.totals.repeated_primitives += 1;
                continue;
            }
            if let Some(found) = self.primitive(primitive, pose.is_skinned())? {
                self.spend(found.positions.len(), found.triangles.len(), primitive.pointer())?;
                read.push((found, primitive));
            }
        }
        let center = center_primitives(&mut read);
        let mut from = None;
        for (mut primitive, json) in read {
            self.morph(&mut primitive, json, pose)?;
            from = Some(self.skinned(&mut primitive, json, pose, center, from)?);
            if primitive.marks.is_some() {
                self.marks(&mut primitive, json)?;
                self.spend(primitive.positions.len(), primitive.triangles.len(), json.pointer())?;
            }
            if let Some(merged) = merged.as_ref().filter(|merged| manifold::agrees(&primitive, merged)) {
                let one = |i: u32| merged.get(&i).copied().unwrap_or(i);
                primitive.merged = primitive.triangles.iter().map(|t| t.map(one)).collect();
            }
            self.clean(&mut primitive, json);
            self.check_uv_sets(&primitive, json);
            primitives.push(primitive);
        }
        primitives.retain(|p| !p.triangles.is_empty());
        let mesh = if primitives.is_empty() {
            None
        } else {
            let materials = &self.scene.materials;
            primitives.par_iter_mut().for_each(|primitive| {
                let material = materials.get(primitive.material as usize);
                match material.and_then(MaterialDescription::tangent_uvs) {
                    Some((uv_set, transform)) => tangent::complete(primitive, uv_set, transform),
                    None => primitive.tangents.clear(),
                }
            });
            let mut mesh = merge(primitives);
            if merged.is_some() && mesh.merged.is_empty() {
                let pointer = format!("{}/extensions", json.pointer());
                self.warn(
                    &pointer,
                    "the mesh is not as manifold as it says; equal positions are merged",
                    None,
                );
            }
            mesh.name = json.name_or(|| format!("mesh {index}"));
            mesh.pointer = json.pointer().to_owned();
            self.scene.meshes.push(mesh);
            let place = self.scene.meshes.len() - 1;
            self.centers.extend(from.filter(|from| *from != DVec3::ZERO).map(|from| (place, from)));
            Some(place)
        };
        self.meshes.insert(key, mesh);
        Ok(mesh)
    }

    /// Whether no light passes a primitive: then repetitions of it cannot be seen.
    fn is_opaque(&mut self, primitive: &Json<'_>) -> Result<bool, AssetError> {
        let index = self.alternative(primitive)?.or(primitive.usize("material")?);
        let material = index.and_then(|index| self.scene.materials.get(index));
        Ok(material.is_none_or(MaterialDescription::is_opaque))
    }

    /// Removes what cannot be drawn, and makes normals and tangents unit vectors.
    fn clean(&mut self, primitive: &mut Primitive, json: &Json<'_>) {
        let usable = |p: &Vec3| f64::from(p.abs().max_element()) <= FARTHEST && p.is_finite();
        let before = primitive.triangles.len();
        let positions = &primitive.positions;
        retain(&mut primitive.triangles, &mut primitive.merged, |t| {
            t.iter().all(|&i| usable(&positions[i as usize]))
        });
        let lost = before - primitive.triangles.len();
        for p in primitive.positions.iter_mut().filter(|p| !usable(p)) {
            *p = Vec3::ZERO;
        }
        if lost > 0 {
            let has = if lost == 1 { "has" } else { "have" };
            let message = format!(
                "{lost} of {} {has} a corner that is no number or beyond {FARTHEST:e} m",
                count(before, "triangle", "triangles")
            );
            self.warn(json.pointer(), message, None);
        }
        let positions = &primitive.positions;
        let before = primitive.triangles.len();
        retain(&mut primitive.triangles, &mut primitive.merged, |t| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            a != b && b != c && c != a
        });
        self.totals.collapsed += before - primitive.triangles.len();
        if !primitive.normals.is_empty() {
            let bad = normalize(primitive);
            if bad > 0 {
                let has = if bad == 1 { "has" } else { "have" };
                let normals = count(primitive.normals.len(), "normal", "normals");
                let message = format!("{bad} of {normals} {has} no direction");
                self.warn(&format!("{}/NORMAL", json.pointer_to("attributes")), message, None);
            }
        }
        if primitive.morphed_colors {
            let shown = |c: Vec4| if c.is_finite() { c.clamp(Vec4::ZERO, Vec4::ONE) } else { Vec4::ONE };
            primitive.colors.iter_mut().for_each(|c| *c = shown(*c));
        }
        for uv in primitive.uvs.iter_mut().flatten().filter(|uv| !uv.is_finite()) {
            *uv = Vec2::ZERO;
        }
    }

    fn check_uv_sets(&mut self, primitive: &Primitive, json: &Json<'_>) {
        let Some(material) = self.scene.materials.get(primitive.material as usize) else { return };
        let sets = primitive.uvs.len();
        let Some(missing) = material.textures().map(|t| t.uv_set).filter(|&set| set >= sets).max() else {
            return;
        };
        let message =
            format!("a texture of {} uses TEXCOORD_{missing}, which is not there", material.pointer);
        self.warn(&json.pointer_to("attributes"), message, Some("its coordinates are taken to be (0, 0)"));
    }
}

/// Moves the primitives of a mesh to the origin, if they are far from it: the returned vector is subtracted.
fn center_primitives(primitives: &mut [(Primitive, &Json<'_>)]) -> DVec3 {
    let boxes = primitives.iter().filter_map(|(primitive, _)| {
        let Primitive { positions, triangles, marks, .. } = primitive;
        match marks {
            None => bounds::bounds_of(positions, triangles),
            Some((_, indices)) => {
                let points = indices.iter().map(|&i| positions[i as usize]).filter(|p| p.is_finite());
                points.map(|p| [p; 2]).reduce(bounds::union)
            }
        }
    });
    let Some(all) = boxes.reduce(bounds::union) else { return DVec3::ZERO };
    // Rounded to what positions are in: then no corner of the box is rounded (Sterbenz's lemma).
    let center = rebase::far_center(all.into_iter().map(|p| p.as_dvec3())).as_vec3();
    if center != Vec3::ZERO {
        let positions = primitives.iter_mut().flat_map(|(primitive, _)| &mut primitive.positions);
        positions.for_each(|p| *p -= center);
    }
    center.as_dvec3()
}

/// Keeps the triangles for which something holds, and what belongs to them.
fn retain(triangles: &mut Vec<[u32; 3]>, beside: &mut Vec<[u32; 3]>, keep: impl Fn(&[u32; 3]) -> bool) {
    if !beside.is_empty() {
        let mut kept = triangles.iter().map(&keep);
        beside.retain(|_| kept.next().unwrap_or(false));
    }
    triangles.retain(keep);
}

/// Unit normals and tangents; a normal without direction becomes that of a triangle around it. Returns their number.
fn normalize(primitive: &mut Primitive) -> usize {
    let unit = |v: Vec3| v.as_dvec3().try_normalize().map(|v| v.as_vec3());
    let mut bad: Vec<usize> = Vec::new();
    for (i, normal) in primitive.normals.iter_mut().enumerate() {
        match unit(*normal) {
            Some(n) => *normal = n,
            None => {
                *normal = Vec3::ZERO;
                bad.push(i);
            }
        }
    }
    if !bad.is_empty() {
        for triangle in &primitive.triangles {
            let normal = face_normal(triangle.map(|i| primitive.positions[i as usize]));
            for &i in triangle {
                if primitive.normals[i as usize] == Vec3::ZERO {
                    primitive.normals[i as usize] = normal;
                }
            }
        }
        for &i in &bad {
            if primitive.normals[i] == Vec3::ZERO {
                primitive.normals[i] = Vec3::Y;
            }
        }
    }
    for tangent in &mut primitive.tangents {
        let sign = if tangent.w < 0.0 { -1.0 } else { 1.0 };
        *tangent = unit(tangent.truncate()).unwrap_or(Vec3::X).extend(sign);
    }
    bad.len()
}

/// Unit normal of a triangle; +Y for one without area.
pub(crate) fn face_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a).try_normalize().map_or(Vec3::Y, |n| n.as_vec3())
}

/// Gives every triangle its own three vertices.
pub(crate) fn unshare(primitive: &mut Primitive) {
    fn spread<T: Copy>(values: &mut Vec<T>, corners: &[u32]) {
        if !values.is_empty() {
            *values = corners.iter().map(|&i| values[i as usize]).collect();
        }
    }
    let corners: Vec<u32> = primitive.triangles.iter().flatten().copied().collect();
    spread(&mut primitive.positions, &corners);
    spread(&mut primitive.normals, &corners);
    spread(&mut primitive.tangents, &corners);
    spread(&mut primitive.colors, &corners);
    for set in &mut primitive.uvs {
        spread(set, &corners);
    }
    for (i, triangle) in primitive.triangles.iter_mut().enumerate() {
        let first = 3 * i as u32;
        *triangle = [first, first + 1, first + 2];
    }
}

/// Flat normals, on vertices that belong to one triangle each.
pub(crate) fn flatten(primitive: &mut Primitive) {
    unshare(primitive);
    primitive.normals.clear();
    for triangle in &primitive.triangles {
        let normal = face_normal(triangle.map(|i| primitive.positions[i as usize]));
        primitive.normals.extend([normal; 3]);
    }
}

/// One mesh out of several primitives; an attribute that some lack is filled up with neutral values.
fn merge(mut primitives: Vec<Primitive>) -> MeshDescription {
    if primitives.iter().any(|p| !p.normals.is_empty()) {
        for primitive in primitives.iter_mut().filter(|p| p.normals.is_empty()) {
            flatten(primitive);
        }
    }
    let has_tangents = primitives.iter().any(|p| !p.tangents.is_empty());
    let has_colors = primitives.iter().any(|p| !p.colors.is_empty());
    let uv_sets = primitives.iter().map(|p| p.uvs.len()).max().unwrap_or(0);
    let mut mesh = MeshDescription { uvs: vec![Vec::new(); uv_sets], ..MeshDescription::default() };
    if primitives.iter().all(|p| p.merged.len() == p.triangles.len())
        && manifold::is_manifold(primitives.iter().flat_map(|p| p.merged.iter().copied()))
    {
        mesh.merged = primitives.iter_mut().flat_map(|p| std::mem::take(&mut p.merged)).collect();
    }
    for mut primitive in primitives {
        let count = primitive.positions.len();
        let first = mesh.positions.len() as u32;
        mesh.triangles.extend(primitive.triangles.iter().map(|t| t.map(|i| i + first)));
        mesh.triangle_materials.extend(std::iter::repeat_n(primitive.material, primitive.triangles.len()));
        mesh.positions.append(&mut primitive.positions);
        mesh.normals.append(&mut primitive.normals);
        if has_tangents {
            primitive.tangents.resize(count, Vec4::new(1.0, 0.0, 0.0, 1.0));
            mesh.tangents.append(&mut primitive.tangents);
        }
        if has_colors {
            primitive.colors.resize(count, Vec4::ONE);
            mesh.colors.append(&mut primitive.colors);
        }
        primitive.uvs.resize(uv_sets, Vec::new());
        for (all, mut set) in mesh.uvs.iter_mut().zip(primitive.uvs) {
            set.resize(count, Vec2::ZERO);
            all.append(&mut set);
        }
    }
    mesh
}
