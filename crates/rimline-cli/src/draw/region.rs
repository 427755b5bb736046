//! Where in a target there is anything to do for a model. Elsewhere passes would write what was cleared.

use glam::DVec3;
use rimline::mesh::Bounds;
use rimline::wgpu;

/// A rectangle of pixels: its lower corner, and the one past it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    first: [u32; 2],
    end: [u32; 2],
}

impl Region {
    /// Around pixel positions, `margin` wider on each side, within a target of this size. All of it, if one of them is not
    /// finite.
    pub(super) fn around(places: impl Iterator<Item = [f64; 2]>, margin: f64, size: [u32; 2]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in places {
            if place.iter().any(|c| !c.is_finite()) {
                return Self { first: [0; 2], end: size };
            }
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        // From float to integer is within the range of the integer.
        let first = [0, 1].map(|axis| ((low[axis] - margin).floor() as u32).min(size[axis]));
        let end = [0, 1].map(|axis| ((high[axis] + margin).ceil() as u32).min(size[axis]).max(first[axis]));
        Self { first, end }
    }

    /// Keeps to it what a pass draws from now on. Nothing need be drawn if it returns `false`: there is no pixel.
    pub(super) fn keep(self, pass: &mut wgpu::RenderPass<'_>) -> bool {
        let [width, height] = [0, 1].map(|axis| self.end[axis] - self.first[axis]);
        let is_there = width > 0 && height > 0;
        if is_there {
            pass.set_scissor_rect(self.first[0], self.first[1], width, height);
        }
        is_there
    }
}

/// The corners of a box.
pub(super) fn corners(bounds: &Bounds) -> impl Iterator<Item = DVec3> {
    let sides = [bounds.min, bounds.max].map(|side| DVec3::from(side.map(f64::from)));
    (0..8).map(move |number| DVec3::from([0, 1, 2].map(|axis| sides[number >> axis & 1][axis])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_hold_what_they_are_around_and_stay_in_the_target() {
        let around = |places: &[[f64; 2]], margin| Region::around(places.iter().copied(), margin, [100, 50]);
        let region = |first, end| Region { first, end };
        assert_eq!(around(&[[10.5, 20.0], [30.25, 25.5]], 2.0), region([8, 18], [33, 28]));
        assert_eq!(around(&[[-1e30, 20.0], [1e30, 25.0]], 0.0), region([0, 20], [100, 25]));
        assert_eq!(around(&[[10.0, f64::NAN], [30.0, 25.0]], 0.0), region([0, 0], [100, 50]));
        assert_eq!(around(&[[f64::INFINITY, 1.0]], 0.0), region([0, 0], [100, 50]));
        // Beside the target.
        assert_eq!(around(&[[150.0, 20.0], [160.0, 30.0]], 0.0), region([100, 20], [100, 30]));
    }

    #[test]
    fn a_box_has_eight_corners() {
        let all: Vec<_> = corners(&Bounds { min: [0.0, 1.0, 2.0], max: [3.0, 4.0, 5.0] }).collect();
        assert_eq!(all.len(), 8);
        assert_eq!(
            (all[0], all[1], all[7]),
            (DVec3::new(0.0, 1.0, 2.0), DVec3::new(3.0, 1.0, 2.0), DVec3::new(3.0, 4.0, 5.0))
        );
    }
}
