//! Tone maps: linear Rec. 709 radiance (after exposure) to linear Rec. 709 display light in \[0, 1\], and the sRGB
//! encoding that follows.
//!
//! | name | curve | source |
//! | --- | --- | --- |
//! | `pbr-neutral` | hue-keeping shoulder above 0.76, 1:1 below | Khronos PBR Neutral specification (2024), github.com/KhronosGroup/ToneMapping |
//! | `aces` | S. Hill's fit of the ACES RRT + sRGB ODT, exposure / 0.6 | Hill in MJP's BakingLab; the variant of three.js and of the glTF Sample Viewer's "Hill – Exposure Boost" |
//! | `agx` | AgX "base", Rec. 2020 working space, polynomial contrast | T. Sobotka's AgX, matrices of E. Chow's `AgX_LUT_Gen`, polynomial by B. Wrensch (2023); as in Filament and three.js |
//! | `linear` | none, clipped | |
//!
//! Curves are written here from the published formulas; the matrices and coefficients are the published numbers.

use glam::{Mat3, Vec3, vec3};

/// A tone map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Khronos PBR Neutral: keeps base colours as they are under white light of radiance 1.
    #[default]
    PbrNeutral,
    /// ACES filmic, Hill's fit.
    Aces,
    /// AgX base contrast.
    Agx,
    /// Clipping at 1.
    Linear,
}

impl ToneMap {
    /// Every tone map, the default first.
    pub const ALL: [Self; 4] = [Self::PbrNeutral, Self::Aces, Self::Agx, Self::Linear];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PbrNeutral => "pbr-neutral",
            Self::Aces => "aces",
            Self::Agx => "agx",
            Self::Linear => "linear",
        }
    }

    /// Maps linear radiance to linear display light in \[0, 1\]. Negative channels count as 0.
    pub fn apply(self, radiance: Vec3) -> Vec3 {
        let radiance = radiance.max(Vec3::ZERO);
        let mapped = match self {
            Self::PbrNeutral => pbr_neutral(radiance),
            Self::Aces => aces(radiance),
            Self::Agx => agx(radiance),
            Self::Linear => radiance,
        };
        mapped.clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// The sRGB encoding of linear light in \[0, 1\] (IEC 61966-2-1).
pub fn encode_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Khronos PBR Neutral. `F90`, `K_s`, `K_d` are the specification's names: the Fresnel offset it takes away, where
/// the shoulder starts, and how fast highlights lose saturation.
fn pbr_neutral(color: Vec3) -> Vec3 {
    const F90: f32 = 0.04;
    const K_S: f32 = 0.8 - F90;
    const K_D: f32 = 0.15;

    let x = color.min_element();
    let offset = if x < 2.0 * F90 { x - x * x / (4.0 * F90) } else { F90 };
    let color = color - offset;
    let peak = color.max_element();
    if peak <= K_S {
        return color;
    }
    let shoulder = 1.0 - K_S;
    let compressed = 1.0 - shoulder * shoulder / (peak + shoulder - K_S);
    let white = 1.0 - 1.0 / (K_D * (peak - compressed) + 1.0);
    (color * (compressed / peak)).lerp(Vec3::splat(compressed), white)
}

/// Hill's fit: sRGB → AP1 with RRT saturation, rational curve, ODT saturation → sRGB.
fn aces(color: Vec3) -> Vec3 {
    const INPUT: Mat3 =
        rows([0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]);
    const OUTPUT: Mat3 =
        rows([1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]);
    /// Makes mid grey about as bright as with the other curves.
    const EXPOSURE: f32 = 1.0 / 0.6;

    // The rational function tends to 1/0.983729; beyond this its squares would overflow.
    let v = INPUT * (color * EXPOSURE).min(Vec3::splat(1e15));
    let fitted = (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    OUTPUT * fitted
}

/// AgX: log2 encoding of an inset gamut, a sigmoid, the outset gamut, and back to linear with exponent 2.2.
fn agx(color: Vec3) -> Vec3 {
    const TO_REC_2020: Mat3 =
        rows([0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0113], [0.0164, 0.0880, 0.8956]);
    const FROM_REC_2020: Mat3 =
        rows([1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]);
    const INSET: Mat3 = rows(
        [0.856_627_15, 0.095_121_24, 0.048_251_606],
        [0.137_318_97, 0.761_242, 0.101_439_04],
        [0.111_898_21, 0.076_799_42, 0.811_302_4],
    );
    const OUTSET: Mat3 = rows(
        [1.127_100_6, -0.110_606_64, -0.016_493_939],
        [-0.141_329_76, 1.157_823_7, -0.016_493_939],
        [-0.141_329_76, -0.110_606_64, 1.251_936_4],
    );
    const MIN_EV: f32 = -12.473_93;
    const MAX_EV: f32 = 4.026_069;

    let inset = (INSET * (TO_REC_2020 * color)).max(Vec3::splat(1e-10));
    let log = inset.map(f32::log2);
    let encoded = ((log - MIN_EV) / (MAX_EV - MIN_EV)).clamp(Vec3::ZERO, Vec3::ONE);
    let outset = OUTSET * encoded.map(agx_contrast);
    FROM_REC_2020 * outset.max(Vec3::ZERO).map(|c| c.powf(2.2))
}

/// The sixth-order polynomial for AgX's default contrast curve on \[0, 1\], mean error 3.7·10⁻⁶.
fn agx_contrast(x: f32) -> f32 {
    const COEFFICIENTS: [f32; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
    COEFFICIENTS.into_iter().fold(0.0, |sum, c| sum * x + c)
}

/// A matrix written as it is printed.
const fn rows(r: [f32; 3], g: [f32; 3], b: [f32; 3]) -> Mat3 {
    Mat3::from_cols(vec3(r[0], g[0], b[0]), vec3(r[1], g[1], b[1]), vec3(r[2], g[2], b[2]))
}
