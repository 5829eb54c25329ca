//! Values of every closed form.

use super::*;
use nephrite::optics::diffusion::directional::{Entry, Exit};
use nephrite::optics::diffusion::single::Connection;
use nephrite::optics::diffusion::*;
use std::f64::consts::TAU;

#[test]
fn fresnel_reflectance_and_refraction() {
    each_case("fresnel_dielectric", |i, out, d| {
        let (cos, eta) = (i.number("cos_i"), i.number("n_t") / i.number("n_i"));
        d.compare("R", fresnel::dielectric(cos, eta), &out["R"], ROUNDING);
        d.compare("T", fresnel::transmittance(cos, eta), &out["T"], ROUNDING);
        let refracted = fresnel::refracted_cosine(cos, eta);
        assert_eq!(refracted.is_none(), out["tir"].as_bool().expect("tir"), "{cos} {eta}");
        d.compare("cos_t", refracted.unwrap_or(f64::NAN), &out["cos_t"], ROUNDING);
    });
    each_case("refract", |i, out, d| match fresnel::refract(i.unit("w"), i.unit("n"), i.number("eta")) {
        Some(w) => d.compare_vector("propagation", w, &out["propagation"], ROUNDING),
        None => {
            assert!(out["propagation"].is_null());
            d.compared += 1;
        }
    });
}

/// The printed fits are short polynomials: rounding alone, but for 3C₂ above 1, whose terms of 1e3 cancel.
#[test]
fn diffuse_fresnel_reflectance_and_moments() {
    each_case("fdr", |i, out, d| {
        let eta = i.number("eta");
        let exact = fresnel::diffuse_reflectance(eta);
        d.compare("F_dr exact", exact, &out["F_dr_exact"], ROUNDING);
        d.compare("A exact", fresnel::boundary_coefficient(exact), &out["A_exact"], ROUNDING);
        let fit = fresnel::diffuse_reflectance_fit(eta);
        d.compare("F_dr fit", fit, &out["F_dr_jensen2001_fit"], ROUNDING);
        d.compare("F_dr fit below 1", fit, &out["F_dr_egan_hilgeman_fit"], ROUNDING);
        d.compare("A fit", fresnel::boundary_coefficient(fit), &out["A_fit"], ROUNDING);
    });
    each_case("fresnel_moments", |i, out, d| {
        let eta = i.number("eta");
        let (exact, fit, rounded) = (Moments::exact(eta), Moments::fit(eta), Moments::fit_rounded(eta));
        for (what, got, tolerance) in [
            ("C1_exact", exact.c1, ROUNDING),
            ("C2_exact", exact.c2, ROUNDING),
            ("C_phi_exact", exact.c_phi(), ROUNDING),
            ("C_E_exact", exact.c_e(), ROUNDING),
            ("A_exact", exact.a(), ROUNDING),
            ("two_C1_fit", 2.0 * fit.c1, ROUNDING),
            ("three_C2_fit", 3.0 * fit.c2, 1e-9),
            ("C_phi_fit", fit.c_phi(), ROUNDING),
            ("C_E_fit", fit.c_e(), ROUNDING),
            ("A_fit", fit.a(), ROUNDING),
            ("C1_pbrt_fit", rounded.c1, ROUNDING),
            ("C2_pbrt_fit", rounded.c2, 1e-9),
        ] {
            d.compare(what, got, &out[what], tolerance);
        }
    });
}

#[test]
fn derived_coefficients() {
    each_case("coefficients", |i, out, d| {
        let c = i.coefficients();
        for (what, got) in [
            ("sigma_t", c.sigma_t()),
            ("sigma_s_prime", c.reduced_scattering()),
            ("sigma_t_prime", c.reduced_extinction()),
            ("albedo", c.albedo()),
            ("albedo_prime", c.reduced_albedo()),
            ("mfp", c.mean_free_path()),
            ("mfp_prime", c.transport_mean_free_path()),
            ("D", c.diffusion_coefficient()),
            ("D_grosjean", c.grosjean_coefficient()),
            ("sigma_tr", c.effective_transport()),
            ("sigma_tr_grosjean", c.grosjean_transport()),
            ("dmfp", c.diffuse_mean_free_path()),
        ] {
            d.compare(what, got, &out[what], ROUNDING);
        }
    });
}

#[test]
fn phase_function() {
    each_case("hg", |i, out, d| {
        let (g, cos) = (i.number("g"), i.number("cos"));
        d.compare("pdf", phase::henyey_greenstein(g, cos), &out["pdf"], ROUNDING);
        d.compare("cdf", phase::henyey_greenstein_cdf(g, cos), &out["cdf"], ROUNDING);
    });
    each_case("hg_sample", |i, out, d| {
        d.compare(
            "cos",
            phase::henyey_greenstein_inverse(i.number("g"), i.number("xi")),
            &out["cos"],
            ROUNDING,
        );
    });
}

/// The deepest value asked for is some 1e-6 of the peak; differences of the two sources are taken so that they keep
/// their digits.
#[test]
fn dipoles() {
    each_case("dipole_classical", |i, out, d| {
        let (c, r) = (i.isotropic(), i.number("r"));
        let fit = ClassicalDipole::new(&c);
        let exact = ClassicalDipole::with_reflectance(&c, fresnel::diffuse_reflectance(c.eta));
        d.compare("R_d", fit.eval(r), &out["R_d"], ROUNDING);
        d.compare("R_d exact F_dr", exact.eval(r), &out["R_d_exactFdr"], ROUNDING);
        d.compare("A", fit.a(), &out["A"], ROUNDING);
        d.compare("A exact", exact.a(), &out["A_exactFdr"], ROUNDING);
        d.compare("z_r", fit.z_r(), &out["z_r"], ROUNDING);
        d.compare("z_v", fit.z_v(), &out["z_v"], ROUNDING);
    });
    each_case("dipole_classical_total", |i, out, d| {
        let (albedo, eta) = (i.number("albedo_prime"), i.number("eta"));
        let c = Coefficients::isotropic(1.0 - albedo, albedo, eta);
        let exact = fresnel::boundary_coefficient(fresnel::diffuse_reflectance(eta));
        d.compare("total", ClassicalDipole::new(&c).total(), &out["R_d_total"], ROUNDING);
        d.compare(
            "total exact F_dr",
            classical::total_reflectance(albedo, exact),
            &out["R_d_total_exactFdr"],
            ROUNDING,
        );
    });
    each_case("dipole_better", |i, out, d| {
        let (c, r) = (i.isotropic(), i.number("r"));
        let exact = BetterDipole::new(&c);
        d.compare("R_d exact", exact.eval(r), &out["R_d_exact"], ROUNDING);
        d.compare("z_v exact", exact.z_v(), &out["z_v_exact"], ROUNDING);
        if c.eta != 1.0 {
            let fit = BetterDipole::with_moments(&c, Moments::fit(c.eta));
            d.compare("R_d fit", fit.eval(r), &out["R_d_fit"], ROUNDING);
            d.compare("z_v fit", fit.z_v(), &out["z_v_fit"], ROUNDING);
        }
    });
    each_case("dipole_better_total", |i, out, d| {
        let (albedo, eta) = (i.number("albedo_prime"), i.number("eta"));
        let total = |m| better::total_reflectance(albedo, &m);
        d.compare("total exact", total(Moments::exact(eta)), &out["R_d_total_exact"], ROUNDING);
        d.compare("total fit", total(Moments::fit(eta)), &out["R_d_total_fit"], ROUNDING);
    });
}

fn fit_of(name: &Value) -> ScaleFit {
    match name.as_str() {
        Some("searchlight_mfp") => ScaleFit::SearchlightMfp,
        Some("diffuse_mfp") => ScaleFit::DiffuseMfp,
        Some("searchlight_dmfp") => ScaleFit::SearchlightDmfp,
        other => panic!("no fit {other:?}"),
    }
}

#[test]
fn normalized_diffusion() {
    each_case("normalized_diffusion", |i, out, d| {
        let (fit, albedo, l, r) = (fit_of(&i.0["fit"]), i.number("A"), i.number("l"), i.number("r"));
        let profile = NormalizedDiffusion::new(albedo, l, fit);
        d.compare("s", fit.scale(albedo), &out["s"], ROUNDING);
        d.compare("d", profile.d, &out["d"], ROUNDING);
        d.compare("R", profile.eval(r), &out["R"], ROUNDING);
        d.compare("pdf_r", profile.pdf_radius(r), &out["pdf_r"], ROUNDING);
        d.compare("pdf_area", profile.pdf_radius(r) / (TAU * r), &out["pdf_area"], ROUNDING);
        d.compare("cdf", profile.cdf(r), &out["cdf"], ROUNDING);
        if profile.cdf(r) < 0.999 {
            d.compare_scaled("there and back", profile.invert(profile.cdf(r)), r, r, ROUNDING);
        }
    });
    each_case("normalized_diffusion_inverse", |i, out, d| {
        let profile = NormalizedDiffusion { albedo: 1.0, d: i.number("l") / i.number("s") };
        d.compare("r", profile.invert(i.number("xi")), &out["r"], ROUNDING);
    });
}

#[test]
fn brdf_approximation() {
    each_case("jensen_brdf", |i, out, d| {
        let c = i.coefficients();
        let (wi, wo, n) = (i.unit("wi"), i.unit("wo"), i.unit("n"));
        let exact = BrdfApproximation::new(&c);
        let printed = exact.with_single_term(SingleTerm::Printed);
        d.compare("f1 printed", printed.single(wi, wo, n), &out["f1_printed"], ROUNDING);
        d.compare("f1 exact", exact.single(wi, wo, n), &out["f1_radiance_exact"], ROUNDING);
        d.compare("f multi", exact.multiple(n.dot(wi), n.dot(wo)), &out["f_multi"], ROUNDING);
        d.compare("f total", printed.eval(wi, wo, n), &out["f_total_printed"], ROUNDING);
        d.compare("R_d", exact.diffuse_reflectance(), &out["R_d_total"], ROUNDING);
    });
}

#[test]
fn single_scattering_along_a_view_ray() {
    each_case("jensen_single_scatter", |i, out, d| {
        let c = i.coefficients();
        let connection = Connection {
            n_i: i.unit("n_i"),
            n_o: i.unit("n_o"),
            wi: i.unit("wi"),
            wo: i.unit("wo"),
            s_i: i.number("s_i"),
            s_o: i.number("s_o_prime"),
        };
        let got = connection.evaluate(&c).expect("a connection");
        for (what, value) in [
            ("s_i_prime", got.s_i_refracted),
            ("attenuation", got.attenuation),
            ("integrand", got.integrand),
            ("sigma_tc", got.combined_extinction),
            ("estimator_over_sigma_tc", got.integrand / got.combined_extinction),
            ("physical_factor", got.physical_factor),
        ] {
            d.compare(what, value, &out[what], ROUNDING);
        }
    });
}

/// Quadratures with a fixed number of nodes: multiple scattering within 1e-6, single scattering within 1e-8.
#[test]
fn photon_beam_diffusion() {
    each_case("photon_beam_diffusion", |i, out, d| {
        let (c, r) = (i.coefficients(), i.number("r"));
        let exact = PhotonBeam::new(&c);
        let fit = PhotonBeam::with_moments(&c, Moments::fit_rounded(c.eta));
        let t = c.reduced_extinction();
        d.compare("ms exact moments", exact.eval(r), &out["ms_exact_moments"], 1e-6);
        d.compare("ms fit", fit.eval(r), &out["ms_fit"], 1e-6);
        d.compare("ms without kappa", fit.uncorrected().eval(r), &out["ms_no_kappa_fit"], 1e-6);
        d.compare("ss", exact.single(r), &out["ss"], 1e-8);
        // The 100-point rule: the same integrands at stratified exponential depths.
        let depths = || (0..100).map(|k| -(1.0 - (f64::from(k) + 0.5) / 100.0).ln());
        let ms: f64 = depths().map(|u| fit.source(u / t, r)).sum::<f64>() / 100.0;
        d.compare("ms of 100 points", ms, &out["ms_pbrt_100"], ROUNDING);
        let single = SingleScattering::new(&c);
        let ss: f64 = depths()
            .map(|u| (u / c.sigma_t() + single.critical_depth(r), u))
            .map(|(depth, u)| single.integrand(depth, r) * u.exp() / c.sigma_t())
            .sum();
        d.compare("ss of 100 points", ss / 100.0, &out["ss_pbrt_100"], ROUNDING);
    });
}

/// The two sources within 1e-10 of the larger of their terms; their difference loses what they cancel, at most a
/// factor of 20.
#[test]
fn directional_dipole() {
    each_case("directional_dipole", |i, out, d| {
        let c = i.coefficients();
        let entry = Entry { x: i.vector("x_i"), n: i.unit("n_i"), w: i.unit("w_i") };
        let exit = Exit { x: i.vector("x_o"), n: i.unit("n_o") };
        let wo = i.unit("w_o");
        let model = DirectionalDipole::with_fits(&c);
        let got = model.evaluate(&entry, &exit).expect("an evaluation");
        for (what, value) in [
            ("S_real", got.real),
            ("mu0", got.mu0),
            ("d_r", got.d_r),
            ("d_v", got.d_v),
            ("d_e", model.d_e()),
            ("A", model.a()),
            ("C_phi_inv", model.c_phi_outside()),
            ("S_d", model.s_d(&entry, &exit)),
            ("S_d_unclamped", got.real - got.image),
            ("S_d_exact_moments", DirectionalDipole::new(&c).s_d(&entry, &exit)),
            ("S_d_reciprocal_mean", model.reciprocal(&entry, &exit, wo)),
            (
                "S_d_swapped",
                model.s_d(&Entry { x: exit.x, n: exit.n, w: wo }, &Exit { x: entry.x, n: entry.n }),
            ),
            (
                "S_full",
                fresnel::transmittance(entry.n.dot(entry.w), c.eta)
                    * got.clamped()
                    * fresnel::transmittance(exit.n.dot(wo), c.eta),
            ),
        ] {
            d.compare(what, value, &out[what], ROUNDING);
        }
        // On the way to the far side the image's two terms cancel and its sign may change.
        let image = out["S_virtual"].as_f64().expect("a number");
        d.compare_scaled("S_virtual", got.image, image, image.abs().max(1e-5 * got.real), ROUNDING);
        let cos_beta = out["cos_beta"].as_f64().expect("a number");
        d.compare_scaled("cos_beta", got.cos_beta, cos_beta, 1.0, ROUNDING);
        d.compare_vector("n_i_star", got.n_star, &out["n_i_star"], ROUNDING);
        d.compare_vector("w12", got.w12, &out["w12"], ROUNDING);
        d.compare_vector("w_v", got.w_v, &out["w_v"], ROUNDING);
        d.compare_vector("x_v", got.x_v, &out["x_v"], ROUNDING);
    });
}

/// Albedos near 0 are differences from 1 and are compared absolutely.
#[test]
fn albedo_inversions() {
    let absolute = |d: &mut Deviations, what: &str, got: f64, expected: &Value| {
        d.compare_scaled(what, got, expected.as_f64().expect("a number"), 1.0, 1e-12);
    };
    each_case("albedo_inversion", |i, out, d| {
        let (rho, g) = (i.number("rho_ms"), i.number("g"));
        let (s, exact) = (inversion::similarity(rho), inversion::similarity_exact(rho));
        absolute(d, "s", s, &out["s"]);
        absolute(d, "rho_ss", inversion::single_from_similarity(s, g), &out["rho_ss"]);
        absolute(
            d,
            "rho_ss for g = 0",
            inversion::single_from_similarity(s, 0.0),
            &out["rho_ss_KHR_volume_scatter"],
        );
        absolute(d, "s exact", exact, &out["s_exact_inverse"]);
        absolute(
            d,
            "rho_ss exact",
            inversion::single_from_similarity(exact, g),
            &out["rho_ss_exact_inverse"],
        );
    });
    each_case("albedo_forward", |i, out, d| {
        let (albedo, g) = (i.number("rho_ss"), i.number("g"));
        d.compare("van de Hulst", inversion::multiple_from_single(albedo, g), &out["C_vdh"], ROUNDING);
        let (normal, diffuse) = ("exact_isotropic_normal_incidence", "exact_isotropic_diffuse_incidence");
        d.compare("H, normal", chandrasekhar::directional_albedo(albedo, 1.0), &out[normal], ROUNDING);
        d.compare("H, diffuse", chandrasekhar::spherical_albedo(albedo), &out[diffuse], ROUNDING);
    });
    each_case("chiang2016", |i, out, d| {
        let c = inversion::chiang(i.number("A"), i.number("d"));
        d.compare("albedo", c.albedo(), &out["albedo"], ROUNDING);
        d.compare("sigma_t", c.sigma_t(), &out["sigma_t"], ROUNDING);
        d.compare("sigma_s", c.sigma_s, &out["sigma_s"], ROUNDING);
    });
    each_case("chandrasekhar_H", |i, out, d| {
        let (albedo, mu) = (i.number("albedo"), i.number("mu"));
        d.compare("H", chandrasekhar::h(albedo, mu), &out["H"], ROUNDING);
        let r = chandrasekhar::directional_albedo(albedo, mu);
        d.compare("R", r, &out["R_directional_hemispherical"], ROUNDING);
    });
}
