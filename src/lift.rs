//! Points on a surface, lifted off it towards a light.

use crate::Light;

impl Light {
    /// Moves `point` towards this light by `distance`, and not beyond it: in `f64`, rounded once to `f32`. A query of
    /// occluder counts then does not count a face that the point is on. The move must take it farther from the face
    /// than rounding did. A light low over the face needs a larger distance. Other faces between the point and its new
    /// position do not count either. [`cpu::shadow_depth_on_faces`](crate::cpu::shadow_depth_on_faces) and
    /// [`gpu::QueryPoints`](crate::gpu::QueryPoints) leave a face out exactly.
    ///
    /// A point that is not finite, one at the light, and every point if the light is not finite or the distance not above 0
    /// stay as they are.
    pub fn lift(self, point: [f32; 3], distance: f64) -> [f32; 3] {
        let is_finite = point.iter().chain(&self.to_array()).all(|c| c.is_finite());
        if !is_finite || distance.is_nan() || distance <= 0.0 {
            return point;
        }
        let [p, l] = [point, self.xyz].map(|v| v.map(f64::from));
        let w = f64::from(self.w);
        // In f64 neither quotients nor squares of finite f32 overflow or vanish.
        let towards = if self.w == 0.0 { l } else { [0, 1, 2].map(|axis| l[axis] / w - p[axis]) };
        let length = towards.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length == 0.0 {
            return point;
        }
        let is_all_the_way = self.w != 0.0 && distance >= length;
        [0, 1, 2].map(|axis| {
            let step = towards[axis] / length * distance.min(f64::MAX);
            let moved = if is_all_the_way { l[axis] / w } else { p[axis] + step };
            moved.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_move_towards_the_light_and_not_beyond() {
        let point = [1.0, 2.0, 3.0];
        let above = Light::point([1.0, 2.0, 8.0]);
        assert_eq!(above.lift(point, 0.5), [1.0, 2.0, 3.5]);
        assert_eq!(above.lift(point, 5.0), [1.0, 2.0, 8.0]);
        assert_eq!(above.lift(point, 1e30), [1.0, 2.0, 8.0]);
        assert_eq!(Light::homogeneous([2.0, 4.0, 16.0, 2.0]).lift(point, 0.5), [1.0, 2.0, 3.5]);
        assert_eq!(Light::directional([0.0, -1e-40, 0.0]).lift(point, 4.0), [1.0, -2.0, 3.0]);
        assert_eq!(Light::directional([3e38, 0.0, 0.0]).lift(point, 1.0), [2.0, 2.0, 3.0]);
        assert_eq!(Light::directional([3.0, 4.0, 0.0]).lift([0.0; 3], 5.0), [3.0, 4.0, 0.0]);
        // Rounding swallows a distance below half of what floats are apart.
        assert_eq!(above.lift(point, 1e-9), point);
    }

    #[test]
    fn what_cannot_move_stays() {
        let light = Light::point([1.0, 2.0, 8.0]);
        for distance in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(light.lift([1.0, 2.0, 3.0], distance), [1.0, 2.0, 3.0]);
        }
        assert_eq!(light.lift([1.0, 2.0, 8.0], 1.0), [1.0, 2.0, 8.0], "at the light");
        assert_eq!(light.lift([f32::INFINITY, 0.0, 0.0], 1.0), [f32::INFINITY, 0.0, 0.0]);
        assert_eq!(Light::point([f32::NAN; 3]).lift([1.0; 3], 1.0), [1.0; 3]);
        assert_eq!(Light::directional([1.0, 0.0, 0.0]).lift([f32::MAX, 0.0, 0.0], f64::MAX)[0], f32::MAX);
        assert_eq!(light.lift([0.0; 3], f64::INFINITY), light.xyz);
        assert_eq!(Light::directional([1e-40, 0.0, 0.0]).lift([0.0; 3], f64::INFINITY), [f32::MAX, 0.0, 0.0]);
    }
}
