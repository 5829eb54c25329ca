//! Radial profiles against Monte Carlo.

use super::*;
use nephrite::optics::diffusion::*;
use std::f64::consts::TAU;

/// Power between the radii `a` and `b`: Simpson's rule in ln r.
fn power(profile: &dyn RadialProfile, a: f64, b: f64, panels: usize) -> f64 {
    let h = (b / a).ln() / (2 * panels) as f64;
    let sum: f64 = (0..=2 * panels)
        .map(|k| {
            let r = a * (h * k as f64).exp();
            let weight = if k == 0 || k == 2 * panels { 1.0 } else { [2.0, 4.0][k % 2] };
            weight * r * r * profile.eval(r)
        })
        .sum();
    TAU * sum * h / 3.0
}

struct Reference {
    bins: Vec<f64>,
    total: f64,
}

/// The models of the accuracy table.
fn model(name: &str, c: &Coefficients, albedo: f64) -> Option<Box<dyn RadialProfile>> {
    let single = || SingleScattering::new(c);
    let beam = PhotonBeam::new(c);
    let normalized = |l, fit| Box::new(NormalizedDiffusion::new(albedo, l, fit));
    Some(match name {
        "single_scatter_exact_quadrature" => Box::new(single()),
        "dipole_classical_ms" => Box::new(ClassicalDipole::new(c)),
        "dipole_classical_plus_ss" => Box::new((ClassicalDipole::new(c), single())),
        "dipole_better_ms" => Box::new(BetterDipole::new(c)),
        "dipole_better_plus_ss" => Box::new((BetterDipole::new(c), single())),
        "pbd_ms" => Box::new(beam),
        "pbd_ms_plus_ss" => Box::new((beam, single())),
        "pbd_nokappa_ms_plus_ss" => Box::new((beam.uncorrected(), single())),
        "directional_dipole" => Box::new(DirectionalDipole::new(c)),
        "burley_searchlight_mfp" => normalized(c.transport_mean_free_path(), ScaleFit::SearchlightMfp),
        "burley_diffuse_mfp" => normalized(c.transport_mean_free_path(), ScaleFit::DiffuseMfp),
        "burley_searchlight_dmfp" => normalized(c.diffuse_mean_free_path(), ScaleFit::SearchlightDmfp),
        _ => return None,
    })
}

/// Against the Monte Carlo profile of a normally incident pencil beam each model has the error it is known to have.
/// The reference is the same data that the expected errors were computed from, so its noise is common to both and the
/// tolerance is that of quadrature: 1e-5 of the reference total, where the errors of bins are 0.0002 to 4.
#[test]
fn profiles_have_their_known_errors_against_monte_carlo() {
    const TOLERANCE: f64 = 1e-5;
    // Powers and errors of bands of radii are printed with four to six digits.
    const BAND_TOLERANCE: f64 = 3e-4;
    let mut banded = 0;
    let data: Value =
        serde_json::from_str(include_str!("../oracles/searchlight.json")).expect("searchlight.json");
    let numbers = |v: &Value| -> Vec<f64> {
        v.as_array().expect("numbers").iter().map(|x| x.as_f64().expect("a number")).collect()
    };
    let edges = numbers(&data["searchlight"]["edges"]);
    let media = data["searchlight"]["media"].as_array().expect("media");
    let mut worst: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    for row in data["model_accuracy"]["table"].as_array().expect("a table") {
        let medium = media.iter().find(|m| m["id"] == row["id"]).expect("a medium");
        let number = |key: &str| medium[key].as_f64().expect("a number");
        let c = Coefficients {
            sigma_a: number("sigma_a"),
            sigma_s: number("sigma_s"),
            g: number("g"),
            eta: number("n"),
        };
        let (all, single) = (numbers(&medium["bin_fraction"]), numbers(&medium["bin_fraction_single"]));
        let (total, single_total) = (number("total"), number("total_single"));
        for (name, expected) in row["models"].as_object().expect("models") {
            let reference = if name.starts_with("single") {
                Reference { bins: single.clone(), total: single_total }
            } else if name.ends_with("_ms") {
                let bins = all.iter().zip(&single).map(|(a, s)| a - s).collect();
                Reference { bins, total: total - single_total }
            } else {
                Reference { bins: all.clone(), total }
            };
            let profile = model(name, &c, total).unwrap_or_else(|| panic!("{name} is unknown"));
            let mut bins = vec![power(&*profile, 1e-10, edges[0], 100)];
            bins.extend(edges.windows(2).map(|e| power(&*profile, e[0], e[1], 4)));
            bins.push(power(&*profile, edges[60], 1e6, 200));
            let sum: f64 = bins.iter().sum();
            let own = profile.total();
            assert!((own / sum - 1.0).abs() < TOLERANCE, "{name}: total {own}, bins {sum}");
            let l1 =
                bins.iter().zip(&reference.bins).map(|(a, b)| (a - b).abs()).sum::<f64>() / reference.total;
            let error = own / reference.total - 1.0;
            let [known, known_l1] = ["total_rel_err", "L1_bin_error"].map(|k| expected[k].as_f64().expect(k));
            let id = &row["id"];
            assert!((error - known).abs() < TOLERANCE, "{id} {name}: total off by {error}, known {known}");
            assert!((l1 - known_l1).abs() < TOLERANCE, "{id} {name}: bins off by {l1}, known {known_l1}");
            for band in expected["bands"].as_array().expect("bands") {
                let band = numbers(band);
                let [from, to, truth, known] = band[..] else { panic!("{id} {name}: {band:?}") };
                let error = power(&*profile, from, to, 40) / truth - 1.0;
                let tolerance = BAND_TOLERANCE * (1.0 + known.abs());
                assert!(
                    (error - known).abs() < tolerance,
                    "{id} {name}: off by {error} between {from} and {to}, known {known}"
                );
                banded += 1;
            }
            let entry = worst.entry(name.clone()).or_default();
            *entry = (entry.0.max((error - known).abs()), entry.1.max((l1 - known_l1).abs()));
        }
    }
    assert!(banded > 300, "only {banded} bands");
    for (name, (total, l1)) in worst {
        println!("{name:<34} total error within {total:.1e}, L1 within {l1:.1e} of the known");
    }
}
