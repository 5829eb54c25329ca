//! Exponentially distributed numbers without a logarithm: the ziggurat.
//!
//! Marsaglia & Tsang 2000, "The ziggurat method for generating random variables". The area below e^{−x} is cut into 256
//! layers of equal area, 255 rectangles and a strip with the tail. In a layer chosen at random a uniform x is nearly
//! always below the curve whatever its height (98.9 %), which one comparison tells. A walk draws one for each flight;
//! the logarithm of [`super::fast_math`] would be a third of what an event far from the boundary costs.

use super::rng::SmallRng;

const LAYERS: usize = 256;
/// Where the tail begins, which with the strip below it has the area [`AREA`] of every layer.
const TAIL: f64 = 7.697_117_470_131_05;
const AREA: f64 = 3.949_659_822_581_557e-3;
/// e^{−[`TAIL`]}.
const HEIGHT_OF_TAIL: f64 = 4.541_343_538_414_967e-4;

/// Layers from the lowest up.
struct Layers {
    /// Width of each layer, and what of it is below the curve at any height.
    widths: [[f32; 2]; LAYERS],
    /// Height of the lower edge of each layer.
    heights: [f32; LAYERS + 1],
}

static ZIGGURAT: Layers = Layers::new();

impl Layers {
    const fn new() -> Self {
        let mut this = Self { widths: [[0.0; 2]; LAYERS], heights: [0.0; LAYERS + 1] };
        // The lowest one is as wide as a rectangle of the same area and height would be.
        this.widths[0] = [(AREA / HEIGHT_OF_TAIL) as f32, TAIL as f32];
        let (mut x, mut height) = (TAIL, HEIGHT_OF_TAIL);
        let mut i = 1;
        while i < LAYERS {
            this.heights[i] = height as f32;
            height += AREA / x;
            let next = if i == LAYERS - 1 { 0.0 } else { -ln(height) };
            this.widths[i] = [x as f32, next as f32];
            x = next;
            i += 1;
        }
        this.heights[LAYERS] = 1.0;
        this
    }
}

/// The natural logarithm of a number in (0, 2), where the standard library's is not yet constant.
const fn ln(mut x: f64) -> f64 {
    let mut halvings = 0.0;
    while x < 0.75 {
        x *= 2.0;
        halvings += 1.0;
    }
    // 2 artanh((x − 1)/(x + 1)) as a series; the argument is at most 1/3.
    let z = (x - 1.0) / (x + 1.0);
    let (mut power, mut sum, mut n) = (z, 0.0, 1.0);
    while n < 60.0 {
        sum += power / n;
        power *= z * z;
        n += 2.0;
    }
    2.0 * sum - halvings * std::f64::consts::LN_2
}

impl SmallRng {
    /// Positive, with density e^{−x}.
    #[inline]
    pub fn exponential(&mut self) -> f32 {
        let bits = self.next_u32();
        let layer = bits as u8;
        let [width, inside] = ZIGGURAT.widths[usize::from(layer)];
        let x = uniform(bits) * width;
        if x < inside { x } else { self.exponential_at_edge(layer, x) }
    }

    #[cold]
    #[inline(never)]
    fn exponential_at_edge(&mut self, mut layer: u8, mut x: f32) -> f32 {
        let mut beyond = 0.0;
        loop {
            let i = usize::from(layer);
            let [width, inside] = ZIGGURAT.widths[i];
            if x < inside {
                return beyond + x;
            }
            if layer == 0 {
                // The tail of an exponential distribution is one itself.
                beyond += TAIL as f32;
            } else {
                let [low, high] = [ZIGGURAT.heights[i], ZIGGURAT.heights[i + 1]];
                if x < width && low + (high - low) * self.f32() < (-x).exp() {
                    return beyond + x;
                }
            }
            let bits = self.next_u32();
            layer = bits as u8;
            x = uniform(bits) * ZIGGURAT.widths[usize::from(layer)][0];
        }
    }
}

/// Uniform in (0, 1] from all bits but the lowest eight.
#[inline]
fn uniform(bits: u32) -> f32 {
    ((bits >> 8) as f32 + 0.5) * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::statistics::chi_square_z;

    #[test]
    fn layers_have_equal_areas_and_end_at_the_top() {
        for i in 1..LAYERS {
            let [width, inside] = ZIGGURAT.widths[i];
            let height = ZIGGURAT.heights[i + 1] - ZIGGURAT.heights[i];
            // Heights are rounded to 6e-8 of at most 1.
            assert!((f64::from(width * height) - AREA).abs() < 2e-6, "layer {i}");
            assert!((ZIGGURAT.heights[i] - (-width).exp()).abs() < 2e-7, "layer {i}");
            assert!(inside < width);
        }
        assert!((AREA - (TAIL + 1.0) * HEIGHT_OF_TAIL).abs() < 1e-15);
        assert!((HEIGHT_OF_TAIL - (-TAIL).exp()).abs() < 1e-17);
    }

    /// Chi-square over 64 intervals of equal probability and 16 more of the tail, 4 million draws, |z| < 4.
    #[test]
    fn draws_follow_the_exponential_distribution() {
        const N: usize = 4_000_000;
        let mut rng = SmallRng::new(5);
        let edges: Vec<f64> = (1..64)
            .map(|i| -(1.0 - f64::from(i) / 64.0).ln())
            .chain((1..=16).map(|i| 64f64.ln() + 0.4 * f64::from(i)))
            .collect();
        let mut counts = vec![0_u64; edges.len() + 1];
        let mut sum = 0.0;
        for _ in 0..N {
            let x = f64::from(rng.exponential());
            assert!(x > 0.0);
            sum += x;
            counts[edges.partition_point(|&e| e <= x)] += 1;
        }
        let below = |i: usize| if i == 0 { 1.0 } else { (-edges[i - 1]).exp() };
        let expected: Vec<f64> = (0..counts.len())
            .map(|i| N as f64 * (below(i) - if i < edges.len() { below(i + 1) } else { 0.0 }))
            .collect();
        let z = chi_square_z(&counts, &expected);
        assert!(z.abs() < 4.0, "z = {z}");
        assert!((sum / N as f64 - 1.0).abs() < 4.0 / (N as f64).sqrt());
    }
}
