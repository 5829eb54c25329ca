//! Filters of meshopt compression, in place: unit vectors, quaternions, floats and colours from compact integers. After
//! Appendix B of KHR_meshopt_compression.

/// What is done to the elements of mode ATTRIBUTES once they are decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Filter {
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "NONE" => Self::None,
            "OCTAHEDRAL" => Self::Octahedral,
            "QUATERNION" => Self::Quaternion,
            "EXPONENTIAL" => Self::Exponential,
            "COLOR" => Self::Color,
            _ => return None,
        })
    }

    /// Whether elements may have that many bytes.
    pub fn allows(self, stride: usize) -> bool {
        match self {
            Self::None | Self::Exponential => stride.is_multiple_of(4),
            Self::Octahedral | Self::Color => stride == 4 || stride == 8,
            Self::Quaternion => stride == 8,
        }
    }

    /// Applies the filter to elements of `stride` bytes.
    pub fn apply(self, elements: &mut [u8], stride: usize) {
        match self {
            Self::None => {}
            Self::Exponential => {
                each(elements, |v: [u8; 4]| exponential(i32::from_le_bytes(v)).to_le_bytes())
            }
            Self::Octahedral if stride == 4 => each(elements, |v: [u8; 4]| {
                octahedral(v.map(|x| i16::from(x as i8)), 127.0).map(|x| x as i8 as u8)
            }),
            Self::Octahedral => {
                each(elements, |v| bytes(octahedral(words(v).map(|x| x as i16), 32767.0).map(|x| x as u16)))
            }
            Self::Quaternion => {
                each(elements, |v| bytes(quaternion(words(v).map(|x| x as i16)).map(|x| x as u16)))
            }
            Self::Color if stride == 4 => each(elements, |v: [u8; 4]| {
                let chroma = [i32::from(v[1] as i8), i32::from(v[2] as i8)];
                color(u16::from(v[0]), chroma, u16::from(v[3]), 255.0).map(|x| x as u8)
            }),
            Self::Color => each(elements, |v| {
                let v = words(v);
                let chroma = [i32::from(v[1] as i16), i32::from(v[2] as i16)];
                bytes(color(v[0], chroma, v[3], 65535.0))
            }),
        }
    }
}

fn each<const N: usize>(elements: &mut [u8], change: impl Fn([u8; N]) -> [u8; N]) {
    for element in elements.as_chunks_mut::<N>().0 {
        *element = change(*element);
    }
}

fn words(v: [u8; 8]) -> [u16; 4] {
    std::array::from_fn(|k| u16::from_le_bytes([v[2 * k], v[2 * k + 1]]))
}

fn bytes(v: [u16; 4]) -> [u8; 8] {
    std::array::from_fn(|k| v[k / 2].to_le_bytes()[k % 2])
}

/// A unit vector from its place on an octahedron; the third number stands for 1, the fourth is left alone.
fn octahedral([x, y, one, rest]: [i16; 4], top: f32) -> [i16; 4] {
    let (x, y) = (f32::from(x) / f32::from(one), f32::from(y) / f32::from(one));
    let z = 1.0 - x.abs() - y.abs();
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let scale = top / (x * x + y * y + z * z).sqrt();
    [(x * scale).round() as i16, (y * scale).round() as i16, (z * scale).round() as i16, rest]
}

/// A unit quaternion from its three smaller components, scaled by √2; the fourth number stands for 1, but for its last
/// two bits, which say which component is missing.
fn quaternion(v: [i16; 4]) -> [i16; 4] {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(v[3] | 3);
    let [x, y, z] = [v[0], v[1], v[2]].map(|c| f32::from(c) * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let missing = (v[3] & 3) as usize;
    let mut out = [0; 4];
    for (k, c) in [w, x, y, z].into_iter().enumerate() {
        out[(missing + k) % 4] = (c * 32767.0).round() as i16;
    }
    out
}

/// m · 2^e of a mantissa of 24 bits and an exponent of 8, both signed.
fn exponential(v: i32) -> f32 {
    let (exponent, mantissa) = (v >> 24, v << 8 >> 8);
    // Exponents are −128…127: the power is a normal number as a double, and the product is rounded once.
    (f64::from(mantissa) * 2_f64.powi(exponent)) as f32
}

/// RGBA from luma and two chroma numbers of K bits; the highest bit of the fourth number says how many.
fn color(luma: u16, [co, cg]: [i32; 2], alpha: u16, top: f32) -> [u16; 4] {
    let ones = (1_i32 << (16 - alpha.leading_zeros())) - 1;
    let y = i32::from(luma);
    let a = i32::from(alpha) & (ones >> 1);
    let scale = top / ones as f32;
    [y + co - cg, y + cg, y - co - cg, a << 1 | (a & 1)]
        .map(|c| (c as f32 * scale).round().clamp(0.0, top) as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octahedra_give_unit_vectors() {
        let mut bytes = [127, 0, 127, 5, 0, 0, 127, 6, 64, 64_i8 as u8, 127, 7, 127, 127, 127, 8];
        Filter::Octahedral.apply(&mut bytes, 4);
        assert_eq!(bytes[..8], [127, 0, 0, 5, 0, 0, 127, 6]);
        let (x, y, z) = (bytes[8] as i8, bytes[9] as i8, bytes[10] as i8);
        assert!(x == y && x == 90 && z.abs() <= 1, "{x} {y} {z}: (1, 1, 0)/√2 is (90, 90, 0)/127");
        // The corner of the octahedron's square is the south pole.
        assert_eq!(bytes[12..], [0, 0, -127_i8 as u8, 8]);
    }

    #[test]
    fn quaternions_get_their_largest_component_back() {
        for missing in 0..4_i16 {
            let mut v = bytes([0_i16, 0, 0, 0x7ffc | missing].map(|x| x as u16));
            Filter::Quaternion.apply(&mut v, 8);
            let mut expected = [0; 4];
            expected[missing as usize] = 32767;
            assert_eq!(words(v), expected);
        }
        // (½, ½, ½, ½) has √½ of its range in each of the three.
        let half = (32767.0 * 0.5 / std::f64::consts::FRAC_1_SQRT_2).round() as u16;
        let mut v = bytes([half, half, half, 0x7fff]);
        Filter::Quaternion.apply(&mut v, 8);
        for c in words(v) {
            assert!(c.abs_diff(16384) <= 1, "{c}");
        }
    }

    #[test]
    fn exponents_and_mantissas_are_signed() {
        let float = |e: i32, m: i32| exponential(e << 24 | (m & 0x00ff_ffff));
        assert_eq!(float(0, 1), 1.0);
        assert_eq!(float(-2, -3), -0.75);
        assert_eq!(float(100, 8_388_607), 8_388_607.0 * 2_f32.powi(100));
        assert_eq!(float(-100, -8_388_608), -(2_f32.powi(-77)));
    }

    /// 8 bits: white is luma 255, no chroma, alpha 127 below the bit that marks the width.
    #[test]
    fn colors_come_back_from_luma_and_chroma() {
        let mut v = [255, 0, 0, 255, 0, 0, 0, 128];
        Filter::Color.apply(&mut v, 4);
        assert_eq!(v, [255, 255, 255, 255, 0, 0, 0, 0]);
        // 4 bits: r = y + co − cg = 15, g = y + cg = 5, b = y − co − cg = 1.
        let mut v = [7, 7, -2_i8 as u8, 8];
        Filter::Color.apply(&mut v, 4);
        assert_eq!(v, [16 * 17, 5 * 17, 2 * 17, 0].map(|x: u16| x.min(255) as u8));
    }
}
