use super::*;
use glam::Vec3;

/// A file with that first line and that ballast line, two by two angles of type C.
fn file(first: &str, tilt: &str, ballast: &str) -> String {
    format!(
        "{first}\r\n[TEST] of ours, TILT=NONE in a keyword is none\r\n[OTHER] \u{b0}\r\n{tilt}\r\n1 1000 2.5 3,2 1 2\r\n\
         0 0 0\r\n{ballast}\r\n0 45\r\n90\r\n0 360\r\n10 20 30\r\n4\t5 6\r\n"
    )
}

fn candela(text: &str) -> f32 {
    let read = Lm63::read(text.as_bytes()).expect("a file");
    assert!(read.oddities.is_empty(), "{:?}", read.oddities);
    assert_eq!(read.web.counts(), (3, 2));
    read.web.largest()
}

#[test]
fn versions_differ_in_what_multiplies() {
    for (first, factor) in [
        ("A luminaire of 1986", 2.5 * 0.5 * 0.8),
        ("IESNA91", 2.5 * 0.5 * 0.8),
        ("IESNA:LM-63-1995", 2.5 * 0.5 * 0.8),
        ("IESNA:LM-63-2002", 2.5 * 0.5),
        ("IES:LM-63-2019", 2.5 * 0.5),
    ] {
        let found = candela(&file(first, "TILT=NONE", "0.5 0.8 100"));
        assert!((found - 30.0 * factor).abs() < 1e-4, "{first}: {found}");
    }
}

#[test]
fn the_table_is_read_horizontal_angle_by_horizontal_angle() {
    let read = Lm63::read(file("IESNA91", "TILT=NONE", "1 1 0").as_bytes()).expect("a file");
    let at = |d: Vec3| read.web.relative(d) * read.web.largest() / 2.5;
    // Straight ahead, and at 90°; the plane of 360° is that of 0°, from the side of which it is looked at.
    assert!([10.0, 4.0].iter().any(|c| (at(Vec3::NEG_Z) - c).abs() < 1e-4));
    assert!((at(Vec3::NEG_X) - 18.0).abs() < 1e-3, "half way: {}", at(Vec3::NEG_X));
    assert!((at(Vec3::Y) - (30.0 + 0.25 * (6.0 - 30.0))).abs() < 1e-3);
    assert!((at(Vec3::NEG_Y) - (30.0 + 0.75 * (6.0 - 30.0))).abs() < 1e-3);
}

#[test]
fn tilt_is_read_past() {
    let included = "TILT=INCLUDE\r\n1\r\n3\r\n0 45 90\r\n1 0.9 0.8";
    for (tilt, tilts) in [("tilt = none", false), (included, true), ("TILT=lamp.tlt", true)] {
        let read = Lm63::read(file("IESNA91", tilt, "1 1 0").as_bytes()).expect("a file");
        assert_eq!((read.tilts, read.web.largest()), (tilts, 75.0), "{tilt}");
    }
}

#[test]
fn zeros_and_negative_candela_are_told() {
    let text = file("IESNA91", "TILT=NONE", "0 0 0").replace("4\t5", "-4 -5");
    let read = Lm63::read(text.as_bytes()).expect("a file");
    assert_eq!(read.web.largest(), 75.0);
    assert_eq!(read.oddities.len(), 3, "{:?}", read.oddities);
    // Bytes that are no UTF-8 are in many headers.
    let mut bytes = file("IESNA91", "TILT=NONE", "1 1 0").into_bytes();
    bytes[12] = 0xff;
    assert!(Lm63::read(&bytes).is_ok());
}

#[test]
fn what_is_broken_is_an_error_that_says_where() {
    let good = file("IESNA91", "TILT=NONE", "1 1 0");
    let error = |text: &str| Lm63::read(text.as_bytes()).expect_err("broken");
    assert_eq!(error(""), Lm63Error::NoTilt);
    assert_eq!(error("no such thing"), Lm63Error::NoTilt);
    assert_eq!(error("TILT=NONE"), Lm63Error::End { what: "the number of lamps" });
    assert_eq!(error(good.trim_end().trim_end_matches('6')), Lm63Error::End { what: "a candela value" });
    let number = error(&good.replace("20", "twenty"));
    assert_eq!(number, Lm63Error::Number { line: 11, word: "twenty".into(), what: "a candela value" });
    for word in ["inf", "NaN", "1e999"] {
        assert!(matches!(error(&good.replace("20", word)), Lm63Error::Number { .. }), "{word}");
    }
    for (from, to) in [
        ("2.5 3,2 1 2", "2.5 0,2 1 2"),
        ("2.5 3,2 1 2", "2.5 3,1e9 1 2"),
        ("2.5 3,2 1 2", "2.5 2.5,2 1 2"),
        ("2.5 3,2 1 2", "2.5 3,-2 1 2"),
        ("2.5 3,2 1 2", "2.5 3,2 4 2"),
        ("2.5 3,2 1 2", "-2.5 3,2 1 2"),
        ("1 1 0", "-1 1 0"),
    ] {
        assert!(matches!(error(&good.replace(from, to)), Lm63Error::Value { .. }), "{to}");
    }
    // Counts that are promised only make no room.
    assert!(matches!(error(&good.replace("3,2 1 2", "3601,3601 1 2")), Lm63Error::End { .. }));
    assert!(matches!(
        error(&good.replace("0 45\r\n90", "0 95\r\n90")),
        Lm63Error::Web(WebError::Order { .. })
    ));
    assert!(matches!(error(&good.replace("0 360", "0 120")), Lm63Error::Web(WebError::Range { .. })));
    assert!(matches!(Lm63::read(&vec![b' '; MOST_BYTES + 1]), Err(Lm63Error::Size { .. })));
    // Every file that is cut off is an error or as good as whole, and none panics.
    for end in 0..good.len() {
        if let Some(text) = good.get(..end) {
            let _ = Lm63::read(text.as_bytes());
        }
    }
}
