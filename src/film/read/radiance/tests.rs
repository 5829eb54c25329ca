use super::*;
use glam::Vec3;

const W: usize = 9;
const H: usize = 3;

/// A pixel of its own for each place.
fn pixel(x: usize, y: usize) -> [u8; 4] {
    [128 + x as u8, 64 + y as u8, 32, 129]
}

fn value([r, g, b, e]: [u8; 4]) -> Vec3 {
    Vec3::new(f32::from(r), f32::from(g), f32::from(b)) * (f32::from(e) - 136.0).exp2()
}

/// A file with that information and resolution and pixels in the order of the file.
fn file(lines: &str, resolution: &str, pixels: &[u8]) -> Vec<u8> {
    [format!("#?RGBE\n{lines}\n{resolution}\n").as_bytes(), pixels].concat()
}

fn one(lines: &str, pixel: [u8; 4]) -> Vec3 {
    decode(&file(lines, "-Y 1 +X 1", &pixel), 1).unwrap().pixels[0]
}

#[track_caller]
fn near(found: Vec3, expected: Vec3) {
    assert!((found - expected).abs().max_element() < 2e-3, "{found} {expected}");
}

#[test]
fn pixels_are_where_the_resolution_says() {
    for (resolution, columns, left, up) in [
        ("-Y 3 +X 9", false, false, false),
        ("-Y 3 -X 9", false, true, false),
        ("+Y 3 +X 9", false, false, true),
        ("+Y 3 -X 9", false, true, true),
        ("+X 9 -Y 3", true, false, false),
        ("-X 9 -Y 3", true, true, false),
        ("+X 9 +Y 3", true, false, true),
        ("-X 9 +Y 3", true, true, true),
    ] {
        let (lines, length) = if columns { (W, H) } else { (H, W) };
        let mut stored = Vec::new();
        for line in 0..lines {
            for i in 0..length {
                let (x, y) = if columns { (line, i) } else { (i, line) };
                stored.extend(pixel(if left { W - 1 - x } else { x }, if up { H - 1 - y } else { y }));
            }
        }
        let picture = decode(&file("FORMAT=32-bit_rle_rgbe\n", resolution, &stored), W * H).unwrap();
        assert_eq!((picture.width as usize, picture.height as usize), (W, H));
        for (i, found) in picture.pixels.iter().enumerate() {
            assert_eq!(*found, value(pixel(i % W, i / W)), "{resolution}, pixel {i}");
        }
    }
}

#[test]
fn every_encoding_means_the_same() {
    let (a, b) = ([128, 64, 32, 129], [10, 20, 30, 140]);
    let line = [a, a, a, a, a, a, a, b, b];
    // Seven of a, two of b: runs and literals of each component.
    let mut new = vec![2, 2, 0, 9];
    for c in 0..3 {
        new.extend([128 + 7, a[c], 2, b[c], b[c]]);
    }
    new.extend([3, a[3], a[3], a[3], 128 + 4, a[3], 128 + 2, b[3]]);
    let old = [a, [1, 1, 1, 6], b, [1, 1, 1, 1]].concat();
    for stored in [line.concat(), new, old] {
        for signature in ["#?RADIANCE", "#?RGBE"] {
            let bytes = file("", "-Y 1 +X 9", &stored);
            let bytes = [signature.as_bytes(), &bytes[6..]].concat();
            let picture = decode(&bytes, 9).unwrap();
            assert_eq!(picture.pixels, line.map(value));
        }
    }
    // The second of two runs counts 256 times as much.
    let long = [a, [1, 1, 1, 3], [1, 1, 1, 2]].concat();
    let picture = decode(&file("", "-Y 1 +X 516", &long), 516).unwrap();
    assert_eq!(picture.pixels, vec![value(a); 516]);
}

#[test]
fn xyz_becomes_rec_709() {
    // XYZ of 1, 0.5, 0.25 by the matrix of sRGB.
    let xyz = Vec3::new(0.636_35, 0.588_34, 0.316_52);
    let stored = [xyz.x, xyz.y, xyz.z].map(|c| (c * 256.0) as u8);
    let lines = "SOFTWARE=x\nFORMAT=32-bit_rle_xyze\r\n";
    let found = one(lines, [stored[0], stored[1], stored[2], 128]);
    assert!((found - Vec3::new(1.0, 0.5, 0.25)).abs().max_element() < 0.012, "{found}");
}

#[test]
fn exposures_are_divided_out_and_primaries_converted() {
    let grey = [128, 128, 128, 129];
    near(one("EXPOSURE=4\n# EXPOSURE=9\n\tEXPOSURE=9\nEXPOSURE= 0.5\n", grey), Vec3::splat(0.5));
    near(one("COLORCORR=1 2 4\nEXPOSURE=2\n", grey), Vec3::new(0.5, 0.25, 0.125));
    near(one("EXPOSURE=0\nEXPOSURE=nan\nEXPOSURE=x\nCOLORCORR=1 2\n", grey), Vec3::ONE);
    // White stays white; the green of Rec. 2020 lies outside of Rec. 709.
    let rec_2020 = "PRIMARIES= 0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290\n";
    near(one(rec_2020, grey), Vec3::ONE);
    near(one(rec_2020, [128, 0, 0, 129]), Vec3::new(1.6605, 0.0, 0.0));
    near(one("PRIMARIES=0 0 0 0 0 0 0 0\n", [128, 64, 0, 129]), Vec3::new(1.0, 0.5, 0.0));
}

#[test]
fn broken_files_say_what_is_wrong() {
    let long = format!("{}\n", "x".repeat(MOST_HEADER));
    for (lines, resolution, pixels, word) in [
        ("FORMAT=32-bit_rle_luv\n", "-Y 1 +X 1", &[1, 2, 3, 4][..], "32-bit_rle_xyze"),
        (&long, "-Y 1 +X 1", &[1, 2, 3, 4], "no end"),
        ("", "-Y 1 +Y 1", &[], "-Y 512 +X 1024"),
        ("", "-Y -1 +X 1", &[], "-Y 512 +X 1024"),
        ("", "-Y 1", &[], "-Y 512 +X 1024"),
        ("", "-Y 0 +X 1", &[], "no pixels"),
        ("", "-Y 1 +X 1", &[1, 2, 3], "ends in scan line 1 of 1"),
        ("", "-Y 2 +X 1", &[1, 2, 3, 4], "ends in scan line 2 of 2"),
        ("", "-Y 1 +X 1", &[1, 1, 1, 1], "without a pixel"),
        ("", "-Y 1 +X 2", &[5, 1, 1, 1, 1, 1, 1, 2], "beyond the end"),
        ("", "-Y 1 +X 8", &[2, 2, 0, 9, 0, 0, 0, 0, 0, 0], "other than that"),
        ("", "-Y 1 +X 8", &[2, 2, 0, 8, 137, 0, 0, 0, 0, 0, 0, 0], "beyond the end"),
        ("", "-Y 1 +X 8", &[2, 2, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0], "ends"),
        ("", "-Y 1 +X 8", &[2, 2, 0, 8, 128, 0, 0, 0, 0, 0, 0, 0], "beyond the end"),
    ] {
        let error = decode(&file(lines, resolution, pixels), 1000).unwrap_err().to_string();
        assert!(error.contains(word), "{resolution}: {error}");
    }
    assert!(matches!(
        decode(&file("", "-Y 4000000000 +X 4000000000", &[]), 1 << 27),
        Err(ReadError::TooLarge { .. })
    ));
    // A header for the largest picture takes no memory by itself.
    assert!(decode(&file("", "-Y 8192 +X 16384", &[]), 1 << 27).is_err());
}
