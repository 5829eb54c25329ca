//! Photometric webs: how much light a luminaire sends in each direction, as it was measured (IES LM-63).
//!
//! A web is a table of candela over two angles, with the directions that the three kinds of goniometers have for them. In
//! the frame of a light of glTF, which shines along −Z (EXT_lights_ies), with the length of the luminaire along X and its
//! width along Y:
//!
//! | | polar axis | direction of vertical angle v and horizontal angle h |
//! | --- | --- | --- |
//! | C | −Z | (sin v cos h, sin v sin h, −cos v) |
//! | B | Y, the width | (cos v sin h, sin v, −cos v cos h) |
//! | A | X, the length | (sin v, −cos v sin h, −cos v cos h) |
//!
//! Both angles 0 are straight ahead. Polar axes, and what of a table stands for what is left out of it by symmetry, are
//! those of LM-63-95 as Ashdown (*Parsing the IESNA LM-63 photometric data file*, 1998) has them; that horizontal angles
//! of A and B run clockwise about their axis, and those of C do not, is said in EXT_lights_ies. Between the
//! directions of the table candela are bilinear in the angles; outside of it there is no light.

use glam::{Mat3, Vec3};
use std::f32::consts::PI;

/// Angles closer than this, in degrees, are the same.
const SAME: f32 = 1e-3;

/// The kinds of goniometers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Photometry {
    /// Automobile lamps: vertical angles from the plane across the length of the luminaire.
    A,
    /// Floodlights: vertical angles from the plane across the width of the luminaire.
    B,
    /// All else: vertical angles from straight ahead, horizontal ones around that.
    C,
}

/// Which horizontal angles a table leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fold {
    /// C: all planes are one.
    Round,
    /// C: 0° to 90°.
    Quadrant,
    /// C: 0° to 180°.
    Half,
    /// C: 90° to 270°.
    HalfAcross,
    /// C: none.
    Whole,
    /// A, B: negative ones, where the first is 0°.
    Mirrored,
    /// A, B: none.
    Signed,
}

/// Why a table is no web.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WebError {
    /// Angles that do not ascend.
    #[error("{which} angle {index} ({value}°) is not above the one before it")]
    Order {
        /// `vertical` or `horizontal`.
        which: &'static str,
        /// Counted from 0.
        index: usize,
        /// Degrees.
        value: f32,
    },
    /// Angles that the photometry does not have.
    #[error("{which} angles from {first}° to {last}° are none of photometry {photometry:?}: {expected}")]
    Range {
        /// `vertical` or `horizontal`.
        which: &'static str,
        /// Degrees.
        first: f32,
        /// Degrees.
        last: f32,
        /// Of the table.
        photometry: Photometry,
        /// What would be right.
        expected: &'static str,
    },
    /// Candela that are no numbers, or another count of them than of directions.
    #[error("{found} candela of {expected} directions are numbers of at least 0")]
    Values {
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
}

/// Candela by direction, relative to the largest.
#[derive(Clone, PartialEq)]
pub struct PhotometricWeb {
    photometry: Photometry,
    fold: Fold,
    /// Degrees, ascending; two at least.
    vertical: Vec<f32>,
    /// Degrees, ascending.
    horizontal: Vec<f32>,
    /// All vertical angles of the first horizontal one, then of the second, and so on; at most 1.
    values: Vec<f32>,
    largest: f32,
    /// −1 where the light is about along +Z instead, and the angle around it that holds all light, radians.
    cone: (f32, f32),
}

impl std::fmt::Debug for PhotometricWeb {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let angles = (self.vertical.len(), self.horizontal.len());
        write!(f, "PhotometricWeb({:?}, {angles:?}, {} cd)", self.photometry, self.largest)
    }
}

impl PhotometricWeb {
    /// A web of candela at vertical and horizontal angles in degrees, all vertical ones for the first horizontal one first.
    ///
    /// # Errors
    /// Angles that do not ascend or that the photometry does not have, and candela that are not as many or no numbers.
    pub fn new(
        photometry: Photometry,
        vertical: Vec<f32>,
        horizontal: Vec<f32>,
        candela: &[f32],
    ) -> Result<Self, WebError> {
        ascends("vertical", &vertical)?;
        ascends("horizontal", &horizontal)?;
        check_vertical(photometry, &vertical)?;
        let fold = fold(photometry, &horizontal)?;
        let expected = vertical.len().saturating_mul(horizontal.len());
        let found = candela.iter().filter(|c| c.is_finite() && **c >= 0.0).count();
        if found != expected || candela.len() != expected {
            return Err(WebError::Values { found, expected });
        }
        let largest = candela.iter().copied().fold(0.0, f32::max);
        let values: Vec<f32> =
            candela.iter().map(|c| if largest > 0.0 { c / largest } else { 0.0 }).collect();
        let cone = cone(photometry, &vertical, &values);
        Ok(Self { photometry, fold, vertical, horizontal, values, largest, cone })
    }

    /// Largest candela of the table.
    pub fn largest(&self) -> f32 {
        self.largest
    }

    /// Numbers of vertical and horizontal angles.
    pub fn counts(&self) -> (usize, usize) {
        (self.vertical.len(), self.horizontal.len())
    }

    /// Candela in a unit direction of the frame of the light, over the largest of them.
    #[inline]
    pub fn relative(&self, d: Vec3) -> f32 {
        let (v, h) = self.angles(d);
        let Some((i, s)) = between(&self.vertical, v) else { return 0.0 };
        let Some((rows, t)) = self.rows(h) else { return 0.0 };
        let row = |row: usize| {
            let at = row * self.vertical.len() + i;
            let next = if s > 0.0 { at + 1 } else { at };
            self.values[at] + s * (self.values[next] - self.values[at])
        };
        let first = row(rows[0]);
        if t > 0.0 { first + t * (row(rows[1]) - first) } else { first }
    }

    /// Vertical and horizontal angle of a direction, degrees, where the table has them.
    fn angles(&self, d: Vec3) -> (f32, f32) {
        let Vec3 { x, y, z } = d;
        let angle = |sine: f32, cosine: f32| sine.atan2(cosine).to_degrees();
        let (v, h) = match self.photometry {
            Photometry::C => (angle(x.hypot(y), -z), angle(y, x)),
            Photometry::B => (angle(y, x.hypot(z)), angle(x, -z)),
            Photometry::A => (angle(x, y.hypot(z)), angle(-y, -z)),
        };
        let below_zero = self.photometry != Photometry::C && self.vertical[0] >= 0.0;
        let v = if below_zero { v.abs() } else { v };
        let h = match self.fold {
            Fold::Round => self.horizontal[0],
            Fold::Quadrant => h.abs().min(180.0 - h.abs()),
            Fold::Half | Fold::Mirrored => h.abs(),
            // −270° to 90° mirrored about the plane of 90° and 270°.
            Fold::HalfAcross if h.abs() <= 90.0 => 180.0 - h,
            Fold::HalfAcross => h.rem_euclid(360.0),
            Fold::Whole => self.horizontal[0] + (h - self.horizontal[0]).rem_euclid(360.0),
            Fold::Signed => h,
        };
        (v, h)
    }

    /// Two rows of the table around a horizontal angle, and where between them.
    fn rows(&self, h: f32) -> Option<([usize; 2], f32)> {
        if self.fold == Fold::Round {
            return Some(([0, 0], 0.0));
        }
        let last = self.horizontal.len() - 1;
        if self.fold == Fold::Whole && h > self.horizontal[last] {
            // The table may end before it comes around.
            let gap = self.horizontal[0] + 360.0 - self.horizontal[last];
            let t = if gap > SAME { (h - self.horizontal[last]) / gap } else { 0.0 };
            return Some(([last, 0], t.clamp(0.0, 1.0)));
        }
        let (i, t) = between(&self.horizontal, h)?;
        Some(([i, (i + 1).min(last)], t))
    }

    /// Light flux, lumens: the integral of what [`Self::relative`] gives, times the largest candela.
    pub fn lumens(&self) -> f64 {
        let count = self.vertical.len();
        let row = |h: usize| self.row_integral(&self.values[h * count..(h + 1) * count]);
        let rows: Vec<f64> = (0..self.horizontal.len()).map(row).collect();
        let angle = |i: usize| f64::from(self.horizontal[i]).to_radians();
        let mut sum: f64 =
            (1..rows.len()).map(|i| 0.5 * (rows[i - 1] + rows[i]) * (angle(i) - angle(i - 1))).sum();
        let last = rows.len() - 1;
        match self.fold {
            Fold::Round => sum = std::f64::consts::TAU * rows[0],
            Fold::Quadrant => sum *= 4.0,
            Fold::Half | Fold::HalfAcross | Fold::Mirrored => sum *= 2.0,
            Fold::Whole => {
                sum += 0.5 * (rows[last] + rows[0]) * (angle(0) + std::f64::consts::TAU - angle(last));
            }
            Fold::Signed => {}
        }
        sum * f64::from(self.largest)
    }

    /// ∫ I sin v dv of what is linear between the vertical angles, for C; ∫ I cos v dv for A and B.
    fn row_integral(&self, values: &[f32]) -> f64 {
        let polar = self.photometry == Photometry::C;
        // cos v is the sine of the angle from the pole.
        let from_pole = |v: f32| f64::from(if polar { v } else { v + 90.0 }).to_radians();
        let piece = |i: usize| {
            let (v0, v1) = (from_pole(self.vertical[i - 1]), from_pole(self.vertical[i]));
            let (a, b) = (f64::from(values[i - 1]), f64::from(values[i]));
            a * v0.cos() - b * v1.cos() + (b - a) / (v1 - v0) * (v1.sin() - v0.sin())
        };
        let sum: f64 = (1..values.len()).map(piece).sum();
        if !polar && self.vertical[0] >= 0.0 { 2.0 * sum } else { sum }
    }
}

/// A web as a light of the scene has it.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnedWeb {
    web: std::sync::Arc<PhotometricWeb>,
    to_light: Mat3,
}

impl TurnedWeb {
    /// Columns of `to_world` are unit vectors at right angles: the axes of the light.
    pub fn new(web: std::sync::Arc<PhotometricWeb>, to_world: Mat3) -> Self {
        Self { web, to_light: to_world.transpose() }
    }

    /// The web.
    pub fn web(&self) -> &PhotometricWeb {
        &self.web
    }

    /// Candela in a unit direction of the world, over the largest.
    #[inline]
    pub fn relative(&self, direction: Vec3) -> f32 {
        self.web.relative(self.to_light * direction)
    }

    /// Unit vector of the world and the angle around it, in radians, that hold all light.
    pub fn cone(&self) -> (Vec3, f32) {
        let (sign, angle) = self.web.cone;
        (-sign * self.to_light.transpose().z_axis, angle)
    }
}

/// Index of the angle before `x`, and where it is between that and the next; `None` outside of the table.
fn between(angles: &[f32], x: f32) -> Option<(usize, f32)> {
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    if !(first - SAME <= x && x <= last + SAME) {
        return None;
    }
    let after = angles.partition_point(|a| *a <= x);
    if after == 0 || after == angles.len() {
        return Some((after.saturating_sub(1), 0.0));
    }
    Some((after - 1, (x - angles[after - 1]) / (angles[after] - angles[after - 1])))
}

fn ascends(which: &'static str, angles: &[f32]) -> Result<(), WebError> {
    let wrong = |i: &usize| !angles[*i].is_finite() || (*i > 0 && angles[*i] <= angles[*i - 1]);
    match (0..angles.len()).find(wrong) {
        Some(index) => Err(WebError::Order { which, index, value: angles[index] }),
        None => Ok(()),
    }
}

fn check_vertical(photometry: Photometry, angles: &[f32]) -> Result<(), WebError> {
    let (low, expected) = match photometry {
        Photometry::C => (0.0, "two of them at least, from 0° to 180°"),
        Photometry::A | Photometry::B => (-90.0, "two of them at least, from −90° to 90°"),
    };
    let [first, .., last] = *angles else {
        let only = angles.first().copied().unwrap_or(f32::NAN);
        return Err(WebError::Range { which: "vertical", first: only, last: only, photometry, expected });
    };
    let inside = first >= low - SAME && last <= low + 180.0 + SAME;
    if inside {
        Ok(())
    } else {
        Err(WebError::Range { which: "vertical", first, last, photometry, expected })
    }
}

fn fold(photometry: Photometry, angles: &[f32]) -> Result<Fold, WebError> {
    let (first, last) = match *angles {
        [first, .., last] => (first, last),
        [only] => (only, only),
        [] => (f32::NAN, f32::NAN),
    };
    let same = |a: f32, b: f32| (a - b).abs() <= SAME;
    let whole = last - first <= 360.0 + SAME;
    let (found, expected) = if photometry == Photometry::C {
        let found = if angles.len() == 1 {
            Some(Fold::Round)
        } else if same(first, 0.0) && same(last, 90.0) {
            Some(Fold::Quadrant)
        } else if same(first, 0.0) && same(last, 180.0) {
            Some(Fold::Half)
        } else if same(first, 90.0) && same(last, 270.0) {
            Some(Fold::HalfAcross)
        } else {
            Some(Fold::Whole).filter(|_| whole && last - first > 180.0)
        };
        (found, "one, or from 0° to 90°, 180° or 360°, or from 90° to 270°")
    } else {
        let inside = angles.len() > 1 && first >= -90.0 - SAME && last <= 90.0 + SAME;
        let kind = if first >= 0.0 { Fold::Mirrored } else { Fold::Signed };
        (Some(kind).filter(|_| inside), "two of them at least, from −90° or 0° to 90°")
    };
    found.ok_or(WebError::Range { which: "horizontal", first, last, photometry, expected })
}

/// Bounds of the light: the sign of the axis and the angle around it.
fn cone(photometry: Photometry, vertical: &[f32], values: &[f32]) -> (f32, f32) {
    if photometry != Photometry::C {
        return (1.0, 0.5 * PI);
    }
    let count = vertical.len();
    let shines = |i: &usize| values.iter().skip(*i).step_by(count).any(|v| *v > 0.0);
    let (Some(low), Some(high)) = ((0..count).find(shines), (0..count).rfind(shines)) else {
        return (1.0, 0.0);
    };
    // Light goes on to the next angle of the table.
    let low = vertical[low.saturating_sub(1)].max(0.0);
    let high = vertical[(high + 1).min(count - 1)].min(180.0);
    let (sign, angle) = if high <= 180.0 - low { (1.0, high) } else { (-1.0, 180.0 - low) };
    (sign, angle.to_radians())
}

#[cfg(test)]
#[path = "web_tests.rs"]
mod tests;
