//! Is a mesh the boundary of a solid, and which way does it face?
//!
//! Positions that are equal to the bit become one vertex (files split vertices at seams; [`super::close_seams`] makes
//! those equal that differ by roundings), and triangles that share an edge one component; where several solids touch in
//! an edge, each keeps its own two triangles. A component is closed if as many triangles run along each edge in one
//! direction as in the other: then winding numbers are whole, and do not depend on the way. Its orientation follows from
//! the sign of its volume (the divergence theorem, one tetrahedron a triangle) and from nesting: a component inside
//! another one may face inwards, as a cavity does, but where the outermost is inside out, all that it holds is taken to
//! be so too.
//!
//! Triangles with two equal corners and repetitions of a triangle are ignored. Triangles without area are not: they
//! may join edges.

use super::edges::{
    EdgeUse, distinct_triangles, edge_uses, first_corners, is_balanced, merged_vertices, same_edge,
};
use super::mesh::MeshGeometry;
use super::nesting::Solids;
use super::oriented_sets::OrientedSets;
use super::ray::Aabb;
use super::wedges::{Side, wedges};
use glam::{DVec3, Vec3};
use std::collections::HashSet;

/// The component of a triangle that belongs to none: dropped, with equal corners, or a repetition.
pub const NO_COMPONENT: u32 = u32::MAX;

/// Triangles of a component that are looked for in others, at most.
const MOST_SAMPLES: usize = 16;

/// Sample positions kept for messages.
const LEAK_SAMPLES: usize = 4;

/// Triangles that are connected through edges.
#[derive(Clone, Debug)]
pub struct Component {
    /// Number of triangles.
    pub triangles: usize,
    /// Edges of one triangle.
    pub open_edges: usize,
    /// Edges of three or more triangles.
    pub non_manifold_edges: usize,
    /// Edges of two triangles that run along it in the same direction.
    pub inconsistent_edges: usize,
    /// Whether it has an inside: as many triangles run along every edge in one direction as in the other. Mostly that is
    /// one each.
    pub closed: bool,
    /// Closed only because repetitions of triangles count.
    pub repeated: bool,
    /// Closed, or would be once [`Topology::flips`] has been applied.
    pub closable: bool,
    /// Enclosed volume in cubic units of the mesh's space, positive where fronts are outside; exact only if closed.
    pub signed_volume: f64,
    /// Fronts face the material: the volume is negative, and this is not a cavity in another component.
    pub inside_out: bool,
    /// The closest component around this one, if any.
    pub inside_of: Option<usize>,
    /// Middles of a few edges that keep it from being closed.
    pub leaks: Vec<Vec3>,
}

/// What [`Topology::analyse`] finds.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Connected parts, in the order of their first triangles.
    pub components: Vec<Component>,
    /// Component of each triangle, or [`NO_COMPONENT`].
    pub component_of: Vec<u32>,
    /// Whether a triangle must be turned over so that fronts face away from the material. Parts that are not closable
    /// are left alone.
    pub flips: Vec<bool>,
}

impl Topology {
    /// Analyses a mesh. Deterministic.
    pub fn analyse(mesh: &MeshGeometry) -> Self {
        Self::analyse_merged(mesh, &[])
    }

    /// As [`Self::analyse`], where it is known which vertices are one: `merged` has the vertices of each triangle, by any
    /// numbers. If it is not as long as there are triangles, equal positions are merged.
    pub fn analyse_merged(mesh: &MeshGeometry, merged: &[[u32; 3]]) -> Self {
        let (positions, triangles) = mesh.indexed();
        let vertices = if merged.len() == mesh.triangle_count() {
            first_corners(merged)
        } else {
            merged_vertices(positions, triangles)
        };
        let used = distinct_triangles(&vertices);
        let edges = edge_uses(&vertices, &used, mesh.is_reversed());
        let mut sets = OrientedSets::new(vertices.len());
        let mut solved = HashSet::new();
        let mut inverted = None;
        for edge in edges.chunk_by(same_edge) {
            if edge.len() > 3 {
                let inverted = *inverted.get_or_insert_with(|| is_inverted(mesh, &used));
                if let Some(pairs) = wedges_at(mesh, edge, inverted) {
                    pairs.into_iter().for_each(|[a, b]| sets.join(a, b, false));
                    solved.insert((edge[0].0, edge[0].1));
                    continue;
                }
            }
            for pair in edge.windows(2) {
                // Across another non-manifold edge there is no telling which sides belong together.
                let same_direction = edge.len() == 2 && pair[0].2 & 1 == pair[1].2 & 1;
                sets.join(pair[0].2 >> 1, pair[1].2 >> 1, same_direction);
            }
        }
        let mut topology = Self::components(mesh, &used, &mut sets);
        topology.count_edges(mesh, &edges, &solved);
        topology.count_repetitions(&vertices, &used, mesh.is_reversed());
        for (component, set) in
            topology.components.iter_mut().zip(&sets.contradictions_of(&topology.component_of))
        {
            let tight = component.open_edges == 0 && component.non_manifold_edges == 0;
            component.closable = component.closed || (tight && !set);
        }
        topology.orient(mesh, &mut sets);
        topology
    }

    /// Whether there is a component and all are closed.
    pub fn is_closed(&self) -> bool {
        !self.components.is_empty() && self.components.iter().all(|c| c.closed)
    }

    /// Whether there are edges of one triangle.
    pub fn has_open_edges(&self) -> bool {
        self.components.iter().any(|c| c.open_edges > 0)
    }

    /// Whether any triangle must be turned over.
    pub fn needs_flips(&self) -> bool {
        self.flips.contains(&true)
    }

    fn components(mesh: &MeshGeometry, used: &[bool], sets: &mut OrientedSets) -> Self {
        let mut component_of = vec![NO_COMPONENT; used.len()];
        let mut components = Vec::new();
        let mut of_root = vec![NO_COMPONENT; used.len()];
        let center = mesh.bounds().center().as_dvec3();
        for triangle in (0..used.len()).filter(|&t| used[t]) {
            let root = sets.find(triangle as u32).0 as usize;
            if of_root[root] == NO_COMPONENT {
                of_root[root] = components.len() as u32;
                components.push(Component {
                    triangles: 0,
                    open_edges: 0,
                    non_manifold_edges: 0,
                    inconsistent_edges: 0,
                    closed: true,
                    repeated: false,
                    closable: false,
                    signed_volume: 0.0,
                    inside_out: false,
                    inside_of: None,
                    leaks: Vec::new(),
                });
            }
            component_of[triangle] = of_root[root];
            let component = &mut components[of_root[root] as usize];
            component.triangles += 1;
            component.signed_volume += signed_volume(mesh, triangle, center);
        }
        Self { components, component_of, flips: vec![false; used.len()] }
    }

    fn count_edges(&mut self, mesh: &MeshGeometry, edges: &[EdgeUse], solved: &HashSet<(u32, u32)>) {
        for edge in edges.chunk_by(same_edge) {
            let triangle = edge[0].2 >> 1;
            let component = &mut self.components[self.component_of[triangle as usize] as usize];
            let solved = solved.contains(&(edge[0].0, edge[0].1));
            component.closed &= solved || is_balanced(edge);
            match edge {
                [_] => component.open_edges += 1,
                [a, b] if a.2 & 1 == b.2 & 1 => component.inconsistent_edges += 1,
                [_, _] => continue,
                _ if solved => continue,
                _ => component.non_manifold_edges += 1,
            }
            if component.leaks.len() < LEAK_SAMPLES {
                component.leaks.extend(edge_middle(mesh, edge));
            }
        }
    }

    /// Takes repetitions of triangles for what they are where a component has no inside without them: two bodies that
    /// share a face, one of them wound the other way.
    fn count_repetitions(&mut self, vertices: &[[u32; 3]], used: &[bool], reversed: bool) {
        let solid: Vec<bool> = vertices.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
        if solid == used {
            return;
        }
        let edges = edge_uses(vertices, &solid, reversed);
        let mut balanced = vec![true; self.components.len()];
        let mut twins = Vec::new();
        for edge in edges.chunk_by(same_edge) {
            let known = edge.iter().map(|use_| self.component_of[(use_.2 >> 1) as usize]);
            let Some(component) = known.clone().find(|&c| c != NO_COMPONENT) else { continue };
            balanced[component as usize] &= is_balanced(edge);
            let repeated = edge.iter().zip(known).filter(|(_, c)| *c == NO_COMPONENT);
            twins.extend(repeated.map(|(use_, _)| (use_.2 >> 1, component)));
        }
        for (triangle, component) in twins {
            let whole = &mut self.components[component as usize];
            if balanced[component as usize] && (!whole.closed || whole.repeated) {
                whole.closed = true;
                whole.repeated = true;
                self.component_of[triangle as usize] = component;
            }
        }
    }

    /// Sets `inside_out`, `inside_of` and `flips`.
    fn orient(&mut self, mesh: &MeshGeometry, sets: &mut OrientedSets) {
        let count = self.components.len();
        // Relative to the majority of its triangles, which are turned over, and the volume once they are.
        let mut turned = vec![0_usize; count];
        let mut boxes = vec![Aabb::EMPTY; count];
        let mut samples: Vec<Vec<u32>> = vec![Vec::new(); count];
        let mut seen = vec![0_usize; count];
        for (t, &c) in self.component_of.iter().enumerate().filter(|(_, c)| **c != NO_COMPONENT) {
            turned[c as usize] += usize::from(sets.find(t as u32).1);
            let (part, samples) = (&self.components[c as usize], &mut samples[c as usize]);
            if count > 1 {
                boxes[c as usize] = boxes[c as usize].union(Aabb::from_points(&mesh.triangle(t as u32)));
                if seen[c as usize].is_multiple_of(part.triangles.div_ceil(MOST_SAMPLES)) {
                    samples.push(t as u32);
                }
                seen[c as usize] += 1;
            }
        }
        let mut volume = vec![0.0_f64; count];
        let center = mesh.bounds().center().as_dvec3();
        for (t, &c) in self.component_of.iter().enumerate().filter(|(_, c)| **c != NO_COMPONENT) {
            let component = &self.components[c as usize];
            if component.closable {
                let minority = sets.find(t as u32).1 != (2 * turned[c as usize] > component.triangles);
                self.flips[t] = minority;
                volume[c as usize] += signed_volume(mesh, t, center) * if minority { -1.0 } else { 1.0 };
            }
        }
        for (samples, component) in samples.iter_mut().zip(&self.components) {
            if !component.closable {
                samples.clear();
            }
        }
        let solids = Solids { mesh, component_of: &self.component_of, samples: &samples, boxes: &boxes };
        let parents = solids.parents();
        let outermost = roots(&parents);
        for (c, component) in self.components.iter_mut().enumerate() {
            component.inside_of = parents[c];
            component.inside_out = component.closable && volume[outermost[c]] < 0.0;
        }
        for (flip, &c) in self.flips.iter_mut().zip(&self.component_of) {
            *flip ^= c != NO_COMPONENT && self.components[c as usize].inside_out;
        }
    }
}

/// The last one of each chain of parents, which has no cycle.
fn roots(parents: &[Option<usize>]) -> Vec<usize> {
    let mut roots: Vec<usize> = parents.iter().enumerate().map(|(c, parent)| parent.unwrap_or(c)).collect();
    loop {
        let farther: Vec<usize> = roots.iter().map(|&root| roots[root]).collect();
        if farther == roots {
            return roots;
        }
        roots = farther;
    }
}

/// Whether most of the material is behind fronts that face inwards.
fn is_inverted(mesh: &MeshGeometry, used: &[bool]) -> bool {
    let center = mesh.bounds().center().as_dvec3();
    (0..used.len()).filter(|&t| used[t]).map(|t| signed_volume(mesh, t, center)).sum::<f64>() < 0.0
}

/// Which triangles belong together at an edge of several solids.
fn wedges_at(mesh: &MeshGeometry, edge: &[EdgeUse], inverted: bool) -> Option<Vec<[u32; 2]>> {
    let ends = [edge[0].0, edge[0].1].map(|i| mesh.triangle(i / 3)[i as usize % 3]);
    let side = |&(_, _, use_): &EdgeUse| {
        let triangle = use_ >> 1;
        let corner = mesh.triangle(triangle).into_iter().find(|corner| !ends.contains(corner))?;
        Some(Side { triangle, corner, upwards: (use_ & 1 == 1) != inverted })
    };
    wedges(ends, &edge.iter().map(side).collect::<Option<Vec<_>>>()?)
}

/// Middle of an edge; vertices are numbered by the first corner at their position.
fn edge_middle(mesh: &MeshGeometry, edge: &[EdgeUse]) -> Option<Vec3> {
    let (a, b, _) = *edge.first()?;
    let corner = |i: u32| mesh.triangle(i / 3)[i as usize % 3];
    Some(0.5 * (corner(a) + corner(b)))
}

/// Volume of the tetrahedron between a triangle and `center`.
fn signed_volume(mesh: &MeshGeometry, triangle: usize, center: DVec3) -> f64 {
    let [a, b, c] = mesh.triangle(triangle as u32).map(|v| v.as_dvec3() - center);
    a.dot(b.cross(c)) / if mesh.is_reversed() { -6.0 } else { 6.0 }
}
