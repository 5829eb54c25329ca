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
