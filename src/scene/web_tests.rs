use super::*;
use std::f64::consts::TAU;

fn direction(photometry: Photometry, v: f32, h: f32) -> Vec3 {
    let ((sv, cv), (sh, ch)) = (v.to_radians().sin_cos(), h.to_radians().sin_cos());
    match photometry {
        Photometry::C => Vec3::new(sv * ch, sv * sh, -cv),
        Photometry::B => Vec3::new(cv * sh, sv, -cv * ch),
        Photometry::A => Vec3::new(sv, -cv * sh, -cv * ch),
    }
}

/// Candela in a direction.
fn candela(web: &PhotometricWeb, v: f32, h: f32) -> f32 {
    web.relative(direction(web.photometry, v, h)) * web.largest()
}

/// A table whose candela are 10 · (index of h) + (index of v) + 1.
fn numbered(
    photometry: Photometry,
    vertical: &[f32],
    horizontal: &[f32],
) -> Result<PhotometricWeb, WebError> {
    let candela: Vec<f32> = (0..horizontal.len())
        .flat_map(|h| (0..vertical.len()).map(move |v| (10 * h + v + 1) as f32))
        .collect();
    PhotometricWeb::new(photometry, vertical.to_vec(), horizontal.to_vec(), &candela)
}

#[track_caller]
fn near(found: f32, expected: f32) {
    assert!((found - expected).abs() < 2e-4 * expected.max(1.0), "{found} instead of {expected}");
}

#[test]
fn candela_at_and_between_the_angles_of_the_table() {
    let tables: [(Photometry, &[f32], &[f32]); 4] = [
        (Photometry::C, &[0.0, 30.0, 90.0, 180.0], &[0.0, 45.0, 100.0, 250.0, 360.0]),
        (Photometry::C, &[0.0, 10.0, 80.0], &[90.0, 180.0, 270.0]),
        (Photometry::B, &[-90.0, -20.0, 0.0, 60.0], &[-80.0, -10.0, 45.0, 90.0]),
        (Photometry::A, &[-30.0, 0.0, 15.0], &[-90.0, 0.0, 30.0]),
    ];
    for (photometry, vertical, horizontal) in tables {
        let web = numbered(photometry, vertical, horizontal).expect("a web");
        for (i, &v) in vertical.iter().enumerate() {
            for (j, &h) in horizontal.iter().enumerate() {
                // At the poles all planes are one direction, which is that of one of the rows; 0° and 360° are one plane.
                let pole = if photometry == Photometry::C { v % 180.0 == 0.0 } else { v.abs() == 90.0 };
                let seam = photometry == Photometry::C && (h == 360.0 || (h == 0.0 && horizontal.len() == 5));
                if !pole && !seam {
                    near(candela(&web, v, h), (10 * j + i + 1) as f32);
                }
            }
        }
        // Bilinear: a quarter of the way along v, three quarters along h.
        let (i, j) = (1, 1);
        let (v, h) =
            (0.75 * vertical[i] + 0.25 * vertical[i + 1], 0.25 * horizontal[j] + 0.75 * horizontal[j + 1]);
        near(candela(&web, v, h), 10.0 * (j as f32 + 0.75) + i as f32 + 0.25 + 1.0);
        let outside = |v: f32, h: f32| assert_eq!(candela(&web, v, h), 0.0, "{v} {h}");
        match photometry {
            Photometry::C if vertical.len() == 3 => outside(81.0, 120.0),
            Photometry::B => {
                [(61.0, 0.0), (0.0, -81.0), (0.0, 150.0)].iter().for_each(|(v, h)| outside(*v, *h))
            }
            Photometry::A => {
                [(16.0, 0.0), (-31.0, 0.0), (0.0, 31.0)].iter().for_each(|(v, h)| outside(*v, *h))
            }
            Photometry::C => {}
        }
    }
}

#[test]
fn straight_ahead_is_minus_z_and_axes_are_those_of_the_luminaire() {
    for photometry in [Photometry::A, Photometry::B, Photometry::C] {
        assert!((direction(photometry, 0.0, 0.0) - Vec3::NEG_Z).length() < 1e-6);
    }
    // One bright spot each: C at the side of +Y, B up and to the right, A along the length.
    let spot = |photometry, vertical: &[f32], horizontal: &[f32], at: usize| {
        let mut candela = vec![0.0; vertical.len() * horizontal.len()];
        candela[at] = 5.0;
        PhotometricWeb::new(photometry, vertical.to_vec(), horizontal.to_vec(), &candela).expect("a web")
    };
    let c = spot(Photometry::C, &[0.0, 90.0, 180.0], &[0.0, 90.0, 180.0, 270.0, 360.0], 4);
    near(c.relative(Vec3::Y), 1.0);
    assert!(c.relative(Vec3::NEG_Y) < 1e-6 && c.relative(Vec3::X) < 1e-6);
    let b = spot(Photometry::B, &[-90.0, 0.0, 45.0, 90.0], &[-90.0, 0.0, 45.0, 90.0], 10);
    near(b.relative(Vec3::new(0.5, 0.5f32.sqrt(), -0.5)), 1.0);
    let a = spot(Photometry::A, &[-90.0, 0.0, 45.0, 90.0], &[-90.0, 0.0, 45.0, 90.0], 10);
    near(a.relative(Vec3::new(0.5f32.sqrt(), -0.5, -0.5)), 1.0);
    // Turned as a node is: −Z to +X, X to +Z … so a light that shone along −Z shines along +X.
    let turn = Mat3::from_cols(Vec3::Z, Vec3::Y, Vec3::NEG_X);
    let beam = spot(Photometry::C, &[0.0, 10.0, 20.0], &[0.0], 0);
    let turned = TurnedWeb::new(beam.into(), turn);
    near(turned.relative(Vec3::X), 1.0);
    near(turned.relative(Vec3::new(5f32.to_radians().cos(), 5f32.to_radians().sin(), 0.0)), 0.5);
    assert_eq!(turned.relative(Vec3::NEG_Z), 0.0);
    let (axis, angle) = turned.cone();
    assert!((axis - Vec3::X).length() < 1e-6 && (angle.to_degrees() - 10.0).abs() < 1e-4);
}

#[test]
fn what_symmetry_leaves_out_is_mirrored() {
    let v = [0.0, 50.0, 90.0];
    let at = |web: &PhotometricWeb, h: f32| candela(web, 50.0, h);
    let round = numbered(Photometry::C, &v, &[0.0]).expect("round");
    assert!([0.0, 77.0, 180.0, 333.0].iter().all(|h| (at(&round, *h) - 2.0).abs() < 1e-4));
    let quadrant = numbered(Photometry::C, &v, &[0.0, 40.0, 90.0]).expect("quadrant");
    let half = numbered(Photometry::C, &v, &[0.0, 40.0, 180.0]).expect("half");
    let across = numbered(Photometry::C, &v, &[90.0, 130.0, 270.0]).expect("half");
    let open = numbered(Photometry::C, &v, &[0.0, 40.0, 320.0]).expect("ends before 360°");
    for h in [40.0, 140.0, 220.0, 320.0] {
        near(at(&quadrant, h), 12.0);
    }
    near(at(&half, 320.0), 12.0);
    near(at(&half, 140.0), at(&half, 220.0));
    near(at(&across, 130.0), 12.0);
    near(at(&across, 50.0), 12.0);
    near(at(&across, 0.0), at(&across, 180.0));
    near(at(&across, -10.0), at(&across, 190.0));
    near(at(&open, 340.0), 0.5 * (22.0 + 2.0));
    for photometry in [Photometry::A, Photometry::B] {
        let web = numbered(photometry, &[0.0, 50.0, 90.0], &[0.0, 30.0, 90.0]).expect("mirrored");
        for (v, h) in [(50.0, 30.0), (-50.0, 30.0), (50.0, -30.0), (-50.0, -30.0)] {
            near(candela(&web, v, h), 12.0);
        }
    }
}

#[test]
fn flux_is_the_integral_over_the_sphere() {
    let close =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    let constant = |photometry, v: &[f32], h: &[f32]| {
        PhotometricWeb::new(photometry, v.to_vec(), h.to_vec(), &vec![3.0; v.len() * h.len()]).expect("a web")
    };
    close(constant(Photometry::C, &[0.0, 60.0, 180.0], &[0.0]).lumens(), 3.0 * 2.0 * TAU);
    for h in [&[0.0, 90.0][..], &[0.0, 33.0, 180.0], &[90.0, 270.0], &[0.0, 200.0], &[0.0, 7.0, 360.0]] {
        close(constant(Photometry::C, &[0.0, 90.0], h).lumens(), 3.0 * TAU);
    }
    for photometry in [Photometry::A, Photometry::B] {
        close(constant(photometry, &[-90.0, 90.0], &[-90.0, 90.0]).lumens(), 3.0 * TAU);
        close(constant(photometry, &[0.0, 20.0, 90.0], &[0.0, 90.0]).lumens(), 3.0 * TAU);
    }
    // By quadrature of what is looked up, for tables without any symmetry.
    let tables: [(Photometry, &[f32], &[f32]); 3] = [
        (Photometry::C, &[0.0, 30.0, 95.0], &[0.0, 45.0, 100.0, 250.0]),
        (Photometry::B, &[-60.0, 0.0, 60.0], &[-80.0, 45.0, 90.0]),
        (Photometry::A, &[0.0, 15.0, 40.0], &[0.0, 30.0]),
    ];
    for (photometry, v, h) in tables {
        let web = numbered(photometry, v, h).expect("a web");
        const N: usize = 600;
        let mut sum = 0.0;
        for i in 0..N {
            let z = 2.0 * (i as f64 + 0.5) / N as f64 - 1.0;
            let ring = (1.0 - z * z).sqrt();
            for j in 0..N {
                let (sin, cos) = (TAU * (j as f64 + 0.5) / N as f64).sin_cos();
                let d = glam::DVec3::new(ring * cos, ring * sin, z).as_vec3();
                sum += f64::from(web.relative(d));
            }
        }
        let expected = sum * f64::from(web.largest()) * 2.0 * TAU / (N * N) as f64;
        // Edges of the table cut cells of the quadrature.
        assert!((web.lumens() / expected - 1.0).abs() < 4e-3, "{photometry:?}: {} {expected}", web.lumens());
    }
}

#[test]
fn all_light_is_within_the_cone() {
    let web = |v: &[f32], values: &[f32]| {
        PhotometricWeb::new(Photometry::C, v.to_vec(), vec![0.0], values).expect("a web")
    };
    let check = |v: &[f32], values: &[f32], sign: f32, degrees: f32| {
        let (s, angle) = web(v, values).cone;
        let angle = angle.to_degrees();
        assert!(s == sign && (angle - degrees).abs() < 1e-3, "{v:?}: {s} {angle}");
    };
    check(&[0.0, 20.0, 40.0, 90.0], &[3.0, 1.0, 0.0, 0.0], 1.0, 40.0);
    check(&[0.0, 90.0], &[3.0, 1.0], 1.0, 90.0);
    check(&[0.0, 90.0, 150.0, 180.0], &[0.0, 0.0, 0.0, 2.0], -1.0, 30.0);
    check(&[90.0, 120.0, 180.0], &[1.0, 2.0, 2.0], -1.0, 90.0);
    check(&[0.0, 180.0], &[1.0, 1.0], 1.0, 180.0);
}

#[test]
fn what_is_no_web_is_refused() {
    let web = |photometry, v: &[f32], h: &[f32]| numbered(photometry, v, h).expect_err("no web");
    use Photometry::{A, B, C};
    assert!(matches!(
        web(C, &[0.0, 30.0, 30.0], &[0.0]),
        WebError::Order { which: "vertical", index: 2, .. }
    ));
    assert!(matches!(web(C, &[0.0, f32::NAN], &[0.0]), WebError::Order { index: 1, .. }));
    assert!(matches!(web(B, &[0.0, 90.0], &[90.0, 0.0]), WebError::Order { which: "horizontal", .. }));
    for (photometry, v, h) in [
        (C, &[0.0][..], &[0.0][..]),
        (C, &[], &[0.0]),
        (C, &[0.0, 90.0], &[]),
        (C, &[-10.0, 90.0], &[0.0]),
        (C, &[0.0, 200.0], &[0.0]),
        (C, &[0.0, 90.0], &[0.0, 120.0]),
        (C, &[0.0, 90.0], &[0.0, 400.0]),
        (B, &[0.0, 120.0], &[0.0, 90.0]),
        (B, &[0.0, 90.0], &[0.0]),
        (A, &[0.0, 90.0], &[-100.0, 90.0]),
    ] {
        assert!(matches!(web(photometry, v, h), WebError::Range { .. }), "{v:?} {h:?}");
    }
    for candela in [&[1.0][..], &[1.0, f32::INFINITY], &[1.0, -1.0], &[1.0; 3]] {
        let made = PhotometricWeb::new(C, vec![0.0, 90.0], vec![0.0], candela);
        assert!(matches!(made, Err(WebError::Values { expected: 2, .. })), "{candela:?}");
    }
    // One that is dark is a web.
    let dark = PhotometricWeb::new(C, vec![0.0, 90.0], vec![0.0], &[0.0; 2]).expect("dark");
    assert_eq!((dark.largest(), dark.relative(Vec3::NEG_Z), dark.lumens()), (0.0, 0.0, 0.0));
}
