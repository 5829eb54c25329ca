//! Pictures that show nothing because they are far too bright or too dark, and what would help.
//!
//! Only what light comes from counts: a black background is neither too dark nor a reason to call a white object on it well
//! exposed. The exposure that is proposed puts the median of that at middle grey; so after it at most half of it can be
//! white, and at most half black, whatever the picture.

use super::args::SceneArgs;
use super::lights::LightUnits;
use super::message::Reporter;
use crate::film::Picture;
use crate::film::tonemap::{ToneMap, encode_srgb};
use crate::scene::{EnvironmentDescription, SceneDescription};

/// Middle grey, linear.
const MIDDLE: f32 = 0.18;
/// Pixels that are looked at, at most, evenly spread.
const MOST_PIXELS: usize = 1 << 20;
/// The share of pixels that makes “nearly all”.
const NEARLY_ALL: f64 = 0.9;
/// The brightest channel of a white pixel on a display, of 1; and what it has to be before the tone map, since something
/// may be meant to be just white.
const WHITE: f32 = 250.0 / 255.0;
const TOO_BRIGHT: f32 = 1.5;
/// The brightest channel of a pixel that counts as black on a display, and the pixels that may be brighter.
const BLACK: f32 = 25.0 / 255.0;
const MAY_BE_BRIGHTER: f64 = 0.01;

/// What is wrong with the exposure of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    /// Nothing, or there is nothing to be seen.
    Fine,
    /// Nearly all white; the exposure that helps, in stops.
    White(f32),
    /// Nearly all black.
    Black(f32),
    /// No light at all.
    Dark,
}

/// Judges a picture as it is displayed.
fn judge(picture: &Picture, tone_map: ToneMap, exposure: f32) -> Verdict {
    let step = picture.pixels.len().div_ceil(MOST_PIXELS).max(1);
    let alpha = |i: usize| picture.alpha.as_ref().map_or(1.0, |alpha| alpha[i]);
    let is_lit = |v: f32| v > 0.0 && v.is_finite();
    let pixels = picture.pixels.iter().enumerate().filter(|(i, _)| alpha(*i) > 0.0);
    let mut seen = pixels.clone().peekable();
    if seen.peek().is_none() {
        return Verdict::Fine;
    }
    let mut lit: Vec<(f32, f32)> = pixels
        .step_by(step)
        .map(|(i, p)| *p / alpha(i))
        .filter(|p| is_lit(p.max_element()))
        .map(|p| {
            let shown = tone_map.apply(p * exposure.exp2()).max_element();
            (p.max_element(), encode_srgb(shown))
        })
        .collect();
    if lit.is_empty() {
        let all_dark = seen.all(|(_, p)| !is_lit(p.max_element()));
        return if all_dark { Verdict::Dark } else { Verdict::Fine };
    }
    lit.sort_by(|a, b| a.0.total_cmp(&b.0));
    let share = |n: usize| n as f64 / lit.len() as f64;
    let stops = (MIDDLE / lit[lit.len() / 2].0).log2();
    // Beyond this the numbers of a display are lost in single precision.
    if stops.abs() > 100.0 {
        return Verdict::Fine;
    }
    let gain = exposure.exp2();
    let white = lit.iter().filter(|(v, shown)| *shown >= WHITE && v * gain >= TOO_BRIGHT).count();
    let visible = lit.iter().filter(|(_, shown)| *shown > BLACK).count();
    if share(white) >= NEARLY_ALL {
        Verdict::White(stops)
    } else if share(visible) <= MAY_BE_BRIGHTER {
        Verdict::Black(stops)
    } else {
        Verdict::Fine
    }
}

/// Says what would help a picture of a scene that shows nothing; `of_blender` says who wrote the file.
pub(super) fn say_how_to_expose(
    picture: &Picture,
    scene: &SceneDescription,
    of_blender: bool,
    args: &SceneArgs,
    reporter: &Reporter,
) {
    let candela = !scene.lights.is_empty() && args.lights.light_units == LightUnits::Candela;
    match judge(picture, args.tonemap, args.exposure) {
        Verdict::Fine => {}
        Verdict::White(stops) => {
            let units = match (candela, of_blender) {
                (true, true) => {
                    "; its lamps are from Blender, and with --light-units blender they are as bright as there"
                }
                (true, false) => {
                    "; its lamps are in candela: --light-scale X makes them X times as strong, and --light-units \
                     tells of other units"
                }
                _ => "",
            };
            reporter.note(format!(
                "nearly all that is lit in the picture is white: --exposure {stops:.1} shows it{units}"
            ));
        }
        Verdict::Black(stops) => reporter
            .note(format!("nearly all that is lit in the picture is black: --exposure {stops:.1} shows it")),
        Verdict::Dark if has_light(scene) => {
            reporter
                .note("the picture is black: none of the light in the scene reaches what the camera sees");
        }
        Verdict::Dark => reporter.note(
            "the picture is black, since there is no light: no lamp, no emission, no environment \
             (choose one with --env, for example --env studio)",
        ),
    }
}

/// Whether anything shines in a scene.
fn has_light(scene: &SceneDescription) -> bool {
    let sky = match &scene.environment {
        EnvironmentDescription::Constant(radiance) => radiance.max_element() > 0.0,
        EnvironmentDescription::Map { scale, .. } => scale.max_element() > 0.0,
    };
    let shines = |&material: &u32| {
        scene.materials.get(material as usize).is_some_and(|m| m.emission.max_element() > 0.0)
    };
    let mut meshes = scene.instances.iter().filter_map(|instance| scene.meshes.get(instance.mesh));
    sky || scene.lights.iter().any(|light| light.intensity.max_element() > 0.0)
        || meshes.any(|mesh| mesh.triangle_materials.iter().any(shines))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn picture(pixels: Vec<f32>) -> Picture {
        let mut picture = Picture::new(pixels.len() as u32, 1);
        picture.pixels = pixels.into_iter().map(Vec3::splat).collect();
        picture
    }

    /// Following the hint leaves nothing to say, in every tone map.
    #[test]
    fn the_exposure_that_is_proposed_helps() {
        let pictures = [
            vec![553.6; 100],
            // A white object before a black background; a few pixels that are out of all proportion.
            [vec![0.0; 900], vec![2e4; 95], vec![1e30, 1e-30, 5.0, 1e25, 1e-20]].concat(),
            (0..100).map(|i| 1e-5 * (1.0 + i as f32)).collect(),
            [vec![1e-6; 60], vec![1e-12; 40], vec![0.0; 900]].concat(),
        ];
        for pixels in pictures {
            for tone_map in ToneMap::ALL {
                let picture = picture(pixels.clone());
                let stops = match judge(&picture, tone_map, 0.0) {
                    Verdict::White(stops) => {
                        assert!(pixels.contains(&553.6) || pixels.contains(&2e4));
                        stops
                    }
                    Verdict::Black(stops) => stops,
                    other => panic!("{tone_map:?} {:?}: {other:?}", &pixels[..3]),
                };
                assert_eq!(judge(&picture, tone_map, stops), Verdict::Fine, "{tone_map:?} {stops}");
            }
        }
        // 0.18 / 553.6 = 2^−11.5866.
        let Verdict::White(stops) = judge(&picture(vec![553.6; 4]), ToneMap::PbrNeutral, 0.0) else {
            panic!("is white")
        };
        assert!((stops + 11.586_6).abs() < 1e-3, "{stops}");
    }

    #[test]
    fn pictures_that_are_meant_to_are_left_alone() {
        for pixels in [
            vec![1.0; 100],
            vec![0.18; 100],
            // Night with a lamp, an object of a hundredth of the picture.
            [vec![1e-5; 95], vec![0.5; 5]].concat(),
            [vec![0.0; 990], vec![0.3; 10]].concat(),
            [vec![50.0; 80], vec![0.2; 20]].concat(),
        ] {
            for tone_map in [ToneMap::PbrNeutral, ToneMap::Linear] {
                assert_eq!(
                    judge(&picture(pixels.clone()), tone_map, 0.0),
                    Verdict::Fine,
                    "{:?}",
                    &pixels[..2]
                );
            }
        }
        assert_eq!(judge(&picture(vec![0.0; 9]), ToneMap::Linear, 0.0), Verdict::Dark);
        let mut nothing = picture(vec![0.0; 9]);
        nothing.alpha = Some(vec![0.0; 9]);
        assert_eq!(judge(&nothing, ToneMap::Linear, 0.0), Verdict::Fine);
    }
}
