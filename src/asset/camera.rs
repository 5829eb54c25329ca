//! Cameras (glTF 2.0 §3.10). The scale of a camera's node is stripped: a lens has none.

use glam::{Affine3A, DAffine3, DMat3, DVec3};

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::node::NodeContext;
use crate::scene::{CameraDescription, Clip, Projection};

impl Loader<'_> {
    /// Places camera `index` at a node.
    pub(crate) fn camera(&mut self, index: usize, node: &NodeContext) -> Result<(), AssetError> {
        let json = self.entry("cameras", index, &format!("{}/camera", node.pointer))?;
        let kind = json.str("type")?.ok_or_else(|| json.error_at("type", "is missing"))?;
        let lens = |key: &str| json.object(key)?.ok_or_else(|| json.error_at(key, "is missing"));
        let (projection, clip) = match kind {
            "perspective" => (self.perspective(&lens(kind)?)?, self.clip(&lens(kind)?, 0.0)?),
            "orthographic" => (self.orthographic(&lens(kind)?)?, self.clip(&lens(kind)?, f64::MIN)?),
            _ => return Err(json.error_at("type", "is neither `perspective` nor `orthographic`")),
        };
        let Some(transform) = rigid(&node.world) else {
            let message = "the camera is left out, since the scale of its node leaves it no direction";
            self.warn(&node.pointer, message, None);
            return Ok(());
        };
        let name = json.name_or(|| node.name.clone());
        let mut camera = CameraDescription { name, transform, projection, clip, lens: None };
        for extension in self.options.registry.iter() {
            if let Some(own) = json.extension(extension.name()) {
                own.as_object()?;
                extension.camera(self, &own, &json, &mut camera)?;
            }
        }
        self.exact.cameras.push((self.scene.cameras.len(), node.world.translation));
        self.scene.cameras.push(camera);
        Ok(())
    }

    fn perspective(&mut self, lens: &Json<'_>) -> Result<Projection, AssetError> {
        let yfov = lens.f64("yfov")?.ok_or_else(|| lens.error_at("yfov", "is missing"))?;
        if yfov <= 0.0 || yfov >= std::f64::consts::PI {
            return Err(lens.error_at("yfov", format!("{yfov} is not between 0 and π")));
        }
        let aspect = match lens.f64("aspectRatio")? {
            Some(aspect) if aspect as f32 > 0.0 && (aspect as f32).is_finite() => Some(aspect as f32),
            Some(aspect) => {
                self.invalid(&lens.pointer_to("aspectRatio"), format!("{aspect} is no shape of a picture"))?;
                None
            }
            None => None,
        };
        Ok(Projection::Perspective { yfov: (yfov as f32).max(f32::MIN_POSITIVE), aspect })
    }

    fn orthographic(&mut self, lens: &Json<'_>) -> Result<Projection, AssetError> {
        let ymag = lens.f64("ymag")?.ok_or_else(|| lens.error_at("ymag", "is missing"))?;
        if ymag == 0.0 || (ymag.abs() as f32) == 0.0 {
            return Err(lens.error_at("ymag", "0 leaves nothing to see"));
        }
        if ymag < 0.0 {
            self.invalid(&lens.pointer_to("ymag"), format!("{ymag} is below 0; its sign is ignored"))?;
        }
        let xmag = lens.f64("xmag")?.unwrap_or(0.0).abs();
        let aspect = (xmag > 0.0).then(|| (xmag / ymag.abs()) as f32).filter(|a| a.is_finite() && *a > 0.0);
        Ok(Projection::Orthographic { ymag: (ymag.abs() as f32).min(f32::MAX), aspect })
    }

    /// The planes between which a camera sees (§3.10.3). A near plane behind the eye is none of glTF; parallel rays start
    /// there all the same, since exporters write it, others at the eye. Planes that leave nothing between them are ignored.
    fn clip(&mut self, lens: &Json<'_>, least: f64) -> Result<Clip, AssetError> {
        let near = lens.f64("znear")?.unwrap_or(0.0);
        let far = lens.f64("zfar")?.unwrap_or(f64::INFINITY);
        if near < 0.0 {
            self.invalid(&lens.pointer_to("znear"), format!("{near} is below 0"))?;
        }
        if far <= near {
            let message = format!("{far} is not above znear ({near}); neither is used");
            self.invalid(&lens.pointer_to("zfar"), message)?;
            return Ok(Clip::NONE);
        }
        let clip = Clip { near: near.max(least) as f32, far: far as f32 };
        // Both may be beyond what single precision tells apart.
        Ok(if clip.near.is_finite() && clip.far > clip.near { clip } else { Clip::NONE })
    }
}

/// Rotation and translation of a transform: −Z is kept, +Y as far as it is perpendicular.
fn rigid(world: &DAffine3) -> Option<Affine3A> {
    let back = (world.matrix3 * DVec3::Z).try_normalize()?;
    let up = world.matrix3 * DVec3::Y;
    let right = up.cross(back).try_normalize()?;
    let rotation = DMat3::from_cols(right, back.cross(right), back);
    let rigid = DAffine3 { matrix3: rotation, translation: world.translation };
    let single = Affine3A::from_mat3_translation(rigid.matrix3.as_mat3(), rigid.translation.as_vec3());
    single.is_finite().then_some(single)
}
