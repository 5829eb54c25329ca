//! Primaries and white points of files, and the way from them to linear Rec. 709.

use glam::{DMat3, DVec3};

/// Chromaticities x, y of the primaries and of white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Primaries {
    pub red: [f64; 2],
    pub green: [f64; 2],
    pub blue: [f64; 2],
    pub white: [f64; 2],
}

/// Rec. 709 with D65.
pub(super) const REC_709: Primaries =
    Primaries { red: [0.64, 0.33], green: [0.3, 0.6], blue: [0.15, 0.06], white: [0.3127, 0.329] };

/// Chromaticities this close are the same: files round them to three digits.
const SAME: f64 = 1e-3;

/// From XYZ to the responses of cones by Bradford, in which whites are adapted (CIE 159:2004, annex).
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// XYZ of a chromaticity at Y = 1.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

fn inverse(matrix: DMat3) -> Option<DMat3> {
    let inverse = matrix.inverse();
    (matrix.determinant().abs() > 1e-9 && inverse.is_finite()).then_some(inverse)
}

impl Primaries {
    /// From these RGB to XYZ, white at Y = 1; `None` where the primaries span nothing.
    pub fn to_xyz(self) -> Option<DMat3> {
        let all = [self.red, self.green, self.blue, self.white];
        if all.iter().any(|[x, y]| !x.is_finite() || !y.is_finite() || *y == 0.0) {
            return None;
        }
        let unscaled = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        let scale = inverse(unscaled)? * xyz(self.white);
        let matrix = unscaled * DMat3::from_diagonal(scale);
        inverse(matrix).map(|_| matrix)
    }

    /// The shares of R, G and B in luminance.
    pub fn luminance(self) -> Option<DVec3> {
        self.to_xyz().map(|m| m.row(1)).filter(|shares| shares.min_element() > 0.0)
    }

    /// From these RGB to Rec. 709, white to white by Bradford; `None` where they are Rec. 709 or span nothing.
    pub fn to_rec_709(self) -> Option<DMat3> {
        let (ours, theirs) = (REC_709, self);
        let same = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < SAME && (a[1] - b[1]).abs() < SAME;
        if same(ours.red, theirs.red)
            && same(ours.green, theirs.green)
            && same(ours.blue, theirs.blue)
            && same(ours.white, theirs.white)
        {
            return None;
        }
        let to_xyz = theirs.to_xyz()?;
        let (from, to) = (BRADFORD * xyz(theirs.white), BRADFORD * xyz(ours.white));
        let adapt = inverse(BRADFORD)? * DMat3::from_diagonal(to / from) * BRADFORD;
        Some(xyz_to_rec_709()? * adapt * to_xyz).filter(|m| m.is_finite())
    }
}

/// From XYZ, whose white is D65, to Rec. 709.
pub(super) fn xyz_to_rec_709() -> Option<DMat3> {
    inverse(REC_709.to_xyz()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_those_of_the_standards() {
        let luminance = REC_709.luminance().unwrap();
        assert!((luminance - DVec3::new(0.2126, 0.7152, 0.0722)).length() < 1e-4, "{luminance}");
        assert_eq!(REC_709.to_rec_709(), None);
        let nothing = Primaries { green: REC_709.red, ..REC_709 };
        assert_eq!(nothing.to_xyz(), None);
        // ACES AP0 to Rec. 709 through Bradford, as the ACES documents print it.
        let ap0 = Primaries {
            red: [0.7347, 0.2653],
            green: [0.0, 1.0],
            blue: [0.0001, -0.077],
            white: [0.32168, 0.33767],
        };
        let m = ap0.to_rec_709().unwrap();
        let expected = DMat3::from_cols(
            DVec3::new(2.5217, -0.2765, -0.0154),
            DVec3::new(-1.1341, 1.3727, -0.1530),
            DVec3::new(-0.3876, -0.0962, 1.1684),
        );
        assert!((0..3).all(|i| (m.col(i) - expected.col(i)).length() < 2e-3), "{m}");
        assert!((m * DVec3::ONE - DVec3::ONE).length() < 1e-3);
    }
}
