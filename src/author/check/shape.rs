//! Whether the meshes that hold media are closed, which way they face, and what their parts do with each other.

use super::contact::Contacts;
use super::finding;
use super::triangles::Triangle;
use crate::asset::{Diagnostic, Severity};
use crate::author::nephrite::NAME;
use crate::geometry::{Component, NO_COMPONENT};
use crate::scene::{Analysed, InstanceDescription, MeshDescription, SceneDescription};
use serde_json::Value;
use std::collections::HashMap;

/// A body with a medium, for [`super::overlap`].
pub(super) struct Solid {
    pub instance: usize,
    pub priority: i32,
    pub closed: bool,
}

/// What is known of the meshes that hold media, by their indices.
pub(super) type Shapes<'a> = HashMap<usize, Analysed<'a>>;

/// Checks every mesh that holds a medium once, at the first node that shows it; all bodies with a medium. Our extension
/// must be on closed meshes only, so an open one is an error there.
pub(super) fn check<'a>(
    document: &Value,
    scene: &'a SceneDescription,
    found: &mut Vec<Diagnostic>,
) -> (Vec<Solid>, Shapes<'a>) {
    let mut shapes = Shapes::new();
    let mut solids = Vec::new();
    for (i, instance) in scene.instances.iter().enumerate() {
        let Some(mesh) = scene.meshes.get(instance.mesh) else { continue };
        let medium = |m: &u32| scene.materials.get(*m as usize)?.medium.as_ref().map(|medium| (*m, medium));
        let Some((material, medium)) = mesh.triangle_materials.iter().find_map(medium) else { continue };
        let must_be_closed = document.pointer(&format!("/materials/{material}/extensions/{NAME}")).is_some();
        let shape = shapes.entry(instance.mesh).or_insert_with(|| {
            let shape = scene.analyse(instance.mesh);
            tell_open(scene, instance, &shape, must_be_closed, found);
            tell_parts(mesh, &shape, found);
            shape
        });
        let parts = &shape.topology.components;
        let closed = !parts.is_empty() && parts.iter().all(|part| part.closable);
        solids.push(Solid { instance: i, priority: medium.priority, closed });
    }
    (solids, shapes)
}

/// “1 edge”, “2 edges”.
fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// “1 of 2 parts is”, “2 of 2 parts are”, given both verbs.
fn of_parts(n: usize, all: usize, [does, do_]: [&str; 2]) -> String {
    format!("{n} of {} {}", count(all, "part", "parts"), if n == 1 { does } else { do_ })
}

fn tell_open(
    scene: &SceneDescription,
    instance: &InstanceDescription,
    shape: &Analysed<'_>,
    must_be_closed: bool,
    found: &mut Vec<Diagnostic>,
) {
    let parts = &shape.topology.components;
    let open: Vec<_> = parts.iter().filter(|part| !part.closable).collect();
    if open.is_empty() {
        return;
    }
    let sum = |of: fn(&Component) -> usize| open.iter().map(|part| of(part)).sum::<usize>();
    let kinds = [
        (sum(|p| p.open_edges), "of one triangle", "of one triangle"),
        (sum(|p| p.non_manifold_edges), "of three or more triangles", "of three or more triangles"),
        (
            sum(|p| p.inconsistent_edges),
            "whose triangles face different ways",
            "whose triangles face different ways",
        ),
    ];
    let kinds: Vec<String> = kinds
        .iter()
        .filter(|k| k.0 > 0)
        .map(|&(n, kind, kinds)| count(n, &format!("edge {kind}"), &format!("edges {kinds}")))
        .collect();
    let place = open.iter().flat_map(|part| &part.leaks).next();
    let place = place.map(|&p| (instance.transform.transform_point3(p).as_dvec3() + scene.origin).as_vec3());
    let place = place.map_or(String::new(), |p| format!(", such as at ({}, {}, {})", p.x, p.y, p.z));
    found.push(finding(
        if must_be_closed { Severity::Error } else { Severity::Warning },
        &*scene.meshes[instance.mesh].pointer,
        format!(
            "a medium needs a closed mesh, and {} open: {}{place}",
            of_parts(open.len(), parts.len(), ["is", "are"]),
            kinds.join(", ")
        ),
        Some("close the holes and merge the vertices by distance in the program the mesh is from"),
    ));
}

/// Parts that face inwards, cross themselves or others, share faces, or are there twice.
fn tell_parts(mesh: &MeshDescription, shape: &Analysed<'_>, found: &mut Vec<Diagnostic>) {
    let parts = &shape.topology.components;
    let mut tell = |severity, n: usize, verbs, rest: &str, advice| {
        if n > 0 {
            let message = format!("{}{rest}", of_parts(n, parts.len(), verbs));
            found.push(finding(severity, &*mesh.pointer, message, advice));
        }
    };
    let inside_out = parts.iter().filter(|part| part.inside_out).count();
    let (turned, other) = if inside_out == 1 { ("it is turned", "it") } else { ("they are turned", "them") };
    tell(
        Severity::Warning,
        inside_out,
        ["is", "are"],
        &format!(" inside out; {turned} here, but other viewers may not turn {other}"),
        Some("recalculate the normals to the outside in the program the mesh is from"),
    );
    tell(
        Severity::Warning,
        repeated(mesh, shape),
        ["is", "are"],
        " in the very place of an equal one, which changes nothing here, but may elsewhere",
        Some("merge the vertices by distance, or delete what is there twice"),
    );
    let contacts = Contacts::new(&triangles(mesh, shape));
    tell(
        Severity::Warning,
        contacts.crossing_themselves(),
        ["crosses itself", "cross themselves"],
        "; what is inside follows from the winding number here, and may be otherwise elsewhere",
        Some("look for faces that intersect in the program the mesh is from"),
    );
    tell(
        Severity::Warning,
        contacts.with_others(|contact| contact.cross),
        ["crosses others", "cross each other"],
        "; what is inside of any is filled once",
        Some("unite the parts (boolean union) in the program the mesh is from"),
    );
    tell(
        Severity::Note,
        contacts.with_others(|contact| contact.touch && !contact.cross),
        ["shares faces with others", "share faces with each other"],
        ", inside of which light goes on",
        None,
    );
    if !contacts.complete {
        let message = "the mesh is too detailed to look for all parts that touch or cross";
        found.push(finding(Severity::Note, &*mesh.pointer, message, None));
    }
}

/// The triangles of closed parts, which are the bodies; fronts are outside.
fn triangles(mesh: &MeshDescription, shape: &Analysed<'_>) -> Vec<Triangle> {
    let topology = &shape.topology;
    let parts = mesh.triangles.iter().zip(&topology.component_of).zip(&topology.flips);
    let closed = parts.filter(|((_, part), _)| {
        topology.components.get(**part as usize).is_some_and(|component| component.closable)
    });
    closed
        .map(|((t, &body), &flip)| {
            let [a, b, c] = t.map(|i| shape.positions[i as usize].as_dvec3());
            Triangle { corners: if flip { [a, c, b] } else { [a, b, c] }, body }
        })
        .collect()
}

/// How many parts are there more than once, triangle by triangle.
fn repeated(mesh: &MeshDescription, shape: &Analysed<'_>) -> usize {
    let topology = &shape.topology;
    if !topology.component_of.contains(&NO_COMPONENT) {
        return 0;
    }
    let key = |t: &[u32; 3]| {
        let corners = t.map(|i| (shape.positions[i as usize] + 0.0).to_array().map(f32::to_bits));
        let first = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
        [0, 1, 2].map(|i| corners[(first + i) % 3])
    };
    let all = || mesh.triangles.iter().zip(&topology.component_of);
    let of: HashMap<_, u32> = all().filter(|(_, c)| **c != NO_COMPONENT).map(|(t, &c)| (key(t), c)).collect();
    let mut again = vec![0; topology.components.len()];
    for (t, _) in all().filter(|(_, c)| **c == NO_COMPONENT) {
        of.get(&key(t)).into_iter().for_each(|&c| again[c as usize] += 1);
    }
    topology.components.iter().zip(again).filter(|(part, again)| *again >= part.triangles).count()
}
