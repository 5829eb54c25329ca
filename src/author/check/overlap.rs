//! Bodies with media that meet: those that overlap and do not say which of them fills the overlap, those that share faces,
//! and those that are there twice.

use super::contact::Contacts;
use super::finding;
use super::shape::{Shapes, Solid};
use super::triangles::Triangle;
use crate::asset::{Diagnostic, Severity};
use crate::geometry::{MeshGeometry, NO_COMPONENT};
use crate::scene::{Analysed, InstanceDescription, SceneDescription};
use glam::Vec3;
use std::collections::{BTreeSet, HashMap};

/// Vertices of a body that are looked for in another, at most, and pairs of bodies.
const MOST_VERTICES: usize = 256;
const MOST_PAIRS: usize = 4096;
/// Distances below this part of a body's size are roundings.
const ROUNDING: f32 = 16.0 * f32::EPSILON;

type Pair = [usize; 2];

pub(super) fn check(
    scene: &SceneDescription,
    solids: &[Solid],
    shapes: &Shapes<'_>,
    found: &mut Vec<Diagnostic>,
) {
    let (pairs, mut complete) = near(scene, solids);
    let contacts = Contacts::new(&triangles(scene, solids, shapes, &pairs));
    complete &= contacts.complete;
    let of = |pair: Pair| contacts.between(pair[0] as u32, pair[1] as u32);
    let (twice, apart): (Vec<Pair>, Vec<Pair>) =
        pairs.iter().copied().partition(|&[a, b]| contacts.are_one(a as u32, b as u32));
    tell_twice(scene, solids, &twice, found);
    let mut meshes: HashMap<usize, MeshGeometry> = HashMap::new();
    for &pair in apart.iter().filter(|[a, b]| solids[*a].priority == solids[*b].priority) {
        if of(pair).cross {
            tell_overlap(scene, pair.map(|i| &solids[i]), found);
        } else {
            tell_inside(scene, pair.map(|i| &solids[i]), &mut meshes, found);
        }
    }
    let touching: Vec<Pair> = apart.into_iter().filter(|&pair| of(pair).touch && !of(pair).cross).collect();
    tell_touching(scene, solids, &touching, found);
    if !complete {
        let message = "the bodies are too many or too detailed to look for all that touch or cross";
        found.push(finding(Severity::Note, "/nodes", message, None));
    }
}

/// Pairs of closed bodies whose boxes touch, and whether these are all.
fn near(scene: &SceneDescription, solids: &[Solid]) -> (Vec<Pair>, bool) {
    let boxes: Vec<[Vec3; 2]> = solids.iter().map(|solid| bounds(scene, solid)).collect();
    let mut pairs = Vec::new();
    // Sorted by their left sides, only neighbours can touch.
    let mut order: Vec<usize> = (0..solids.len()).filter(|&i| solids[i].closed).collect();
    order.sort_by(|&a, &b| boxes[a][0].x.total_cmp(&boxes[b][0].x).then(a.cmp(&b)));
    for (k, &a) in order.iter().enumerate() {
        for &b in order[k + 1..].iter().take_while(|&&b| boxes[b][0].x <= boxes[a][1].x) {
            if boxes[a][0].cmple(boxes[b][1]).all() && boxes[b][0].cmple(boxes[a][1]).all() {
                if pairs.len() == MOST_PAIRS {
                    return (pairs, false);
                }
                pairs.push([a.min(b), a.max(b)]);
            }
        }
    }
    pairs.sort_unstable();
    (pairs, true)
}

/// The triangles of the bodies of pairs, in the world.
fn triangles(
    scene: &SceneDescription,
    solids: &[Solid],
    shapes: &Shapes<'_>,
    pairs: &[Pair],
) -> Vec<Triangle> {
    let bodies: BTreeSet<usize> = pairs.iter().flatten().copied().collect();
    let of_body = |body: usize| {
        let instance = instance(scene, &solids[body]);
        let shape = shapes.get(&instance.mesh);
        let mirrored = instance.transform.matrix3.determinant() < 0.0;
        let placed = move |shape: &Analysed<'_>, t: &[u32; 3], flip: bool| {
            let corner = |i: u32| instance.transform.transform_point3(shape.positions[i as usize]).as_dvec3();
            let [a, b, c] = t.map(corner);
            Triangle { corners: if flip { [a, c, b] } else { [a, b, c] }, body: body as u32 }
        };
        let of_shape = move |shape: &Analysed<'_>| -> Vec<Triangle> {
            let all = scene.meshes[instance.mesh].triangles.iter().zip(&shape.topology.flips);
            let used = all.zip(&shape.topology.component_of).filter(|(_, part)| **part != NO_COMPONENT);
            used.map(|((t, &flip), _)| placed(shape, t, flip != mirrored)).collect()
        };
        shape.map(of_shape).unwrap_or_default()
    };
    bodies.into_iter().flat_map(of_body).collect()
}

fn instance<'a>(scene: &'a SceneDescription, solid: &Solid) -> &'a InstanceDescription {
    &scene.instances[solid.instance]
}

fn tell_overlap(scene: &SceneDescription, pair: [&Solid; 2], found: &mut Vec<Diagnostic>) {
    let [a, b] = pair.map(|solid| instance(scene, solid));
    tell_pair(Severity::Warning, a, &format!("overlaps {:?} ({})", b.name, b.pointer), found);
}

/// Bodies whose surfaces do not cross: one may be inside the other.
fn tell_inside(
    scene: &SceneDescription,
    pair: [&Solid; 2],
    meshes: &mut HashMap<usize, MeshGeometry>,
    found: &mut Vec<Diagnostic>,
) {
    let [a, b] = pair.map(|solid| instance(scene, solid));
    for (inner, outer) in [(a, b), (b, a)] {
        let geometry = meshes.entry(outer.mesh).or_insert_with(|| {
            let mesh = &scene.meshes[outer.mesh];
            MeshGeometry::build(&mesh.positions, &mesh.triangles)
        });
        let rounding = ROUNDING * geometry.bounds().max.abs().max(geometry.bounds().min.abs()).max_element();
        let to_outer = outer.transform.inverse() * inner.transform;
        let positions = scene.meshes[inner.mesh].seen_positions();
        let chosen = positions.iter().step_by(positions.len().div_ceil(MOST_VERTICES).max(1));
        let (mut inside, mut all) = (0usize, 0usize);
        // What lies on the surface of the other is on no side of it.
        for p in chosen.map(|&p| to_outer.transform_point3(p)) {
            if geometry.nearest(p, rounding).is_none() {
                all += 1;
                inside += usize::from(geometry.contains(p));
            }
        }
        if inside > 0 {
            let (severity, does) =
                if inside == all { (Severity::Note, "is inside") } else { (Severity::Warning, "overlaps") };
            return tell_pair(
                severity,
                inner,
                &format!("{does} {:?} ({})", outer.name, outer.pointer),
                found,
            );
        }
    }
}

fn tell_pair(severity: Severity, at: &InstanceDescription, does: &str, found: &mut Vec<Diagnostic>) {
    found.push(finding(
        severity,
        &*at.pointer,
        format!("{:?} {does} and has the same priority: the smaller volume fills the overlap", at.name),
        Some(
            "give the material of the body that should win a higher `priority` (`nephrite edit --priority`)",
        ),
    ));
}

/// How many bodies are in pairs, and one of the pairs.
fn counted(scene: &SceneDescription, solids: &[Solid], pairs: &[Pair]) -> Option<(usize, String, String)> {
    let first = pairs.first()?;
    let bodies = pairs.iter().flatten().collect::<BTreeSet<_>>().len();
    let [a, b] = first.map(|i| instance(scene, &solids[i]));
    let such = if pairs.len() > 1 { "such as " } else { "" };
    let example = format!("{such}{:?} ({}) and {:?} ({})", a.name, a.pointer, b.name, b.pointer);
    Some((bodies, example, a.pointer.clone()))
}

fn tell_touching(scene: &SceneDescription, solids: &[Solid], pairs: &[Pair], found: &mut Vec<Diagnostic>) {
    let Some((bodies, example, pointer)) = counted(scene, solids, pairs) else { return };
    let message =
        format!("{bodies} bodies touch: {example} share faces, where light goes from one into the other");
    found.push(finding(Severity::Note, pointer, message, None));
}

fn tell_twice(scene: &SceneDescription, solids: &[Solid], pairs: &[Pair], found: &mut Vec<Diagnostic>) {
    let Some((bodies, example, pointer)) = counted(scene, solids, pairs) else { return };
    let message = format!("{bodies} bodies are in the very place of equal ones: {example}");
    let advice = Some("leave one of them; what they fill is filled once");
    found.push(finding(Severity::Warning, pointer, message, advice));
}

fn bounds(scene: &SceneDescription, solid: &Solid) -> [Vec3; 2] {
    let instance = instance(scene, solid);
    let [low, high] = scene.meshes[instance.mesh].bounds();
    let corner = |i: usize| Vec3::new([low, high][i & 1].x, [low, high][i >> 1 & 1].y, [low, high][i >> 2].z);
    let [low, high] = (0..8)
        .map(|i| instance.transform.transform_point3(corner(i)))
        .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)]);
    let rounding = ROUNDING * low.abs().max(high.abs()).max_element();
    [low - rounding, high + rounding]
}
