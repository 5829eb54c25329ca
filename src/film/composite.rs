//! Alpha, and the shadow on a ground, of what the samples of a pixel saw of the background.
//!
//! Where the background is transparent, colours are premultiplied: light from objects, over nothing. A shadow is black
//! there, with the alpha of the luminance that it takes away. A shadow may have a colour, which one alpha cannot say, so
//! the picture also gets a layer `shadow`: what each channel of a background keeps, of all that objects do not cover. A
//! background B goes behind a picture C as C + B · shadow.
//!
//! What is shown of a ground is a ratio of two sums, E_with / E_without, times the background: a film keeps the sums, and
//! divides last.

use super::layer::{Averaging, FilmLayer};
use super::raw::Film;
use super::{Channel, Layer, Picture};
use glam::{DVec3, Vec3};

/// Name of the layer that says how much objects hide of a background that is transparent.
const COVERAGE: &str = "coverage";
/// Of the layer that says the same where the background is shown.
const HIDDEN: &str = "hidden";
/// Of the layer with what samples saw of the ground.
const GROUND: &str = "ground";

/// The ground as one path saw it.
#[derive(Clone, Copy, Debug)]
pub struct Caught {
    /// Radiance of the background there.
    pub behind: Vec3,
    /// Irradiance with everything there.
    pub with: Vec3,
    /// If nothing were in the way of light.
    pub without: Vec3,
}

/// The layers that a film needs for a transparent background, and for a ground that catches shadows.
pub fn layers(transparent: bool, ground: bool) -> Vec<FilmLayer> {
    let mut layers = Vec::new();
    if transparent || ground {
        let name = if transparent { COVERAGE } else { HIDDEN };
        layers.push(FilmLayer::new(name, &["A"], Averaging::Hidden));
    }
    if ground {
        let channels = [
            "caught",
            "behind.R",
            "behind.G",
            "behind.B",
            "with.R",
            "with.G",
            "with.B",
            "without.R",
            "without.G",
            "without.B",
        ];
        layers.push(FilmLayer::new(GROUND, &channels, Averaging::Hidden));
    }
    layers
}

/// Appends the numbers that a sample has in those layers.
pub fn push_values(
    values: &mut Vec<f32>,
    (transparent, ground): (bool, bool),
    covered: f32,
    caught: Option<&Caught>,
) {
    if transparent || ground {
        values.push(covered);
    }
    if ground {
        values.push(if caught.is_some() { 1.0 } else { 0.0 });
        let [behind, with, without] = caught.map_or([Vec3::ZERO; 3], |c| [c.behind, c.with, c.without]);
        for v in [behind, with, without] {
            values.extend(v.to_array());
        }
    }
}

/// Makes alpha and shadow of the hidden layers of a film.
pub(super) fn finish(film: &Film, picture: &mut Picture) {
    let transparent = film.layer_sums(COVERAGE);
    let (Some(covered), is_transparent) = (match &transparent {
        Some(_) => (film.layer_sums(COVERAGE), true),
        None => (film.layer_sums(HIDDEN), false),
    }) else {
        return;
    };
    let ground = film.layer_sums(GROUND);
    let mut kept = Vec::new();
    let mut alpha = Vec::new();
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let n = f64::from(film.counts()[i].max(1));
        let caught = ground.as_ref().map_or(&[0.0; 10][..], |sums| sums(i));
        let of = |at: usize| DVec3::new(caught[at], caught[at + 1], caught[at + 2]);
        let (behind, with, without) = (of(1), of(4), of(7));
        let ratio = DVec3::select(without.cmpgt(DVec3::ZERO), with / without, DVec3::ONE);
        let open = (1.0 - (covered(i)[0] + caught[0]) / n).max(0.0);
        let left = DVec3::splat(open) + ratio * (caught[0] / n);
        if !is_transparent {
            *pixel = (film.mean(i) + behind * ratio / n).as_vec3();
        }
        let luminance = DVec3::new(0.2126, 0.7152, 0.0722).dot(left);
        alpha.push((1.0 - luminance).clamp(0.0, 1.0) as f32);
        if ground.is_some() {
            kept.push(left.as_vec3());
        }
    }
    if is_transparent {
        picture.alpha = Some(alpha);
    }
    if ground.is_some() {
        let channel = |i: usize, name: &str| Channel {
            name: name.to_owned(),
            values: kept.iter().map(|k: &Vec3| k[i]).collect(),
        };
        let channels = vec![channel(0, "R"), channel(1, "G"), channel(2, "B")];
        picture.layers.push(Layer { name: "shadow".to_owned(), channels });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_covered_pixel_with_a_shadow_adds_up() {
        let caught =
            Caught { behind: Vec3::splat(3.0), with: Vec3::new(1.0, 2.0, 4.0), without: Vec3::splat(4.0) };
        let object = (Vec3::splat(2.0), 1.0, None);
        let exposed = |transparent: bool, samples: &[(Vec3, f32, Option<Caught>)]| {
            let mut film = Film::new(1, 1, layers(transparent, true));
            let mut values = Vec::new();
            for (radiance, covered, caught) in samples {
                values.clear();
                push_values(&mut values, (transparent, true), *covered, caught.as_ref());
                film.add(0, radiance.as_dvec3(), &values);
            }
            film.develop()
        };
        let ground = (Vec3::ZERO, 0.0, Some(caught));
        // Opaque: (2 + 2 + 3 r + 3)/4.
        let shown = exposed(false, &[object, object, ground, (Vec3::splat(3.0), 0.0, None)]);
        assert!((shown.pixels[0] - Vec3::new(7.75, 8.5, 10.0) / 4.0).abs().max_element() < 1e-6);
        assert!(shown.alpha.is_none());
        // Transparent: colour (2 + 2)/4; of a background a quarter, and r quarters more, are kept.
        let clear = exposed(true, &[object, object, ground, (Vec3::ZERO, 0.0, None)]);
        assert_eq!(clear.pixels[0], Vec3::ONE);
        let kept: Vec<f32> = clear.layers[0].channels.iter().map(|c| c.values[0]).collect();
        assert!(
            (Vec3::from_slice(&kept) - (1.0 + Vec3::new(0.25, 0.5, 1.0)) / 4.0).abs().max_element() < 1e-6
        );
        let luminance = 0.2126 * 0.3125 + 0.7152 * 0.375 + 0.0722 * 0.5;
        assert!((clear.alpha.unwrap()[0] - (1.0 - luminance)).abs() < 1e-6);
        // A place that no light reaches in any case keeps its background.
        let dark = Caught { with: Vec3::ZERO, without: Vec3::ZERO, ..caught };
        assert_eq!(exposed(true, &[(Vec3::ZERO, 0.0, Some(dark))]).alpha.unwrap()[0], 0.0);
    }
}
