//! Every closed form of the analytic subsurface models against high-precision values, and every radial profile against
//! Monte Carlo: an approximate model has to be wrong by exactly as much as it should.
//!
//! Values are double precision against 40-digit arithmetic rounded to double. Where nothing but rounding separates the
//! two the tolerance is 1e-10 relative, where a quadrature or a difference of large terms is in between it is stated at
//! the test. `cargo test --test formulas -- --nocapture` prints the largest deviation of every quantity.

mod closed_forms;
mod mistakes;
mod profiles;

use glam::DVec3;
use nephrite::optics::diffusion::Coefficients;
use serde_json::Value;
use std::collections::BTreeMap;

/// Rounding alone.
const ROUNDING: f64 = 1e-10;

fn groups() -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("../oracles/formulas.json")).expect("formulas.json");
    all["groups"].as_array().expect("groups").clone()
}

fn group(id: &str) -> Value {
    groups().into_iter().find(|g| g["id"] == id).unwrap_or_else(|| panic!("no group {id}"))
}

/// The inputs of a case by name.
struct Input<'a>(&'a Value);

impl Input<'_> {
    fn number(&self, key: &str) -> f64 {
        self.0[key].as_f64().unwrap_or_else(|| panic!("no {key} in {}", self.0))
    }

    fn vector(&self, key: &str) -> DVec3 {
        vector(&self.0[key])
    }

    /// Directions are renormalised, as the oracle's are.
    fn unit(&self, key: &str) -> DVec3 {
        self.vector(key).normalize()
    }

    fn coefficients(&self) -> Coefficients {
        let [sigma_a, sigma_s, g] = ["sigma_a", "sigma_s", "g"].map(|k| self.number(k));
        Coefficients { sigma_a, sigma_s, g, eta: self.0["eta"].as_f64().unwrap_or(1.0) }
    }

    fn isotropic(&self) -> Coefficients {
        Coefficients::isotropic(self.number("sigma_a"), self.number("sigma_s_prime"), self.number("eta"))
    }
}

fn vector(v: &Value) -> DVec3 {
    let c: Vec<f64> = v.as_array().expect("a vector").iter().map(|x| x.as_f64().expect("a number")).collect();
    DVec3::new(c[0], c[1], c[2])
}

/// Deviations from one group, the largest of each quantity.
#[derive(Default)]
struct Deviations {
    worst: BTreeMap<String, f64>,
    compared: usize,
}

impl Deviations {
    /// Relative to the expected value, absolute where that is 0. `null` has no counterpart and is passed over.
    fn compare(&mut self, what: &str, got: f64, expected: &Value, tolerance: f64) {
        let Some(expected) = expected.as_f64() else { return };
        let scale = if expected == 0.0 { 1.0 } else { expected.abs() };
        self.compare_scaled(what, got, expected, scale, tolerance);
    }

    fn compare_scaled(&mut self, what: &str, got: f64, expected: f64, scale: f64, tolerance: f64) {
        let deviation = (got - expected).abs() / scale;
        assert!(
            deviation <= tolerance,
            "{what}: {got} for {expected}, off by {deviation:.2e} > {tolerance:.0e}"
        );
        let worst = self.worst.entry(what.to_owned()).or_default();
        *worst = worst.max(deviation);
        self.compared += 1;
    }

    fn compare_vector(&mut self, what: &str, got: DVec3, expected: &Value, tolerance: f64) {
        let expected = vector(expected);
        self.compare_scaled(what, (got - expected).length(), 0.0, expected.length(), tolerance);
    }
}

/// Compares every case of a group.
fn each_case(id: &str, mut compare: impl FnMut(&Input, &Value, &mut Deviations)) {
    let group = group(id);
    let cases = group["cases"].as_array().expect("cases");
    let mut deviations = Deviations::default();
    for case in cases {
        compare(&Input(&case["in"]), &case["out"], &mut deviations);
    }
    assert!(deviations.compared >= cases.len(), "{id}: only {} comparisons", deviations.compared);
    println!("{id}: {} cases, {} comparisons", cases.len(), deviations.compared);
    for (what, worst) in &deviations.worst {
        println!("    {what:<36} {worst:.1e}");
    }
}
