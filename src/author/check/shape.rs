//! Whether the meshes that hold media are closed, and which way they face.

use super::finding;
use crate::asset::{Diagnostic, Severity};
use crate::author::nephrite::NAME;
use crate::geometry::{MeshGeometry, Topology};
use crate::scene::{InstanceDescription, SceneDescription};
use serde_json::Value;
use std::collections::HashMap;

/// A body with a medium, for [`super::overlap`].
pub(super) struct Solid {
    pub instance: usize,
    pub priority: i32,
    pub closed: bool,
}

/// Checks every mesh that holds a medium once, at the first node that shows it; all bodies with a medium. Our extension
/// must be on closed meshes only, so an open one is an error there.
pub(super) fn check(document: &Value, scene: &SceneDescription, found: &mut Vec<Diagnostic>) -> Vec<Solid> {
    let mut closed: HashMap<usize, bool> = HashMap::new();
    let mut solids = Vec::new();
    for (i, instance) in scene.instances.iter().enumerate() {
        let Some(mesh) = scene.meshes.get(instance.mesh) else { continue };
        let medium = |m: &u32| scene.materials.get(*m as usize)?.medium.as_ref().map(|medium| (*m, medium));
        let Some((material, medium)) = mesh.triangle_materials.iter().find_map(medium) else { continue };
        let must_be_closed = document.pointer(&format!("/materials/{material}/extensions/{NAME}")).is_some();
        let closed = *closed.entry(instance.mesh).or_insert_with(|| {
            let topology = Topology::analyse(&MeshGeometry::build(&mesh.positions, &mesh.triangles));
            tell(instance, &mesh.pointer, &topology, must_be_closed, found);
            !topology.components.is_empty() && topology.components.iter().all(|part| part.closable)
        });
        solids.push(Solid { instance: i, priority: medium.priority, closed });
    }
    solids
}

fn tell(
    instance: &InstanceDescription,
    pointer: &str,
    topology: &Topology,
    must_be_closed: bool,
    found: &mut Vec<Diagnostic>,
) {
    let parts = &topology.components;
    let open: Vec<_> = parts.iter().filter(|part| !part.closable).collect();
    if !open.is_empty() {
        let sum = |count: fn(&crate::geometry::Component) -> usize| {
            open.iter().map(|part| count(part)).sum::<usize>()
        };
        let kinds = [
            (sum(|p| p.open_edges), "edges of one triangle"),
            (sum(|p| p.non_manifold_edges), "edges of three or more triangles"),
            (sum(|p| p.inconsistent_edges), "edges whose triangles face different ways"),
        ];
        let kinds: Vec<String> =
            kinds.iter().filter(|k| k.0 > 0).map(|(n, kind)| format!("{n} {kind}")).collect();
        let place = open.iter().flat_map(|part| &part.leaks).next();
        let place = place.map(|&p| instance.transform.transform_point3(p));
        let place = place.map_or(String::new(), |p| format!(", such as at ({}, {}, {})", p.x, p.y, p.z));
        found.push(finding(
            if must_be_closed { Severity::Error } else { Severity::Warning },
            pointer,
            format!(
                "a medium needs a closed mesh, and {} of {} parts are open: {}{place}",
                open.len(),
                parts.len(),
                kinds.join(", ")
            ),
            Some("close the holes and merge the vertices by distance in the program the mesh is from"),
        ));
    }
    let inside_out = parts.iter().filter(|part| part.inside_out).count();
    if inside_out > 0 {
        found.push(finding(
            Severity::Warning,
            pointer,
            format!(
                "{inside_out} of {} parts are inside out; they are turned here, but other viewers may not",
                parts.len()
            ),
            Some("recalculate the normals to the outside in the program the mesh is from"),
        ));
    }
}
