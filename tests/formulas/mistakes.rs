//! The values of usual mistakes.

use super::*;
use nephrite::optics::diffusion::brdf::{Cosines, SingleTerm};
use nephrite::optics::diffusion::single::refracted_distance;
use nephrite::optics::diffusion::*;

/// What the mistake of a control gives here, made on purpose where that takes a line, and what is right. `None`: a
/// control that this test does not know.
fn control(id: &str, i: &Input) -> Option<(f64, Option<f64>)> {
    let eta = i.0["eta"].as_f64().unwrap_or(1.0);
    Some(match id {
        "fdr_minus_1440" => (fresnel::diffuse_reflectance_fit(eta), None),
        "f1_unrefracted_cosines" => {
            let printed = BrdfApproximation::new(&i.coefficients()).with_single_term(SingleTerm::Printed);
            let mistaken = printed.with_cosines(Cosines::Unrefracted);
            let single = |b: &BrdfApproximation| b.single(i.unit("wi"), i.unit("wo"), DVec3::Z);
            (single(&printed), Some(single(&mistaken)))
        }
        "Rd_unreduced_albedo" => {
            let c = i.coefficients();
            let a = fresnel::boundary_coefficient(fresnel::diffuse_reflectance_fit(eta));
            (ClassicalDipole::new(&c).total(), Some(classical::total_reflectance(c.albedo(), a)))
        }
        "hg_sign" => {
            let (g, cos) = (i.number("g"), i.number("cos"));
            (phase::henyey_greenstein(g, cos), Some(phase::henyey_greenstein(g, -cos)))
        }
        "A_inverse" => {
            let a = fresnel::boundary_coefficient(fresnel::diffuse_reflectance_fit(eta));
            (a, Some(1.0 / a))
        }
        "moments_wrong_side" => (Moments::exact(eta).c_phi(), Some(Moments::exact(1.0 / eta).c_phi())),
        "refraction_missing_in_si" => {
            let s = i.number("s_i");
            (refracted_distance(s, i.number("cos_i"), eta), Some(s))
        }
        _ => return None,
    })
}

/// The usual mistakes differ from the right value by far more than any tolerance here, and are what they are taken for.
#[test]
fn typical_mistakes_are_told_apart() {
    for case in group("negative_controls")["cases"].as_array().expect("cases") {
        let id = case["id"].as_str().expect("an id");
        let (right, mistake) = control(id, &Input(&case["inp"])).unwrap_or_else(|| panic!("{id} is unknown"));
        let [expected, wrong] = ["right", "wrong"].map(|k| case[k].as_f64().expect("a number"));
        assert!((right / expected - 1.0).abs() < ROUNDING, "{id}: {right} for {expected}");
        assert!((right / wrong - 1.0).abs() > 0.1, "{id}: {right} is as good as the mistaken {wrong}");
        if let Some(mistake) = mistake {
            assert!((mistake / wrong - 1.0).abs() < ROUNDING, "{id}: {mistake} for the mistaken {wrong}");
        }
    }
}
