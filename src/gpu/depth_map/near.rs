//! Whether the near rectangle of an eye may be in shadow. The CPU finds, in `f64`, which samples of the map decide this, and
//! a stage reads them. docs/numerics/depth-maps.md, "Near caps".

use glam::DVec4;

use super::view::{Placing, near_columns};
use crate::ShadowCamera;
use crate::layout::DepthNearBox;
use crate::shadow::DepthDirection;

/// By how much the near rectangle is widened: a share of it.
const WIDER: f64 = 1e-4;
/// The distance that rounding to floats may move a point by: a share of the terms that add up to it.
const ROUNDING: f64 = 1e-5;
/// The largest share that distances from the light may be off by, for anything to be told.
const MOST_ROUNDING: f64 = 1e-3;
/// By how much a surface has to be behind it: a share of the depth, and with standard depth a constant.
const BEHIND: f64 = 1e-5;
/// Samples around it: a cell on each side, and one for boundaries that are moved by parts of a texel.
const MARGIN: f64 = 2.0;
/// Cells along the side of a tile of contours, and samples beyond it up to which the flaps of its walls reach.
const TILE: f64 = 16.0;
const FLAP: f64 = 2.0;
/// Samples that are looked at.
const MOST_SAMPLES: u64 = 1 << 16;
/// The range of device depths, in the units of distances, and what these may be off by.
const RANGE: f64 = (1_u32 << 29) as f64;
const DISTANCE_SLACK: i32 = 8;

/// The part of a map that decides whether a near rectangle is in shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NearReach {
    /// No place of it is behind a surface.
    Lit,
    /// Only these samples matter.
    Samples(DepthNearBox),
    /// It has to be looked at.
    Unknown,
}

/// The cameras of one map or of six, texels of each across and down, and the format of the eye's depth. Where contours have walls,
/// all that reaches into a tile matters.
pub(crate) fn near_reach(
    lights: &[ShadowCamera],
    size: [u32; 2],
    (eye, format): (&ShadowCamera, wgpu::TextureFormat),
    has_walls: bool,
) -> NearReach {
    let placing = |border| Placing { border, jitter: [0.0; 2], slope_bias: 0.0 };
    let of = |light: &ShadowCamera, border| {
        let columns = near_columns((light, size), (eye, format), &placing(border));
        Rectangle::project(columns, light.depth)
    };
    if let [light] = lights {
        return match of(light, 1.0) {
            Found::Behind => NearReach::Lit,
            Found::Unknown => NearReach::Unknown,
            Found::Ahead(rectangle) => {
                let rectangle = if has_walls { rectangle.with_tiles() } else { rectangle };
                rectangle.reach([0, 0], size.map(|texels| texels + 1), light.depth)
            }
        };
    }
    // Where it is within one map of a cube, the others do not matter.
    let most = size.map(|texels| texels.saturating_sub(1));
    for (face, light) in (0..).zip(lights) {
        let Found::Ahead(rectangle) = of(light, 0.0) else { continue };
        if rectangle.is_within(most) {
            let corner = [face % 3 * size[0], face / 3 * size[1]];
            return rectangle.reach(corner, most, light.depth);
        }
    }
    NearReach::Unknown
}

/// A near rectangle on the lattice of a map, all of it before the light.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    low: [f64; 2],
    high: [f64; 2],
    /// The device depth that is farthest away from the light.
    farthest: f64,
}

enum Found {
    /// All of it is beside or behind the light.
    Behind,
    Ahead(Rectangle),
    Unknown,
}

impl Rectangle {
    fn project([across, up, middle]: [DVec4; 3], depth: DepthDirection) -> Found {
        let error = ROUNDING * (across.abs() + up.abs() + middle.abs());
        let corner = |x: f64, y: f64| (1.0 + WIDER) * (x * across + y * up) + middle;
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        if !corners.iter().all(|corner| corner.is_finite()) {
            return Found::Unknown;
        }
        if corners.iter().all(|corner| corner.w < -error.w) {
            return Found::Behind;
        }
        let least = corners.iter().map(|corner| corner.w).fold(f64::INFINITY, f64::min) - error.w;
        if least <= 0.0 || error.w > MOST_ROUNDING * least {
            return Found::Unknown;
        }
        // Projected, with what rounding may move it by.
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in corners {
            for axis in 0..3 {
                let at = corner[axis] / corner.w;
                let by = (error[axis] + at.abs() * error.w) / least;
                low[axis] = low[axis].min(at - by);
                high[axis] = high[axis].max(at + by);
            }
        }
        let farthest = if depth == DepthDirection::Reversed { low[2] } else { high[2] };
        Found::Ahead(Self { low: [low[0], low[1]], high: [high[0], high[1]], farthest })
    }

    /// Enlarged to all tiles whose flaps may be before it, with the samples that these reach to.
    fn with_tiles(self) -> Self {
        let low = self.low.map(|at| ((at - FLAP) / TILE).floor() * TILE - FLAP);
        let high = self.high.map(|at| ((at + FLAP) / TILE).floor() * TILE + TILE + FLAP);
        Self { low, high, ..self }
    }

    /// Whether it is between the samples from 0 to `most`.
    fn is_within(&self, most: [u32; 2]) -> bool {
        (0..2).all(|axis| self.low[axis] > MARGIN && self.high[axis] < f64::from(most[axis]) - MARGIN)
    }

    /// `corner` is sample 0 of the map, which has samples up to `most`.
    fn reach(&self, corner: [u32; 2], most: [u32; 2], depth: DepthDirection) -> NearReach {
        if (0..2).any(|axis| self.high[axis] < -MARGIN || self.low[axis] > f64::from(most[axis]) + MARGIN) {
            return NearReach::Lit;
        }
        let (key, distance) = match limit(self.farthest, depth) {
            Limit::BeforeAll => return NearReach::Lit,
            Limit::Unknown => return NearReach::Unknown,
            Limit::Behind { key, distance } => (key, distance),
        };
        let range = [0, 1].map(|axis| {
            let most = f64::from(most[axis]);
            let first = (self.low[axis] - MARGIN).floor().clamp(0.0, most) as u32;
            let last = (self.high[axis] + MARGIN).ceil().clamp(0.0, most) as u32;
            [first, last - first + 1]
        });
        let size = range.map(|[_, count]| count);
        if u64::from(size[0]) * u64::from(size[1]) > MOST_SAMPLES {
            return NearReach::Unknown;
        }
        let first = [0, 1].map(|axis| corner[axis] + range[axis][0]);
        NearReach::Samples(DepthNearBox { first, size, key, distance, unused: [0; 2] })
    }
}

/// The depth that samples are compared with.
enum Limit {
    /// It is nearer to the light than any sample.
    BeforeAll,
    /// A surface that is not nearer than the key, or the distance, is behind it.
    Behind { key: u32, distance: i32 },
    /// It may be behind the far end of the depths.
    Unknown,
}

fn limit(farthest: f64, depth: DepthDirection) -> Limit {
    let one = 1.0_f32.to_bits();
    match depth {
        DepthDirection::Standard => {
            let limit = farthest + BEHIND * (1.0 + farthest.abs());
            if limit < 0.0 {
                return Limit::BeforeAll;
            }
            if limit >= 1.0 - BEHIND || limit.is_nan() {
                return Limit::Unknown;
            }
            let key = (limit as f32).to_bits() + 1;
            Limit::Behind { key, distance: (limit * RANGE) as i32 + DISTANCE_SLACK }
        }
        DepthDirection::Reversed => {
            let limit = farthest - BEHIND * farthest.abs();
            if limit > 1.0 {
                return Limit::BeforeAll;
            }
            if limit < 2.0 * f64::from(f32::MIN_POSITIVE) || limit.is_nan() {
                return Limit::Unknown;
            }
            let key = one - ((limit as f32).to_bits() - 1);
            Limit::Behind { key, distance: ((1.0 - limit) * RANGE).ceil() as i32 + DISTANCE_SLACK }
        }
    }
}
