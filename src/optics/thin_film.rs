//! Reflectance of a thin film on a base: KHR_materials_iridescence, after Belcour & Barla 2017 ("A Practical Extension to
//! Microfacet Theory for the Modeling of Varying Iridescence").
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `r12`, `t121` | R12, T121 | reflectance of the film's surface, and what crosses it twice |
//! | `r23` | R23 | reflectance of the base below the film |
//! | `opd` | 2 η d cos θ2 | difference of the optical paths, nanometres |
//!
//! Light that goes back and forth m times in the film has the amplitude of a geometric series and the phase m·(opd, φ);
//! the eye's response to it is a sum of Gaussians, whose Fourier transform is known. Like the specification, reflectances
//! are Schlick's, two orders are summed, and phases are 0 or π. The path difference uses the angle in the film, as the
//! paper has it.

use super::fresnel::schlick_weight;
use glam::{Mat3, Vec3};
use std::f32::consts::{PI, TAU};

/// Films thinner than this many nanometres fade away, since two orders do not add up to the bare base at 0.
const FADING: f32 = 0.03;

/// A film between the outside (index 1) and a base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm {
    ior: f32,
    thickness: f32,
    base_ior: Vec3,
}

impl ThinFilm {
    /// A film of index `ior` ≥ 1, `thickness` nanometres, on a base whose reflectance in air at normal incidence is
    /// `base_f0`.
    pub fn new(ior: f32, thickness: f32, base_f0: Vec3) -> Self {
        let faded = (thickness / FADING).clamp(0.0, 1.0);
        let faded = faded * faded * (3.0 - 2.0 * faded);
        let base_ior = base_f0.clamp(Vec3::splat(1e-4), Vec3::splat(0.9999)).map(|f0| {
            let root = f0.sqrt();
            (1.0 + root) / (1.0 - root)
        });
        Self { ior: 1.0 + (ior - 1.0) * faded, thickness, base_ior }
    }

    /// Reflectance in \[0, 1\] at the cosine of incidence `cos`, outside.
    pub fn reflectance(&self, cos: f32) -> Vec3 {
        let eta = self.ior;
        let cos2_squared = 1.0 - (1.0 - cos * cos) / (eta * eta);
        if cos2_squared <= 0.0 {
            return Vec3::ONE;
        }
        let cos2 = cos2_squared.sqrt();
        let r12 = schlick(normal(eta, 1.0), cos);
        let t121 = 1.0 - r12;
        let r23 = self.base_ior.map(|n| schlick(normal(n, eta), cos2));
        let phi21 = PI;
        let phi = self.base_ior.map(|n| phi21 + if n < eta { PI } else { 0.0 });
        let opd = 2.0 * eta * self.thickness * cos2;
        let r123 = (r12 * r23).clamp(Vec3::splat(1e-5), Vec3::splat(0.9999));
        let root = r123.map(f32::sqrt);
        let rs = t121 * t121 * r23 / (Vec3::ONE - r123);
        let mut sum = Vec3::splat(r12) + rs;
        let mut amplitude = rs - Vec3::splat(t121);
        for m in [1.0, 2.0] {
            amplitude *= root;
            sum += amplitude * 2.0 * sensitivity(m * opd, m * phi);
        }
        sum.clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// Reflectance at normal incidence between two indices.
fn normal(beyond: f32, here: f32) -> f32 {
    let r = (beyond - here) / (beyond + here);
    r * r
}

fn schlick(f0: f32, cos: f32) -> f32 {
    f0 + (1.0 - f0) * schlick_weight(cos)
}

/// The eye's response to a wave of path difference `opd` nanometres and a phase for each channel, linear Rec. 709: the
/// Fourier transform of the colour matching functions as Gaussians (Belcour & Barla 2017, §4).
fn sensitivity(opd: f32, shift: Vec3) -> Vec3 {
    const VALUE: [f32; 4] = [5.4856e-13, 4.4201e-13, 5.2481e-13, 9.7470e-14];
    const PLACE: [f32; 4] = [1.6810e6, 1.7953e6, 2.2084e6, 2.2399e6];
    const VARIANCE: [f32; 4] = [4.3278e9, 9.3046e9, 6.6121e9, 4.5282e9];
    const NORM: f32 = 1.0685e-7;
    let to_rec709 = Mat3::from_cols(
        Vec3::new(3.240_454_2, -0.969_266, 0.055_643_4),
        Vec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
        Vec3::new(-0.498_531_4, 0.041_556, 1.057_225_2),
    );
    let phase = TAU * opd * 1e-9;
    let lobe = |i: usize, shift: f32| {
        let width = (TAU * VARIANCE[i]).sqrt();
        VALUE[i] * width * (PLACE[i] * phase + shift).cos() * (-VARIANCE[i] * phase * phase).exp() / NORM
    };
    let x = lobe(0, shift.x) + lobe(3, shift.x);
    to_rec709 * Vec3::new(x, lobe(1, shift.y), lobe(2, shift.z))
}
