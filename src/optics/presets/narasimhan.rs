//! Narasimhan, Gupta, Donner, Ramamoorthi, Nayar & Jensen, "Acquiring scattering properties of participating media by
//! dilution" (SIGGRAPH 2006): 35 liquids and dissolved powders, at the concentrations of the paper's table. Red, green
//! and blue as the authors measured them, taken for linear Rec. 709; the index is that of water.
//!
//! Where a channel has neither scattering nor g, the scattering was too weak to be measured.

use super::{Preset, Source};

const fn preset(name: &'static str, sigma_a: [f64; 3], sigma_s: [f64; 3], g: [f64; 3]) -> Preset {
    Preset {
        name,
        source: Source::Narasimhan2006,
        sigma_a_per_mm: sigma_a,
        sigma_s_per_mm: sigma_s,
        g,
        eta: 1.33,
        note: "",
    }
}

/// All media of the paper.
#[rustfmt::skip]
pub const NARASIMHAN_2006: [Preset; 35] = [
    preset("lowfat-milk", [0.002875, 0.00575, 0.0115], [13.1157, 15.4445, 17.9572], [0.932, 0.902, 0.859]),
    preset("regular-milk", [0.0015333, 0.0046, 0.019933], [18.2052, 20.3826, 22.3698], [0.75, 0.714, 0.681]),
    preset("mint-mocha-coffee", [3.772, 5.8228, 7.82], [3.51133, 4.14383, 5.59667], [0.91, 0.907, 0.914]),
    preset("regular-soy-milk", [0.0019167, 0.0095833, 0.065167], [4.66325, 5.20183, 8.74575], [0.873, 0.858, 0.832]),
    preset("regular-chocolate-milk", [0.010063, 0.043125, 0.14375], [10.5685, 13.1416, 15.2202], [0.862, 0.838, 0.806]),
    preset("pepsi", [0.091641, 0.14158, 0.20729], [0.00083, 0.00203, 0.0], [0.926, 0.979, 0.0]),
    preset("gatorade", [0.024794, 0.019289, 0.008878], [0.03668, 0.04488, 0.05742], [0.933, 0.933, 0.935]),
    preset("white-zinfandel", [0.012072, 0.016184, 0.019843], [0.00022, 0.00033, 0.00046], [0.919, 0.943, 0.972]),
    preset("budweiser-beer", [0.011492, 0.024911, 0.057786], [0.00029, 0.00055, 0.00059], [0.917, 0.956, 0.982]),
    preset("clorox", [0.0033542, 0.014892, 0.026297], [0.02731, 0.03302, 0.03695], [0.912, 0.905, 0.892]),
    preset("cranberry-juice", [0.039437, 0.094223, 0.12426], [0.00196, 0.00238, 0.00301], [0.947, 0.951, 0.974]),
    preset("ruby-grapefruit-juice", [0.085867, 0.18314, 0.25262], [0.15496, 0.15391, 0.15995], [0.929, 0.929, 0.931]),
    preset("shampoo", [0.014107, 0.045693, 0.061717], [0.00797, 0.00874, 0.01127], [0.91, 0.905, 0.92]),
    preset("head-and-shoulders-shampoo", [0.084621, 0.15688, 0.20365], [0.26747, 0.27696, 0.29574], [0.911, 0.896, 0.884]),
    preset("orange-powder", [0.001449, 0.003441, 0.007863], [0.00193, 0.00213, 0.00226], [0.919, 0.918, 0.922]),
    preset("cappuccino-powder", [35.844, 49.547, 61.084], [12.2094, 16.4659, 29.2727], [0.849, 0.843, 0.926]),
    preset("sugar-powder", [0.012638, 0.031051, 0.050124], [0.00282, 0.00315, 0.00393], [0.921, 0.919, 0.931]),
    preset("pacific-ocean-surface-water", [0.031845, 0.031324, 0.030147], [0.0018, 0.00183, 0.00228], [0.902, 0.825, 0.914]),
    preset("reduced-milk", [0.0025556, 0.0051111, 0.012778], [13.7335, 15.6003, 17.8007], [0.819, 0.797, 0.746]),
    preset("espresso", [4.7984, 6.5751, 8.8493], [7.78262, 8.1305, 8.53875], [0.907, 0.896, 0.88]),
    preset("lowfat-soy-milk", [0.0014375, 0.0071875, 0.035937], [2.03838, 2.32875, 3.90281], [0.85, 0.853, 0.842]),
    preset("lowfat-chocolate-milk", [0.0115, 0.0368, 0.1564], [9.8371, 11.4954, 13.1629], [0.934, 0.927, 0.916]),
    preset("coke", [0.10014, 0.16503, 0.2468], [0.00254, 0.00299, 0.0], [0.965, 0.972, 0.0]),
    preset("sprite", [0.001886, 0.0018308, 0.0020025], [0.00011, 0.00014, 0.00014], [0.943, 0.953, 0.952]),
    preset("chardonnay", [0.010782, 0.011855, 0.023997], [0.00021, 0.00033, 0.00048], [0.914, 0.958, 0.975]),
    preset("merlot", [0.11632, 0.25191, 0.29434], [0.00081, 0.0, 0.0], [0.974, 0.0, 0.0]),
    preset("coors-light-beer", [0.006164, 0.013984, 0.034983], [0.00062, 0.00127, 0.0], [0.918, 0.966, 0.0]),
    preset("apple-juice", [0.012957, 0.023741, 0.052184], [0.00257, 0.00311, 0.00413], [0.947, 0.949, 0.945]),
    preset("grape-juice", [0.10404, 0.23958, 0.29325], [0.00138, 0.0, 0.0], [0.961, 0.0, 0.0]),
    preset("white-grapefruit-juice", [0.0138, 0.018831, 0.056781], [0.50499, 0.52742, 0.75282], [0.548, 0.545, 0.565]),
    preset("strawberry-shampoo", [0.01449, 0.05796, 0.075823], [0.00215, 0.00245, 0.00253], [0.927, 0.935, 0.994]),
    preset("lemon-tea-powder", [2.4288, 4.5757, 7.2127], [0.74489, 0.83823, 1.00158], [0.946, 0.946, 0.949]),
    preset("pink-lemonade-powder", [0.001165, 0.002366, 0.003195], [0.00123, 0.00133, 0.00131], [0.902, 0.902, 0.904]),
    preset("salt-powder", [0.28415, 0.3257, 0.34148], [0.13805, 0.15677, 0.17865], [0.802, 0.793, 0.821]),
    preset("suisse-mocha-powder", [17.502, 27.004, 35.433], [30.0848, 33.4452, 38.7191], [0.907, 0.894, 0.888]),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Reduced scattering coefficients in 1/mm, which another transcription of the paper's table has.
    #[rustfmt::skip]
    const REDUCED: [(&str, [f64; 3]); 4] = [
        ("lowfat-milk", [0.89187, 1.5136, 2.532]),
        ("regular-chocolate-milk", [1.4585, 2.1289, 2.9527]),
        ("espresso", [0.72378, 0.84557, 1.0247]),
        ("white-grapefruit-juice", [0.22826, 0.23998, 0.32748]),
    ];

    #[test]
    fn two_transcriptions_of_the_table_agree() {
        for (name, reduced) in REDUCED {
            let preset = Preset::named(name).unwrap();
            for (i, expected) in reduced.into_iter().enumerate() {
                let found = preset.coefficients(i).reduced_scattering() / 1000.0;
                assert!((found / expected - 1.0).abs() < 1e-4, "{name} [{i}]: {found} for {expected}");
            }
        }
    }
}
