//! Primitive modes (glTF 2.0 §3.7.2.1): strips and fans become lists of triangles, counter-clockwise as the list is.

/// What the indices of a primitive mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topology {
    /// Mode 4: three indices a triangle.
    Triangles,
    /// Mode 5: every index continues the strip; every other triangle is turned over.
    Strip,
    /// Mode 6: all triangles share the first index.
    Fan,
}

impl Topology {
    /// The triangles of a sequence of indices; what is left over at the end is left out.
    pub fn triangles(self, indices: &[u32]) -> Vec<[u32; 3]> {
        match self {
            Self::Triangles => indices.as_chunks::<3>().0.to_vec(),
            Self::Strip => {
                let turn = |(i, w): (usize, &[u32])| {
                    if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] }
                };
                indices.windows(3).enumerate().map(turn).collect()
            }
            Self::Fan => match indices.split_first() {
                Some((&hub, rim)) => rim.windows(2).map(|w| [w[0], w[1], hub]).collect(),
                None => Vec::new(),
            },
        }
    }

    /// Whether a sequence of `count` indices is complete.
    pub fn is_whole(self, count: usize) -> bool {
        match self {
            Self::Triangles => count.is_multiple_of(3),
            Self::Strip | Self::Fan => count >= 3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Topology;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        assert_eq!(Topology::Triangles.triangles(&[0, 1, 2, 3, 4, 5, 6]), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(Topology::Strip.triangles(&[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(Topology::Fan.triangles(&[9, 1, 2, 3]), [[1, 2, 9], [2, 3, 9]]);
        for topology in [Topology::Triangles, Topology::Strip, Topology::Fan] {
            assert!(topology.triangles(&[]).is_empty());
            assert!(topology.triangles(&[1, 2]).is_empty());
            assert!(!topology.is_whole(2));
        }
    }
}
