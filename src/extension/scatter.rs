//! `KHR_materials_scatter` (glTF pull request 2579) and its predecessor `KHR_materials_volume_scatter` (2453): drafts
//! that make the medium of `KHR_materials_volume` scatter.
//!
//! The attenuation of the volume is *total* extinction σt. The drafts state a multi-scatter albedo ρ, from which Kulla
//! & Conty 2017 give the single-scattering albedo σs/σt ([`crate::optics::albedo`]); the older draft leaves the
//! anisotropy g out of that step. Both are read in every spelling that is in use. The medium is already there when
//! these hooks run; splitting its extinction anew is what makes the newer draft win over the older. Without a volume,
//! the newer draft scatters at the surface of a thin wall.

use glam::Vec3;

use super::{Extension, order};
use crate::asset::{AssetError, Json, Loader, MutableProperty, PropertyKind};
use crate::optics::albedo::{absorbed_from_multiple, single_from_multiple};
use crate::scene::layers::ThinScatter;
use crate::scene::{ColorSpace, MaterialDescription};

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
        Some("a draft; its textures are ignored in volumes")
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let strength = spelling(loader, own, &["scatterStrengthFactor", "scatterFactor"])?;
        let strength = loader.factor(own, strength, 0.0, 0.0..=1.0)?;
        let color =
            spelling(loader, own, &["multiscatterColorFactor", "multiscatterColor", "scatterAlbedo"])?;
        let color = Vec3::from(loader.factors(own, color, [1.0; 3], 0.0..=1.0)?);
        let g = anisotropy(loader, own)?;
        if strength > 0.0 && out.medium.is_none() && out.transmission > 0.0 {
            let anisotropy = own.f64("scatterAnisotropy")?.unwrap_or(0.0).clamp(-1.0, 1.0) as f32;
            out.layers_mut().thin_scatter = Some(ThinScatter {
                strength,
                strength_texture: loader.texture_slot(own, "scatterStrengthTexture", ColorSpace::Linear)?,
                color,
                color_texture: loader.texture_slot(own, "multiscatterColorTexture", ColorSpace::Srgb)?,
                anisotropy,
            });
        } else if strength > 0.0 {
            split(loader, own, out, color * strength, g, g);
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
        Some("a draft; its textures are ignored")
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let color =
            spelling(loader, own, &["multiscatterColorFactor", "multiscatterColor", "scatterAlbedo"])?;
        let color = Vec3::from(loader.factors(own, color, [0.0; 3], 0.0..=1.0)?);
        let g = anisotropy(loader, own)?;
        split(loader, own, out, color, g, 0.0);
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

/// Splits the extinction of the medium into scattering and absorption. `g` is the anisotropy of the medium, and
/// `mapping_g` that of the mapping from the multi-scatter albedo `rho`.
fn split(
    loader: &mut Loader<'_>,
    own: &Json<'_>,
    out: &mut MaterialDescription,
    rho: Vec3,
    g: f32,
    mapping_g: f32,
) {
    for key in ["scatterStrengthTexture", "multiscatterColorTexture"] {
        if own.get(key).is_some() {
            loader.warn(&own.pointer_to(key), "the texture is ignored; its factor alone counts", None);
        }
    }
    let Some(medium) = &mut out.medium else {
        let advice =
            "give the material KHR_materials_transmission and a KHR_materials_volume.thicknessFactor";
        loader.warn(own.pointer(), "there is no volume that could scatter, so this is ignored", Some(advice));
        return;
    };
    let sigma_t = medium.sigma_a + medium.sigma_s;
    medium.sigma_s = sigma_t * rho.map(|r| single_from_multiple(r, mapping_g));
    medium.sigma_a = sigma_t * rho.map(|r| absorbed_from_multiple(r, mapping_g));
    medium.anisotropy = g;
}
