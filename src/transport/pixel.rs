//! What the samples of a pixel add up to: light, coverage, and the shadow on the ground.
//!
//! Where the background is transparent, colours are premultiplied: light from objects, over nothing. A shadow is black
//! there, with the alpha of the luminance that it takes away. A shadow may have a colour, which one alpha cannot say, so
//! the picture also gets a layer `shadow`: what each channel of a background keeps, of all that objects do not cover. A
//! background B goes behind a picture C as C + B · shadow.

use crate::film::{Channel, Layer, Picture};
use glam::{DVec3, Vec3};

/// What one camera path found.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelSample {
    pub radiance: Vec3,
    /// How much of the background is hidden, by objects.
    pub covered: f32,
    /// The ground.
    pub caught: Option<Caught>,
}

/// The ground as one path saw it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caught {
    /// Radiance of the background there.
    pub behind: Vec3,
    /// Irradiance with everything there, and if nothing were in the way of light.
    pub with: Vec3,
    pub without: Vec3,
}

/// Sums beside that of the radiance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Coverage {
    covered: f64,
    caught: f64,
    behind: DVec3,
    with: DVec3,
    without: DVec3,
}

/// What [`Coverage`] comes to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Composite {
    pub radiance: Vec3,
    pub alpha: f32,
    /// What is left of each channel of a background.
    pub kept: Vec3,
}

impl Coverage {
    pub fn add(&mut self, sample: &PixelSample) {
        self.covered += f64::from(sample.covered);
        if let Some(caught) = &sample.caught {
            self.caught += 1.0;
            self.behind += caught.behind.as_dvec3();
            self.with += caught.with.as_dvec3();
            self.without += caught.without.as_dvec3();
        }
    }

    /// With the mean radiance of `samples` paths.
    pub fn finish(&self, radiance: DVec3, samples: u32, transparent: bool) -> Composite {
        let n = f64::from(samples.max(1));
        let lit = self.without.cmpgt(DVec3::ZERO);
        let ratio = DVec3::select(lit, self.with / self.without, DVec3::ONE);
        let open = (1.0 - (self.covered + self.caught) / n).max(0.0);
        let kept = DVec3::splat(open) + ratio * (self.caught / n);
        let luminance = DVec3::new(0.2126, 0.7152, 0.0722).dot(kept);
        let shown = if transparent { radiance } else { radiance + self.behind * ratio / n };
        Composite {
            radiance: shown.as_vec3(),
            alpha: if transparent { (1.0 - luminance).clamp(0.0, 1.0) as f32 } else { 1.0 },
            kept: kept.as_vec3(),
        }
    }
}

/// Puts composites, row by row, into a picture.
pub(super) fn into_picture(picture: &mut Picture, composites: &[Composite], transparent: bool, ground: bool) {
    picture.pixels = composites.iter().map(|c| c.radiance).collect();
    if transparent {
        picture.alpha = Some(composites.iter().map(|c| c.alpha).collect());
    }
    if ground {
        let channel = |i: usize, name: &str| Channel {
            name: name.to_owned(),
            values: composites.iter().map(|c| c.kept[i]).collect(),
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
        let mut coverage = Coverage::default();
        let object = PixelSample { radiance: Vec3::splat(2.0), covered: 1.0, caught: None };
        let caught =
            Caught { behind: Vec3::splat(3.0), with: Vec3::new(1.0, 2.0, 4.0), without: Vec3::splat(4.0) };
        let ground = PixelSample { radiance: Vec3::ZERO, covered: 0.0, caught: Some(caught) };
        let open = PixelSample { radiance: Vec3::splat(3.0), covered: 0.0, caught: None };
        for sample in [&object, &object, &ground, &open] {
            coverage.add(sample);
        }
        // Opaque: (2 + 2 + 3 r + 3)/4.
        let c = coverage.finish(DVec3::splat(7.0 / 4.0), 4, false);
        assert!((c.radiance - Vec3::new(7.75, 8.5, 10.0) / 4.0).abs().max_element() < 1e-6);
        assert_eq!(c.alpha, 1.0);
        // Transparent: colour (2 + 2)/4; of a background a quarter, and r quarters more, are kept.
        let c = coverage.finish(DVec3::splat(1.0), 4, true);
        assert_eq!(c.radiance, Vec3::ONE);
        assert!((c.kept - (1.0 + Vec3::new(0.25, 0.5, 1.0)) / 4.0).abs().max_element() < 1e-6);
        let luminance = 0.2126 * 0.3125 + 0.7152 * 0.375 + 0.0722 * 0.5;
        assert!((c.alpha - (1.0 - luminance)).abs() < 1e-6);
        // A place that no light reaches in any case keeps its background.
        let mut dark = Coverage::default();
        let caught = Caught { with: Vec3::ZERO, without: Vec3::ZERO, ..caught };
        dark.add(&PixelSample { caught: Some(caught), ..ground });
        assert_eq!(dark.finish(DVec3::ZERO, 1, true).alpha, 0.0);
    }
}
