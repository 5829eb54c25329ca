//! The medium that other viewers get of one whose coefficients come from textures: that of the mean of its places.

use crate::author::paint::mean::field;
use crate::author::{Medium, nephrite, paint};
use crate::scene::texture::TextureSampler;
use crate::scene::{SceneDescription, TextureRef};
use serde_json::Value;

/// The homogeneous medium of the mean extinction and the mean multi-scatter albedo; `white`, the medium of white texels,
/// where there are no textures, or where they are not those that the scene was loaded with.
pub(super) fn mean(
    [before, after]: [&Value; 2],
    white: Medium,
    index: usize,
    scene: Option<&SceneDescription>,
) -> Medium {
    let info = |material: &Value, key: &str| {
        material.pointer(&format!("/extensions/{}/{key}", nephrite::NAME)).cloned()
    };
    let textured = ["absorptionTexture", "scatteringTexture"].map(|key| info(after, key).is_some());
    if ["absorptionTexture", "scatteringTexture"].iter().any(|key| info(before, key) != info(after, key)) {
        return white;
    }
    let loaded = scene.and_then(|scene| Some((scene, scene.materials.get(index)?.medium.as_ref()?)));
    let Some((scene, loaded)) = loaded.filter(|_| textured != [false; 2]) else { return white };
    let slots = [&loaded.absorption_texture, &loaded.scattering_texture];
    if slots.map(Option::is_some) != textured {
        return white;
    }
    let sampler = |reference: &Option<TextureRef>| {
        let plain = TextureRef { transform: glam::Affine2::IDENTITY, ..*reference.as_ref()? };
        TextureSampler::new(&scene.textures, &scene.images, &plain)
    };
    let samplers = slots.map(sampler);
    let texel = |sampler: &Option<TextureSampler<'_>>, i: u32| match sampler {
        Some(sampler) => {
            let [x, y] = field(i, sampler.size());
            sampler.texel(x, y).truncate().to_array().map(f64::from)
        }
        None => [1.0; 3],
    };
    paint::mean::mean(white, |i| [texel(&samplers[0], i), texel(&samplers[1], i)])
}
