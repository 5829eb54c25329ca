//! Formulas of glTF 2.0 (appendix B) and of its extensions, from the specifications' texts.

use glam::DVec3;
use std::f64::consts::PI;

/// Directions to the viewer and to the light in the frame (tangent, bitangent, normal), and half-way between.
#[derive(Clone, Copy, Debug)]
pub struct Geometry {
    pub v: DVec3,
    pub l: DVec3,
    pub h: DVec3,
}

impl Geometry {
    pub fn new(v: DVec3, l: DVec3) -> Self {
        Self { v, l, h: (v + l).normalize() }
    }
}

/// From the polar angle and the azimuth, degrees.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((st, ct), (sp, cp)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(st * cp, st * sp, ct)
}

/// Schlick's approximation.
pub fn schlick(f0: f64, f90: f64, cos: f64) -> f64 {
    f0 + (f90 - f0) * (1.0 - cos).powi(5)
}

/// Reflectance at normal incidence.
pub fn f0(ior: f64) -> f64 {
    ((ior - 1.0) / (ior + 1.0)).powi(2)
}

/// D G/(4 |N·L| |N·V|) of GGX with the separable masking of appendix B; widths along the tangent and across
/// (KHR_materials_anisotropy).
pub fn microfacets(g: &Geometry, widths: [f64; 2]) -> f64 {
    let [at, ab] = widths;
    let scaled = DVec3::new(g.h.x / at, g.h.y / ab, g.h.z).length_squared();
    let d = 1.0 / (PI * at * ab * scaled * scaled);
    // 2 |N·L|/(|N·L| + √(α² + (1 − α²)(N·L)²)), where α² + (1 − α²)(N·L)² is α² sin² + cos².
    let masking = |w: DVec3| 2.0 * w.z / (w.z + DVec3::new(at * w.x, ab * w.y, w.z).length());
    d * masking(g.l) * masking(g.v) / (4.0 * g.l.z * g.v.z)
}

/// D V of KHR_materials_sheen.
pub fn sheen(g: &Geometry, roughness: f64) -> f64 {
    let alpha_g = roughness * roughness;
    let mix = |x: f64, y: f64| {
        let m = (1.0 - alpha_g) * (1.0 - alpha_g);
        x * (1.0 - m) + y * m
    };
    let l = |x: f64| {
        mix(21.5473, 25.3245) / (1.0 + mix(3.82987, 3.32435) * x.powf(mix(0.19823, 0.16801)))
            + mix(-1.97760, -1.27393) * x
            + mix(-4.32054, -4.85967)
    };
    let lambda = |c: f64| if c < 0.5 { l(c).exp() } else { (2.0 * l(0.5) - l(1.0 - c)).exp() };
    let d = (2.0 + 1.0 / alpha_g) * (1.0 - g.h.z * g.h.z).max(0.0).powf(0.5 / alpha_g) / (2.0 * PI);
    d / ((1.0 + lambda(g.v.z) + lambda(g.l.z)) * 4.0 * g.v.z * g.l.z)
}

/// ∫ f(v, l) N·L dl over the hemisphere, by `steps`² midpoints.
pub fn albedo(v: DVec3, steps: u32, f: impl Fn(&Geometry) -> f64) -> f64 {
    let n = f64::from(steps);
    let mut sum = 0.0;
    for a in 0..steps {
        let theta = 90.0 * (f64::from(a) + 0.5) / n;
        for b in 0..steps {
            let l = direction(theta, 360.0 * (f64::from(b) + 0.5) / n);
            sum += f(&Geometry::new(v, l)) * l.z * theta.to_radians().sin();
        }
    }
    sum * (0.5 * PI / n) * (2.0 * PI / n)
}

/// Exact reflectance of a dielectric at the cosine `c`, of relative index `n`.
pub fn fresnel(c: f64, n: f64) -> f64 {
    let t = (1.0 - (1.0 - c * c) / (n * n)).max(0.0).sqrt();
    let (s, p) = ((c - n * t) / (c + n * t), (n * c - t) / (n * c + t));
    0.5 * (s * s + p * p)
}

/// Colour matching functions as sums of Gaussians (Wyman, Sloan & Shirley 2013), at `nm` nanometres.
pub fn color_matching(nm: f64) -> DVec3 {
    let g = |peak: f64, below: f64, above: f64| {
        let t = (nm - peak) / if nm < peak { below } else { above };
        (-0.5 * t * t).exp()
    };
    DVec3::new(
        1.056 * g(599.8, 37.9, 31.0) + 0.362 * g(442.0, 16.0, 26.7) - 0.065 * g(501.1, 20.4, 26.2),
        0.821 * g(568.8, 46.9, 40.5) + 0.286 * g(530.9, 16.3, 31.1),
        1.217 * g(437.0, 11.8, 36.0) + 0.681 * g(459.0, 26.0, 13.8),
    )
}

/// CIE XYZ to linear Rec. 709.
pub fn rec709(xyz: DVec3) -> DVec3 {
    DVec3::new(
        DVec3::new(3.240_454_2, -1.537_138_5, -0.498_531_4).dot(xyz),
        DVec3::new(-0.969_266, 1.876_010_8, 0.041_556).dot(xyz),
        DVec3::new(0.055_643_4, -0.204_025_9, 1.057_225_2).dot(xyz),
    )
}

/// EON (Portsmouth, Kutz & Hill 2024), listing 1: the BRDF, and the directional albedo towards `g.v`.
pub fn eon(g: &Geometry, rho: f64, r: f64) -> (f64, f64) {
    let af = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
    let e = |mu: f64| {
        let sin = (1.0 - mu * mu).max(0.0).sqrt();
        let tangent = sin / mu * (1.0 - sin.powi(3));
        af + r * af / PI * (sin * (mu.min(1.0).acos() - sin * mu) + 2.0 / 3.0 * (tangent - sin))
    };
    let average = af * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
    let s = g.v.dot(g.l) - g.v.z * g.l.z;
    let once = rho / PI * af * (1.0 + r * if s > 0.0 { s / g.v.z.max(g.l.z) } else { s });
    let again = rho * rho * average / (1.0 - rho * (1.0 - average));
    let more = again / PI * (1.0 - e(g.v.z)) * (1.0 - e(g.l.z)) / (1.0 - average);
    (once + more, rho * e(g.v.z) + again * (1.0 - e(g.v.z)))
}

/// The fuzz of Zeltner, Burley & Chiang 2022 by MaterialX's fits, the mean of both directions.
pub fn fuzz(g: &Geometry, y: f64) -> f64 {
    let reflected = |x: f64| {
        let s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y));
        let m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y);
        let o = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y));
        (-0.5 * ((x - m) / s).powi(2)).exp() / (s * (2.0 * PI).sqrt()) + o
    };
    let lobe = |o: DVec3, i: DVec3| {
        let x = o.z;
        let a = (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y);
        let b = (1.0 - x).max(0.0).sqrt() * (y - 1.0) * y * y * y
            / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y);
        let along = DVec3::new(o.x, o.y, 0.0).normalize_or(DVec3::X);
        let across = DVec3::Z.cross(along);
        let w = DVec3::new(a * along.dot(i) + b * i.z, a * across.dot(i), i.z);
        reflected(x) / PI * (a / w.length_squared()).powi(2)
    };
    0.5 * (lobe(g.v, g.l) + lobe(g.l, g.v))
}
