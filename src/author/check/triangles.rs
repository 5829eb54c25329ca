//! How the triangles of bodies meet: which pairs are near, by a hierarchy of boxes, and what each pair does.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Triangles in a leaf of the hierarchy.
const LEAF: usize = 4;

/// A triangle of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub corners: [DVec3; 3],
    pub body: u32,
}

/// What two triangles do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meeting {
    /// One runs through the other.
    Cross,
    /// They share an area.
    Share {
        /// Their fronts are on opposite sides.
        opposite: bool,
        /// They have the same corners.
        equal: bool,
    },
}

/// Calls `found` with each pair of triangles that meet, the tolerance being a length that is taken for a rounding; false if
/// there are more than `most` pairs of boxes that overlap, and not all were looked at.
pub(super) fn meetings<T: Send>(
    triangles: &[Triangle],
    tolerance: f64,
    most: u64,
    found: impl Fn(&mut T, [u32; 2], Meeting) + Sync,
    new: impl Fn() -> T + Sync,
) -> (Vec<T>, bool) {
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    let centers: Vec<DVec3> = triangles.iter().map(|t| t.corners.iter().sum::<DVec3>()).collect();
    let mut nodes = Vec::new();
    build(triangles, &centers, &mut order, 0, &mut nodes);
    let share = most / (triangles.len() as u64).max(1) + 1;
    let chunk = triangles.len().div_ceil(256).max(1);
    let chunks: Vec<usize> = (0..triangles.len()).step_by(chunk).collect();
    let visit = |&start: &usize| {
        let (mut out, mut left, mut stack) = (new(), share * chunk as u64, Vec::new());
        for place in start..(start + chunk).min(triangles.len()) {
            let own = &triangles[order[place] as usize];
            let bounds = Bounds::of(own, tolerance);
            stack.push(0);
            while let Some(node) = stack.pop() {
                let Node { bounds: around, first, end, right } = nodes[node];
                // Each pair once: with the later ones only.
                if end <= place + 1 || !around.overlaps(&bounds) {
                    continue;
                }
                if right != 0 {
                    stack.extend([right, node + 1]);
                    continue;
                }
                for &other in &order[first.max(place + 1)..end] {
                    let other = &triangles[other as usize];
                    if !bounds.overlaps(&Bounds::of(other, 0.0)) {
                        continue;
                    }
                    if left == 0 {
                        return (out, false);
                    }
                    left -= 1;
                    if let Some(meeting) = meet(&own.corners, &other.corners, tolerance) {
                        found(&mut out, [own.body, other.body], meeting);
                    }
                }
            }
        }
        (out, true)
    };
    let (out, complete): (Vec<T>, Vec<bool>) = chunks.par_iter().map(visit).unzip();
    (out, complete.into_iter().all(|complete| complete))
}

#[derive(Clone, Copy)]
struct Bounds([DVec3; 2]);

impl Bounds {
    fn of(triangle: &Triangle, room: f64) -> Self {
        let [a, b, c] = triangle.corners;
        Self([a.min(b).min(c) - room, a.max(b).max(c) + room])
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.0[0].cmple(other.0[1]).all() && other.0[0].cmple(self.0[1]).all()
    }
}

/// Triangles `first..end` of the order; the left child follows, `right` is 0 for a leaf.
#[derive(Clone, Copy)]
struct Node {
    bounds: Bounds,
    first: usize,
    end: usize,
    right: usize,
}

/// Halves at the median of the longest side.
fn build(
    triangles: &[Triangle],
    centers: &[DVec3],
    order: &mut [u32],
    first: usize,
    nodes: &mut Vec<Node>,
) -> usize {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [low, high] = order.iter().fold(none, |[low, high], &i| {
        let Bounds([l, h]) = Bounds::of(&triangles[i as usize], 0.0);
        [low.min(l), high.max(h)]
    });
    let node = nodes.len();
    nodes.push(Node { bounds: Bounds([low, high]), first, end: first + order.len(), right: 0 });
    if order.len() > LEAF {
        let axis = (high - low).max_position();
        let middle = order.len() / 2;
        order.select_nth_unstable_by(middle, |&a, &b| {
            centers[a as usize][axis].total_cmp(&centers[b as usize][axis]).then(a.cmp(&b))
        });
        let (left, right) = order.split_at_mut(middle);
        build(triangles, centers, left, first, nodes);
        nodes[node].right = build(triangles, centers, right, first + middle, nodes);
    }
    node
}

/// What two triangles do; `None` where they are apart, or only touch in points and lines.
fn meet(a: &[DVec3; 3], b: &[DVec3; 3], tolerance: f64) -> Option<Meeting> {
    let (plane_a, plane_b) = (Plane::of(a, tolerance)?, Plane::of(b, tolerance)?);
    let (of_b, of_a) = (plane_a.distances(b), plane_b.distances(a));
    let flat = |distances: [f64; 3]| distances.iter().all(|d| d.abs() <= tolerance);
    if flat(of_b) && flat(of_a) {
        let normal = plane_a.normal;
        let longest = edges(a).into_iter().chain(edges(b)).map(DVec3::length).fold(0.0, f64::max);
        return (shared_area(a, b, normal) > 4.0 * tolerance * longest).then(|| {
            let equal = a.iter().all(|p| b.iter().any(|q| p.distance(*q) <= tolerance));
            Meeting::Share { opposite: normal.dot(plane_b.normal) < 0.0, equal }
        });
    }
    let beside = |d: [f64; 3]| d.iter().all(|d| *d >= -tolerance) || d.iter().all(|d| *d <= tolerance);
    if beside(of_b) || beside(of_a) {
        return None;
    }
    // Both meet the line of the two planes in a stretch (Möller 1997).
    let line = plane_a.normal.cross(plane_b.normal).try_normalize()?;
    let ([a_low, a_high], [b_low, b_high]) = (chord(a, of_a, line), chord(b, of_b, line));
    let common = a_high.min(b_high) - a_low.max(b_low);
    (common > 4.0 * tolerance).then_some(Meeting::Cross)
}

struct Plane {
    point: DVec3,
    normal: DVec3,
}

impl Plane {
    /// The plane of a triangle, unless that is thinner than roundings.
    fn of(triangle: &[DVec3; 3], tolerance: f64) -> Option<Self> {
        let [e, f, g] = edges(triangle);
        let double = e.cross(f);
        let height = double.length() / e.length().max(f.length()).max(g.length());
        (height > 4.0 * tolerance).then(|| Self { point: triangle[0], normal: double.normalize() })
    }

    fn distances(&self, points: &[DVec3; 3]) -> [f64; 3] {
        points.map(|p| (p - self.point).dot(self.normal))
    }
}

fn edges([a, b, c]: &[DVec3; 3]) -> [DVec3; 3] {
    [b - a, c - b, a - c]
}

/// Where a triangle, whose corners have distances `d` from a plane, crosses the plane: the least and the greatest place
/// along a direction.
fn chord(triangle: &[DVec3; 3], d: [f64; 3], along: DVec3) -> [f64; 2] {
    let places = (0..3).flat_map(|i| {
        let j = (i + 1) % 3;
        let at = |t: f64| (triangle[i] + (triangle[j] - triangle[i]) * t).dot(along);
        if d[i] == 0.0 { Some(at(0.0)) } else { (d[i] * d[j] < 0.0).then(|| at(d[i] / (d[i] - d[j]))) }
    });
    places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// The area that triangles of one plane share, by clipping (Sutherland & Hodgman 1974).
fn shared_area(a: &[DVec3; 3], b: &[DVec3; 3], normal: DVec3) -> f64 {
    let (x, y) = normal.any_orthonormal_pair();
    let flat = |p: DVec3| DVec2::new((p - a[0]).dot(x), (p - a[0]).dot(y));
    let (clip, mut polygon) = (a.map(flat), b.map(flat).to_vec());
    let turn = (clip[1] - clip[0]).perp_dot(clip[2] - clip[0]).signum();
    for i in 0..3 {
        let (from, along) = (clip[i], clip[(i + 1) % 3] - clip[i]);
        let side = |p: DVec2| turn * along.perp_dot(p - from);
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (k, &p) in polygon.iter().enumerate() {
            let q = polygon[(k + 1) % polygon.len()];
            let (s, t) = (side(p), side(q));
            if s >= 0.0 {
                kept.push(p);
            }
            if s * t < 0.0 {
                kept.push(p + (q - p) * (s / (s - t)));
            }
        }
        polygon = kept;
    }
    let doubled = |(i, p): (usize, &DVec2)| p.perp_dot(polygon[(i + 1) % polygon.len()]);
    0.5 * polygon.iter().enumerate().map(doubled).sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    fn moved(by: DVec3) -> [DVec3; 3] {
        FLAT.map(|p| p + by)
    }

    #[test]
    fn pairs_meet_as_they_should() {
        let meets = |b: [DVec3; 3]| meet(&FLAT, &b, 1e-6);
        let share = |opposite, equal| Some(Meeting::Share { opposite, equal });
        assert_eq!(meets(FLAT), share(false, true));
        assert_eq!(meets([FLAT[0], FLAT[2], FLAT[1]]), share(true, true));
        assert_eq!(meets(moved(DVec3::X * 0.5)), share(false, false));
        assert_eq!(meets(moved(DVec3::Z * 1e-7)), share(false, true));
        assert_eq!(meets(moved(DVec3::Z * 1e-3)), None);
        assert_eq!(meets(moved(DVec3::X)), None, "a point");
        assert_eq!(meets([DVec3::X, DVec3::ZERO, -DVec3::Y]), None, "an edge");
        assert_eq!(meets([DVec3::X, DVec3::ZERO, DVec3::Z]), None, "an edge that is bent");
        let upright =
            |z: f64| [DVec3::new(0.2, 0.2, z), DVec3::new(0.3, 0.2, z), DVec3::new(0.2, 0.3, z + 1.0)];
        assert_eq!(meets(upright(-0.5)), Some(Meeting::Cross));
        assert_eq!(meets(upright(0.0)), None, "it stands on it");
        assert_eq!(meets(upright(0.5)), None);
    }

    #[test]
    fn shared_areas_are_exact() {
        assert!((shared_area(&FLAT, &FLAT, DVec3::Z) - 0.5).abs() < 1e-12);
        // Two right triangles that share one of half the size.
        assert!((shared_area(&FLAT, &moved(DVec3::X * 0.5), DVec3::Z) - 0.125).abs() < 1e-12);
        assert!(shared_area(&FLAT, &moved(DVec3::X * 2.0), DVec3::Z) == 0.0);
    }

    #[test]
    fn all_pairs_are_found_once_or_it_is_told() {
        // A row in which each one shares an area with the next.
        let triangles: Vec<Triangle> =
            (0..1000).map(|i| Triangle { corners: moved(DVec3::X * 0.6 * f64::from(i)), body: i }).collect();
        let collect = |most| {
            let push = |out: &mut Vec<[u32; 2]>, mut pair: [u32; 2], _| {
                pair.sort_unstable();
                out.push(pair);
            };
            let (found, complete) = meetings(&triangles, 1e-9, most, push, Vec::new);
            let mut found = found.concat();
            found.sort_unstable();
            (found, complete)
        };
        let expected: Vec<[u32; 2]> = (0..999).map(|i| [i, i + 1]).collect();
        assert_eq!(collect(1_000_000), (expected, true));
        let (few, complete) = collect(0);
        assert!(!complete || few.len() == 999);
        assert!(meetings(&[], 1e-9, 9, |(), _, _| (), || ()).0.is_empty());
    }
}
