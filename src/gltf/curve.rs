//! Keyframe curves (glTF 2.0, appendix C).

use super::document::{Interpolation, unit};

/// Values over time. The reader (animation.rs) makes sure that there is a key, and that times never decrease. It
/// refuses numbers that are not finite, and keys with a rotation of length 0. Keys of one time are a step: before it the
/// first counts, at it and after it the last.
#[derive(Debug)]
pub(super) struct Curve {
    /// In seconds.
    pub(super) times: Vec<f32>,
    /// The values of all keys, `width` for each. For a cubic spline a key has an in-tangent, a value and an out-tangent
    /// of that width.
    pub(super) values: Vec<f32>,
    pub(super) width: usize,
    pub(super) interpolation: Interpolation,
}

impl Curve {
    /// How many of `values` a key has: three times the width for a cubic spline, else the width.
    pub(super) fn stride(&self) -> usize {
        if self.interpolation == Interpolation::CubicSpline { 3 * self.width } else { self.width }
    }

    /// The curve's `width` values at a time in seconds, which is clamped to the range of the keys. Values of a rotation are
    /// a quaternion of length 1. Between keys of a LINEAR curve it takes the shorter arc. All its components are NaN where a
    /// spline passes through zero.
    pub(super) fn sample(&self, time: f64, is_rotation: bool) -> Vec<f64> {
        let key_value = |key| if is_rotation { normalized(&self.value(key)) } else { self.value(key) };
        let after = self.times.partition_point(|&t| f64::from(t) <= time);
        let Some(key) = after.checked_sub(1) else {
            return key_value(0);
        };
        if after >= self.times.len() || self.interpolation == Interpolation::Step {
            return key_value(key);
        }
        let (start, end) = (f64::from(self.times[key]), f64::from(self.times[after]));
        let interval = end - start;
        let t = (time - start) / interval;
        match self.interpolation {
            Interpolation::CubicSpline => {
                let value = self.spline(key, interval, t);
                if is_rotation { normalized(&value) } else { value }
            }
            _ if is_rotation => slerp(&key_value(key), &key_value(after), t),
            _ => {
                let (a, b) = (key_value(key), key_value(after));
                a.iter().zip(b).map(|(a, b)| a * (1.0 - t) + b * t).collect()
            }
        }
    }

    /// The value of a key, without tangents, as the file has it: a rotation need not have length 1.
    pub(super) fn value(&self, key: usize) -> Vec<f64> {
        self.part(key, usize::from(self.interpolation == Interpolation::CubicSpline)).collect()
    }

    /// A part of a key. A key of a spline has an in-tangent (0), the value (1) and an out-tangent (2), another key the value
    /// (0).
    fn part(&self, key: usize, part: usize) -> impl Iterator<Item = f64> {
        let start = key * self.stride() + part * self.width;
        self.values[start..start + self.width].iter().map(|&value| f64::from(value))
    }

    /// The cubic Hermite spline from `key` to the next, `interval` seconds later, at the fraction `t`. Tangents are per
    /// second.
    fn spline(&self, key: usize, interval: f64, t: f64) -> Vec<f64> {
        let (t2, t3) = (t * t, t * t * t);
        let [starts, ends] =
            [self.part(key, 1).zip(self.part(key, 2)), self.part(key + 1, 1).zip(self.part(key + 1, 0))];
        let mix = |((start, leaving), (end, arriving))| {
            (2.0 * t3 - 3.0 * t2 + 1.0) * start
                + interval * (t3 - 2.0 * t2 + t) * leaving
                + (3.0 * t2 - 2.0 * t3) * end
                + interval * (t3 - t2) * arriving
        };
        starts.zip(ends).map(mix).collect()
    }
}

/// The quaternion with length 1, or NaN in all components if its length is 0.
fn normalized(rotation: &[f64]) -> Vec<f64> {
    let unit = rotation.try_into().ok().and_then(unit);
    unit.map_or(vec![f64::NAN; rotation.len()], |unit| unit.to_array().to_vec())
}

/// Interpolates between two unit quaternions along the shorter arc.
fn slerp(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    let angle = dot.abs().min(1.0).acos();
    // Below this angle the quotient of sines loses more than linear interpolation is off.
    let (from, to) = if angle < 1e-4 {
        (1.0 - t, t)
    } else {
        ((angle * (1.0 - t)).sin() / angle.sin(), (angle * t).sin() / angle.sin())
    };
    let mixed: Vec<f64> = a.iter().zip(b).map(|(a, b)| a * from + sign * b * to).collect();
    normalized(&mixed)
}
