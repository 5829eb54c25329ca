//! Light trees: probabilities against sampling and against what can be seen, noise against the best choice there is.

use super::*;
use crate::light::emitter::{EmissiveRadiance, EmissiveTriangle, Emitter};
use crate::sampling::{SmallRng, statistics::chi_square_z, warp};
use std::f32::consts::PI;

const DEFENSIVE: f32 = 0.1;

fn emitter(vertices: [Vec3; 3], radiance: f32, double_sided: bool) -> Emitter {
    let cross = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]);
    let sides = if double_sided { 2.0 } else { 1.0 };
    Emitter::new(EmissiveTriangle {
        instance: 0,
        triangle: 0,
        vertices,
        geometric_normal: cross.normalize(),
        double_sided,
        power: Vec3::splat(radiance * 0.5 * cross.length() * PI * sides),
        radiance: EmissiveRadiance::Constant(Vec3::splat(radiance)),
    })
    .unwrap()
}

/// Triangles of all sizes and directions in a cube of half size 1.
fn chaos(n: usize, rng: &mut SmallRng) -> Vec<Emitter> {
    let mut point = || Vec3::new(rng.f32(), rng.f32(), rng.f32()) * 2.0 - 1.0;
    (0..n)
        .map(|i| {
            let (at, size) = (point(), 10f32.powi(-((i % 4) as i32)) * 0.2);
            let vertices = [at, at + size * point(), at + size * point()];
            emitter(vertices, 1.0 + (i % 7) as f32 * 3.0, i % 5 == 0)
        })
        .collect()
}

/// Small lamps under a ceiling at height 3, in a square of `side`², shining down.
fn ceiling(side: usize, pitch: f32) -> Vec<Emitter> {
    let at = |i: usize| (i as f32 - 0.5 * side as f32) * pitch;
    (0..side * side)
        .map(|i| {
            let corner = Vec3::new(at(i / side), 3.0, at(i % side));
            emitter([corner, corner + 0.1 * Vec3::X, corner + 0.1 * Vec3::Z], 1.0 + (i % 3) as f32, false)
        })
        .collect()
}

fn tree(lights: &[Emitter]) -> LightTree {
    let bounds: Vec<_> = lights.iter().map(Emitter::bounds).collect();
    LightTree::new(&bounds, DEFENSIVE).unwrap()
}

/// Points inside and outside of the cube, with normals and without.
fn anchors(n: usize, rng: &mut SmallRng) -> Vec<(Vec3, Option<Vec3>)> {
    (0..n)
        .map(|i| {
            let reach = [0.5, 1.0, 2.0, 30.0][i % 4];
            let point = (Vec3::new(rng.f32(), rng.f32(), rng.f32()) * 2.0 - 1.0) * reach;
            (point, (i % 3 > 0).then(|| warp::uniform_sphere(rng.vec2())))
        })
        .collect()
}

#[test]
fn probabilities_sum_to_one_and_nothing_visible_is_missed() {
    let mut rng = SmallRng::new(1);
    for n in [1, 2, 5, 17, 300] {
        let lights = chaos(n, &mut rng);
        let tree = tree(&lights);
        for anchor in anchors(60, &mut rng) {
            let exact = |i: usize| lights[i].importance(anchor.0, anchor.1);
            let probability: Vec<f32> = (0..n).map(|i| tree.probability(i, anchor, exact)).collect();
            for (i, &p) in probability.iter().enumerate() {
                assert_eq!(p > 0.0, exact(i) > 0.0, "{i} of {n} from {anchor:?}: {p}, {}", exact(i));
            }
            // Where a leaf is entered for nothing (a bound lets in what is not there), its share of the samples is lost.
            let lost = |u: f32| tree.sample(anchor, f64::from(u), exact).is_none();
            let blank = (0..512).filter(|i| lost((*i as f32 + 0.5) / 512.0)).count() as f32 / 512.0;
            let sum: f32 = probability.iter().sum();
            assert!((sum + blank - 1.0).abs() < 0.02, "{n} from {anchor:?}: {sum} and {blank} lost");
            if blank == 0.0 {
                assert!((sum - 1.0).abs() < 0.004, "{n} from {anchor:?}: {sum}");
            }
        }
    }
}

#[test]
fn frequencies_are_the_probabilities() {
    let mut rng = SmallRng::new(5);
    let lights = chaos(200, &mut rng);
    let tree = tree(&lights);
    for anchor in anchors(12, &mut rng) {
        let exact = |i: usize| lights[i].importance(anchor.0, anchor.1);
        let n = 40_000;
        let mut counts = vec![0u64; lights.len() + 1];
        for _ in 0..n {
            let u = finer(rng.f32(), rng.vec2());
            match tree.sample(anchor, u, exact) {
                Some((i, p)) => {
                    counts[i] += 1;
                    // Products in another order.
                    let again = tree.probability(i, anchor, exact);
                    assert!((p - again).abs() < 1e-5 * p, "{p} {again}");
                }
                None => counts[lights.len()] += 1,
            }
        }
        let mut expected: Vec<f64> =
            (0..lights.len()).map(|i| f64::from(tree.probability(i, anchor, exact) * n as f32)).collect();
        expected.push((f64::from(n) - expected.iter().sum::<f64>()).max(0.0));
        let z = chi_square_z(&counts, &expected);
        assert!(z.abs() < 4.0, "{anchor:?}: z = {z}");
    }
}

/// Second moment of radiance/probability for lights seen without obstacles, over that of the best probabilities.
fn noise(lights: &[Emitter], anchor: (Vec3, Option<Vec3>)) -> f64 {
    let tree = tree(lights);
    let exact = |i: usize| lights[i].importance(anchor.0, anchor.1);
    let (mut second, mut total) = (0.0, 0.0);
    for i in 0..lights.len() {
        let (e, p) = (f64::from(exact(i)), f64::from(tree.probability(i, anchor, exact)));
        total += e;
        second += if e > 0.0 { e * e / p } else { 0.0 };
    }
    second / (total * total)
}

#[test]
fn a_thousand_lamps_are_chosen_nearly_as_well_as_can_be() {
    // E[f²]/E[f]² is 1 for p ∝ f. Choosing by power alone costs what the last number says; the bounds are those of the
    // method with room for other compilers' rounding.
    let mut rng = SmallRng::new(2);
    let all = chaos(1000, &mut rng);
    let (mut mean, mut count) = ([0.0; 2], 0.0);
    let power: f64 = all.iter().map(|l| f64::from(l.bounds().flux)).sum();
    for anchor in anchors(40, &mut rng) {
        let exact = |l: &Emitter| f64::from(l.importance(anchor.0, anchor.1));
        let total: f64 = all.iter().map(exact).sum();
        if total == 0.0 {
            continue;
        }
        let by_power: f64 =
            all.iter().map(|l| exact(l).powi(2) / f64::from(l.bounds().flux) * power).sum::<f64>();
        mean[0] += noise(&all, anchor).ln();
        mean[1] += (by_power / (total * total)).ln();
        count += 1.0;
    }
    let mean = mean.map(|m| m / count);
    assert!(count > 30.0);
    println!("chaos: {:.2} by tree, {:.2} by power", mean[0].exp(), mean[1].exp());
    assert!(mean[0].exp() < 4.0 && mean[0] < mean[1] - 0.7);
    let lamps = ceiling(32, 0.5);
    for x in [0.0, 3.1, 7.9, 30.0] {
        let ratio = noise(&lamps, (Vec3::new(x, 0.0, 0.3), Some(Vec3::Y)));
        println!("ceiling, x = {x}: {ratio:.3}");
        assert!(ratio < 1.3, "{x}: {ratio}");
    }
}

#[test]
fn odd_arrangements_make_no_deep_trees() {
    // Distances that grow as powers of two, lights at one place, and lights without size.
    let powers: Vec<LightBounds> = (0..3000)
        .map(|i| {
            let at = Vec3::X * 2f32.powi(i % 120 - 60) + Vec3::Y * (i as f32 * 1e-9);
            LightBounds { low: at, high: at, cone: Cone::SPHERE, flux: 1.0, reach: f32::INFINITY }
        })
        .collect();
    let same: Vec<LightBounds> =
        powers.iter().map(|l| LightBounds { low: Vec3::ONE, high: Vec3::ONE, ..*l }).collect();
    for lights in [powers, same] {
        let tree = LightTree::new(&lights, DEFENSIVE).unwrap();
        let anchor = (Vec3::new(0.3, 0.2, 0.1), None);
        let mut sum = 0.0;
        for i in 0..lights.len() {
            sum += tree.probability(i, anchor, |_| 1.0);
            let (mut at, mut depth) = (tree.leaf_of[i], 0);
            while at != 0 {
                (at, depth) = (tree.nodes[at as usize].parent, depth + 1);
            }
            assert!(depth < 50, "{depth} levels");
        }
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        // On top of a light.
        assert!(tree.sample((Vec3::ONE, None), 0.5, |_| 1.0).is_some());
    }
    assert!(LightTree::new(&[], DEFENSIVE).is_none());
}

#[test]
fn lights_out_of_reach_are_not_chosen() {
    let lamp = |x: f32, reach| {
        let at = Vec3::X * x;
        LightBounds { low: at, high: at, cone: Cone::SPHERE, flux: 1.0, reach }
    };
    let lights: Vec<_> = (0..40).map(|i| lamp(i as f32, 2.0)).collect();
    let tree = LightTree::new(&lights, DEFENSIVE).unwrap();
    let exact = |i: usize| if (i as f32 - 10.0).abs() < 2.0 { 1.0 } else { 0.0 };
    let anchor = (Vec3::X * 10.0, None);
    let sum: f32 = (9..12).map(|i| tree.probability(i, anchor, exact)).sum();
    assert!(sum > 0.8, "{sum}");
    assert!(tree.sample((Vec3::Y * 5.0, None), 0.5, |_| 1.0).is_none());
}
