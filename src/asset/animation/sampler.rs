//! Samplers of animations (glTF 2.0 §3.11 and appendix C): keyframes, and the values between them.
//!
//! A value is looked up, never all of them, so that a moment of an animation with a million keyframes costs two dozen
//! reads. Before the first keyframe the first value holds, after the last one the last.

use std::sync::Arc;

use glam::DQuat;

use crate::asset::{Accessor, AssetError, Component, Json, Loader};

/// Keyframes whose data have been checked.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    times: Arc<Accessor>,
    values: Arc<Accessor>,
    interpolation: Interpolation,
    /// Times of the first and the last keyframe, seconds.
    pub range: [f32; 2],
}

/// How a value comes from those of the keyframes around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    /// That of the keyframe before.
    Step,
    /// On the straight line, or the great circle of rotations.
    Linear,
    /// Hermite splines with tangents from the file.
    CubicSpline,
}

impl Interpolation {
    /// Elements of the output for each keyframe.
    fn parts(self) -> usize {
        if self == Self::CubicSpline { 3 } else { 1 }
    }
}

/// What the numbers of a value mean, as far as their interpolation is concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Space {
    /// Independent numbers.
    Numbers,
    /// One unit quaternion.
    Rotation,
    /// Numbers that jump.
    Steps,
}

impl Loader<'_> {
    /// Reads a sampler and checks its times.
    pub(super) fn sampler_of(&mut self, json: &Json<'_>) -> Result<Sampler, AssetError> {
        let interpolation = match json.str("interpolation")? {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(_) => {
                return Err(json.error_at("interpolation", "is none of LINEAR, STEP and CUBICSPLINE"));
            }
        };
        let times = self.keyframes(json, "input")?;
        let values = self.keyframes(json, "output")?;
        let range = self.time_range(&times, &json.pointer_to("input"))?;
        Ok(Sampler { times, values, interpolation, range })
    }

    fn keyframes(&mut self, sampler: &Json<'_>, key: &str) -> Result<Arc<Accessor>, AssetError> {
        let index = sampler.usize(key)?.ok_or_else(|| sampler.error_at(key, "is missing"))?;
        if let Some(known) = self.cache.keyframes.get(&index) {
            return Ok(Arc::clone(known));
        }
        let accessor = Arc::new(self.accessor(index, &sampler.pointer_to(key))?);
        self.cache.keyframes.insert(index, Arc::clone(&accessor));
        Ok(accessor)
    }

    /// First and last time, if times are numbers that increase.
    fn time_range(&mut self, times: &Accessor, from: &str) -> Result<[f32; 2], AssetError> {
        if let Some(known) = self.cache.times.get(&times.pointer) {
            return known.clone().map_err(|message| AssetError::invalid(from, message));
        }
        self.spend_pose(times.count, &times.pointer)?;
        let checked = check_times(times);
        if let Ok((_, Some(oddity))) = &checked {
            self.invalid(&times.pointer, *oddity)?;
        }
        let range = checked.map(|(range, _)| range);
        self.cache.times.insert(times.pointer.clone(), range.clone());
        range.map_err(|message| AssetError::invalid(from, message))
    }
}

/// First and last time and what is odd about the times between.
fn check_times(times: &Accessor) -> Result<([f32; 2], Option<&'static str>), String> {
    if !times.is_vector(1) || times.count == 0 {
        return Err("the times of keyframes must be scalars, at least one".to_owned());
    }
    let mut oddity =
        (times.component != Component::F32).then_some("the times of keyframes should be floating point");
    let mut last = f32::NEG_INFINITY;
    for i in 0..times.count {
        let [time] = times.element::<1>(i);
        if !time.is_finite() || time < last {
            return Err(format!("the times of keyframes do not increase at keyframe {i}"));
        }
        if time == last {
            oddity = Some("two keyframes have the same time");
        }
        last = time;
    }
    Ok(([times.element::<1>(0)[0], last], oddity))
}

impl Sampler {
    /// Type of the components of a value.
    pub fn output(&self) -> &Accessor {
        &self.values
    }

    /// Whether values may lie between those of keyframes.
    pub fn is_smooth(&self) -> bool {
        self.interpolation != Interpolation::Step
    }

    /// Numbers of a value, if the output is whole values: as many elements as keyframes make.
    pub fn numbers(&self) -> Result<usize, String> {
        let keys = self.times.count * self.interpolation.parts();
        let width = self.values.shape.0 * self.values.shape.1;
        let (per_key, rest) = (self.values.count / keys, self.values.count % keys);
        if per_key == 0 || rest != 0 || (width > 1 && per_key != 1) {
            let count = self.values.count;
            return Err(format!("{count} elements for {} keyframes", self.times.count));
        }
        Ok(per_key * width)
    }

    /// The value at a time in seconds, as that many numbers; `integers` stand for fractions if they say so, or if
    /// `fractions`.
    pub fn at(&self, time: f64, space: Space, numbers: usize, fractions: bool) -> Vec<f64> {
        let (before, after) = self.around(time);
        let value = |key: usize, part: usize| self.value(key, part, numbers, fractions);
        let parts = self.interpolation.parts();
        let main = parts / 2;
        let exact = |key| finished(value(key, main), space);
        if before == after || self.interpolation == Interpolation::Step || space == Space::Steps {
            return exact(before);
        }
        let [t0, t1] = [before, after].map(|k| f64::from(self.times.element::<1>(k)[0]));
        let step = t1 - t0;
        let s = (time - t0) / step;
        if self.interpolation == Interpolation::CubicSpline {
            let (v0, out) = (value(before, 1), value(before, 2));
            let (into, v1) = (value(after, 0), value(after, 1));
            let spline = (0..numbers).map(|i| hermite(v0[i], out[i], into[i], v1[i], s, step));
            return finished(spline.collect(), space);
        }
        let (v0, v1) = (value(before, 0), value(after, 0));
        match (space, &v0[..], &v1[..]) {
            (Space::Rotation, &[a, b, c, d], &[e, f, g, h]) => {
                let q = slerp(DQuat::from_xyzw(a, b, c, d), DQuat::from_xyzw(e, f, g, h), s);
                q.to_array().to_vec()
            }
            _ => v0.iter().zip(&v1).map(|(a, b)| a + (b - a) * s).collect(),
        }
    }

    /// The keyframes around a time, the same one twice at and beyond the ends.
    fn around(&self, time: f64) -> (usize, usize) {
        let at = |k: usize| f64::from(self.times.element::<1>(k)[0]);
        let last = self.times.count.saturating_sub(1);
        if time.is_nan() || time <= at(0) {
            return (0, 0);
        }
        if time >= at(last) {
            return (last, last);
        }
        let (mut low, mut high) = (0, last);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if at(middle) <= time { low = middle } else { high = middle }
        }
        (low, high)
    }

    fn value(&self, key: usize, part: usize, numbers: usize, fractions: bool) -> Vec<f64> {
        let parts = self.interpolation.parts();
        let (rows, columns) = self.values.shape;
        let width = rows * columns;
        let elements = numbers / width.max(1);
        let first = (key * parts + part) * elements;
        let top = match self.values.component {
            _ if !fractions || self.values.normalized => None,
            Component::I8 => Some(127.0),
            Component::U8 => Some(255.0),
            Component::I16 => Some(32767.0),
            Component::U16 => Some(65535.0),
            Component::U32 | Component::F32 => None,
        };
        let scaled = |x: f32| top.map_or(f64::from(x), |top: f64| (f64::from(x) / top).max(-1.0));
        (first..first + elements)
            .flat_map(|i| self.values.element::<16>(i).into_iter().take(width))
            .map(scaled)
            .collect()
    }
}

/// A quaternion of unit length, or the numbers as they are.
fn finished(value: Vec<f64>, space: Space) -> Vec<f64> {
    match (space, &value[..]) {
        (Space::Rotation, &[x, y, z, w]) => {
            let q = DQuat::from_xyzw(x, y, z, w);
            let length = q.length();
            if length > 0.0 && length.is_finite() { (q / length).to_array().to_vec() } else { value }
        }
        _ => value,
    }
}

/// Appendix C.5: the cubic Hermite spline through `v0` and `v1`, with tangents per second, at fraction `s` of `step`
/// seconds.
fn hermite(v0: f64, out: f64, into: f64, v1: f64, s: f64, step: f64) -> f64 {
    let (s2, s3) = (s * s, s * s * s);
    (2.0 * s3 - 3.0 * s2 + 1.0) * v0
        + step * (s3 - 2.0 * s2 + s) * out
        + (3.0 * s2 - 2.0 * s3) * v1
        + step * (s3 - s2) * into
}

/// Appendix C.4: along the shorter great circle.
fn slerp(a: DQuat, b: DQuat, s: f64) -> DQuat {
    /// Below this angle the chord is the arc.
    const STRAIGHT: f64 = 1e-6;
    let unit = |q: DQuat| {
        let length = q.length();
        if length > 0.0 && length.is_finite() { q / length } else { DQuat::IDENTITY }
    };
    let (a, b) = (unit(a), unit(b));
    let dot = a.dot(b);
    let b = if dot < 0.0 { -b } else { b };
    let angle = dot.abs().min(1.0).acos();
    let q = if angle < STRAIGHT {
        a * (1.0 - s) + b * s
    } else {
        (a * (angle * (1.0 - s)).sin() + b * (angle * s).sin()) / angle.sin()
    };
    unit(q)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splines_meet_their_ends_with_their_tangents() {
        let f = |s| hermite(2.0, 3.0, -1.0, 5.0, s, 0.5);
        assert_eq!((f(0.0), f(1.0)), (2.0, 5.0));
        let slope = |s: f64| (f(s + 1e-6) - f(s - 1e-6)) / 2e-6 / 0.5;
        assert!((slope(0.0) - 3.0).abs() < 1e-4 && (slope(1.0) + 1.0).abs() < 1e-4);
        // (2 + 5)/2 + 0.5 (3 + 1)/8
        assert!((f(0.5) - 3.75).abs() < 1e-12);
    }

    #[test]
    fn rotations_take_the_shorter_way_at_even_speed() {
        let turn = |degrees: f64| DQuat::from_rotation_y(degrees.to_radians());
        for (from, to, s, expected) in
            [(0.0, 90.0, 0.25, 22.5), (10.0, 10.0, 0.5, 10.0), (170.0, -170.0, 0.5, 180.0)]
        {
            for sign in [1.0, -1.0] {
                let q = slerp(turn(from), turn(to) * sign, s);
                assert!(q.dot(turn(expected)).abs() > 1.0 - 1e-12, "{from} to {to}: {q}");
            }
        }
        assert!(slerp(DQuat::from_array([0.0; 4]), turn(9.0), 0.5).is_finite());
    }
}
