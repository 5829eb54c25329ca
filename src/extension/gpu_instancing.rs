//! `EXT_mesh_gpu_instancing`: many copies of a node's mesh, by accessors of translations, rotations and scales.

use glam::{DAffine3, DQuat, DVec3};

use super::Extension;
use crate::asset::{AssetError, Json, Loader, NodeContext};

pub(super) struct GpuInstancing;

impl Extension for GpuInstancing {
    fn name(&self) -> &str {
        "EXT_mesh_gpu_instancing"
    }

    fn instances(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &NodeContext,
    ) -> Result<Option<Vec<DAffine3>>, AssetError> {
        let Some(attributes) = own.object("attributes")? else {
            loader.invalid(own.pointer(), "has no `attributes`; one copy is shown")?;
            return Ok(None);
        };
        let mut read = |key: &str, width: usize| {
            let Some(index) = attributes.usize(key)? else { return Ok(None) };
            let accessor = loader.accessor(index, &attributes.pointer_to(key))?;
            if !accessor.is_vector(width) {
                return Err(attributes.error_at(key, format!("must have {width} components")));
            }
            Ok(Some(accessor.floats::<4>()))
        };
        let translations = read("TRANSLATION", 3)?;
        let rotations = read("ROTATION", 4)?;
        let scales = read("SCALE", 3)?;
        let counts = [&translations, &rotations, &scales].map(|v| v.as_ref().map(Vec::len));
        let Some(count) = counts.into_iter().flatten().min() else { return Ok(None) };
        if counts.into_iter().flatten().any(|n| n != count) {
            loader.invalid(attributes.pointer(), "the attributes differ in length; the shortest counts")?;
        }
        let vector = |values: &Option<Vec<[f32; 4]>>, i: usize, default: DVec3| {
            values.as_ref().map_or(default, |v| DVec3::new(v[i][0].into(), v[i][1].into(), v[i][2].into()))
        };
        let copies = (0..count).map(|i| {
            let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |r| {
                let q = DQuat::from_array(r[i].map(f64::from));
                if q.length_squared() > 0.0 && q.is_finite() { q.normalize() } else { DQuat::IDENTITY }
            });
            let (scale, translation) =
                (vector(&scales, i, DVec3::ONE), vector(&translations, i, DVec3::ZERO));
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        });
        Ok(Some(copies.collect()))
    }
}
