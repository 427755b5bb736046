//! The box around positions, and where a scene lies.

use std::borrow::Borrow;

use glam::Vec3;

/// The smallest axis-aligned box around some positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The lowest x, y and z.
    pub min: Vec3,
    /// The highest x, y and z.
    pub max: Vec3,
}

impl Bounds {
    /// The box around the finite ones of `positions`. `None` if none is finite.
    pub fn of(positions: impl IntoIterator<Item: Borrow<[f32; 3]>>) -> Option<Self> {
        let positions = positions.into_iter().map(|position| Vec3::from(*position.borrow()));
        let boxes =
            positions.filter(|position| position.is_finite()).map(|position| Self { min: position, max: position });
        boxes.reduce(Self::with)
    }

    /// The box of both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let each = |of: fn(f32, f32) -> f32, a: Vec3, b: Vec3| Vec3::new(of(a.x, b.x), of(a.y, b.y), of(a.z, b.z));
        Self { min: each(f32::min, self.min, other.min), max: each(f32::max, self.max, other.max) }
    }

    /// The middle.
    pub fn centre(&self) -> Vec3 {
        self.min + 0.5 * (self.max - self.min)
    }

    /// The largest side, or 1 for a single point.
    pub fn extent(&self) -> f32 {
        let largest = (self.max - self.min).max_element();
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// The eight corners. Bit `n` of a corner's index tells the side along axis `n`.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|corner| {
            let side = |axis: usize| [self.min, self.max][corner >> axis & 1][axis];
            Vec3::new(side(0), side(1), side(2))
        })
    }

    /// The height of the ground below: the lowest point. Flat models hover, or the ground would be in the same plane.
    pub fn ground(&self) -> f32 {
        let is_flat = self.max.y - self.min.y < 0.01 * self.extent();
        if is_flat { self.min.y - 0.1 * self.extent() } else { self.min.y }
    }
}

/// Where the models and the ground are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneBounds {
    /// The box of the models.
    pub models: Bounds,
    /// The height of the ground.
    pub ground: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_leave_out_what_is_not_finite() {
        let positions = [[1.0, -2.0, 3.0], [f32::NAN, 9.0, 9.0], [-1.0, 4.0, 3.5]];
        let bounds = Bounds::of(positions).expect("two are finite");
        assert_eq!((bounds.min, bounds.max), (Vec3::new(-1.0, -2.0, 3.0), Vec3::new(1.0, 4.0, 3.5)));
        assert_eq!(Bounds::of(&positions[1..2]), None);
    }

    #[test]
    fn a_box_has_eight_corners() {
        let all = Bounds { min: Vec3::new(0.0, 1.0, 2.0), max: Vec3::new(3.0, 4.0, 5.0) }.corners();
        assert_eq!(
            (all[0], all[1], all[7]),
            (Vec3::new(0.0, 1.0, 2.0), Vec3::new(3.0, 1.0, 2.0), Vec3::new(3.0, 4.0, 5.0))
        );
    }
}
