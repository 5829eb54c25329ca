//! What bodies, or parts of one, do where they meet: cross, share faces, or are the same one twice.

use super::triangles::{Meeting, Triangle, meetings};
use std::collections::{BTreeMap, BTreeSet};

/// Pairs of triangles near each other that are looked at, at most: some seconds.
const MOST_PAIRS: u64 = 1 << 26;
/// Triangles that are looked at, at most.
const MOST_TRIANGLES: usize = 1 << 22;
/// Lengths below this part of the largest coordinate are roundings: those of both positions, placed in single precision.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// What two bodies do, or one with itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// A surface runs through the other, or both have an area in common and are on the same side of it.
    pub cross: bool,
    /// They have an area in common and are on opposite sides of it.
    pub touch: bool,
    /// Triangles that are in both.
    equal: usize,
}

/// All contacts among bodies.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    of: BTreeMap<[u32; 2], Contact>,
    sizes: BTreeMap<u32, usize>,
    /// Whether everything was looked at.
    pub complete: bool,
}

impl Contacts {
    pub fn new(triangles: &[Triangle]) -> Self {
        if triangles.len() > MOST_TRIANGLES {
            return Self::default();
        }
        let corners = triangles.iter().flat_map(|t| t.corners);
        let largest = corners.map(|p| p.abs().max_element()).filter(|x| x.is_finite()).fold(0.0, f64::max);
        let add = |of: &mut BTreeMap<[u32; 2], Contact>, mut pair: [u32; 2], meeting| {
            pair.sort_unstable();
            let contact = of.entry(pair).or_default();
            match meeting {
                Meeting::Cross => contact.cross = true,
                Meeting::Share { opposite, equal } => {
                    contact.touch |= opposite;
                    contact.cross |= !opposite;
                    contact.equal += usize::from(equal);
                }
            }
        };
        let (found, complete) = meetings(triangles, ROUNDING * largest, MOST_PAIRS, add, BTreeMap::new);
        let mut of: BTreeMap<[u32; 2], Contact> = BTreeMap::new();
        for (pair, more) in found.into_iter().flatten() {
            let contact = of.entry(pair).or_default();
            contact.cross |= more.cross;
            contact.touch |= more.touch;
            contact.equal += more.equal;
        }
        let mut sizes = BTreeMap::new();
        triangles.iter().for_each(|t| *sizes.entry(t.body).or_default() += 1);
        Self { of, sizes, complete }
    }

    /// What two bodies do; nothing by default.
    pub fn between(&self, a: u32, b: u32) -> Contact {
        self.of.get(&[a.min(b), a.max(b)]).copied().unwrap_or_default()
    }

    /// Whether two bodies have all their triangles in common, which are all that were given.
    pub fn are_one(&self, a: u32, b: u32) -> bool {
        let size = |body| self.sizes.get(&body).copied();
        let equal = Some(self.between(a, b).equal).filter(|&n| n > 0);
        a != b && equal == size(a) && equal == size(b)
    }

    /// Bodies that cross themselves.
    pub fn crossing_themselves(&self) -> usize {
        self.of.iter().filter(|([a, b], contact)| a == b && contact.cross).count()
    }

    /// Bodies that do something with another one.
    pub fn with_others(&self, what: impl Fn(&Contact) -> bool) -> usize {
        let pairs = self.of.iter().filter(|([a, b], contact)| a != b && what(contact));
        pairs.flat_map(|(pair, _)| pair).collect::<BTreeSet<_>>().len()
    }
}
