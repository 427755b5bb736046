//! The part of a face that is in a leaf of `tree.rs`, or a little more: docs/numerics/occluded-faces.md.

use super::plane::Plane;

/// The most corners. A cut that needs more is not made.
const MOST: usize = 10;
/// The most cuts, each of which adds rounding.
const CUTS: u8 = 64;
/// The most that a corner is off the face along an axis, relative to the face's largest coordinate. A cut adds three
/// roundings.
const SLACK: f64 = 4.0 * CUTS as f64 * f64::EPSILON;

/// A convex polygon that contains a part of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clipped {
    corners: [[f64; 3]; MOST],
    count: u8,
    cuts: u8,
    /// Each corner is at most so far from a point of the face, along each axis.
    off: f64,
}

impl Clipped {
    /// All of a face.
    pub(crate) fn whole(face: [[f32; 3]; 3]) -> Self {
        let largest = face.as_flattened().iter().fold(0.0_f32, |largest, c| largest.max(c.abs()));
        let mut corners = [[0.0; 3]; MOST];
        for (corner, of) in corners.iter_mut().zip(face) {
            *corner = of.map(f64::from);
        }
        Self { corners, count: 3, cuts: 0, off: SLACK * f64::from(largest) }
    }

    fn corners(&self) -> &[[f64; 3]] {
        self.corners.get(..usize::from(self.count)).unwrap_or_default()
    }

    /// Whether all of it is certainly on `side` (1 or −1) of the plane, and not on the plane.
    pub(crate) fn is_on(&self, plane: &Plane, side: i32) -> bool {
        self.corners().iter().all(|&corner| {
            let (value, error) = plane.value(corner, self.off);
            f64::from(side) * value > error
        })
    }

    /// The part that may be on `side` (1 or −1) of the plane, or on the plane. `None` if there is none.
    pub(crate) fn cut(&self, plane: &Plane, side: i32) -> Option<Self> {
        // The largest possible heights on `side`: a corner below zero is certainly on the other side.
        let mut heights = [0.0; MOST];
        for (height, &corner) in heights.iter_mut().zip(self.corners()) {
            let (value, error) = plane.value(corner, self.off);
            *height = f64::from(side) * value + error;
        }
        let count = usize::from(self.count);
        let kept = heights.iter().take(count).filter(|height| **height >= 0.0).count();
        if kept == 0 {
            return None;
        }
        if kept == count || self.cuts == CUTS {
            return Some(*self);
        }
        let mut cut = Self { count: 0, cuts: self.cuts + 1, ..*self };
        for at in 0..count {
            let next = if at + 1 < count { at + 1 } else { 0 };
            let (from, to) = (self.corners[at], self.corners[next]);
            let is_kept = [heights[at] >= 0.0, heights[next] >= 0.0];
            if is_kept[0] {
                cut.push(from);
            }
            if is_kept[0] != is_kept[1] {
                let [inner, outer] = if is_kept[0] { [at, next] } else { [next, at] };
                let (from, to) = if is_kept[0] { (from, to) } else { (to, from) };
                // At the crossing or beyond it.
                let part = heights[inner] / (heights[inner] - heights[outer]);
                let part = (part * (1.0 + 8.0 * f64::EPSILON)).min(1.0);
                cut.push(std::array::from_fn(|axis| from[axis] + part * (to[axis] - from[axis])));
            }
        }
        Some(if usize::from(cut.count) > MOST { *self } else { cut })
    }

    /// Adds a corner. Without room only the count grows.
    fn push(&mut self, corner: [f64; 3]) {
        if let Some(next) = self.corners.get_mut(usize::from(self.count)) {
            *next = corner;
        }
        self.count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By rounding, a sliver may cross a plane more than twice.
    #[test]
    fn a_cut_that_has_no_room_for_all_corners_is_not_made() {
        let plane = Plane::of_face([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let mut part = Clipped { count: 0, ..Clipped::whole([[0.0; 3]; 3]) };
        for corner in 0..9 {
            part.push([f64::from(corner), 0.0, if corner % 3 == 2 { -1.0 } else { 1.0 }]);
        }
        assert_eq!(part.cut(&plane, 1).map(|cut| cut.corners().to_vec()), Some(part.corners().to_vec()));
    }
}
