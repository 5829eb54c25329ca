//! Tables against the profiles they are made of, and their sampler against its density.

use super::*;
use crate::optics::test_support::Rng;
use crate::sampling::statistics::chi_square_z;
use std::f64::consts::TAU;

/// Media from dark to bright, without absorption, forward scattering, small units.
const MEDIA: [Coefficients; 6] = [
    Coefficients { sigma_a: 0.7, sigma_s: 0.3, g: 0.0, eta: 1.0 },
    Coefficients { sigma_a: 0.05, sigma_s: 0.95, g: 0.0, eta: 1.5 },
    Coefficients { sigma_a: 1e-3, sigma_s: 4.995, g: 0.8, eta: 1.33 },
    Coefficients { sigma_a: 0.0, sigma_s: 1.0, g: 0.0, eta: 1.3 },
    Coefficients { sigma_a: 2.1, sigma_s: 2190.0, g: 0.0, eta: 1.5 },
    Coefficients { sigma_a: 32.0, sigma_s: 5_000.0, g: -0.4, eta: 0.8 },
];

fn profiles(c: &Coefficients) -> Vec<(&'static str, Box<dyn RadialProfile>)> {
    vec![
        ("classical", Box::new(ClassicalDipole::new(c))),
        ("better", Box::new(BetterDipole::new(c))),
        ("beam", Box::new(PhotonBeam::new(c))),
        ("beam and single", Box::new((PhotonBeam::new(c), SingleScattering::new(c)))),
        ("single", Box::new(SingleScattering::new(c))),
        ("directional", Box::new(DirectionalDipole::new(c))),
        (
            "normalized",
            Box::new(NormalizedDiffusion::new(0.6, c.transport_mean_free_path(), ScaleFit::SearchlightMfp)),
        ),
    ]
}

fn tables() -> impl Iterator<Item = (String, Box<dyn RadialProfile>, TabulatedProfile)> {
    MEDIA.iter().flat_map(|c| {
        profiles(c).into_iter().map(move |(name, profile)| {
            let table = TabulatedProfile::new(&*profile).expect("a table");
            (format!("{name} of {c:?}"), profile, table)
        })
    })
}

/// ∫ pdf_radius dr from `a` to `b`, Simpson's rule in ln r.
fn mass(table: &TabulatedProfile, a: f64, b: f64) -> f64 {
    const PANELS: usize = 20_000;
    let h = (b / a).ln() / (2 * PANELS) as f64;
    let sum: f64 = (0..=2 * PANELS)
        .map(|k| {
            let r = a * (h * k as f64).exp();
            let weight = if k == 0 || k == 2 * PANELS { 1.0 } else { [2.0, 4.0][k % 2] };
            weight * r * f64::from(table.pdf_radius(r as f32))
        })
        .sum();
    sum * h / 3.0
}

#[test]
fn density_integrates_to_one() {
    for (name, _, table) in tables() {
        let r = f64::from(table.max_radius());
        let sum = mass(&table, r * 1e-9, r * 1e7);
        assert!((sum - 1.0).abs() < 1e-4, "{name}: {sum}");
        let held = mass(&table, r * 1e-9, r);
        assert!((held - 0.9995).abs() < 1e-5, "{name}: {held} within {r}");
    }
}

/// χ² of half a million samples in 60 bins, the outer ones beyond the last radius of the table. One fixed seed a
/// table; |z| < 4.
#[test]
fn samples_follow_the_density() {
    const SAMPLES: usize = 500_000;
    const BINS: usize = 60;
    for (k, (name, _, table)) in tables().enumerate() {
        let quantile = |i: usize| match i {
            0 => 0.0,
            BINS => f64::INFINITY,
            _ if i > BINS - 6 => f64::from(table.max_radius()) * 1.3f64.powi(i as i32 - BINS as i32 + 4),
            _ => f64::from(table.sample(i as f32 / (BINS - 5) as f32 * 0.999)),
        };
        let mut edges: Vec<f64> = (0..=BINS).map(quantile).collect();
        edges.sort_by(f64::total_cmp);
        let mut counts = vec![0u64; BINS];
        let mut rng = Rng::new(77 + k as u64);
        for _ in 0..SAMPLES {
            let r = f64::from(table.sample(rng.next()));
            counts[edges.partition_point(|&e| e <= r).clamp(1, BINS) - 1] += 1;
        }
        let far = f64::from(table.max_radius());
        let mut expected: Vec<f64> = edges
            .windows(2)
            .map(|e| mass(&table, e[0].max(far * 1e-9), e[1].min(far * 1e7)) * SAMPLES as f64)
            .collect();
        let scale = SAMPLES as f64 / expected.iter().sum::<f64>();
        expected.iter_mut().for_each(|e| *e *= scale);
        let z = chi_square_z(&counts, &expected);
        assert!(z.abs() < 4.0, "{name}: z = {z}");
    }
}

/// Where the profile holds 99 % of its energy the table is within 0.5 % of it, and its total is the profile's.
#[test]
fn tables_are_close_to_their_profiles() {
    let mut worst = (0.0f64, String::new());
    for (name, profile, table) in tables() {
        let total = profile.total();
        assert!((f64::from(table.total()) / total - 1.0).abs() < 1e-6, "{name}");
        for i in 0..=200 {
            let r = table.sample(0.005 + 0.99 * i as f32 / 200.0);
            let (got, expected) = (f64::from(table.eval(r)), profile.eval(f64::from(r)));
            let error = (got / expected - 1.0).abs();
            assert!(error < 5e-3, "{name} at {r}: {got} for {expected}");
            if error > worst.0 {
                worst = (error, format!("{name} at {r}"));
            }
        }
    }
    println!("tables within {:.1e} ({})", worst.0, worst.1);
}

/// The unbiased estimate ∫ R dA = E[R/pdf_area], with the profile itself and not the table: no energy is lost anywhere.
#[test]
fn sampling_keeps_the_energy() {
    const SAMPLES: usize = 20_000;
    for (name, profile, table) in tables() {
        let sum: f64 = (0..SAMPLES)
            .map(|i| table.sample((i as f32 + 0.5) / SAMPLES as f32))
            .map(|r| profile.eval(f64::from(r)) / f64::from(table.pdf_area(r)))
            .sum();
        let ratio = sum / SAMPLES as f64 / profile.total();
        assert!((ratio - 1.0).abs() < 1e-3, "{name}: {ratio}");
    }
}

/// Totals in closed form are the integrals of their profiles.
#[test]
fn totals_are_integrals() {
    for c in &MEDIA[..3] {
        for (name, profile) in profiles(c) {
            let steps = 4000;
            let (from, to) = (-21.0, 18.0);
            let h = (to - from) / f64::from(steps);
            let sum: f64 =
                (0..=steps).map(|k| (from + h * f64::from(k)).exp()).map(|r| r * r * profile.eval(r)).sum();
            let (sum, total) = (TAU * sum * h, profile.total());
            assert!((sum / total - 1.0).abs() < 1e-6, "{name} of {c:?}: {total} for {sum}");
        }
    }
}

#[test]
fn media_that_do_not_scatter_have_no_table() {
    for (sigma_a, sigma_s, g) in [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.5)] {
        let c = Coefficients { sigma_a, sigma_s, g, eta: 1.4 };
        for (name, profile) in profiles(&c).into_iter().filter(|(name, _)| *name != "normalized") {
            assert!(TabulatedProfile::new(&*profile).is_none(), "{name} of {c:?}");
            assert_eq!(profile.total(), 0.0, "{name} of {c:?}");
        }
    }
}

/// Samples are finite, not negative and in order at every number that a generator may give.
#[test]
fn the_ends_of_the_sampler_are_safe() {
    for (name, _, table) in tables() {
        let mut before = 0.0;
        for u in [0.0, f32::MIN_POSITIVE, 1e-9, 1e-4, 0.5, 0.999, 0.99999, crate::sampling::ONE_MINUS_EPSILON]
        {
            let r = table.sample(u);
            assert!(r.is_finite() && r >= before, "{name}: {r} at {u}");
            before = r;
        }
        assert!(table.pdf_area(0.0).is_finite() && table.pdf_radius(1e30) == 0.0, "{name}");
    }
}

/// The best of ten: other work on the machine does not count.
#[test]
fn tables_are_quick_to_build() {
    let milliseconds = |profile: &dyn RadialProfile| {
        let start = std::time::Instant::now();
        assert!(TabulatedProfile::new(profile).is_some());
        start.elapsed().as_secs_f64() * 1e3
    };
    for (name, profile) in profiles(&MEDIA[2]) {
        let best = (0..10).map(|_| milliseconds(&*profile)).fold(f64::INFINITY, f64::min);
        println!("{name}: {best:.2} ms");
        assert!(cfg!(debug_assertions) || best < 5.0, "{name}: {best} ms");
    }
}
