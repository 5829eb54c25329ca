//! `EXT_lights_area`: rectangles and disks that shine to one side (glTF pull request 2525, a draft).
//!
//! Luminance is in nits; the scale of a node makes the light larger, by its largest component on all axes, and no
//! brighter. A light shines along −Z of its node. Files of the draft's first weeks write `shape` for `type`, `luminance` for
//! `intensity`, and `width`, `height` and `radius` for `size` and `aspect`: they are read, with a note, with what these
//! names meant by default.

use glam::{Affine3A, DAffine3, Vec2, Vec3};

use super::Extension;
use super::emissive_strength::MAX_RADIANCE;
use crate::asset::{
    AssetError, FARTHEST, Json, Loader, MutableProperty, NodeContext, PropertyKind, light_frame,
};
use crate::scene::{AreaLight, AreaShape};

const NAME: &str = "EXT_lights_area";

const TOP: f64 = MAX_RADIANCE as f64;

/// What animations may change, as Babylon.js has it: the draft itself says nothing of animations.
const MUTABLE: [MutableProperty; 4] = [
    MutableProperty {
        template: "/extensions/EXT_lights_area/lights/{}/color",
        kind: PropertyKind::Float3,
        range: [0.0, TOP],
    },
    MutableProperty {
        template: "/extensions/EXT_lights_area/lights/{}/intensity",
        kind: PropertyKind::Float,
        range: [0.0, TOP],
    },
    MutableProperty {
        template: "/extensions/EXT_lights_area/lights/{}/size",
        kind: PropertyKind::Float,
        range: [0.0, f64::INFINITY],
    },
    MutableProperty {
        template: "/extensions/EXT_lights_area/lights/{}/rect/aspect",
        kind: PropertyKind::Float,
        range: [0.0, f64::INFINITY],
    },
];

pub(super) struct LightsArea;

impl Extension for LightsArea {
    fn name(&self) -> &str {
        NAME
    }

    fn shortfall(&self) -> Option<&str> {
        Some("a draft, which may still change")
    }

    fn mutable_properties(&self) -> &[MutableProperty] {
        &MUTABLE
    }

    fn node(&self, loader: &mut Loader<'_>, own: &Json<'_>, node: &NodeContext) -> Result<(), AssetError> {
        let Some(index) = own.usize("light")? else {
            return loader.invalid(own.pointer(), "has no `light`; it is left out");
        };
        let lights = loader.root().extension(NAME).and_then(|e| e.get("lights"));
        let Some(light) = lights.and_then(|list| list.item(index)) else {
            return Err(own.error_at("light", format!("there is no light {index}")));
        };
        light.as_object()?;
        let Some(shape) = shape(loader, &light)? else { return Ok(()) };
        let color = Vec3::from(loader.factors(&light, "color", [1.0; 3], 0.0..=TOP)?);
        if color.max_element() > 1.0 {
            loader.invalid(&light.pointer_to("color"), "is above 1; it is used as it is")?;
        }
        let intensity = spelling(loader, &light, ["intensity", "luminance"])?;
        let intensity = loader.factor(&light, intensity, 1000.0, 0.0..=TOP)?;
        if intensity <= 0.0 || color.max_element() <= 0.0 {
            // A light that is off is not there, as with other kinds of light.
            return Ok(());
        }
        let Some(size) = size(loader, &light, shape)? else { return Ok(()) };
        let Some((frame, middle)) = light_frame(&node.world) else {
            loader.warn(&node.pointer, "the light is left out, since its node has no direction", None);
            return Ok(());
        };
        let size = size.map(|side| side * scale(&node.world));
        let reach = node.world.translation.abs().max_element() + size[0].max(size[1]);
        let [width, height] = size.map(|side| side as f32);
        if reach > FARTHEST || width * height <= 0.0 {
            let message = format!(
                "the light is left out: it is {width:e} m wide and {height:e} m high, and reaches as far as {reach:e} m"
            );
            loader.warn(&node.pointer, message, None);
            return Ok(());
        }
        let light = AreaLight {
            name: light.name_or(|| node.name.clone()),
            pointer: node.pointer.clone(),
            radiance: (color * intensity).min(Vec3::splat(MAX_RADIANCE)),
            shape,
            size: Vec2::new(width, height),
            transform: Affine3A::from_mat3_translation(frame, middle),
        };
        loader.add_area_light(light, node.world.translation)
    }
}

/// The largest component of the scale of a node in the world.
fn scale(world: &DAffine3) -> f64 {
    let m = &world.matrix3;
    m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length())
}

fn shape(loader: &mut Loader<'_>, light: &Json<'_>) -> Result<Option<AreaShape>, AssetError> {
    let key = spelling(loader, light, ["type", "shape"])?;
    match light.str(key)? {
        Some("rect") => Ok(Some(AreaShape::Rectangle)),
        Some("disk") => Ok(Some(AreaShape::Disk)),
        Some(other) => {
            let other = other.chars().take(40).collect::<String>();
            let message = format!("`{other}` is no kind of area light (rect, disk); it is left out");
            loader.invalid(&light.pointer_to(key), message)?;
            Ok(None)
        }
        None => {
            loader.invalid(light.pointer(), "has no `type`; it is a rectangle")?;
            Ok(Some(AreaShape::Rectangle))
        }
    }
}

/// Width and height, metres before the scale of the node.
fn size(loader: &mut Loader<'_>, light: &Json<'_>, shape: AreaShape) -> Result<Option<[f64; 2]>, AssetError> {
    let has = |key: &str| light.get(key).is_some();
    let earlier = match shape {
        AreaShape::Rectangle => has("width") || has("height"),
        AreaShape::Disk => has("radius"),
    };
    let earlier = !has("size") && (earlier || (has("shape") && !has("type")));
    let rect = light.object("rect")?;
    let size = match (shape, earlier) {
        (AreaShape::Rectangle, true) => {
            tell_of_earlier(loader, light, "width` and `height", "size` and `rect.aspect");
            length(loader, light, "width")?.zip(length(loader, light, "height")?).map(|(w, h)| [w, h])
        }
        (AreaShape::Disk, true) => {
            tell_of_earlier(loader, light, "radius", "size");
            length(loader, light, "radius")?.map(|radius| [2.0 * radius; 2])
        }
        (AreaShape::Rectangle, false) => {
            let aspect = match &rect {
                Some(rect) => length(loader, rect, "aspect")?,
                None => Some(1.0),
            };
            length(loader, light, "size")?.zip(aspect).map(|(size, aspect)| [size * aspect, size])
        }
        (AreaShape::Disk, false) => length(loader, light, "size")?.map(|size| [size; 2]),
    };
    Ok(size)
}

/// A number above 0, by default 1; `None`, told of, where it is not.
fn length(loader: &mut Loader<'_>, json: &Json<'_>, key: &str) -> Result<Option<f64>, AssetError> {
    let value = json.f64(key)?.unwrap_or(1.0);
    if value > 0.0 {
        return Ok(Some(value));
    }
    loader.invalid(&json.pointer_to(key), format!("{value} is not above 0; the light is left out"))?;
    Ok(None)
}

/// The newest of two spellings that is there.
fn spelling(
    loader: &mut Loader<'_>,
    light: &Json<'_>,
    [now, earlier]: [&'static str; 2],
) -> Result<&'static str, AssetError> {
    if light.get(now).is_some() || light.get(earlier).is_none() {
        return Ok(now);
    }
    tell_of_earlier(loader, light, earlier, now);
    Ok(earlier)
}

fn tell_of_earlier(loader: &mut Loader<'_>, light: &Json<'_>, earlier: &str, now: &str) {
    loader.note(light.pointer(), format!("`{earlier}` is of an earlier draft, which now says `{now}`"));
}
