//! Lights without size: point, spot and directional as the glTF extension KHR_lights_punctual defines them, and measured ones
//! as EXT_lights_ies does.
//!
//! Candela and lux in, irradiance on a surface that faces the light out: `I / d² × window × cone` or × web, or lux.

use std::f32::consts::TAU;

use glam::Vec3;

use crate::scene::{PunctualKind, PunctualLight};

/// What a punctual light sends to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctualIrradiance {
    /// Unit direction from the point towards the light.
    pub direction: Vec3,
    /// Distance in metres, infinite for directional lights.
    pub distance: f32,
    /// Irradiance of a surface that faces the light.
    pub irradiance: Vec3,
}

/// The specification's windowed inverse-square fall-off, 1/m²: `clamp(1 − (d/range)⁴, 0, 1) / d²`.
#[inline]
pub fn distance_attenuation(distance_squared: f32, range: Option<f32>) -> f32 {
    let window = match range {
        Some(range) if range > 0.0 => {
            let ratio = distance_squared / (range * range);
            (1.0 - ratio * ratio).clamp(0.0, 1.0)
        }
        _ => 1.0,
    };
    window / distance_squared
}

/// The specification's recommended cone: the square of the cosine's linear ramp from the outer to the inner angle.
///
/// Angles of a fraction of a degree are lost in single cosines, so the ramp is one of 1 − cos θ = 2 sin²(θ/2), which is half
/// the squared distance between the ends of unit vectors; `twice_versine` is twice that. The specification's code divides by
/// 0.001 at least, so as not to divide by zero, and with it a cone of less than 2.6° never comes to its full intensity. Here
/// equal angles make a sharp edge, and all others the ramp that they name.
#[inline]
pub fn spot_attenuation(twice_versine: f32, inner: f32, outer: f32) -> f32 {
    let end = |angle: f32| (2.0 * (0.5 * angle).sin()).powi(2);
    let (from, to) = (end(outer), end(inner));
    if twice_versine <= to {
        return 1.0;
    }
    let ramp = ((from - twice_versine) / (from - to)).clamp(0.0, 1.0);
    ramp * ramp
}

/// The unit direction from `point` to a light; `None` at the light itself.
#[inline]
pub fn direction_to(light: &PunctualLight, point: Vec3) -> Option<Vec3> {
    if light.kind == PunctualKind::Directional {
        return Some(-light.direction);
    }
    let to_light = light.position - point;
    let direction = to_light / to_light.length();
    direction.is_finite().then_some(direction)
}

/// What the luminous intensity on the axis of a light is multiplied by to give its luminous flux, steradians: 4π for a point,
/// for a cone the integral of its ramp, 2π (vᵢ + (vₒ − vᵢ)/3) with v = 1 − cos θ of the inner and the outer angle, for a
/// measured light its flux over its largest intensity. `None` for parallel light, which has no end. The range is not counted: it takes light away with the distance.
pub fn solid_angle(kind: &PunctualKind) -> Option<f32> {
    match kind {
        PunctualKind::Point => Some(2.0 * TAU),
        &PunctualKind::Spot { inner, outer } => {
            let versine = |angle: f32| 2.0 * (0.5 * angle).sin().powi(2);
            Some(TAU * (versine(inner) + (versine(outer) - versine(inner)) / 3.0))
        }
        PunctualKind::Web(web) => {
            Some((web.web().lumens() / f64::from(web.web().largest().max(f32::MIN_POSITIVE))) as f32)
        }
        PunctualKind::Directional => None,
    }
}

/// What `light` sends to `point`, or `None` where that is nothing (out of range or cone, or at the light itself).
#[inline]
pub fn irradiance(light: &PunctualLight, point: Vec3) -> Option<PunctualIrradiance> {
    if light.kind == PunctualKind::Directional {
        return (light.intensity != Vec3::ZERO).then_some(PunctualIrradiance {
            direction: -light.direction,
            distance: f32::INFINITY,
            irradiance: light.intensity,
        });
    }
    let to_light = light.position - point;
    let distance_squared = to_light.length_squared();
    let distance = distance_squared.sqrt();
    let direction = to_light / distance;
    if !direction.is_finite() || distance == 0.0 {
        return None;
    }
    let mut attenuation = distance_attenuation(distance_squared, light.range);
    match &light.kind {
        PunctualKind::Spot { inner, outer } => {
            attenuation *= spot_attenuation((direction + light.direction).length_squared(), *inner, *outer);
        }
        PunctualKind::Web(web) => attenuation *= web.relative(-direction),
        PunctualKind::Point | PunctualKind::Directional => {}
    }
    let irradiance = light.intensity * attenuation;
    (irradiance.max_element() > 0.0 && irradiance.is_finite()).then_some(PunctualIrradiance {
        direction,
        distance,
        irradiance,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(kind: PunctualKind, range: Option<f32>) -> PunctualLight {
        PunctualLight {
            name: String::new(),
            intensity: Vec3::new(8.0, 4.0, 2.0),
            position: Vec3::new(0.0, 2.0, 0.0),
            direction: Vec3::NEG_Y,
            range,
            kind,
        }
    }

    /// Against a sum over the sphere in double precision.
    #[test]
    fn the_flux_of_a_cone_is_the_sum_of_its_directions() {
        for (inner, outer) in [(0.0f32, 0.5f32), (0.3, 0.31), (0.2, 1.5), (0.0, std::f32::consts::FRAC_PI_2)]
        {
            const STEPS: u32 = 100_000;
            let width = 2.0 / f64::from(STEPS);
            let sum: f64 = (0..STEPS)
                .map(|i| {
                    let versine = (f64::from(i) + 0.5) * width;
                    f64::from(spot_attenuation((2.0 * versine) as f32, inner, outer)) * width
                })
                .sum();
            let found = f64::from(solid_angle(&PunctualKind::Spot { inner, outer }).unwrap());
            let expected = std::f64::consts::TAU * sum;
            assert!((found / expected - 1.0).abs() < 1e-3, "{inner} {outer}: {found} {expected}");
        }
        assert_eq!(solid_angle(&PunctualKind::Point), Some(4.0 * std::f32::consts::PI));
        assert_eq!(solid_angle(&PunctualKind::Directional), None);
    }

    #[test]
    fn values_computed_by_hand() {
        let at = |l: &PunctualLight, p: Vec3| irradiance(l, p).map(|i| i.irradiance.x);
        let point = light(PunctualKind::Point, None);
        assert_eq!(at(&point, Vec3::ZERO), Some(2.0));
        assert_eq!(irradiance(&point, Vec3::ZERO).unwrap().direction, Vec3::Y);
        assert_eq!(irradiance(&point, Vec3::ZERO).unwrap().distance, 2.0);
        assert_eq!(at(&point, point.position), None);
        // Half the range: 1 − 1/16 of 8 cd at 2 m.
        assert_eq!(at(&light(PunctualKind::Point, Some(4.0)), Vec3::ZERO), Some(2.0 * 15.0 / 16.0));
        assert_eq!(at(&light(PunctualKind::Point, Some(2.0)), Vec3::ZERO), None);
        // Cone 30° to 60°: on the axis 1, at 45° ((cos 45° − ½) / (cos 30° − ½))², outside nothing.
        let kind = PunctualKind::Spot { inner: 30f32.to_radians(), outer: 60f32.to_radians() };
        let spot = light(kind, None);
        assert_eq!(at(&spot, Vec3::ZERO), Some(2.0));
        let at_45 = at(&spot, Vec3::new(2.0, 0.0, 0.0)).unwrap();
        let ramp = (0.5f64.sqrt() - 0.5) / (0.75f64.sqrt() - 0.5);
        assert!((f64::from(at_45) - ramp * ramp).abs() < 1e-6);
        assert_eq!(at(&spot, Vec3::new(4.0, 0.0, 0.0)), None);
        assert_eq!(at(&spot, Vec3::new(0.0, 3.0, 0.0)), None);
        // Equal angles: a hard edge, no division by zero.
        let versine = |angle: f32| 2.0 - 2.0 * angle.cos();
        assert_eq!(spot_attenuation(0.0, 0.5, 0.5), 1.0);
        assert_eq!(spot_attenuation(versine(0.6), 0.5, 0.5), 0.0);
        // Between two cones of a tenth of a degree.
        for (inner, outer) in [(0.0f32, 0.004f32), (0.001, 0.002), (0.0001, 0.0002)] {
            let narrow = light(PunctualKind::Spot { inner, outer }, None);
            let profile = |angle: f64| {
                let half = |a: f64| (0.5 * a).sin().powi(2);
                let (a, b) = (half(f64::from(inner)), half(f64::from(outer)));
                ((b - half(angle)) / (b - a)).clamp(0.0, 1.0).powi(2)
            };
            assert_eq!(at(&narrow, Vec3::ZERO), Some(2.0));
            for i in 0..=20 {
                let x = 2.2 * f64::from(outer) * f64::from(i) / 20.0;
                let found = at(&narrow, Vec3::new(x as f32, 0.0, 0.0)).map_or(0.0, f64::from);
                let expected = 8.0 / (4.0 + x * x) * profile((x / 2.0).atan());
                // Unit vectors are rounded to 1e-7.
                let room = 2.0 * 2.0 * 3e-7 / f64::from(outer - inner);
                assert!((found - expected).abs() < room, "{inner} {outer} {x}: {found} {expected}");
            }
        }
        let sun = light(PunctualKind::Directional, Some(1.0));
        let i = irradiance(&sun, Vec3::splat(1e6)).unwrap();
        assert_eq!((i.direction, i.distance, i.irradiance.y), (Vec3::Y, f32::INFINITY, 4.0));
    }
}
