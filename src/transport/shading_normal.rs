//! The normal with which a boundary of a medium refracts where shading normals differ from the triangles'.
//! `docs/shading-normals.md` derives it.
//!
//! All directions and normals here are unit vectors, and normals are on the side from which light arrives.

use super::path::PathTracer;
use super::state::Path;
use crate::optics::fresnel;
use crate::sampling::Sampler;
use crate::scene::Surface;
use glam::Vec3;

/// Total reflections in a row that follow the shading normal alone. More of them are hardly seen as a picture of anything,
/// and light that shading normals have trapped has to be let go.
const SMOOTH_TOTAL_REFLECTIONS: u32 = 8;

/// Normals whose cosine is larger are the same: flat shading written to a file, and rounded there. 0.08°.
const SAME_NORMAL: f32 = 1.0 - 1e-6;

/// Least cosine to the triangle of what leaves about another normal than the triangle's. A ray that hardly leaves the plane
/// of its triangle slips past the next one's edge by rounding, and is taken to be on the side that it is not.
const GRAZING: f32 = 1e-3;

/// Steps of the search between two normals: as close as single precision tells directions near each other apart.
const BISECTIONS: u32 = 16;

/// A direction that meets a boundary.
struct Arrival {
    /// Towards where the path comes from.
    wo: Vec3,
    /// Normal of the triangle.
    geometric: Vec3,
    /// Index beyond over index here.
    eta: f32,
    /// Whether the triangle would reflect it totally.
    total: bool,
}

/// A normal, and whether the boundary reflects totally about it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Chosen {
    normal: Vec3,
    total: bool,
}

impl Arrival {
    fn new(wo: Vec3, geometric: Vec3, eta: f32) -> Self {
        Self { wo, geometric, eta, total: fresnel::refract(wo, geometric, eta).is_none() }
    }

    /// Whether reflection about `normal` stays on this side of the triangle, refraction crosses it, and reflection is total
    /// only where the triangle's is.
    fn admits(&self, normal: Vec3) -> bool {
        let cosine = self.wo.dot(normal);
        let reflected = 2.0 * cosine * normal - self.wo;
        if cosine <= 0.0 || reflected.dot(self.geometric) <= GRAZING {
            return false;
        }
        match fresnel::refract(self.wo, normal, self.eta) {
            Some(refracted) => refracted.dot(self.geometric) < -GRAZING,
            None => self.total,
        }
    }

    /// The admitted normal on the way from `shading` to the triangle's that is closest to `shading`. Where only the shading
    /// normal reflects totally it is the triangle's: anything between would reflect nearly everything.
    fn normal(&self, shading: Vec3) -> Vec3 {
        if self.admits(shading) {
            return shading;
        }
        if !self.total && fresnel::refract(self.wo, shading, self.eta).is_none() {
            return self.geometric;
        }
        let at = |t: f32| shading.lerp(self.geometric, t).normalize_or(self.geometric);
        let (mut refused, mut admitted) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (refused + admitted);
            if self.admits(at(middle)) { admitted = middle } else { refused = middle }
        }
        if admitted < 1.0 { at(admitted) } else { self.geometric }
    }

    /// The normal after so many total reflections in a row; `geometric` says whether the triangle's is to be taken where a
    /// choice is due.
    fn choose(&self, shading: Vec3, in_a_row: u32, geometric: impl FnOnce() -> bool) -> Chosen {
        let normal = self.normal(shading);
        let total = fresnel::refract(self.wo, normal, self.eta).is_none();
        if total && in_a_row >= SMOOTH_TOTAL_REFLECTIONS && geometric() {
            return Chosen { normal: self.geometric, total };
        }
        Chosen { normal, total }
    }
}

/// The normal with which light that has come straight from an event below leaves a boundary: `shading` or one between it
/// and the triangle's. All to the front; `eta` is the index inside over outside.
pub(super) fn from_below(surface: &Surface, shading: Vec3, wo: Vec3, eta: f32) -> Vec3 {
    if shading.dot(surface.geometric_normal) >= SAME_NORMAL {
        return shading;
    }
    -Arrival::new(wo, -surface.geometric_normal, 1.0 / eta).normal(-shading)
}

impl PathTracer<'_> {
    /// The normal with which a path refracts that comes along −`wo` to a boundary: as [`from_below`], from either side.
    /// Total reflections are counted.
    pub(super) fn refracting_normal(
        &self,
        surface: &Surface,
        shading: Vec3,
        wo: Vec3,
        eta: f32,
        path: &mut Path,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let geometric = surface.geometric_normal;
        if shading.dot(geometric) >= SAME_NORMAL {
            return shading;
        }
        let (side, eta) = if wo.dot(geometric) > 0.0 { (1.0, eta) } else { (-1.0, 1.0 / eta) };
        let arrival = Arrival::new(wo, side * geometric, eta);
        let coin = || sampler.rng().f32() < 0.5;
        let chosen = arrival.choose(side * shading, path.total_reflections, coin);
        path.total_reflections = if chosen.total { path.total_reflections + 1 } else { 0 };
        side * chosen.normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::SmallRng;

    /// Index ratios from both sides of water, glass and diamond.
    const ETAS: [f32; 6] = [1.33, 1.5, 2.4, 1.0 / 1.33, 1.0 / 1.5, 1.0 / 2.4];

    fn direction(rng: &mut SmallRng) -> Vec3 {
        let z = 2.0 * rng.f32() - 1.0;
        let (sin, cos) = (std::f32::consts::TAU * rng.f32()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * cos, r * sin, z)
    }

    fn above(normal: Vec3, w: Vec3) -> Vec3 {
        if w.dot(normal) < 0.0 { -w } else { w }
    }

    /// Arrivals from everywhere above a triangle, with shading normals from everywhere above it.
    fn cases(mut check: impl FnMut(&Arrival, Vec3)) {
        let mut rng = SmallRng::new(3);
        for eta in ETAS {
            for _ in 0..20_000 {
                let geometric = direction(&mut rng);
                let wo = above(geometric, direction(&mut rng));
                let spread = rng.f32();
                let shading = (geometric + spread * direction(&mut rng)).normalize();
                check(&Arrival::new(wo, geometric, eta), above(geometric, shading));
            }
        }
    }

    #[test]
    fn reflections_stay_and_refractions_cross() {
        cases(|arrival, shading| {
            let n = arrival.normal(shading);
            assert!(arrival.admits(n) || n == arrival.geometric, "{shading} {n}");
            let reflected = 2.0 * arrival.wo.dot(n) * n - arrival.wo;
            // The triangle's own normal is admitted but for the rounding of grazing directions.
            assert!(reflected.dot(arrival.geometric) > -1e-6);
            match fresnel::refract(arrival.wo, n, arrival.eta) {
                Some(refracted) => assert!(refracted.dot(arrival.geometric) < 1e-6),
                None => assert!(arrival.total, "only the shading normal reflects totally"),
            }
        });
    }

    #[test]
    fn normals_that_are_consistent_stay_as_they_are() {
        let mut kept = 0;
        cases(|arrival, shading| {
            if arrival.admits(shading) {
                kept += 1;
                assert_eq!(arrival.choose(shading, 0, || true).normal, shading);
            }
        });
        assert!(kept > 60_000, "{kept}");
    }

    #[test]
    fn long_chains_of_total_reflections_choose_between_both_normals() {
        cases(|arrival, shading| {
            let few = arrival.choose(shading, SMOOTH_TOTAL_REFLECTIONS - 1, || true);
            let many = |geometric| arrival.choose(shading, SMOOTH_TOTAL_REFLECTIONS, || geometric);
            assert_eq!(few, many(false));
            assert_eq!(many(true).normal, if few.total { arrival.geometric } else { few.normal });
        });
    }
}
