//! The stack of media a path is inside of, with priorities.
//!
//! Closed objects may overlap. Every object with a medium has a *rank*, a total order by (priority, smaller volume,
//! index), so that of all objects around a point the one with the highest rank fills it, whichever way the path came
//! (Schmidt & Budge 2002, "Simple Nested Dielectrics in Ray Traced Images", with the tie broken so that an object
//! inside another wins). A boundary between two objects that do not fill the point is not there.

/// One object around the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Enclosure {
    /// The instance.
    pub instance: u32,
    /// The material of the triangle through which it was entered, which names the medium.
    pub material: u32,
    /// The object's place in the total order; higher wins.
    pub rank: u32,
}

/// Objects around the path, in order of rank (the last fills the point).
///
/// Nesting deeper than [`MediumStack::CAPACITY`] drops the lowest rank, which cannot be seen unless all above are left.
#[derive(Clone, Copy, Debug)]
pub struct MediumStack {
    entries: [Enclosure; Self::CAPACITY],
    len: u8,
}

/// What crossing a boundary means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    /// Both sides hold the same medium because another object fills them: the surface is not there.
    Hidden,
    /// A real interface between the medium outside of the object (`None`: vacuum) and the object.
    Interface {
        /// What is on the outer side.
        outside: Option<Enclosure>,
    },
}

impl Default for MediumStack {
    fn default() -> Self {
        Self {
            entries: [Enclosure { instance: u32::MAX, material: u32::MAX, rank: 0 }; Self::CAPACITY],
            len: 0,
        }
    }
}

impl MediumStack {
    /// Deepest nesting that is followed.
    pub const CAPACITY: usize = 8;

    /// The object that fills the point, if any.
    #[inline]
    pub fn current(&self) -> Option<Enclosure> {
        self.entries[..self.len as usize].last().copied()
    }

    /// Whether nothing is around the path.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// How many objects are around the path.
    #[inline]
    pub fn len(&self) -> usize {
        self.len.into()
    }

    /// Whether `instance` is around the path.
    pub fn contains(&self, instance: u32) -> bool {
        self.entries[..self.len as usize].iter().any(|e| e.instance == instance)
    }

    /// Adds an object around the path.
    pub fn enter(&mut self, enclosure: Enclosure) {
        let mut n = self.len as usize;
        if n == Self::CAPACITY {
            if enclosure.rank <= self.entries[0].rank {
                return;
            }
            self.entries.copy_within(1.., 0);
            n -= 1;
        }
        let at = self.entries[..n].partition_point(|e| e.rank <= enclosure.rank);
        self.entries.copy_within(at..n, at + 1);
        self.entries[at] = enclosure;
        self.len = n as u8 + 1;
    }

    /// Removes one entry of `instance`.
    pub fn leave(&mut self, instance: u32) {
        let n = self.len as usize;
        if let Some(at) = self.entries[..n].iter().rposition(|e| e.instance == instance) {
            self.entries.copy_within(at + 1..n, at);
            self.len = n as u8 - 1;
        }
    }

    /// What the boundary of `enclosure` is to a path with this stack that comes from outside (`entering`) or inside.
    pub fn crossing(&self, enclosure: Enclosure, entering: bool) -> Crossing {
        if entering {
            match self.current() {
                Some(top) if top.rank >= enclosure.rank => Crossing::Hidden,
                outside => Crossing::Interface { outside },
            }
        } else {
            let mut rest = *self;
            rest.leave(enclosure.instance);
            match rest.current() {
                Some(top) if top.rank >= enclosure.rank => Crossing::Hidden,
                outside => Crossing::Interface { outside },
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object(instance: u32, rank: u32) -> Enclosure {
        Enclosure { instance, material: 0, rank }
    }

    #[test]
    fn the_overlap_belongs_to_the_higher_rank_from_either_side() {
        let (glass, milk) = (object(0, 5), object(1, 3));
        let mut s = MediumStack::default();
        assert_eq!(s.crossing(milk, true), Crossing::Interface { outside: None });
        s.enter(milk);
        assert_eq!(s.crossing(glass, true), Crossing::Interface { outside: Some(milk) });
        s.enter(glass);
        assert_eq!(s.current(), Some(glass));
        assert_eq!(s.crossing(milk, false), Crossing::Hidden);
        s.leave(1);
        assert_eq!(s.crossing(glass, false), Crossing::Interface { outside: None });
        s.leave(0);
        assert!(s.is_empty());

        s.enter(glass);
        assert_eq!(s.crossing(milk, true), Crossing::Hidden);
        s.enter(milk);
        assert_eq!(s.current(), Some(glass));
        assert_eq!(s.crossing(glass, false), Crossing::Interface { outside: Some(milk) });
    }

    #[test]
    fn overlapping_parts_of_one_object_have_no_boundary_between_them() {
        let head = object(7, 1);
        let mut s = MediumStack::default();
        s.enter(head);
        assert_eq!(s.crossing(head, true), Crossing::Hidden);
        s.enter(head);
        assert_eq!(s.crossing(head, false), Crossing::Hidden);
        s.leave(7);
        assert_eq!(s.crossing(head, false), Crossing::Interface { outside: None });
    }

    #[test]
    fn a_full_stack_keeps_the_highest_ranks() {
        let mut s = MediumStack::default();
        for i in 0..20 {
            s.enter(object(i, i));
        }
        assert_eq!(s.current(), Some(object(19, 19)));
        for i in (12..20).rev() {
            assert_eq!(s.current(), Some(object(i, i)));
            s.leave(i);
        }
        assert!(s.is_empty());
    }
}
