//! Boxes.

use glam::Vec3;

/// A box along the axes, of something that has a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The lowest corner.
    pub min: Vec3,
    /// The highest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The box of finite points. `None` if there are none.
    pub fn of(points: impl IntoIterator<Item = [f32; 3]>) -> Option<Self> {
        let finite = points.into_iter().map(Vec3::from).filter(|point| point.is_finite());
        finite.map(|point| Self { min: point, max: point }).reduce(Self::with)
    }

    /// The box of both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The middle.
    pub fn centre(&self) -> Vec3 {
        self.min + 0.5 * (self.max - self.min)
    }

    /// The largest side, or 1 for a single point.
    pub fn extent(&self) -> f32 {
        let largest = (self.max - self.min).max_element();
        if largest > 0.0 && largest.is_finite() { largest } else { 1.0 }
    }

    /// The eight corners. Bit `n` of a corner's index tells the side along axis `n`.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|corner| {
            let side = |axis: usize| if corner >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            Vec3::new(side(0), side(1), side(2))
        })
    }

    /// The height of the ground below: the lowest point. What is flat hovers, or the ground would be in the same plane.
    pub fn ground(&self) -> f32 {
        let is_flat = self.max.y - self.min.y < 0.01 * self.extent();
        if is_flat { self.min.y - 0.1 * self.extent() } else { self.min.y }
    }
}
