//! Meshes and random numbers for the tests of this room.

use glam::Vec3;
use std::collections::HashMap;

pub(super) type Triangles = (Vec<Vec3>, Vec<[u32; 3]>);

/// SplitMix64 (Steele, Lea & Flood 2014).
pub(super) struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in \[0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Uniform in the cube \[-1, 1)³.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// Uniform on the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let p = self.cube();
            if p.length_squared() > 1.0e-4 && p.length_squared() < 1.0 {
                return p.normalize();
            }
        }
    }
}

/// A subdivided icosahedron of radius 1 with 20 · 4ⁿ triangles; vertices are moved in and out by up to `bump`.
pub(super) fn sphere(levels: u32, bump: f32, seed: u64) -> Triangles {
    let g = 0.5 + 1.25_f32.sqrt();
    let mut positions: Vec<Vec3> = [
        (-1.0, g, 0.0),
        (1.0, g, 0.0),
        (-1.0, -g, 0.0),
        (1.0, -g, 0.0),
        (0.0, -1.0, g),
        (0.0, 1.0, g),
        (0.0, -1.0, -g),
        (0.0, 1.0, -g),
        (g, 0.0, -1.0),
        (g, 0.0, 1.0),
        (-g, 0.0, -1.0),
        (-g, 0.0, 1.0),
    ]
    .map(|(x, y, z)| Vec3::new(x, y, z).normalize())
    .to_vec();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32, positions: &mut Vec<Vec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        let mut next = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let (ab, bc, ca) =
                (middle(a, b, &mut positions), middle(b, c, &mut positions), middle(c, a, &mut positions));
            next.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = next;
    }
    let mut random = Random(seed);
    for p in &mut positions {
        *p *= 1.0 + bump * (2.0 * random.unit() - 1.0);
    }
    (positions, triangles)
}

/// A closed box, normals outwards.
pub(super) fn cuboid(min: Vec3, max: Vec3) -> Triangles {
    let pick = |corner: u32, axis: usize| if corner >> axis & 1 == 0 { min[axis] } else { max[axis] };
    let positions = (0..8).map(|c| Vec3::new(pick(c, 0), pick(c, 1), pick(c, 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (positions, triangles)
}

/// Loose triangles with corners within `size` of centres in the unit cube; shapes from fat to needles.
pub(super) fn soup(count: usize, size: f32, seed: u64) -> Triangles {
    let mut random = Random(seed);
    let mut positions = Vec::new();
    for _ in 0..count {
        let center = random.cube();
        let stretch = 10.0_f32.powf(-3.0 * random.unit());
        let (a, b) = (random.direction() * size, random.direction() * size * stretch);
        positions.extend([center, center + a, center + b]);
    }
    (positions, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// Both in one mesh.
pub(super) fn merge(mut a: Triangles, b: Triangles) -> Triangles {
    let first = a.0.len() as u32;
    a.0.extend(b.0);
    a.1.extend(b.1.into_iter().map(|t| t.map(|i| i + first)));
    a
}

/// The same mesh inside out.
pub(super) fn reverse(mut mesh: Triangles) -> Triangles {
    for t in &mut mesh.1 {
        t.swap(1, 2);
    }
    mesh
}

/// The same mesh under `p -> scale p + shift`.
pub(super) fn place(mut mesh: Triangles, scale: f32, shift: Vec3) -> Triangles {
    for p in &mut mesh.0 {
        *p = *p * scale + shift;
    }
    mesh
}
