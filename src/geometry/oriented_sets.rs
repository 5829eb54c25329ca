//! Which triangles hang together, and which of them must be turned over to face the same way.

use super::topology::NO_COMPONENT;

/// Disjoint sets (Tarjan 1975) of triangles, each with whether it must be turned over to agree with the set's first.
pub(super) struct OrientedSets {
    parent: Vec<u32>,
    turned: Vec<bool>,
    contradictions: Vec<u32>,
}

impl OrientedSets {
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect(), turned: vec![false; count], contradictions: Vec::new() }
    }

    /// The root, and whether the triangle is turned relative to it.
    pub fn find(&mut self, triangle: u32) -> (u32, bool) {
        let (mut root, mut turned) = (triangle, false);
        while self.parent[root as usize] != root {
            turned ^= self.turned[root as usize];
            root = self.parent[root as usize];
        }
        let (mut at, mut rest) = (triangle, turned);
        while self.parent[at as usize] != root && at != root {
            let next = self.parent[at as usize];
            let step = self.turned[at as usize];
            self.parent[at as usize] = root;
            self.turned[at as usize] = rest;
            rest ^= step;
            at = next;
        }
        (root, turned)
    }

    pub fn join(&mut self, a: u32, b: u32, opposite: bool) {
        let ((root_a, turned_a), (root_b, turned_b)) = (self.find(a), self.find(b));
        let turn = turned_a ^ turned_b ^ opposite;
        if root_a == root_b {
            if turn {
                self.contradictions.push(a);
            }
            return;
        }
        let (low, high) = (root_a.min(root_b), root_a.max(root_b));
        self.parent[high as usize] = low;
        self.turned[high as usize] = turn;
    }

    /// For each component, whether it has no consistent orientation.
    pub fn contradictions_of(&self, component_of: &[u32]) -> Vec<bool> {
        let count = component_of.iter().filter(|&&c| c != NO_COMPONENT).max().map_or(0, |&c| c as usize + 1);
        let mut out = vec![false; count];
        for &t in &self.contradictions {
            out[component_of[t as usize] as usize] = true;
        }
        out
    }
}
