//! `KHR_materials_scatter` (glTF pull request 2579) and its predecessor `KHR_materials_volume_scatter` (2453): drafts
//! that make the medium of `KHR_materials_volume` scatter.
//!
//! The attenuation of the volume is *total* extinction σt. The drafts state a multi-scatter albedo ρ, from which Kulla
//! & Conty 2017 give the single-scattering albedo σs/σt ([`crate::optics::albedo`]); the older draft leaves the
//! anisotropy g out of that step. Both are read in every spelling that is in use. The medium is already there when
//! these hooks run; splitting its extinction anew is what makes the newer draft win over the older. Without a volume,
//! the newer draft scatters at the surface of a thin wall.

use glam::Vec3;

use super::{Extension, dispersion, order};
use crate::asset::{AssetError, Json, Loader, MutableProperty, PropertyKind};
use crate::optics::albedo::{absorbed_from_multiple, single_from_multiple};
use crate::scene::layers::ThinScatter;
use crate::scene::{ColorSpace, MaterialDescription, MultiScatter, TextureRef};

/// Stands for the anisotropy ±1, which files have and at which scattering changes nothing.
const MOST_ANISOTROPIC: f64 = 0.999;

/// What animations may change.
const SCATTER_MUTABLE: [MutableProperty; 3] = [
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_scatter/scatterStrengthFactor",
        kind: PropertyKind::Float,
        range: [0.0, 1.0],
    },
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_scatter/multiscatterColorFactor",
        kind: PropertyKind::Float3,
        range: [0.0, 1.0],
    },
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_scatter/scatterAnisotropy",
        kind: PropertyKind::Float,
        range: [-1.0, 1.0],
    },
];

pub(super) struct Scatter;

impl Extension for Scatter {
    fn name(&self) -> &str {
        "KHR_materials_scatter"
    }

    fn order(&self) -> i32 {
        order::SCATTER
    }

    fn mutable_properties(&self) -> &[MutableProperty] {
        &SCATTER_MUTABLE
    }

    fn shortfall(&self) -> Option<&str> {
        Some("a draft, which may still change")
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        material: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let strength = spelling(loader, own, &["scatterStrengthFactor", "scatterFactor"])?;
        let strength = loader.factor(own, strength, 0.0, 0.0..=1.0)?;
        exclusions(loader, own, material, strength);
        let color =
            spelling(loader, own, &["multiscatterColorFactor", "multiscatterColor", "scatterAlbedo"])?;
        let color = Vec3::from(loader.factors(own, color, [1.0; 3], 0.0..=1.0)?);
        let g = anisotropy(loader, own)?;
        if strength > 0.0 && out.medium.is_none() && out.transmission > 0.0 {
            let anisotropy = own.f64("scatterAnisotropy")?.unwrap_or(0.0).clamp(-1.0, 1.0) as f32;
            out.layers_mut().thin_scatter = Some(ThinScatter {
                strength,
                strength_texture: strength_texture(loader, own)?,
                color,
                color_texture: color_texture(loader, own)?,
                anisotropy,
            });
        } else if strength > 0.0 {
            let split_by = MultiScatter {
                rho: color * strength,
                mapping_anisotropy: g,
                strength_texture: strength_texture(loader, own)?,
                color_texture: color_texture(loader, own)?,
            };
            split(loader, own, material, out, g, split_by)?;
        }
        Ok(())
    }
}

/// What animations may change.
const VOLUME_SCATTER_MUTABLE: [MutableProperty; 3] = [
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_volume_scatter/multiscatterColorFactor",
        kind: PropertyKind::Float3,
        range: [0.0, 1.0],
    },
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_volume_scatter/multiscatterColor",
        kind: PropertyKind::Float3,
        range: [0.0, 1.0],
    },
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_volume_scatter/scatterAnisotropy",
        kind: PropertyKind::Float,
        range: [-1.0, 1.0],
    },
];

pub(super) struct VolumeScatter;

impl Extension for VolumeScatter {
    fn name(&self) -> &str {
        "KHR_materials_volume_scatter"
    }

    fn order(&self) -> i32 {
        order::VOLUME_SCATTER
    }

    fn mutable_properties(&self) -> &[MutableProperty] {
        &VOLUME_SCATTER_MUTABLE
    }

    fn shortfall(&self) -> Option<&str> {
        Some("a draft, which KHR_materials_scatter replaces")
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        material: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let color =
            spelling(loader, own, &["multiscatterColorFactor", "multiscatterColor", "scatterAlbedo"])?;
        let color = Vec3::from(loader.factors(own, color, [0.0; 3], 0.0..=1.0)?);
        let g = anisotropy(loader, own)?;
        let color_texture = color_texture(loader, own)?;
        let split_by =
            MultiScatter { rho: color, mapping_anisotropy: 0.0, strength_texture: None, color_texture };
        split(loader, own, material, out, g, split_by)?;
        Ok(())
    }
}

/// The spelling of a property that a file uses; the first is the current one.
fn spelling<'k>(
    loader: &mut Loader<'_>,
    own: &Json<'_>,
    spellings: &[&'k str],
) -> Result<&'k str, AssetError> {
    let current = spellings.first().copied().unwrap_or_default();
    let used = spellings.iter().copied().find(|key| own.get(key).is_some()).unwrap_or(current);
    if used != current {
        loader.invalid(&own.pointer_to(used), format!("is an older spelling of `{current}`"))?;
    }
    Ok(used)
}

fn anisotropy(loader: &mut Loader<'_>, own: &Json<'_>) -> Result<f32, AssetError> {
    let g = own.f64("scatterAnisotropy")?.unwrap_or(0.0);
    if g.abs() >= 1.0 {
        let message = format!("{g} is not between -1 and 1; {} is used", MOST_ANISOTROPIC.copysign(g));
        loader.invalid(&own.pointer_to("scatterAnisotropy"), message)?;
    }
    Ok(g.clamp(-MOST_ANISOTROPIC, MOST_ANISOTROPIC) as f32)
}

/// Tells of extensions that the draft takes the place of, or that leave nothing for it to do.
fn exclusions(loader: &mut Loader<'_>, own: &Json<'_>, material: &Json<'_>, strength: f32) {
    let counts = if strength > 0.0 {
        "which it replaces; this one counts"
    } else {
        "which it replaces; the other one counts, since the strength is 0"
    };
    for (name, why) in [
        ("KHR_materials_volume_scatter", counts),
        ("KHR_materials_diffuse_transmission", "which it replaces; what lets light in counts of that one"),
        ("KHR_materials_unlit", "which shows no light at all"),
        ("KHR_materials_pbrSpecularGlossiness", "which no other extension of a material may be used with"),
    ] {
        if material.extension(name).is_some() {
            loader.warn(own.pointer(), format!("is not to be used together with {name}, {why}"), None);
        }
    }
}

fn strength_texture(loader: &mut Loader<'_>, own: &Json<'_>) -> Result<Option<TextureRef>, AssetError> {
    let key = spelling(loader, own, &["scatterStrengthTexture", "scatterTexture"])?;
    loader.texture_slot(own, key, ColorSpace::Linear)
}

fn color_texture(loader: &mut Loader<'_>, own: &Json<'_>) -> Result<Option<TextureRef>, AssetError> {
    loader.texture_slot(own, "multiscatterColorTexture", ColorSpace::Srgb)
}

/// Splits the extinction of the medium, whose anisotropy is `g`, into scattering and absorption.
fn split(
    loader: &mut Loader<'_>,
    own: &Json<'_>,
    material: &Json<'_>,
    out: &mut MaterialDescription,
    g: f32,
    by: MultiScatter,
) -> Result<(), AssetError> {
    let Some(medium) = &mut out.medium else {
        let advice =
            "give the material KHR_materials_transmission and a KHR_materials_volume.thicknessFactor";
        loader.warn(own.pointer(), "there is no volume that could scatter, so this is ignored", Some(advice));
        return Ok(());
    };
    let sigma_t = medium.sigma_a + medium.sigma_s;
    let clear: Vec<&str> = (["red", "green", "blue"].into_iter().enumerate())
        .filter(|&(k, _)| by.rho[k] > 0.0 && sigma_t[k] <= 0.0)
        .map(|(_, name)| name)
        .collect();
    if !clear.is_empty() {
        loader.warn(
            own.pointer(),
            format!("{} cannot scatter: the volume attenuates nothing of it", clear.join(" and ")),
            Some("scattering is a share of attenuation: state an attenuationDistance and an attenuationColor below 1"),
        );
    }
    medium.sigma_s = sigma_t * by.rho.map(|r| single_from_multiple(r, by.mapping_anisotropy));
    medium.sigma_a = sigma_t * by.rho.map(|r| absorbed_from_multiple(r, by.mapping_anisotropy));
    medium.anisotropy = g;
    let has_textures = by.strength_texture.is_some() || by.color_texture.is_some();
    medium.multi_scatter = has_textures.then(|| Box::new(by));
    let is_replaced = material.extension(super::subsurface::NAME).is_some();
    if medium.sigma_s.max_element() > 0.0 && !is_replaced {
        dispersion::tell_beside_scattering(loader, material)?;
    }
    Ok(())
}
