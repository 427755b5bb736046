//! Crossings of contours by `contour_crossings` against rims that are known exactly.

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat;

use crate::contours::{Fit, Traced, rounded};
use crate::maps::Map;

pub(crate) const TESTS: &[Test] = &[("contours_lie_on_rims", on_rims)];

const SIDE: u32 = 96;

/// Body that a map shows before a ground.
#[derive(Clone, Copy, Debug)]
enum Body {
    /// Round towards the light: its depths determine its rim.
    Ellipsoid,
    /// Flat, with a round border: only its border determines it.
    Disc,
    /// Flat, with a straight border.
    HalfPlane,
}

/// A body in a map, in texels.
#[derive(Clone, Copy, Debug)]
struct Placed {
    body: Body,
    middle: [f64; 2],
    /// The axis of the ellipse, or what is at right angles to the border.
    axis: [f64; 2],
    radii: [f64; 2],
    /// The slope of the body along x and y.
    slopes: [f64; 2],
}

impl Placed {
    fn random(body: Body, random: &mut Random) -> Self {
        let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
        let angle = between(0.0, std::f32::consts::TAU);
        Self {
            body,
            middle: [between(40.0, 56.0), between(40.0, 56.0)],
            axis: [angle.cos(), angle.sin()],
            radii: [between(12.0, 36.0), between(12.0, 36.0)],
            slopes: [between(-0.001, 0.001), between(-0.001, 0.001)],
        }
    }

    /// More than 0 within the body. The square of the height, of an ellipsoid.
    fn inside(&self, [x, y]: [f64; 2]) -> f64 {
        let [x, y] = [x - self.middle[0], y - self.middle[1]];
        let along = x * self.axis[0] + y * self.axis[1];
        let across = y * self.axis[0] - x * self.axis[1];
        match self.body {
            Body::HalfPlane => along,
            Body::Ellipsoid | Body::Disc => 1.0 - (along / self.radii[0]).powi(2) - (across / self.radii[1]).powi(2),
        }
    }

    fn depth(&self, position: [f64; 2]) -> f64 {
        let inside = self.inside(position);
        if inside <= 0.0 {
            return 0.9;
        }
        let height = if matches!(self.body, Body::Ellipsoid) { 0.2 * inside.sqrt() } else { 0.0 };
        0.5 + self.slopes[0] * (position[0] - 48.0) + self.slopes[1] * (position[1] - 48.0) - height
    }

    fn map(&self, is_reversed: bool) -> Map {
        Map::new([SIDE; 2], is_reversed, |texel| {
            let depth = self.depth([texel % SIDE, texel / SIDE].map(|at| f64::from(at) + 0.5));
            if is_reversed { 1.0 - depth as f32 } else { depth as f32 }
        })
    }

    /// Where the border is on an edge, in parts of a texel from its first sample on.
    fn crossing(&self, at: [u32; 2], axis: usize) -> f64 {
        let on = |along: f64| {
            let mut position = at.map(|at| f64::from(at) - 0.5);
            position[axis] += along;
            self.inside(position) > 0.0
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = f64::midpoint(low, high);
            if on(middle) == on(0.0) { low = middle } else { high = middle }
        }
        low
    }
}

/// Errors of crossings, in texels.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    edges: usize,
    sum: f64,
}

impl Errors {
    fn add(&mut self, crossing: u32, truth: f64) {
        self.edges += 1;
        self.sum += (f64::from(crossing) / 65_536.0 - truth).abs();
    }

    fn mean(&self) -> f64 {
        self.sum / self.edges.max(1) as f64
    }

    fn check(&self, body: Body) -> Result<(), String> {
        // The middle of an edge is a fourth of a texel off in the mean.
        let most = match body {
            Body::Ellipsoid => 0.03,
            Body::Disc => 0.13,
            Body::HalfPlane => 0.095,
        };
        if self.edges > 1000 && self.mean() < most {
            Ok(())
        } else {
            Err(format!("{body:?}: {} edges are {:.4} texels off in the mean, most is {most}", self.edges, self.mean()))
        }
    }
}

fn on_rims() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1691)?;
    // Segments go through the crossings that they join, so these move by rounding to 1/256 texel alone.
    let fit = Fit { threshold: 1.0 / 2048.0, sideways: 0.0, depth: 0.0, slope_bias: 1.0 };
    for body in [Body::Ellipsoid, Body::Disc, Body::HalfPlane] {
        let [mut found, mut middles, mut mirrored] = [Errors::default(); 3];
        for round in 0..if is_long() { 400 } else { 30 } {
            let placed = Placed::random(body, &mut random);
            let formats = [TextureFormat::R32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];
            let map = rounded(&placed.map(round % 2 == 1), formats[round % 3]);
            let traced = Traced::new(&gpu, &map, fit, Some(formats[round % 3]))?;
            let words: Vec<u32> = gpu.read(&traced.crossings, ((SIDE + 2) * (SIDE + 2)) as usize)?;
            for (sample, word) in (0..).zip(words) {
                let at = [sample % (SIDE + 2), sample / (SIDE + 2)];
                for axis in [0, 1] {
                    let crossing = word >> (16 * axis) & 0xffff;
                    // The outermost edges lead out of the map.
                    if crossing == 0 || at.iter().any(|&at| !(2..SIDE - 1).contains(&at)) {
                        continue;
                    }
                    let truth = placed.crossing(at, axis);
                    found.add(crossing, truth);
                    middles.add(32_768, truth);
                    mirrored.add(65_536 - crossing, truth);
                }
            }
        }
        println!(
            "{body:?}: {} edges, {:.4} off in the mean, {:.4} their middles",
            found.edges,
            found.mean(),
            middles.mean()
        );
        found.check(body)?;
        must_fail("the middles of edges", &middles.check(body))?;
        must_fail("the other side of edges", &mirrored.check(body))?;
    }
    Ok(())
}
