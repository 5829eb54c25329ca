//! Measured profiles: the walk has the numbers that others counted, the models have those of their formulas.

use nephrite::optics::diffusion::{Coefficients, RadialProfile};
use nephrite::subsurface::Registry;
use nephrite::transport::searchlight::{Histogram, Searchlight, SearchlightError, Share, measure};
use serde_json::Value;
use std::f64::consts::TAU;

fn searchlight(coefficients: Coefficients, edges: Vec<f64>, paths: u64) -> Searchlight {
    Searchlight { coefficients, edges, paths, seed: 17, threads: 0 }
}

fn measured(model: &str, light: &Searchlight) -> Result<Histogram, SearchlightError> {
    let models = Registry::standard();
    measure(&*models.get(model).expect("is registered"), light, &())
}

/// |z| < 4 where there is enough to tell.
fn assert_agrees(found: Share, expected: f64, expected_error: f64, what: &str) -> f64 {
    let error = found.standard_error.hypot(expected_error);
    let z = (found.value - expected) / error;
    println!("{what}: {:.6} ± {:.6}, expected {expected:.6}, z {z:+.2}", found.value, found.standard_error);
    assert!(z.abs() < 4.0, "{what}: {} ± {error}, not {expected} (z {z:+.2})", found.value);
    z
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

/// Radial reflectance of six media by an independent Monte Carlo program, up to 10⁹ photons each: `searchlight` of
/// `tests/oracles/searchlight.json`, which says how it was made. Bins are merged six by six.
#[test]
fn the_walk_is_what_others_counted() {
    const MERGED: usize = 6;
    let data: Value = serde_json::from_str(include_str!("../oracles/searchlight.json")).expect("JSON");
    let all = numbers(&data["searchlight"]["edges"]);
    let edges: Vec<f64> = all.iter().copied().step_by(MERGED).collect();
    let mut told = 0;
    for medium in data["searchlight"]["media"].as_array().expect("media") {
        let number = |key: &str| medium[key].as_f64().expect("a number");
        let albedo = number("alpha_prime");
        let coefficients = Coefficients {
            sigma_a: number("sigma_a"),
            sigma_s: number("sigma_s"),
            g: number("g"),
            eta: number("n"),
        };
        // Walks grow longer with the albedo.
        let paths = if albedo > 0.995 { 20_000 } else { 200_000 };
        let found =
            measured("random-walk", &searchlight(coefficients, edges.clone(), paths)).expect("measures");
        let what = format!("albedo {albedo}, g {}, index {}", coefficients.g, coefficients.eta);
        assert_agrees(found.total, number("total"), number("total_se"), &format!("{what}, total"));
        let (shares, errors) = (numbers(&medium["bin_fraction"]), numbers(&medium["bin_fraction_se"]));
        for (i, share) in found.shares.iter().enumerate() {
            // Share 0 is inside the first edge, the last is outside the last one.
            let bins = if i == 0 {
                0..1
            } else if i == edges.len() {
                shares.len() - 1..shares.len()
            } else {
                1 + MERGED * (i - 1)..1 + MERGED * i
            };
            let expected: f64 = shares[bins.clone()].iter().sum();
            let error = errors[bins].iter().map(|e| e * e).sum::<f64>().sqrt();
            // Counts of less than 25 are not normal.
            if expected * paths as f64 >= 25.0 {
                assert_agrees(*share, expected, error, &format!("{what}, share {i}"));
                told += 1;
            }
        }
    }
    assert!(told > 35, "{told} shares were compared");
}

/// ∫ R 2πr dr from `a` to `b`, lengths in units of `unit`.
fn integral(profile: &dyn RadialProfile, unit: f64, a: f64, b: f64) -> f64 {
    const STEPS: u32 = 64;
    let step = (b / a).ln() / f64::from(STEPS);
    let radius = |k: u32| unit * a * (step * (f64::from(k) + 0.5)).exp();
    (0..STEPS).map(radius).map(|r| TAU * r * r * profile.eval(r) * step).sum()
}

#[test]
fn models_have_the_profiles_of_their_formulas() {
    let c = Coefficients { sigma_a: 60.0, sigma_s: 1500.0, g: 0.4, eta: 1.4 };
    let unit = c.transport_mean_free_path();
    let edges: Vec<f64> = (0..=10).map(|i| 0.03 * 2f64.powi(i)).collect();
    let mut compared = 0;
    for model in Registry::standard().iter() {
        // The directional dipole does not look the same both ways: see its `closed_form`.
        let Some(profile) = model.closed_form(&c).filter(|_| model.name() != "directional-dipole") else {
            continue;
        };
        let found = measure(model, &searchlight(c, edges.clone(), 400_000), &()).expect("measures");
        // Tables follow their profiles within 0.2 %, and carry their total to 1e-4.
        let name = model.name();
        assert_agrees(found.total, profile.total(), 1e-4 * profile.total(), &format!("{name}, total"));
        for (i, pair) in edges.windows(2).enumerate() {
            let expected = integral(&*profile, unit, pair[0], pair[1]);
            if expected > 1e-4 {
                assert_agrees(found.shares[i + 1], expected, 1e-3 * expected, &format!("{name}, bin {i}"));
                compared += 1;
            }
        }
    }
    assert!(compared >= 40, "{compared} bins were compared");
}

#[test]
fn profiles_do_not_depend_on_threads_and_scale_with_the_medium() {
    let edges = vec![0.1, 1.0, 10.0];
    let thin = Coefficients { sigma_a: 0.5, sigma_s: 10.0, g: 0.0, eta: 1.3 };
    let dense = Coefficients { sigma_a: 512.0, sigma_s: 10_240.0, ..thin };
    let of = |coefficients, threads| {
        let light = Searchlight { threads, ..searchlight(coefficients, edges.clone(), 2000) };
        measured("random-walk", &light).expect("measures")
    };
    assert_eq!(of(thin, 1), of(thin, 3));
    assert_eq!(of(thin, 1), of(dense, 1));
}

#[test]
fn what_has_no_profile_says_so() {
    let edges = vec![0.1, 1.0];
    let medium = Coefficients::isotropic(1.0, 10.0, 1.3);
    let of = |model, coefficients| measured(model, &searchlight(coefficients, edges.clone(), 1000));
    assert!(matches!(of("brdf-approximation", medium), Err(SearchlightError::LeavesWhereItEntered)));
    assert!(matches!(of("light-biased", medium), Err(SearchlightError::NeedsLights)));
    let clear = Coefficients::isotropic(1.0, 0.0, 1.3);
    assert!(matches!(of("random-walk", clear), Err(SearchlightError::NothingScattered)));
    // Single scattering is a part of what the walk brings home.
    let [single, all] =
        ["single-scattering", "random-walk"].map(|model| of(model, medium).unwrap().total.value);
    assert!(single > 0.02 && single < 0.5 * all, "{single} of {all}");
}
