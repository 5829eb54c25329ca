//! `EXT_lights_ies`: lights without size that shine as luminaires were measured, by files in the format IES LM-63
//! ([`crate::asset::Lm63`]).
//!
//! A light shines along −Z of its node, whose scale does not matter; candela are those of the file times a factor and a
//! colour of the node.

use std::sync::Arc;

use glam::Vec3;

use super::Extension;
use super::emissive_strength::MAX_RADIANCE;
use crate::asset::{AssetError, Json, Lm63, Loader, MutableProperty, NodeContext, PropertyKind, light_frame};
use crate::scene::{PhotometricWeb, PunctualKind, PunctualLight, TurnedWeb};

const NAME: &str = "EXT_lights_ies";
const MIME: &str = "application/x-ies-lm-63";

/// What animations may change, as Babylon.js has it: the extension itself says nothing of animations.
const MUTABLE: [MutableProperty; 2] = [
    MutableProperty {
        template: "/nodes/{}/extensions/EXT_lights_ies/multiplier",
        kind: PropertyKind::Float,
        range: [0.0, MAX_RADIANCE as f64],
    },
    MutableProperty {
        template: "/nodes/{}/extensions/EXT_lights_ies/color",
        kind: PropertyKind::Float3,
        range: [0.0, 1.0],
    },
];

pub(super) struct LightsIes;

impl Extension for LightsIes {
    fn name(&self) -> &str {
        NAME
    }

    fn mutable_properties(&self) -> &[MutableProperty] {
        &MUTABLE
    }

    fn node(&self, loader: &mut Loader<'_>, own: &Json<'_>, node: &NodeContext) -> Result<(), AssetError> {
        let Some(index) = own.usize("light")? else {
            return loader.invalid(own.pointer(), "has no `light`; it is left out");
        };
        let lights = loader.root().extension(NAME).and_then(|e| e.get("lights"));
        let Some(profile) = lights.and_then(|list| list.item(index)) else {
            return Err(own.error_at("light", format!("there is no light {index}")));
        };
        profile.as_object()?;
        let multiplier = loader.factor(own, "multiplier", 1.0, 0.0..=f64::from(MAX_RADIANCE))?;
        let color = Vec3::from(loader.factors(own, "color", [1.0; 3], 0.0..=1.0)?);
        let Some(web) = web(loader, index, &profile)? else { return Ok(()) };
        let Some((frame, position)) = light_frame(&node.world) else {
            loader.warn(&node.pointer, "the light is left out, since its node has no direction", None);
            return Ok(());
        };
        let intensity = color * (f64::from(multiplier) * f64::from(web.largest())) as f32;
        let light = PunctualLight {
            name: profile.name_or(|| node.name.clone()),
            intensity: intensity.min(Vec3::splat(MAX_RADIANCE)),
            position,
            direction: -frame.z_axis,
            range: None,
            kind: PunctualKind::Web(Arc::new(TurnedWeb::new(web, frame))),
        };
        loader.add_light(light, node.world.translation);
        Ok(())
    }
}

/// The web of a light profile, read once; `None`, with a warning, where the file names none.
fn web(
    loader: &mut Loader<'_>,
    index: usize,
    profile: &Json<'_>,
) -> Result<Option<Arc<PhotometricWeb>>, AssetError> {
    if let Some(known) = loader.web(index) {
        return Ok(Some(known));
    }
    let (view, uri) = (profile.usize("bufferView")?, profile.str("uri")?);
    let mime = profile.str("mimeType")?;
    if mime.map_or(view.is_some(), |mime| mime != MIME) {
        loader.invalid(&profile.pointer_to("mimeType"), format!("should be `{MIME}`"))?;
    }
    if view.is_some() && uri.is_some() {
        loader.invalid(profile.pointer(), "has both `uri` and `bufferView`; the latter is used")?;
    }
    let (bytes, from) = match (view, uri) {
        (Some(view), _) => {
            let from = profile.pointer_to("bufferView");
            (loader.buffer_view(view, &from)?, from)
        }
        (None, Some(uri)) => {
            let from = profile.pointer_to("uri");
            (loader.read_uri(&from, uri)?, from)
        }
        (None, None) => {
            loader.invalid(profile.pointer(), "has neither `uri` nor `bufferView`; it is left out")?;
            return Ok(None);
        }
    };
    let read = Lm63::read(&bytes).map_err(|error| {
        AssetError::invalid(&from, format!("the light profile cannot be read: {error}"))
            .with_advice("it has to be a file of IES LM-63 with a table of candela")
    })?;
    for oddity in read.oddities {
        loader.invalid(&from, oddity)?;
    }
    if read.tilts {
        let message = "what the tilt of the lamp does to its light is not used, as the extension allows";
        loader.note(&from, message);
    }
    if read.web.largest() <= 0.0 {
        loader.warn(&from, "the light profile gives no light in any direction", None);
    }
    Ok(Some(loader.keep_web(index, read.web)))
}
