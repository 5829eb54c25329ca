//! `NEPHRITE_materials_subsurface`: a scattering and absorbing medium below the surface.
//!
//! Its specification is in `extensions/NEPHRITE_materials_subsurface/`. Coefficients are per metre of the *world*, so
//! the scale of a node does not change them. Out-of-range values are errors, since there is no telling what was meant;
//! unknown properties are warnings, since they are most likely misspelt.

use glam::Vec3;

use super::volume::MAX_COEFFICIENT;
use super::{Extension, dispersion, ior, order, seen_surface, transmission};
use crate::asset::PropertyKind::{self, Float, Float3};
use crate::asset::{AssetError, Json, Loader, MutableProperty};
use crate::scene::{AlphaMode, ColorSpace, MaterialDescription, MediumDescription};

pub(super) const NAME: &str = "NEPHRITE_materials_subsurface";

const PROPERTIES: [&str; 10] = [
    "absorptionCoefficient",
    "absorptionTexture",
    "scatteringCoefficient",
    "scatteringTexture",
    "scatterAnisotropy",
    "ior",
    "densityFactor",
    "priority",
    "extensions",
    "extras",
];

/// What the specification lists under “glTF Object Model”. Splines end where the specification's ranges do.
const MUTABLE: [MutableProperty; 5] = [
    mutable(
        "/materials/{}/extensions/NEPHRITE_materials_subsurface/absorptionCoefficient",
        Float3,
        [0.0, MAX],
    ),
    mutable(
        "/materials/{}/extensions/NEPHRITE_materials_subsurface/scatteringCoefficient",
        Float3,
        [0.0, MAX],
    ),
    mutable(
        "/materials/{}/extensions/NEPHRITE_materials_subsurface/scatterAnisotropy",
        Float,
        [-MAX_G, MAX_G],
    ),
    mutable("/materials/{}/extensions/NEPHRITE_materials_subsurface/ior", Float, [1.0, MAX]),
    mutable("/materials/{}/extensions/NEPHRITE_materials_subsurface/densityFactor", Float, [0.0, MAX]),
];

/// No upper bound of its own.
const MAX: f64 = f64::MAX;

/// The mean cosine lies between −1 and 1, both excluded.
const MAX_G: f64 = 0.999_999;

const fn mutable(template: &'static str, kind: PropertyKind, range: [f64; 2]) -> MutableProperty {
    MutableProperty { template, kind, range }
}

/// The index where nothing states one.
const DEFAULT_IOR: f32 = 1.5;

/// Mean free paths below this many metres are shorter than a wavelength: radiative transfer means nothing there.
const SHORTEST_FREE_PATH: f32 = 1e-7;

pub(super) struct Subsurface;

impl Extension for Subsurface {
    fn name(&self) -> &str {
        NAME
    }

    fn order(&self) -> i32 {
        order::SUBSURFACE
    }

    fn mutable_properties(&self) -> &[MutableProperty] {
        &MUTABLE
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        material: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        for key in own.as_object()?.keys().filter(|key| !PROPERTIES.contains(&key.as_str())) {
            let message = match nearest(key) {
                Some(known) => format!("is no property of {NAME}; did you mean `{known}`?"),
                None => format!("is no property of {NAME}; it is ignored"),
            };
            loader.invalid(&own.pointer_to(key), message)?;
        }
        let density = non_negative(own, "densityFactor", own.f64("densityFactor")?.unwrap_or(1.0))?;
        let sigma_a = coefficient(own, "absorptionCoefficient", density)?;
        let sigma_s = coefficient(own, "scatteringCoefficient", density)?;
        let ior = index(loader, own, material, out)?;
        let priority = priority(own)?;
        let anisotropy = anisotropy(own)?;
        let mut slot = |key| loader.texture_slot(own, key, ColorSpace::Linear);
        let absorption_texture = slot("absorptionTexture")?;
        let scattering_texture = slot("scatteringTexture")?;
        out.ior = ior;
        if material.extension(transmission::NAME).is_none() {
            out.transmission = 1.0;
        }
        warn(loader, own, material, out);
        if sigma_s.max_element() > 0.0 {
            dispersion::tell_beside_scattering(loader, material)?;
        }
        let densest = (sigma_a + sigma_s).max_element();
        if densest * SHORTEST_FREE_PATH > 1.0 {
            let message =
                format!("the mean free path is {:e} m, shorter than a wavelength of light", 1.0 / densest);
            loader.warn(own.pointer(), message, Some("coefficients are per metre"));
        }
        let medium = MediumDescription {
            sigma_a,
            sigma_s,
            anisotropy,
            ior,
            priority,
            absorption_texture,
            scattering_texture,
            multi_scatter: None,
        };
        if out.medium.as_ref().is_some_and(|other| !is_fallback(other, &medium)) {
            loader.note(own.pointer(), format!("{NAME} replaces the material's other medium"));
        }
        out.medium = Some(medium);
        Ok(())
    }

    fn finish(&self, loader: &mut Loader<'_>) -> Result<(), AssetError> {
        for index in 0..loader.scene.materials.len() {
            if loader.entry("materials", index, "/materials")?.extension(NAME).is_some() {
                seen_surface::warn(loader, index);
            }
        }
        Ok(())
    }
}

fn non_negative(own: &Json<'_>, key: &str, value: f64) -> Result<f64, AssetError> {
    if value < 0.0 {
        return Err(own.error_at(key, format!("{value} is below 0")));
    }
    Ok(value)
}

fn coefficient(own: &Json<'_>, key: &str, density: f64) -> Result<Vec3, AssetError> {
    let values = own.numbers::<3>(key)?.unwrap_or([0.0; 3]);
    for value in values {
        non_negative(own, key, value)?;
    }
    Ok(Vec3::from(values.map(|v| (v * density).min(f64::from(MAX_COEFFICIENT)) as f32)))
}

/// The extension's own index, else that of `KHR_materials_ior`, else 1.5; no more than what stands for infinity there.
fn index(
    loader: &mut Loader<'_>,
    own: &Json<'_>,
    material: &Json<'_>,
    out: &MaterialDescription,
) -> Result<f32, AssetError> {
    if let Some(index) = own.f64("ior")? {
        if index < 1.0 {
            return Err(own.error_at("ior", format!("{index} is below 1")));
        }
        return Ok((index as f32).min(ior::MIRROR_IOR));
    }
    if let Some(other) = material.extension(ior::NAME)
        && other.f64("ior")?.is_some_and(|ior| ior < 1.0)
    {
        let message = format!("is not the index of a medium; {DEFAULT_IOR} is used");
        loader.warn(&other.pointer_to("ior"), message, Some("give the medium an `ior` of its own"));
        return Ok(DEFAULT_IOR);
    }
    Ok(out.ior)
}

fn priority(own: &Json<'_>) -> Result<i32, AssetError> {
    let value = own.f64("priority")?.unwrap_or(0.0);
    if value.fract() != 0.0 || value < f64::from(i32::MIN) || value > f64::from(i32::MAX) {
        return Err(own.error_at("priority", format!("{value} is not an integer of 32 bits")));
    }
    Ok(value as i32)
}

fn anisotropy(own: &Json<'_>) -> Result<f32, AssetError> {
    let g = own.f64("scatterAnisotropy")?.unwrap_or(0.0);
    if g <= -1.0 {
        return Err(own.error_at("scatterAnisotropy", format!("{g} is not above -1")));
    }
    if g >= 1.0 {
        return Err(own.error_at("scatterAnisotropy", format!("{g} is not below 1")));
    }
    Ok((g as f32).clamp((-1.0_f32).next_up(), 1.0_f32.next_down()))
}

fn warn(loader: &mut Loader<'_>, own: &Json<'_>, material: &Json<'_>, out: &MaterialDescription) {
    if out.alpha_mode != AlphaMode::Opaque {
        let message = format!("alpha makes holes in a surface that {NAME} needs closed");
        loader.warn(&material.pointer_to("alphaMode"), message, Some("use OPAQUE"));
    }
    if out.unlit {
        loader.warn(own.pointer(), "KHR_materials_unlit hides the medium", None);
    }
    if out.transmission == 0.0 {
        loader.warn(
            own.pointer(),
            "the transmissionFactor of 0 (which is its default) hides the medium",
            None,
        );
    }
}

/// Whether a medium is told again by another extension, for viewers that do not know this one. Numbers are as near as
/// eyes can tell.
fn is_fallback(other: &MediumDescription, medium: &MediumDescription) -> bool {
    const NEAR: f32 = 0.02;
    let extinction = (medium.sigma_a + medium.sigma_s).max_element();
    let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() <= NEAR * extinction;
    near(other.sigma_a, medium.sigma_a)
        && near(other.sigma_s, medium.sigma_s)
        && (other.anisotropy - medium.anisotropy).abs() <= NEAR
}

/// The known property that a misspelt one most resembles.
fn nearest(key: &str) -> Option<&'static str> {
    if key.len() > 64 {
        return None;
    }
    let distance = |known: &str| edits(key, known);
    let best = PROPERTIES.into_iter().min_by_key(|known| distance(known))?;
    (distance(best) <= best.len() / 3).then_some(best)
}

/// Levenshtein's distance, ignoring case.
fn edits(a: &str, b: &str) -> usize {
    let (a, b) = (a.to_lowercase(), b.to_lowercase());
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.chars().enumerate() {
            let substituted = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row.last().copied().unwrap_or(0)
}
