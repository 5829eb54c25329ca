//! Files read back, tone maps against values computed by hand, and what happens to broken pixels.

use super::tonemap::encode_srgb;
use super::*;
use std::path::Path;

/// A picture whose every channel is different, with a highlight beyond 1.
fn gradient(width: u32, height: u32) -> Picture {
    let mut picture = Picture::new(width, height);
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let t = i as f32 / (width * height) as f32;
        *pixel = Vec3::new(t, 4.0 * t * t, 0.25 * (1.0 - t));
    }
    picture
}

fn written(
    picture: &Picture,
    name: &str,
    options: &WriteOptions,
) -> (tempfile::TempDir, std::path::PathBuf, WriteReport) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let report = write(&path, picture, options).unwrap();
    (folder, path, report)
}

fn channel(path: &Path, name: &str) -> Vec<f32> {
    let image = ::exr::prelude::read_first_flat_layer_from_file(path).unwrap();
    let list = image.layer_data.channel_data.list;
    let found = list.iter().find(|c| c.name.to_string() == name);
    found.unwrap_or_else(|| panic!("no channel {name}")).sample_data.values_as_f32().collect()
}

#[test]
fn float_exr_is_exact_and_half_exr_is_within_half_an_ulp() {
    let picture = gradient(7, 5);
    let (_a, path, _) = written(&picture, "a.exr", &WriteOptions { float: true, ..Default::default() });
    let (_b, half, _) = written(&picture, "b.exr", &WriteOptions::default());
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        let expected: Vec<f32> = picture.pixels.iter().map(|p| p[i]).collect();
        assert_eq!(channel(&path, name), expected);
        for (read, expected) in channel(&half, name).into_iter().zip(expected) {
            assert!(
                (read - expected).abs() <= expected * 2f32.powi(-11) + 2f32.powi(-25),
                "{read} {expected}"
            );
        }
    }
}

#[test]
fn exr_records_alpha_layers_and_attributes_in_one_order() {
    let mut picture = gradient(4, 4);
    picture.alpha = Some(vec![0.5; 16]);
    picture.layers = vec![Layer {
        name: "depth".to_owned(),
        channels: vec![Channel { name: "Z".to_owned(), values: (0..16).map(|i| i as f32).collect() }],
    }];
    let pairs =
        ["scene", "options", "spp", "seed", "version"].map(|n| (format!("nephrite:{n}"), format!("«{n}»")));
    let options = WriteOptions { attributes: pairs.to_vec(), ..Default::default() };
    let (_folder, path, _) = written(&picture, "a.exr", &options);
    assert_eq!(channel(&path, "A"), vec![0.5; 16]);
    assert_eq!(channel(&path, "depth.Z"), (0..16).map(|i| i as f32).collect::<Vec<_>>());
    let image = ::exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
    for (name, value) in &pairs {
        let found = &image.layer_data.attributes.other[&::exr::prelude::Text::from(name.as_str())];
        let ::exr::prelude::AttributeValue::Text(text) = found else { panic!("{found:?}") };
        assert_eq!(text.as_slice(), value.as_bytes());
    }
    assert!(image.attributes.chromaticities.is_some());

    let bytes = std::fs::read(&path).unwrap();
    for _ in 0..4 {
        let (_folder, again, _) = written(&picture, "b.exr", &options);
        assert_eq!(std::fs::read(again).unwrap(), bytes);
    }
}

#[test]
fn png_is_tone_mapped_srgb_and_says_so() {
    let mut picture = Picture::new(2, 1);
    picture.pixels = vec![Vec3::splat(0.25), Vec3::new(8.0, 0.5, 0.0)];
    let options = WriteOptions {
        tone_map: ToneMap::Linear,
        exposure: 1.0,
        attributes: vec![("nephrite:scene".to_owned(), "Schüssel.glb".to_owned())],
        ..Default::default()
    };
    let (_folder, path, _) = written(&picture, "a.png", &options);
    // 0.5 → 188 (0.7354), 16 → 255, 1 → 255.
    assert_eq!(image::open(&path).unwrap().into_rgb8().into_raw(), [188, 188, 188, 255, 255, 0]);
    let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
    let reader = png::Decoder::new(file).read_info().unwrap();
    assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::Perceptual));
    let text = &reader.info().utf8_text[0];
    assert_eq!(
        (text.keyword.as_str(), text.get_text().unwrap().as_str()),
        ("nephrite:scene", "Schüssel.glb")
    );
}

#[test]
fn png_alpha_is_straight() {
    let mut picture = Picture::new(2, 1);
    picture.pixels = vec![Vec3::splat(0.125), Vec3::ZERO];
    picture.alpha = Some(vec![0.25, 0.0]);
    let options = WriteOptions { tone_map: ToneMap::Linear, ..Default::default() };
    let (_folder, path, _) = written(&picture, "a.png", &options);
    assert_eq!(image::open(&path).unwrap().into_rgba8().into_raw(), [188, 188, 188, 64, 0, 0, 0, 0]);
}

#[test]
fn jpeg_and_hdr_come_back_close() {
    let picture = gradient(16, 16);
    let (_a, path, _) = written(&picture, "a.hdr", &WriteOptions::default());
    let image = image::open(&path).unwrap().into_rgb32f();
    for (read, expected) in image.pixels().zip(&picture.pixels) {
        // The shared exponent leaves 8 bits to the largest channel.
        let error = (Vec3::from_array(read.0) - *expected).abs().max_element();
        assert!(error <= expected.max_element() / 128.0, "{read:?} {expected}");
    }
    let mut grey = Picture::new(16, 16);
    grey.pixels.fill(Vec3::splat(0.5));
    let options = WriteOptions { tone_map: ToneMap::Linear, ..Default::default() };
    let (_b, path, _) = written(&grey, "a.jpg", &options);
    let bytes = image::open(&path).unwrap().into_rgb8().into_raw();
    assert!(bytes.iter().all(|b| b.abs_diff(188) <= 1), "{:?}", &bytes[..6]);
}

#[test]
fn broken_pixels_become_black_and_are_counted() {
    let mut picture = gradient(4, 4);
    picture.pixels[3].y = f32::NAN;
    picture.pixels[5] = Vec3::splat(f32::INFINITY);
    picture.pixels[7].x = 1e6;
    for name in ["a.exr", "a.png", "a.jpg", "a.hdr"] {
        let (_folder, path, report) = written(&picture, name, &WriteOptions::default());
        assert_eq!(report.non_finite, 2, "{name}");
        assert_eq!(report.clamped_to_half, usize::from(name == "a.exr"), "{name}");
        if name == "a.exr" {
            assert_eq!((channel(&path, "G")[3], channel(&path, "R")[5]), (0.0, 0.0));
            assert_eq!(channel(&path, "R")[7], 65504.0);
        }
    }
    assert!(picture.mean().iter().all(|m| m.is_finite()));
}

#[test]
fn films_of_the_wrong_length_are_refused_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut picture = gradient(4, 4);
    picture.pixels.pop();
    let error = write(&folder.path().join("a.png"), &picture, &WriteOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::Malformed(_)), "{error}");
    let error =
        write(&folder.path().join("a.png"), &Picture::new(0, 4), &WriteOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::Malformed(_)), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Each row: input, then PBR Neutral, ACES and AgX of it, from the published formulas in double precision.
#[test]
fn tone_maps_have_their_published_values() {
    let rows: [[[f32; 3]; 4]; 5] = [
        [
            [0.18, 0.18, 0.18],
            [0.14, 0.14, 0.14],
            [0.213105, 0.213105, 0.213103],
            [0.214549, 0.214502, 0.214499],
        ],
        [
            [0.05, 0.4, 0.02],
            [0.0325, 0.3825, 0.0025],
            [0.082792, 0.474548, 0.02746],
            [0.13295, 0.359386, 0.063146],
        ],
        [
            [4.0, 1.0, 0.25],
            [0.983256, 0.468299, 0.33956],
            [1.0, 0.796086, 0.504095],
            [0.93648, 0.623567, 0.437369],
        ],
        [
            [0.9, 0.5, 0.1],
            [0.830588, 0.445965, 0.061342],
            [0.764211, 0.56571, 0.179344],
            [0.584123, 0.416174, 0.202886],
        ],
        [
            [100.0, 100.0, 100.0],
            [0.999421, 0.999421, 0.999421],
            [1.0, 1.0, 1.0],
            [0.996978, 0.996879, 0.996779],
        ],
    ];
    for [input, neutral, aces, agx] in rows {
        for (map, expected) in [(ToneMap::PbrNeutral, neutral), (ToneMap::Aces, aces), (ToneMap::Agx, agx)] {
            let value = map.apply(Vec3::from_array(input));
            let error = (value - Vec3::from_array(expected)).abs().max_element();
            assert!(error < 2e-5, "{map:?} of {input:?} is {value}, not {expected:?}");
        }
    }
}

#[test]
fn tone_maps_stay_in_range_and_rise_with_grey() {
    for map in ToneMap::ALL {
        let mut last = -1.0;
        for step in 0..400 {
            let grey = (step as f32 * 0.1 - 20.0).exp2();
            let value = map.apply(Vec3::splat(grey));
            assert!(value.min_element() >= 0.0 && value.max_element() <= 1.0, "{map:?} {grey} {value}");
            assert!(value.y >= last - 1e-4, "{map:?} falls at {grey}: {last} → {value}");
            last = value.y;
        }
        for extreme in [f32::MAX, -1.0, 0.0, 1e-38] {
            assert!(map.apply(Vec3::splat(extreme)).is_finite(), "{map:?} of {extreme}");
        }
    }
}

#[test]
fn srgb_encoding_is_that_of_the_standard() {
    for (linear, encoded) in
        [(0.0, 0.0), (0.003_130_8, 0.040_449_94), (0.214_041_14, 0.5), (0.5, 0.735_357), (1.0, 1.0)]
    {
        assert!((encode_srgb(linear) - encoded).abs() < 1e-6, "{linear}: {}", encode_srgb(linear));
    }
}
