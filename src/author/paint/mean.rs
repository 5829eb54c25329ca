//! The homogeneous medium that other viewers get of one whose coefficients come from textures.

use crate::author::Medium;
use crate::optics::albedo;

/// Fields of a grid over a texture along each side, each of which is looked up in its middle.
const SIDE: u32 = 64;

/// Column and row of the texel in the middle of field `i` of a picture of that size.
pub fn field(i: u32, [width, height]: [u32; 2]) -> [u32; 2] {
    let middle = |i: u32, n: u32| ((2 * u64::from(i) + 1) * u64::from(n) / (2 * u64::from(SIDE))) as u32;
    [middle(i % SIDE, width), middle(i / SIDE, height)]
}

/// The medium of the mean extinction and the mean multi-scatter albedo: `white` is that of white texels, `texels` has those
/// of both textures in a field.
pub fn mean(white: Medium, texels: impl Fn(u32) -> [[f64; 3]; 2]) -> Medium {
    let mut rho = [0.0; 3];
    let mut sigma_t = [0.0; 3];
    let count = f64::from(SIDE * SIDE);
    for i in 0..SIDE * SIDE {
        let [absorption, scattering] = texels(i);
        for c in 0..3 {
            let (a, s) = (white.sigma_a[c] * absorption[c], white.sigma_s[c] * scattering[c]);
            let single = if a + s > 0.0 { s / (a + s) } else { 0.0 };
            rho[c] += f64::from(albedo::multiple_from_single(single as f32, white.g as f32)) / count;
            sigma_t[c] += (a + s) / count;
        }
    }
    let of = |share: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|c| sigma_t[c] * f64::from(share(rho[c] as f32, white.g as f32)))
    };
    Medium { sigma_a: of(albedo::absorbed_from_multiple), sigma_s: of(albedo::single_from_multiple), ..white }
}
