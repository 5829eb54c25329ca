//! Pictures of a case as data URIs: what was rendered, what should have been, and the difference.

use crate::conformance::{Case, Outcome};
use crate::film::Picture;
use crate::film::figure::{Raster, false_color};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use glam::Vec3;

/// Rendered, expected and their difference, as `src` of images.
pub(super) struct Shown {
    pub rendered: String,
    pub expected: String,
    pub difference: String,
    /// The difference of luminance that has the full color.
    pub full_scale: f32,
    /// Radiance that is shown as white.
    pub white: f32,
}

/// The pictures of a case that has one. Both are scaled by one exposure: the brightest expected mean is white.
pub(super) fn pictures(outcome: &Outcome) -> Option<Shown> {
    let picture = outcome.picture.as_ref()?;
    let expected = expected(&outcome.case)?;
    let white = expected.pixels.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    let white = if white > 0.0 && white.is_finite() { white.min(4.0 * mean(&expected)) } else { 1.0 };
    let show = |picture: &Picture| {
        let picture = Raster::from_linear(picture.width, picture.height, &picture.pixels, |p| p / white);
        picture.ok().and_then(|p| uri(&p))
    };
    let difference = false_color::luminance_difference(&picture.pixels, &expected.pixels);
    let full_scale = false_color::full_scale(&difference);
    let colored = false_color::signed(picture.width, picture.height, &difference, full_scale).ok()?;
    Some(Shown {
        rendered: show(picture)?,
        expected: show(&expected)?,
        difference: uri(&colored)?,
        full_scale,
        white,
    })
}

/// The mean of the brightest channel.
fn mean(picture: &Picture) -> f32 {
    picture.mean().into_iter().fold(0.0, f64::max).max(f64::from(f32::MIN_POSITIVE)) as f32
}

/// The reference, or the expected means where they are known: smaller regions lie over larger ones.
fn expected(case: &Case) -> Option<Picture> {
    if let Some(reference) = &case.reference {
        return Some(reference.picture.clone());
    }
    let mut picture = Picture::new(case.width, case.height);
    for expectation in &case.expectations {
        let mean = Vec3::from(expectation.mean?.map(|v| v as f32));
        let [x, y, w, h] = case.region(expectation);
        for row in y..y + h {
            let start = (row * case.width + x) as usize;
            picture.pixels[start..start + w as usize].fill(mean);
        }
    }
    Some(picture)
}

/// A PNG as a data URI.
fn uri(picture: &Raster) -> Option<String> {
    let bytes = picture.encode_png(&[]).ok()?;
    Some(format!("data:image/png;base64,{}", BASE64_STANDARD.encode(bytes)))
}
