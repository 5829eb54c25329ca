use super::super::microsurface_walk::Rng;
use super::*;
use glam::{Vec2, Vec3};

#[test]
#[ignore]
fn explore_tables() {
    use super::super::loss::Quadrature;
    let fine = Quadrature::<32, 32>::new();
    for eta in [1.0001f32, 1.01, 1.1, 1.33, 1.5, 2.0, 2.5] {
        let t = std::time::Instant::now();
        let tables = BoundaryTables::new(eta);
        let ms = t.elapsed().as_secs_f64() * 1e3;
        let kappa = boundary_tables::correlation(eta);
        for side in 0..2 {
            let (mut worst, mut sq, mut n) = ((0.0f32, 0.0, 0.0), 0.0f64, 0.0);
            for j in 0..30 {
                let alpha = 1e-3f32.powf(1.0 - (j as f32 + 0.37) / 30.0);
                for i in 0..60 {
                    let mu = ((i as f32 + 0.5) / 60.0).powi(2);
                    let f = fine.lost(mu, alpha, if side == 0 { eta } else { 1.0 / eta }, kappa);
                    let d = (f.reflected + f.refracted - tables.at(alpha).loss(side, mu)).abs();
                    sq += (d * d) as f64;
                    n += 1.0;
                    if d > worst.0 {
                        worst = (d, alpha, mu);
                    }
                }
            }
            println!("eta {eta} side {side} {ms:.1} ms: worst {worst:?} rms {:.6}", (sq / n).sqrt());
        }
    }
    let b = DielectricBoundary::new(1.5, 0.3, Microfacet::Multiple);
    let mut rng = Rng::new(1);
    let t = std::time::Instant::now();
    let mut s = 0.0;
    for _ in 0..1_000_000 {
        s += b.sample(Vec3::new(0.6, 0.0, 0.8), rng.next(), rng.vec2()).map_or(0.0, |x| x.pdf.min(1.0));
    }
    println!("sample {} ns {s}", t.elapsed().as_nanos() as f64 / 1e6);
    let t = std::time::Instant::now();
    for _ in 0..1_000_000 {
        let u = rng.vec2();
        s += b.pdf(Vec3::new(0.6, 0.0, 0.8), Vec3::new(u.x * 0.3, u.y * 0.3, -0.9)).min(1.0);
    }
    println!("eval {} ns {s}", t.elapsed().as_nanos() as f64 / 1e6);
    let t = std::time::Instant::now();
    for i in 0..1_000_000 {
        let u = 0.1 + 1e-7 * i as f32;
        s += DielectricBoundary::new(1.5, u, Microfacet::Multiple).alpha;
    }
    println!("new {} ns {s}", t.elapsed().as_nanos() as f64 / 1e6);
    // albedo by counting
    for (eta, alpha) in [(1.5f32, 0.3f32), (1.5, 1.0), (2.4, 0.6), (1.01, 0.5), (1.0001, 0.2)] {
        let b = DielectricBoundary::new(eta, alpha, Microfacet::Multiple);
        for z in [-0.9f32, -0.3, 0.05, 0.5] {
            let wo = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
            let (mut none, mut sum) = (0, 0.0f64);
            let n = 100000;
            for _ in 0..n {
                match b.sample(wo, rng.next(), rng.vec2()) {
                    None => none += 1,
                    Some(s) => {
                        let e = b.eval(wo, s.wi) / s.pdf / s.weight;
                        sum += e.x as f64 / n as f64;
                    }
                }
            }
            println!("{eta} {alpha} {z}: none {none} mean ratio {sum}");
        }
    }
    let _ = Vec2::ZERO;
}
