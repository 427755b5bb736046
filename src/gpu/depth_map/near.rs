//! Whether the near rectangle of an eye may be in shadow. The CPU finds, in `f64`, the samples of the map that decide this,
//! and a stage reads them. docs/numerics/depth-maps.md, "Near caps".

use glam::DVec4;

use super::view::{Placing, near_columns};
use crate::ShadowCamera;
use crate::layout::DepthNearBox;
use crate::shadow::DepthDirection;

/// The near rectangle is widened by this share of its size.
const WIDENING: f64 = 1e-4;
/// Rounding to floats moves a coordinate by at most this share of the sum of its terms' absolute values.
const ROUNDING: f64 = 1e-5;
/// If distances from the light may be off by a larger share, the result is unknown.
const MAX_ROUNDING: f64 = 1e-3;
/// A surface is behind the rectangle if it is farther by this share of the depth; with standard depth, by this constant as
/// well.
const BEHIND: f64 = 1e-5;
/// Samples around the rectangle: a cell on each side, and one for jitter.
const MARGIN: f64 = 2.0;
/// Cells along the side of a tile of contours, and samples by which flaps of walls extend beyond it.
const TILE: f64 = 16.0;
const FLAP: f64 = 2.0;
/// The most samples that the stage reads.
const MAX_SAMPLES: u64 = 1 << 16;
/// The range of device depths, in units of distances, and the error of a distance.
const RANGE: f64 = (1_u32 << 29) as f64;
const DISTANCE_SLACK: i32 = 8;

/// Why no samples of a map have to be read for a near rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NearShadow {
    /// No point of the rectangle is behind a surface, for any depths.
    Lit,
    /// Samples do not decide, and the near cap has to be drawn.
    Unknown,
}

/// Finds the samples that decide whether a near rectangle is in shadow, if any do. `lights`: the cameras of one map or
/// of six, of `size` texels each. `format`: that of the eye's depth. `has_walls`: the method has contours, so walls and
/// flaps of whole tiles count.
pub(crate) fn near_shadow(
    lights: &[ShadowCamera],
    size: [u32; 2],
    (eye, format): (&ShadowCamera, wgpu::TextureFormat),
    has_walls: bool,
) -> Result<DepthNearBox, NearShadow> {
    let project = |light: &ShadowCamera, border| {
        let placing = Placing { border, jitter: [0.0; 2], slope_bias: 0.0 };
        Rectangle::project(near_columns((light, size), (eye, format), &placing), light.depth)
    };
    if let [light] = lights {
        let rectangle = project(light, 1.0)?;
        let rectangle = if has_walls { rectangle.with_tiles() } else { rectangle };
        return rectangle.samples([0, 0], size.map(|texels| texels + 1), light.depth);
    }
    // If the rectangle is within one map of a cube, the others do not affect it.
    let last = size.map(|texels| texels.saturating_sub(1));
    for (face, light) in (0..).zip(lights) {
        let Ok(rectangle) = project(light, 0.0) else { continue };
        if rectangle.is_within(last) {
            let corner = [face % 3 * size[0], face / 3 * size[1]];
            return rectangle.samples(corner, last, light.depth);
        }
    }
    Err(NearShadow::Unknown)
}

/// The box of a near rectangle on the lattice of a map. The whole rectangle is before the light.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    low: [f64; 2],
    high: [f64; 2],
    /// The device depth that is farthest away from the light.
    farthest: f64,
}

impl Rectangle {
    /// It is lit if all of it is beside or behind the light.
    fn project([across, up, middle]: [DVec4; 3], depth: DepthDirection) -> Result<Self, NearShadow> {
        let error = ROUNDING * (across.abs() + up.abs() + middle.abs());
        let corner = |x: f64, y: f64| (1.0 + WIDENING) * (x * across + y * up) + middle;
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        if !corners.iter().all(|corner| corner.is_finite()) {
            return Err(NearShadow::Unknown);
        }
        if corners.iter().all(|corner| corner.w < -error.w) {
            return Err(NearShadow::Lit);
        }
        let min_w = corners.iter().map(|corner| corner.w).fold(f64::INFINITY, f64::min) - error.w;
        if min_w <= 0.0 || error.w > MAX_ROUNDING * min_w {
            return Err(NearShadow::Unknown);
        }
        // The box of the corners, widened by rounding.
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in corners {
            for axis in 0..3 {
                let coordinate = corner[axis] / corner.w;
                let rounding = (error[axis] + coordinate.abs() * error.w) / min_w;
                low[axis] = low[axis].min(coordinate - rounding);
                high[axis] = high[axis].max(coordinate + rounding);
            }
        }
        let farthest = if depth == DepthDirection::Reversed { low[2] } else { high[2] };
        Ok(Self { low: [low[0], low[1]], high: [high[0], high[1]], farthest })
    }

    /// Enlarged to all tiles whose flaps may cover it, and to the samples of those flaps.
    fn with_tiles(self) -> Self {
        let low = self.low.map(|at| ((at - FLAP) / TILE).floor() * TILE - FLAP);
        let high = self.high.map(|at| ((at + FLAP) / TILE).floor() * TILE + TILE + FLAP);
        Self { low, high, ..self }
    }

    /// Whether it is between sample 0 and sample `last`.
    fn is_within(&self, last: [u32; 2]) -> bool {
        (0..2).all(|axis| self.low[axis] > MARGIN && self.high[axis] < f64::from(last[axis]) - MARGIN)
    }

    /// `corner`: sample 0 of the map. `last`: its last sample, counted from there.
    fn samples(&self, corner: [u32; 2], last: [u32; 2], depth: DepthDirection) -> Result<DepthNearBox, NearShadow> {
        if (0..2).any(|axis| self.high[axis] < -MARGIN || self.low[axis] > f64::from(last[axis]) + MARGIN) {
            return Err(NearShadow::Lit);
        }
        let (key, distance) = limit(self.farthest, depth)?;
        let range = [0, 1].map(|axis| {
            let last_sample = f64::from(last[axis]);
            let first = (self.low[axis] - MARGIN).floor().clamp(0.0, last_sample) as u32;
            let last = (self.high[axis] + MARGIN).ceil().clamp(0.0, last_sample) as u32;
            [first, last - first + 1]
        });
        let size = range.map(|[_, count]| count);
        if u64::from(size[0]) * u64::from(size[1]) > MAX_SAMPLES {
            return Err(NearShadow::Unknown);
        }
        let first = [0, 1].map(|axis| corner[axis] + range[axis][0]);
        Ok(DepthNearBox { first, size, key, distance, unused: [0; 2] })
    }
}

/// The key and the distance that samples are compared with: a surface with a larger one is behind the rectangle. The
/// rectangle is lit if it is nearer to the light than any sample, and unknown if it may be beyond the far end of depths.
fn limit(farthest: f64, depth: DepthDirection) -> Result<(u32, i32), NearShadow> {
    let one = 1.0_f32.to_bits();
    match depth {
        DepthDirection::Standard => {
            let limit = farthest + BEHIND * (1.0 + farthest.abs());
            if limit < 0.0 {
                return Err(NearShadow::Lit);
            }
            if limit >= 1.0 - BEHIND || limit.is_nan() {
                return Err(NearShadow::Unknown);
            }
            Ok(((limit as f32).to_bits() + 1, (limit * RANGE) as i32 + DISTANCE_SLACK))
        }
        DepthDirection::Reversed => {
            let limit = farthest - BEHIND * farthest.abs();
            if limit > 1.0 {
                return Err(NearShadow::Lit);
            }
            if limit < 2.0 * f64::from(f32::MIN_POSITIVE) || limit.is_nan() {
                return Err(NearShadow::Unknown);
            }
            let key = one - ((limit as f32).to_bits() - 1);
            Ok((key, ((1.0 - limit) * RANGE).ceil() as i32 + DISTANCE_SLACK))
        }
    }
}
