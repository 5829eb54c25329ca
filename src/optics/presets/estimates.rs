//! Our own estimates of matter that people look for and nobody has measured in a way that we could use. Nothing here is a
//! measurement; each has a sentence on what it is derived from.
//!
//! Most start from a colour, that of photographs or of published colour measurements, taken for the seen colour
//! ([`crate::optics::seen_color`]), and from a mean free path that makes the thing as translucent at its real size as it is
//! known to be; scattering is then isotropic and stands for the reduced scattering of what scatters forward. Where light
//! goes through, so that there is no colour of a deep layer, coefficients were chosen by eye for bodies of the real size.
//!
//! Skin: the classes of Del Bino et al. 2006 by the individual typology angle, arctan((L* − 50)/b*) (Chardon et al. 1991), a
//! colour of each; σs′ = 4.6/mm (λ/500 nm)^−1.421 (Jacques, "Optical properties of biological tissues: a
//! review", 2013) at 610, 550 and 465 nm.

use super::{Preset, Source};

const fn preset(
    name: &'static str,
    sigma_a: [f64; 3],
    sigma_s: [f64; 3],
    eta: f64,
    g: f64,
    note: &'static str,
) -> Preset {
    Preset {
        name,
        source: Source::Estimate,
        sigma_a_per_mm: sigma_a,
        sigma_s_per_mm: sigma_s,
        g: [g; 3],
        eta,
        note,
    }
}

/// All estimates, by what they are of: stone, wax and resin, sweets, plants and food, liquids, bodies, and others.
#[rustfmt::skip]
pub const ESTIMATES: [Preset; 70] = [
    preset("jade", [0.062, 0.02, 0.046], [0.62, 0.68, 0.64], 1.61, 0.0,
        "Green nephrite: made by eye so that the edges of a palm-sized carving glow and a pebble is not seen through. Index of nephrite."),
    preset("jade-imperial", [0.356787, 0.0194297, 0.167409], [0.268213, 0.48057, 0.457591], 1.66, 0.0,
        "Chrome-green jadeite: the hue of gem photographs; clearer than nephrite, light carries some millimetres. Index of jadeite."),
    preset("jade-lavender", [0.0135283, 0.0265408, 0.0072245], [0.986472, 0.973459, 0.992775], 1.66, 0.0,
        "Lavender jadeite: the hue of gem photographs. Index of jadeite."),
    preset("jade-white", [0.00344132, 0.00416293, 0.0121093], [1.24656, 1.24584, 1.23789], 1.61, 0.0,
        "White nephrite (mutton fat): a greasy off-white, nearly opaque from a centimetre on. Index of nephrite."),
    preset("marble-carrara", [0.0065939, 0.00657868, 0.00741814], [2.21563, 2.37437, 2.49258], 1.5, 0.0,
        "White Carrara: the mean free path of the marble of Jensen et al. 2001, a cool grey white without its yellow. Veins want a texture."),
    preset("marble-thassos", [0.00123792, 0.00089612, 0.000747458], [2.49876, 2.4991, 2.49925], 1.5, 0.0,
        "Thassos: nearly pure calcite or dolomite, so hardly any absorption; mean free path as of the measured marble."),
    preset("marble-cream", [0.0125344, 0.0358985, 0.136325], [2.84461, 2.82124, 2.72082], 1.5, 0.0,
        "Crema Marfil, Botticino, travertine: a warm beige of photographs; finer grained than Carrara."),
    preset("marble-rose", [0.0116449, 0.0961855, 0.168987], [2.48836, 2.40381, 2.33101], 1.5, 0.0,
        "Rosa Portogallo: white marble tinted by iron oxide."),
    preset("marble-grey", [0.375306, 0.320947, 0.258826], [2.95803, 3.01239, 3.07451], 1.5, 0.0,
        "Bardiglio: white marble with graphite, a blue grey."),
    preset("marble-green", [1.85983, 0.860805, 1.20205], [1.4735, 2.47253, 2.13129], 1.56, 0.0,
        "Verde (serpentine): dark green of photographs, index of serpentine."),
    preset("marble-black", [6.80219, 6.72749, 6.49712], [1.53114, 1.60584, 1.83621], 1.5, 0.0,
        "Nero Marquina: limestone with bitumen, which swallows light within a millimetre."),
    preset("alabaster", [0.000345594, 0.00125543, 0.00442643], [0.55521, 0.5543, 0.551129], 1.52, 0.0,
        "Gypsum alabaster: white, and thin panes serve as windows, so light carries far. Index of gypsum."),
    preset("onyx", [0.00175686, 0.0120772, 0.0776624], [0.452789, 0.442468, 0.376883], 1.55, 0.0,
        "Honey onyx (banded calcite), of back-lit panels two centimetres thick."),
    preset("rose-quartz", [0.002, 0.012, 0.008], [0.14, 0.14, 0.14], 1.544, 0.6,
        "Milky pink quartz: seen through blurred over a centimetre. Index of quartz."),
    preset("salt-lamp", [0.0012, 0.02, 0.05], [0.25, 0.25, 0.25], 1.544, 0.5,
        "Rock salt with iron oxide: orange glow through ten centimetres. Index of halite."),
    preset("opal-glass", [0.00119593, 0.00119593, 0.00198066], [3.9988, 3.9988, 3.99802], 1.5, 0.0,
        "Milk glass: fine white crystals in glass; lamp globes of three millimetres hide the bulb."),
    preset("porcelain", [0.00702799, 0.00978478, 0.0198394], [8.32631, 8.32355, 8.31349], 1.5, 0.0,
        "Porcelain: white, and a cup of two millimetres lets a little light through."),
    preset("wax", [0.004, 0.014, 0.055], [0.9, 0.85, 0.8], 1.43, 0.0,
        "Paraffin candle, warm white: made by eye so that the top centimetre around the flame glows."),
    preset("wax-red", [0.0405712, 1.14164, 1.01038], [1.388, 0.286929, 0.418193], 1.43, 0.0,
        "Dyed candle: the scattering of paraffin with a red dye."),
    preset("beeswax", [0.0056618, 0.0531641, 0.630773], [1.24434, 1.19684, 0.619227], 1.44, 0.0,
        "Yellow beeswax: scattering as of paraffin, the yellow of pollen and propolis."),
    preset("soap", [0.00127738, 0.00235463, 0.00755218], [1.99872, 1.99765, 1.99245], 1.46, 0.0,
        "White bar soap: crystals of fatty acid salts; a worn bar glows at its edges."),
    preset("soap-glycerin", [0.06, 0.012, 0.045], [0.04, 0.04, 0.04], 1.47, 0.8,
        "Clear green soap: glycerol, dyed, faintly hazy; a bar of two centimetres is seen through."),
    preset("amber", [0.003, 0.045, 0.25], [0.004, 0.004, 0.004], 1.54, 0.7,
        "Clear Baltic amber, cognac: made by eye for pieces of one to three centimetres. Index of succinite."),
    preset("amber-butterscotch", [0.00535313, 0.0825479, 0.834802], [1.99465, 1.91745, 1.1652], 1.54, 0.0,
        "Opaque Baltic amber: full of bubbles of some micrometres, which scatter in all directions."),
    preset("honey", [0.004, 0.035, 0.2], [0.008, 0.008, 0.008], 1.49, 0.8,
        "Clear blossom honey: golden in a spoon, brown in a jar."),
    preset("caramel", [0.05, 0.2, 0.7], [0.25, 0.25, 0.25], 1.47, 0.8,
        "Caramel sauce with some milk."),
    preset("gummy", [0.014, 0.23, 0.26], [0.33, 0.33, 0.33], 1.42, 0.85,
        "Red gummy bear: gelatine and sugar with a red dye; two centimetres are dark, legs of five millimetres glow."),
    preset("gummy-orange", [0.008, 0.066, 0.42], [0.33, 0.33, 0.33], 1.42, 0.85,
        "As gummy, with an orange dye."),
    preset("gummy-yellow", [0.007, 0.016, 0.3], [0.33, 0.33, 0.33], 1.42, 0.85,
        "As gummy, with a yellow dye."),
    preset("gummy-green", [0.12, 0.018, 0.24], [0.33, 0.33, 0.33], 1.42, 0.85,
        "As gummy, with a green dye."),
    preset("gummy-white", [0.004, 0.005, 0.009], [0.33, 0.33, 0.33], 1.42, 0.85,
        "As gummy, without a dye."),
    preset("jelly", [0.006, 0.12, 0.1], [0.012, 0.012, 0.012], 1.36, 0.85,
        "Strawberry jelly of gelatine: clear, seen through over centimetres."),
    preset("slime", [0.09, 0.008, 0.12], [0.06, 0.06, 0.06], 1.35, 0.8,
        "Toy slime, green: water bound by a gel, dyed, faintly hazy."),
    preset("white-chocolate", [0.00684361, 0.0315922, 0.218789], [6.65982, 6.63507, 6.44788], 1.47, 0.0,
        "Sugar and milk in cocoa butter: scatters as strongly as dark chocolate, without cocoa."),
    preset("leaf", [2.59132, 0.656042, 4.61295], [4.07535, 6.01062, 2.05371], 1.42, 0.0,
        "Green leaf: a blade of a quarter of a millimetre reflects and passes about a tenth of green and little red and blue, as spectra of leaves do. Index of cell walls."),
    preset("leaf-young", [0.478809, 0.135301, 3.00468], [5.07675, 5.42025, 2.55088], 1.42, 0.0,
        "As leaf, with a third of the chlorophyll."),
    preset("leaf-autumn", [0.0714874, 1.36323, 4.54982], [5.48407, 4.19232, 1.00574], 1.42, 0.0,
        "As leaf, carotenoids and anthocyanin in place of chlorophyll."),
    preset("petal", [0.020383, 0.852964, 0.412008], [8.31295, 7.48037, 7.92133], 1.4, 0.0,
        "Pink petal: air between cells scatters, a fifth of a millimetre lets half of the light through."),
    preset("grape", [0.026, 0.009, 0.084], [0.42, 0.42, 0.42], 1.36, 0.8,
        "Green grape: flesh of water and sugar; seeds show against the light."),
    preset("grape-red", [0.09, 0.4, 0.2], [0.42, 0.42, 0.42], 1.36, 0.8,
        "As grape, with anthocyanin."),
    preset("tomato", [0.0480616, 1.36829, 1.56583], [1.61861, 0.298379, 0.100833], 1.35, 0.0,
        "Ripe tomato: lycopene in watery flesh."),
    preset("strawberry", [0.0829284, 2.26581, 1.8403], [2.41707, 0.23419, 0.659701], 1.35, 0.0,
        "Ripe strawberry: anthocyanin in watery flesh with air."),
    preset("orange", [0.00866733, 0.364001, 2.292], [2.49133, 2.136, 0.207999], 1.36, 0.0,
        "Orange, peel and flesh: carotenoids."),
    preset("lemon", [0.00380678, 0.021693, 1.26407], [1.99619, 1.97831, 0.735928], 1.36, 0.0,
        "Lemon, peel and flesh."),
    preset("watermelon", [0.0059076, 0.401939, 0.381413], [0.827426, 0.431394, 0.45192], 1.34, 0.0,
        "Flesh of a watermelon: lycopene in water, coarse cells, so light carries far."),
    preset("cheese", [0.005, 0.026, 0.19], [1.0, 1.0, 0.9], 1.38, 0.0,
        "Gouda: drops of fat in protein, carotene; slices of two millimetres are translucent."),
    preset("butter", [0.00218839, 0.0198176, 0.443074], [3.33114, 3.31352, 2.89026], 1.45, 0.0,
        "Drops of water in milk fat, carotene."),
    preset("egg-white", [0.00202923, 0.00273743, 0.00678908], [3.3313, 3.3306, 3.32654], 1.37, 0.0,
        "Boiled egg white: clotted protein."),
    preset("salmon", [0.00467631, 0.289865, 0.665452], [1.66199, 1.3768, 1.00122], 1.38, 0.0,
        "Raw salmon: muscle with astaxanthin."),
    preset("meat", [0.294513, 1.68983, 1.68983], [1.70549, 0.310169, 0.310169], 1.38, 0.0,
        "Raw beef: muscle with myoglobin. Scattering of muscle is about 1/mm reduced."),
    preset("orange-juice", [0.00369156, 0.132932, 1.42362], [1.66298, 1.53373, 0.243047], 1.34, 0.0,
        "Pulp and carotenoids in water."),
    preset("tea", [0.004, 0.035, 0.15], [0.002, 0.002, 0.002], 1.333, 0.9,
        "Black tea in a cup."),
    preset("olive-oil", [0.0035, 0.0018, 0.06], [0.0015, 0.0015, 0.0015], 1.47, 0.9,
        "Clear oil with chlorophyll and carotene."),
    preset("blood", [0.81, 23.0, 20.6], [1.6, 1.5, 1.5], 1.38, 0.0,
        "Whole blood, 150 g/l of oxygenated haemoglobin: absorption after the spectrum that S. Prahl compiled, at 610, 550 and 465 nm; reduced scattering of about 1.5/mm."),
    preset("skin-i", [0.0250229, 0.117623, 0.282675], [3.47, 4.02, 5.1], 1.4, 0.0,
        "Skin, very light (Fitzpatrick I, individual typology angle 62°): the reduced scattering of skin after Jacques 2013, and the absorption that shows a colour of the class (Del Bino et al. 2006)."),
    preset("skin-ii", [0.0455109, 0.20909, 0.502788], [3.47, 4.02, 5.1], 1.4, 0.0,
        "Skin, light (Fitzpatrick II, individual typology angle 51°): the reduced scattering of skin after Jacques 2013, and the absorption that shows a colour of the class (Del Bino et al. 2006)."),
    preset("skin-iii", [0.0723352, 0.331921, 0.820155], [3.47, 4.02, 5.1], 1.4, 0.0,
        "Skin, intermediate (Fitzpatrick III, individual typology angle 40°): the reduced scattering of skin after Jacques 2013, and the absorption that shows a colour of the class (Del Bino et al. 2006)."),
    preset("skin-iv", [0.134265, 0.576817, 1.45036], [3.47, 4.02, 5.1], 1.4, 0.0,
        "Skin, tan (Fitzpatrick IV, individual typology angle 22°): the reduced scattering of skin after Jacques 2013, and the absorption that shows a colour of the class (Del Bino et al. 2006)."),
    preset("skin-v", [0.342093, 1.24667, 3.16005], [3.47, 4.02, 5.1], 1.4, 0.0,
        "Skin, brown (Fitzpatrick V, individual typology angle −9°): the reduced scattering of skin after Jacques 2013, and the absorption that shows a colour of the class (Del Bino et al. 2006)."),
    preset("skin-vi", [1.04541, 3.12363, 6.71119], [3.47, 4.02, 5.1], 1.4, 0.0,
        "Skin, dark (Fitzpatrick VI, individual typology angle −49°): the reduced scattering of skin after Jacques 2013, and the absorption that shows a colour of the class (Del Bino et al. 2006)."),
    preset("lips", [0.0932058, 0.787512, 0.893574], [2.76394, 2.06963, 1.96357], 1.4, 0.0,
        "Lips: skin with a thin epidermis, so that blood shows."),
    preset("tooth", [0.00503351, 0.0107438, 0.0412358], [3.99497, 3.98926, 3.95876], 1.62, 0.0,
        "Enamel over dentine as one medium, shade A2. Index of enamel."),
    preset("fingernail", [0.00536456, 0.0513524, 0.103185], [2.49464, 2.44865, 2.39682], 1.54, 0.0,
        "Nail with its bed. Index of keratin."),
    preset("bone", [0.00971496, 0.0217943, 0.0774524], [3.99029, 3.97821, 3.92255], 1.55, 0.0,
        "Dry bone."),
    preset("ivory", [0.00191691, 0.00711918, 0.035488], [2.85523, 2.85002, 2.82165], 1.54, 0.0,
        "Ivory: dentine; thin carvings glow."),
    preset("ice", [0.0003, 0.0001, 0.00004], [0.012, 0.012, 0.012], 1.31, 0.85,
        "Ice cube with small bubbles; absorption of pure ice, rounded up."),
    preset("paper", [0.0218817, 0.0248878, 0.0391391], [33.3115, 33.3084, 33.2942], 1.5, 0.0,
        "Office paper: a sheet of a tenth of a millimetre passes a sixth of the light."),
    preset("plastic-white", [0.00172247, 0.00172247, 0.00271084], [2.49828, 2.49828, 2.49729], 1.53, 0.0,
        "Translucent polyethylene, as of bottles and cutting boards."),
    preset("silicone", [0.00061374, 0.00061374, 0.000993193], [0.453932, 0.453932, 0.453552], 1.41, 0.0,
        "Undyed silicone rubber: milky, a finger behind three millimetres shows as a blur."),
    preset("sea-glass", [0.035, 0.007, 0.018], [0.03, 0.03, 0.03], 1.52, 0.7,
        "Bottle glass, green, weathered; give it a rough surface."),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::seen_color::seen_color;

    /// Seen colour in sRGB, and in millimetres the mean free path (`true`), or in 1/mm the scattering (`false`).
    #[rustfmt::skip]
    const STATED: [(&str, &str, [f64; 3], bool); 47] = [
        ("jade-imperial", "#2f9a52", [1.6, 2.0, 1.6], true),
        ("jade-lavender", "#b9a6c8", [1.0; 3], true),
        ("jade-white", "#dcd9c4", [0.8; 3], true),
        ("marble-carrara", "#dfe0df", [0.45, 0.42, 0.4], true),
        ("marble-thassos", "#f1f3f4", [0.4; 3], true),
        ("marble-cream", "#d9c49e", [0.35; 3], true),
        ("marble-rose", "#d8a592", [0.4; 3], true),
        ("marble-grey", "#7f858d", [0.3; 3], true),
        ("marble-green", "#34594a", [0.3; 3], true),
        ("marble-black", "#1c1d20", [0.12; 3], true),
        ("alabaster", "#efe2cd", [1.8; 3], true),
        ("onyx", "#d9ad6b", [2.2; 3], true),
        ("opal-glass", "#f4f4f1", [0.25; 3], true),
        ("porcelain", "#edeae2", [0.12; 3], true),
        ("wax-red", "#b3202a", [0.7; 3], true),
        ("beeswax", "#dba63f", [0.8; 3], true),
        ("soap", "#f0ebdd", [0.5; 3], true),
        ("amber-butterscotch", "#dfa044", [0.5; 3], true),
        ("white-chocolate", "#ecd9ac", [0.15; 3], true),
        ("leaf", "#4e8a2c", [0.15; 3], true),
        ("leaf-young", "#8fb83c", [0.18; 3], true),
        ("leaf-autumn", "#c8641e", [0.18; 3], true),
        ("petal", "#e58aa4", [0.12; 3], true),
        ("tomato", "#b8200e", [0.6; 3], true),
        ("strawberry", "#b4142a", [0.4; 3], true),
        ("orange", "#e27f12", [0.4; 3], true),
        ("lemon", "#e9cf35", [0.5; 3], true),
        ("watermelon", "#d8474a", [1.2; 3], true),
        ("butter", "#f0d67c", [0.3; 3], true),
        ("egg-white", "#f2f0e8", [0.3; 3], true),
        ("salmon", "#e4764f", [0.6; 3], true),
        ("meat", "#7d1c1c", [0.5; 3], true),
        ("orange-juice", "#e8981c", [0.6; 3], true),
        ("skin-i", "#d5b5a2", [3.47, 4.02, 5.10], false),
        ("skin-ii", "#c9a48f", [3.47, 4.02, 5.10], false),
        ("skin-iii", "#be957e", [3.47, 4.02, 5.10], false),
        ("skin-iv", "#ad826a", [3.47, 4.02, 5.10], false),
        ("skin-v", "#8f6750", [3.47, 4.02, 5.10], false),
        ("skin-vi", "#68493a", [3.47, 4.02, 5.10], false),
        ("lips", "#b1605a", [0.35; 3], true),
        ("tooth", "#e6dcc2", [0.25; 3], true),
        ("fingernail", "#e2b5a0", [0.4; 3], true),
        ("bone", "#e0d3b6", [0.25; 3], true),
        ("ivory", "#eee0c2", [0.35; 3], true),
        ("paper", "#efeeea", [0.03; 3], true),
        ("plastic-white", "#eeeeea", [0.4; 3], true),
        ("silicone", "#ebebe6", [2.2; 3], true),
    ];

    #[test]
    fn the_coefficients_show_the_colours_that_are_stated() {
        for (name, hex, lengths, is_free_path) in STATED {
            let preset = Preset::named(name).unwrap();
            for i in 0..3 {
                let c = preset.coefficients(i);
                let encoded = f64::from(u8::from_str_radix(&hex[1 + 2 * i..3 + 2 * i], 16).unwrap()) / 255.0;
                let linear = f64::from(crate::scene::texture::srgb_to_linear(encoded as f32));
                let seen = seen_color(c.albedo(), c.g, c.eta);
                assert!((seen - linear).abs() < 1e-4, "{name} [{i}]: {seen} for {linear}");
                let found = if is_free_path { 1000.0 * c.mean_free_path() } else { c.sigma_s / 1000.0 };
                assert!((found / lengths[i] - 1.0).abs() < 1e-4, "{name} [{i}]: {found}");
            }
        }
    }

    /// Light travels between a fiftieth of a millimetre (paper) and a metre or so (clear ice) before something happens, and
    /// the types of skin get darker.
    #[test]
    fn estimates_are_sane() {
        for preset in &ESTIMATES {
            for i in 0..3 {
                let free = 1000.0 * preset.coefficients(i).mean_free_path();
                assert!((0.02..1500.0).contains(&free), "{} [{i}]: {free} mm", preset.name);
            }
            assert!(preset.note.ends_with('.') && !preset.note.contains('"'), "{}", preset.name);
        }
        let skins = ["i", "ii", "iii", "iv", "v", "vi"].map(|t| Preset::named(&format!("skin-{t}")).unwrap());
        for pair in skins.windows(2) {
            assert!(
                (0..3).all(|i| pair[0].sigma_a_per_mm[i] < pair[1].sigma_a_per_mm[i]),
                "{}",
                pair[1].name
            );
        }
    }
}
