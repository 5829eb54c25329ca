//! What a layer on top of a surface does to the light that meets it, in numbers that depend on one cosine.
//!
//! A layer reflects the share E(µ). The rest passes straight on, meets the base, and has to pass again: a share
//! min(1 − E(µ_o), 1 − E(µ_i)) of what the base reflects from o to i gets out, the largest that is reciprocal and leaves
//! no direction with more than 1 − E (KHR_materials_sheen layers so). It falls short of 1 − E(µ_o) by what a base that
//! reflects the density e_b sends to directions in which the layer holds back more,
//!
//! ```text
//! R(µ_o) = ∫ e_b(o, i) (E(µ_i) − E(µ_o))⁺ dω_i,
//! ```
//!
//! light that is thrown back to the base and comes out at last: layered surfaces return it by the lobe R(µ_o) R(µ_i) µ_i/(π R̄),
//! R̄ = ∫ 2µ R dµ, like Kulla & Conty 2017 what is lost by masking. Nothing comes back from a mirror, whose µ_i is µ_o; for a
//! Lambertian base, and E that falls with µ, R(µ) = ∫₀^µ 2t E(t) dt − µ² E(µ) =: R_L(µ). Between them R = k R_L is taken, k
//! a function of the roughness ([`spread_of`]).

/// Cells of a table over the cosine.
const CELLS: usize = 64;

/// E, and R_L, of a layer of one roughness.
pub(super) struct TopTable {
    albedo: [f32; CELLS + 1],
    residue: [f32; CELLS + 1],
    residue_average: f32,
}

impl TopTable {
    /// Tabulates `albedo`, a function of the cosine.
    pub(super) fn new(mut albedo: impl FnMut(f32) -> f32) -> Self {
        let mu = |i: usize| i as f32 / CELLS as f32;
        let albedo: [f32; CELLS + 1] = std::array::from_fn(|i| albedo(mu(i)).clamp(0.0, 1.0));
        let mut cumulative = 0.0;
        let mut residue = [0.0; CELLS + 1];
        let cell = |f: &[f32; CELLS + 1], i: usize| {
            let (a, b) = (mu(i - 1), mu(i));
            (b - a) * (2.0 * f[i - 1] * a + f[i - 1] * b + f[i] * a + 2.0 * f[i] * b) / 3.0
        };
        for i in 1..=CELLS {
            cumulative += cell(&albedo, i);
            residue[i] = (cumulative - mu(i) * mu(i) * albedo[i]).max(0.0);
        }
        let residue_average = (1..=CELLS).map(|i| cell(&residue, i)).sum();
        Self { albedo, residue, residue_average }
    }

    #[inline]
    fn read(values: &[f32; CELLS + 1], mu: f32) -> f32 {
        let x = mu.clamp(0.0, 1.0) * CELLS as f32;
        let i = (x as usize).min(CELLS - 1);
        values[i] + (x - i as f32) * (values[i + 1] - values[i])
    }

    /// E(µ).
    pub(super) fn albedo(&self, mu: f32) -> f32 {
        Self::read(&self.albedo, mu)
    }

    /// R_L(µ).
    pub(super) fn residue(&self, mu: f32) -> f32 {
        Self::read(&self.residue, mu)
    }

    /// ∫ 2µ R_L dµ.
    pub(super) fn residue_average(&self) -> f32 {
        self.residue_average
    }
}

/// Where among `count` even slices of \[0, 1\] a parameter is: the slice, and the weight of the next.
#[inline]
pub(super) fn slice(parameter: f32, count: usize) -> (usize, f32) {
    let x = parameter.clamp(0.0, 1.0) * (count - 1) as f32;
    let j = (x as usize).min(count - 2);
    (j, x - j as f32)
}

#[inline]
pub(super) fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

/// k(α): how much of R_L a GGX metal of width α has, fitted to quadrature (`docs/materials.md`).
#[inline]
pub(super) fn spread_of(alpha: f32) -> f32 {
    let a = alpha.clamp(0.0, 1.0);
    (a * (1.0 + 0.6 * a * (1.0 - a))).min(1.0)
}
