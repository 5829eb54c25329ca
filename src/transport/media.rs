//! The stack of media a path is inside of, with priorities.
//!
//! Closed objects may overlap. Every object with a medium has a *rank*, a total order by (priority, smaller volume,
//! index), so that of all objects around a point the one with the highest rank fills it, whichever way the path came
//! (Schmidt & Budge 2002, "Simple Nested Dielectrics in Ray Traced Images", with the tie broken so that an object
//! inside another wins). A boundary between two objects that do not fill the point is not there.
//!
//! An object is around a point if its winding number about it is not zero. Crossing a triangle from its front adds one,
//! from its back takes one away, so it does not matter which way a body is wound, or how often it overlaps itself.

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
    /// Of each entry, never zero.
    windings: [i8; Self::CAPACITY],
    len: u8,
}

impl Default for MediumStack {
    fn default() -> Self {
        Self {
            entries: [Enclosure { instance: u32::MAX, material: u32::MAX, rank: 0 }; Self::CAPACITY],
            windings: [0; Self::CAPACITY],
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

    /// The object that would fill the point without that one.
    #[inline]
    pub fn below(&self) -> Option<Enclosure> {
        self.entries[..(self.len as usize).saturating_sub(1)].last().copied()
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

    /// The objects around the path.
    pub fn instances(&self) -> impl Iterator<Item = u32> {
        self.entries[..self.len as usize].iter().map(|e| e.instance)
    }

    /// How often `instance` winds about the path; 0: it is not around it.
    #[inline]
    pub fn winding(&self, instance: u32) -> i32 {
        self.position(instance).map_or(0, |at| self.windings[at].into())
    }

    #[inline]
    fn position(&self, instance: u32) -> Option<usize> {
        self.entries[..self.len as usize].iter().rposition(|e| e.instance == instance)
    }

    /// Sets how often an object winds about the path.
    pub fn set(&mut self, enclosure: Enclosure, winding: i32) {
        let narrow = winding.clamp(i8::MIN.into(), i8::MAX.into()) as i8;
        match self.position(enclosure.instance) {
            Some(_) if winding == 0 => self.leave(enclosure.instance),
            Some(at) => self.windings[at] = narrow,
            None if winding != 0 => self.insert(enclosure, narrow),
            None => {}
        }
    }

    fn insert(&mut self, enclosure: Enclosure, winding: i8) {
        let mut n = self.len as usize;
        if n == Self::CAPACITY {
            if enclosure.rank <= self.entries[0].rank {
                return;
            }
            self.entries.copy_within(1.., 0);
            self.windings.copy_within(1.., 0);
            n -= 1;
        }
        let at = self.entries[..n].partition_point(|e| e.rank <= enclosure.rank);
        self.entries.copy_within(at..n, at + 1);
        self.windings.copy_within(at..n, at + 1);
        self.entries[at] = enclosure;
        self.windings[at] = winding;
        self.len = n as u8 + 1;
    }

    /// Removes an object, however often it winds about the path.
    pub fn leave(&mut self, instance: u32) {
        let n = self.len as usize;
        if let Some(at) = self.position(instance) {
            self.entries.copy_within(at + 1..n, at);
            self.windings.copy_within(at + 1..n, at);
            self.len = n as u8 - 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl MediumStack {
        /// Crosses a boundary.
        fn wind(&mut self, enclosure: Enclosure, change: i32) {
            self.set(enclosure, self.winding(enclosure.instance) + change);
        }
    }

    fn object(instance: u32, rank: u32) -> Enclosure {
        Enclosure { instance, material: 0, rank }
    }

    #[test]
    fn the_overlap_belongs_to_the_higher_rank_from_either_side() {
        let (glass, milk) = (object(0, 5), object(1, 3));
        for order in [[glass, milk], [milk, glass]] {
            let mut s = MediumStack::default();
            order.iter().for_each(|&e| s.wind(e, 1));
            assert_eq!(s.current(), Some(glass));
            s.wind(glass, -1);
            assert_eq!(s.current(), Some(milk));
            s.wind(milk, -1);
            assert!(s.is_empty());
        }
    }

    #[test]
    fn overlapping_parts_of_one_object_are_one_and_either_winding_is_inside() {
        let head = object(7, 1);
        let mut s = MediumStack::default();
        s.wind(head, 1);
        s.wind(head, 1);
        s.wind(head, -1);
        assert_eq!((s.current(), s.winding(7)), (Some(head), 1));
        s.wind(head, -1);
        assert!(s.is_empty());
        s.wind(head, -1);
        assert_eq!((s.current(), s.winding(7)), (Some(head), -1));
        s.wind(head, 1);
        assert!(s.is_empty());
    }

    #[test]
    fn a_full_stack_keeps_the_highest_ranks() {
        let mut s = MediumStack::default();
        for i in 0..20 {
            s.wind(object(i, i), 1);
        }
        assert_eq!(s.current(), Some(object(19, 19)));
        for i in (12..20).rev() {
            assert_eq!(s.current(), Some(object(i, i)));
            s.leave(i);
        }
        assert!(s.is_empty());
    }
}
