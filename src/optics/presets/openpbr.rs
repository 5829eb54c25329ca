//! The example materials of OpenPBR with a subsurface (<https://github.com/AcademySoftwareFoundation/OpenPBR>,
//! `examples/`, in its revision f8d6d94; Apache License 2.0). They are made by eye, some after measurements.
//!
//! An example states an observed colour in ACEScg and a mean free path. The colour is converted to linear Rec. 709 and
//! taken for the seen colour, which is how OpenPBR defines it ([`crate::optics::seen_color`]). The length has no unit there;
//! it is taken for centimetres, since that of the marble is the diffuse mean free path of Jensen et al. 2001 in centimetres.
//! Scattering is isotropic.

use super::{Preset, Source};

const fn preset(name: &'static str, sigma_a: [f64; 3], sigma_s: [f64; 3], eta: f64) -> Preset {
    Preset {
        name,
        source: Source::OpenPbr,
        sigma_a_per_mm: sigma_a,
        sigma_s_per_mm: sigma_s,
        g: [0.0; 3],
        eta,
        note: "",
    }
}

/// The examples whose `subsurface_weight` is 1.
#[rustfmt::skip]
pub const OPENPBR_EXAMPLES: [Preset; 15] = [
    preset("openpbr-chocolate", [0.163876, 0.6036, 1.71337], [0.836124, 1.3964, 2.28663], 1.5),
    preset("openpbr-eye-sclera", [0.00164696, 0.0132812, 0.0395086], [0.205822, 0.578435, 0.877923], 1.4),
    preset("openpbr-honey-crystallized", [0.0122171, 0.0275832, 0.412271], [0.487783, 0.472417, 0.0877293], 1.5),
    preset("openpbr-ketchup", [0.0470065, 1.59558, 2.49776], [0.163078, 0.128557, 0.0663411], 1.3),
    preset("openpbr-marble", [0.000125494, 0.000309036, 0.000649655], [0.117383, 0.179224, 0.252515], 1.5),
    preset("openpbr-milk", [0.000106069, 0.000191794, 0.00204773], [0.0541827, 0.0955936, 0.283667], 1.35),
    preset("openpbr-pearl", [0.00052363, 0.000528544, 0.00137662], [0.33281, 0.199471, 0.331957], 1.5),
    preset("openpbr-petroleum", [0.0203198, 0.0644928, 0.273431], [0.0130136, 0.0355072, 0.126569], 1.5),
    preset("openpbr-skin-i", [0.000229668, 0.00517995, 0.0146356], [0.207239, 0.586536, 0.902796], 1.4),
    preset("openpbr-skin-ii", [0.000426891, 0.0145915, 0.0525655], [0.207042, 0.577124, 0.864866], 1.4),
    preset("openpbr-skin-iii", [0.00204247, 0.020104, 0.0538648], [0.205426, 0.571612, 0.863566], 1.4),
    preset("openpbr-skin-iv", [0.00903435, 0.0893077, 0.361241], [0.263445, 0.640619, 1.10935], 1.4),
    preset("openpbr-skin-v", [0.0233443, 0.155644, 0.56921], [0.249135, 0.574283, 0.901379], 1.4),
    preset("openpbr-skin-vi", [0.0951224, 0.380381, 1.10082], [0.177357, 0.349546, 0.369772], 1.4),
    preset("openpbr-snow", [0.000683326, 0.000683326, 0.000136665], [0.499317, 0.499317, 0.0998633], 1.31),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::seen_color::seen_color;

    /// Observed colour in linear Rec. 709, and mean free path in millimetres.
    #[rustfmt::skip]
    const STATED: [(&str, [f64; 3], [f64; 3]); 15] = [
        ("openpbr-chocolate", [0.162, 0.092, 0.059], [1.0, 0.5, 0.25]),
        ("openpbr-eye-sclera", [0.652, 0.5, 0.394], [4.82, 1.69, 1.09]),
        ("openpbr-honey-crystallized", [0.449, 0.319, 0.011], [2.0, 2.0, 2.0]),
        ("openpbr-ketchup", [0.165, 0.006, 0.002], [4.76, 0.58, 0.39]),
        ("openpbr-marble", [0.83, 0.791, 0.753], [8.51, 5.57, 3.95]),
        ("openpbr-milk", [0.815, 0.813, 0.682], [18.42, 10.44, 3.5]),
        ("openpbr-pearl", [0.799, 0.75, 0.701], [3.0, 5.0, 3.0]),
        ("openpbr-petroleum", [0.031, 0.027, 0.023], [30.0, 10.0, 2.5]),
        ("openpbr-skin-i", [0.847, 0.639, 0.553], [4.82, 1.69, 1.09]),
        ("openpbr-skin-ii", [0.799, 0.485, 0.347], [4.82, 1.69, 1.09]),
        ("openpbr-skin-iii", [0.623, 0.433, 0.343], [4.82, 1.69, 1.09]),
        ("openpbr-skin-iv", [0.437, 0.227, 0.131], [3.67, 1.37, 0.68]),
        ("openpbr-skin-v", [0.282, 0.149, 0.079], [3.67, 1.37, 0.68]),
        ("openpbr-skin-vi", [0.09, 0.05, 0.02], [3.67, 1.37, 0.68]),
        ("openpbr-snow", [0.85, 0.85, 0.85], [2.0, 2.0, 10.0]),
    ];

    #[test]
    fn the_coefficients_show_the_colours_that_are_stated() {
        for (preset, (name, color, mean_free_path)) in OPENPBR_EXAMPLES.iter().zip(STATED) {
            assert_eq!(preset.name, name);
            for i in 0..3 {
                let c = preset.coefficients(i);
                assert!((1000.0 * c.mean_free_path() / mean_free_path[i] - 1.0).abs() < 1e-4, "{name} [{i}]");
                let seen = seen_color(c.albedo(), 0.0, c.eta);
                assert!((seen - color[i]).abs() < 1e-4, "{name} [{i}]: {seen} for {}", color[i]);
            }
        }
    }
}
