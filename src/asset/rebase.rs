//! Far from the origin: positions are subtracted in double precision before they become single.
//!
//! A model in its place on the globe is millions of metres from the origin, where single precision counts in half
//! metres. Three things bring its digits back, and each acts only where coordinates are [`FAR`] times as large as what
//! they describe, so that everything else keeps its bits:
//!
//! 1. A mesh that lies far from its own origin is moved there; its instances move it back.
//! 2. A skinned mesh, which is in world space, is counted from its own middle.
//! 3. Instances, lights and cameras are counted from a point of what the camera looks at, [`SceneDescription::origin`].
//!
//! What is subtracted from the scene is a multiple of a power of two, no finer than single precision is at that distance:
//! coordinates that are exact stay exact.
//!
//! [`SceneDescription::origin`]: crate::scene::SceneDescription

use glam::{DAffine3, DVec3};

use super::error::AssetError;
use super::loader::Loader;
use crate::scene::{AreaLight, CameraDescription, PunctualLight};

/// Coordinates are far that are so many times as large as what they describe: they waste three of 24 bits.
const FAR: f64 = 8.0;
/// A body with a medium must not have its thickness changed by more than this part, since what it absorbs follows from it.
const THICKNESS_LOSS: f64 = 1.0 / 1024.0;

/// Positions of the scene as the file has them; indices refer to the vectors of the scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Exact {
    pub instances: Vec<(usize, DVec3)>,
    pub cameras: Vec<(usize, DVec3)>,
    pub lights: Vec<(usize, DVec3)>,
    pub area_lights: Vec<(usize, DVec3)>,
}

/// An object as the camera sees it.
#[derive(Clone, Copy, Debug)]
struct Target {
    low: DVec3,
    high: DVec3,
    mesh: usize,
    scale: f64,
}

impl Loader<'_> {
    /// Adds a light to the scene, whose position is known in double precision.
    pub fn add_light(&mut self, light: PunctualLight, position: DVec3) {
        self.exact.lights.push((self.scene.lights.len(), position));
        self.scene.lights.push(light);
    }

    /// Adds an area light to the scene, whose middle is known in double precision.
    ///
    /// # Errors
    /// Where there are more of them, or of what they become, than the limits allow.
    pub fn add_area_light(&mut self, light: AreaLight, position: DVec3) -> Result<(), AssetError> {
        let needed = self.scene.instances.len() as u64 + self.scene.area_lights.len() as u64 + 1;
        let what = "the scene, in instances and area lights,";
        Self::within(needed, self.options.limits.instances, &light.pointer, what, "instances")?;
        let (vertices, triangles) = light.shape.counts();
        self.spend(vertices, triangles, &light.pointer)?;
        self.exact.area_lights.push((self.scene.area_lights.len(), position));
        self.scene.area_lights.push(light);
        Ok(())
    }

    /// Counts the positions of the scene from where the camera looks, if that is far away.
    pub(crate) fn rebase(&mut self) {
        let origin = self.cache.origin.unwrap_or_else(|| self.choose_origin());
        self.cache.origin = Some(origin);
        self.scene.origin = origin;
        self.scene.weld_tolerance = self.options.weld_tolerance;
        self.scene.limits = self.options.limits.derived;
        if origin == DVec3::ZERO {
            return;
        }
        let exact = std::mem::take(&mut self.exact);
        let scene = &mut self.scene;
        let instances = scene.instances.iter_mut().map(|i| &mut i.transform.translation);
        let cameras = scene.cameras.iter_mut().map(|c| &mut c.transform.translation);
        let area_lights = scene.area_lights.iter_mut().map(|l| &mut l.transform.translation);
        for (all, exact) in [
            (instances.collect::<Vec<_>>(), exact.instances),
            (cameras.collect::<Vec<_>>(), exact.cameras),
            (area_lights.collect::<Vec<_>>(), exact.area_lights),
        ] {
            let mut places: Vec<DVec3> = all.iter().map(|t| t.as_dvec3()).collect();
            keep(exact, &mut places);
            all.into_iter().zip(places).for_each(|(t, place)| *t = (place - origin).as_vec3a());
        }
        let mut places: Vec<DVec3> = scene.lights.iter().map(|l| l.position.as_dvec3()).collect();
        keep(exact.lights, &mut places);
        for (light, place) in scene.lights.iter_mut().zip(places) {
            light.position = (place - origin).as_vec3();
        }
    }

    fn choose_origin(&mut self) -> DVec3 {
        let targets = self.boxes_of_objects();
        let Some(&first) = targets.first() else { return DVec3::ZERO };
        let Some(eye) = self.eye() else {
            // The automatic camera frames everything.
            let all = targets
                .iter()
                .fold((first.low, first.high), |(low, high), t| (low.min(t.low), high.max(t.high)));
            return origin_near(0.5 * (all.0 + all.1), (all.1 - all.0).length(), FAR);
        };
        let nearest_point = |t: &Target| eye.clamp(t.low, t.high);
        let size = |t: &Target| (t.high - t.low).length();
        let view = |t: &Target| nearest_point(t).distance(eye) + size(t);
        let nearest = targets.iter().min_by(|a, b| view(a).total_cmp(&view(b))).unwrap_or(&first);
        let point = nearest_point(nearest);
        // The rounding that would be too much for its thickness is at a distance of so many sizes.
        let thin = self.thickness(nearest).map_or(f64::INFINITY, |thickness| {
            THICKNESS_LOSS * thickness / (0.5 * f64::from(f32::EPSILON)) / size(nearest)
        });
        origin_near(point, size(nearest), (FAR * view(nearest) / size(nearest)).min(thin))
    }

    /// The boxes of all objects in the world.
    fn boxes_of_objects(&mut self) -> Vec<Target> {
        let mut places = vec![None; self.scene.instances.len()];
        for &(i, place) in &self.exact.instances {
            places.get_mut(i).into_iter().for_each(|known| *known = Some(place));
        }
        let mut targets = Vec::with_capacity(places.len());
        for (i, place) in places.into_iter().enumerate() {
            let instance = &self.scene.instances[i];
            let (mesh, linear) = (instance.mesh, instance.transform.matrix3.as_dmat3());
            let translation = place.unwrap_or_else(|| instance.transform.translation.as_dvec3());
            let world = DAffine3 { matrix3: linear, translation };
            let corners = self.corners(mesh).map(|c| world.transform_point3(c));
            let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let high = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            let scale = linear.determinant().abs().cbrt();
            if low.is_finite() && high.is_finite() && low != high {
                targets.push(Target { low, high, mesh, scale });
            }
        }
        targets
    }

    /// Where the camera is that is looked through.
    fn eye(&self) -> Option<DVec3> {
        let cameras = &self.scene.cameras;
        let wanted = self.options.camera.as_deref();
        let chosen = wanted.map_or(Some(0), |wanted| CameraDescription::find(cameras, wanted));
        let index = chosen.filter(|&i| i < cameras.len())?;
        let exact = self.exact.cameras.iter().find(|(i, _)| *i == index);
        Some(exact.map_or_else(|| cameras[index].transform.translation.as_dvec3(), |(_, place)| *place))
    }

    /// The least edge of the box of a body with a medium.
    fn thickness(&mut self, target: &Target) -> Option<f64> {
        let mesh = self.scene.meshes.get(target.mesh)?;
        let medium = |&m: &u32| self.scene.materials.get(m as usize).is_some_and(|m| m.medium.is_some());
        if !mesh.triangle_materials.iter().any(medium) {
            return None;
        }
        let corners = self.corners(target.mesh);
        let thickness = (corners[7] - corners[0]).min_element() * target.scale;
        (thickness > 0.0).then_some(thickness)
    }
}

/// Puts the places that are known exactly where others are.
fn keep(exact: Vec<(usize, DVec3)>, places: &mut [DVec3]) {
    for (i, place) in exact {
        places.get_mut(i).into_iter().for_each(|known| *known = place);
    }
}

/// On each axis on which a point is more than `far` sizes away from zero, a round number next to it; else zero.
fn origin_near(point: DVec3, size: f64, far: f64) -> DVec3 {
    let finest = point.abs().max_element() * f64::from(f32::EPSILON);
    let step = power_of_two_below(size).max(2.0 * power_of_two_below(finest));
    let near = |x: f64| if x.abs() > far * size { (x / step).round() * step } else { 0.0 };
    let origin = DVec3::new(near(point.x), near(point.y), near(point.z));
    if origin.is_finite() { origin } else { DVec3::ZERO }
}

fn power_of_two_below(x: f64) -> f64 {
    x.log2().floor().exp2()
}

/// The middle of points on each axis on which they are far from zero, else zero.
pub(crate) fn far_center(points: impl Iterator<Item = DVec3>) -> DVec3 {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(none, |(low, high), p| (low.min(p), high.max(p)));
    let (center, size) = (0.5 * (low + high), (high - low).max_element());
    let far = center.abs().cmpgt(DVec3::splat(FAR * size));
    if center.is_finite() { DVec3::select(far, center, DVec3::ZERO) } else { DVec3::ZERO }
}
