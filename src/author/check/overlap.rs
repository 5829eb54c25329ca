//! Bodies with media that overlap and do not say which of them fills the overlap.
//!
//! Vertices of one body are looked for in the other. Bodies that cross without a vertex of one in the other (two rods) are
//! not found.

use super::finding;
use super::shape::Solid;
use crate::asset::{Diagnostic, Severity};
use crate::geometry::MeshGeometry;
use crate::scene::SceneDescription;
use glam::Vec3;
use std::collections::HashMap;

/// Vertices of a body that are looked for, at most, and pairs of bodies.
const MOST_VERTICES: usize = 256;
const MOST_PAIRS: usize = 256;

pub(super) fn check(scene: &SceneDescription, solids: &[Solid], found: &mut Vec<Diagnostic>) {
    let boxes: Vec<[Vec3; 2]> = solids.iter().map(|solid| bounds(scene, solid)).collect();
    let mut meshes: HashMap<usize, MeshGeometry> = HashMap::new();
    let mut pairs = 0;
    // Sorted by their left sides, only neighbours can touch.
    let mut order: Vec<usize> = (0..solids.len()).filter(|&i| solids[i].closed).collect();
    order.sort_by(|&a, &b| boxes[a][0].x.total_cmp(&boxes[b][0].x));
    for (k, &a) in order.iter().enumerate() {
        for &b in order[k + 1..].iter().take_while(|&&b| boxes[b][0].x <= boxes[a][1].x) {
            let touch = boxes[a][0].cmple(boxes[b][1]).all() && boxes[b][0].cmple(boxes[a][1]).all();
            if !touch || solids[a].priority != solids[b].priority {
                continue;
            }
            pairs += 1;
            if pairs > MOST_PAIRS {
                return;
            }
            for solid in [a, b] {
                let mesh = scene.instances[solids[solid].instance].mesh;
                meshes.entry(mesh).or_insert_with(|| {
                    let mesh = &scene.meshes[mesh];
                    MeshGeometry::build(&mesh.positions, &mesh.triangles)
                });
            }
            tell(scene, [&solids[a], &solids[b]], &meshes, found);
        }
    }
}

fn tell(
    scene: &SceneDescription,
    pair: [&Solid; 2],
    meshes: &HashMap<usize, MeshGeometry>,
    found: &mut Vec<Diagnostic>,
) {
    let share = |of: &Solid, within: &Solid| {
        let [from, to] = [of, within].map(|solid| &scene.instances[solid.instance]);
        let positions = &scene.meshes[from.mesh].positions;
        let to_mesh = to.transform.inverse() * from.transform;
        let chosen = positions.iter().step_by(positions.len().div_ceil(MOST_VERTICES).max(1));
        let (mut inside, mut all) = (0usize, 0usize);
        for &p in chosen {
            all += 1;
            inside += usize::from(meshes[&to.mesh].contains(to_mesh.transform_point3(p)));
        }
        (inside, all)
    };
    let shares = [share(pair[0], pair[1]), share(pair[1], pair[0])];
    let [a, b] = pair.map(|solid| &scene.instances[solid.instance]);
    if shares.iter().all(|(inside, _)| *inside == 0) {
        return;
    }
    let (severity, at, message) = match shares.map(|(inside, all)| inside == all) {
        [true, _] => (Severity::Note, a, format!("is inside {:?} ({})", b.name, b.pointer)),
        [_, true] => (Severity::Note, b, format!("is inside {:?} ({})", a.name, a.pointer)),
        _ => (Severity::Warning, a, format!("overlaps {:?} ({})", b.name, b.pointer)),
    };
    found.push(finding(
        severity,
        &*at.pointer,
        format!("{:?} {message} and has the same priority: the smaller volume fills the overlap", at.name),
        Some(
            "give the material of the body that should win a higher `priority` (`nephrite edit --priority`)",
        ),
    ));
}

fn bounds(scene: &SceneDescription, solid: &Solid) -> [Vec3; 2] {
    let instance = &scene.instances[solid.instance];
    let [low, high] = scene.meshes[instance.mesh].bounds();
    let corner = |i: usize| Vec3::new([low, high][i & 1].x, [low, high][i >> 1 & 1].y, [low, high][i >> 2].z);
    (0..8)
        .map(|i| instance.transform.transform_point3(corner(i)))
        .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}
