//! Places of contours against rims that are known exactly.

use bytemuck::Zeroable;
use rimline::reference::cpu::{ContourMap, Samples, contour_marks, contour_places};
use rimline::reference::layout::ContourShape;
use rimline_measure::is_long;
use rimline_measure::random::Random;

use crate::maps::Map;

const SIDE: u32 = 96;

/// Body that a map shows before a ground.
#[derive(Clone, Copy, Debug)]
enum Body {
    /// Round towards the light: its depths tell of its rim.
    Ellipsoid,
    /// Flat, with a round border: only its run tells.
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

    fn depth(&self, place: [f64; 2]) -> f64 {
        let inside = self.inside(place);
        if inside <= 0.0 {
            return 0.9;
        }
        let height = if matches!(self.body, Body::Ellipsoid) { 0.2 * inside.sqrt() } else { 0.0 };
        0.5 + self.slopes[0] * (place[0] - 48.0) + self.slopes[1] * (place[1] - 48.0) - height
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
            let mut place = at.map(|at| f64::from(at) - 0.5);
            place[axis] += along;
            self.inside(place) > 0.0
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = f64::midpoint(low, high);
            if on(middle) == on(0.0) { low = middle } else { high = middle }
        }
        low
    }
}

/// Errors of places, in texels.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    edges: usize,
    sum: f64,
}

impl Errors {
    fn add(&mut self, place: u32, truth: f64) {
        self.edges += 1;
        self.sum += (f64::from(place) / 65_536.0 - truth).abs();
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

/// A map as a format holds it: steps of its depths, or none.
fn rounded(map: &Map, steps: Option<f64>) -> Map {
    let round = |depth: &f32| steps.map_or(*depth, |steps| ((f64::from(*depth) * steps).round() / steps) as f32);
    Map { depths: map.depths.iter().map(round).collect(), ..*map }
}

/// How contours are found in such maps.
fn contour(precision: i32) -> ContourShape {
    let tiles = SIDE / 16 + 1;
    ContourShape {
        tiles: [tiles, tiles * tiles],
        words: (SIDE + 2).div_ceil(16),
        threshold: 1 << 18,
        sure: 1 << 22,
        slope_bias: 128,
        constant: precision,
        ..ContourShape::zeroed()
    }
}

#[test]
fn contours_lie_on_rims() {
    const SEED: u64 = 1691;
    println!("seed {SEED}");
    let mut random = Random::new(SEED);
    for body in [Body::Ellipsoid, Body::Disc, Body::HalfPlane] {
        let [mut own, mut middles, mut mirrored] = [Errors::default(); 3];
        for round in 0..if is_long() { 400 } else { 30 } {
            let placed = Placed::random(body, &mut random);
            // Floats, 24 bits and 16 bits. The precision of a format is four of its steps.
            let (steps, precision) = [(None, 128), (Some(16_777_215.0), 128), (Some(65_535.0), 1 << 15)][round % 3];
            let given = rounded(&placed.map(round % 2 == 1), steps);
            let (shape, contour) = (given.shape(0.0005, u32::MAX), contour(precision));
            let samples = Samples { shape: &shape, depths: &given.depths, objects: &[] };
            let map = ContourMap { samples: &samples, shape: &contour };
            let places = contour_places(&map, &contour_marks(&map));
            for (sample, place) in (0..).zip(places) {
                let at = [sample % (SIDE + 2), sample / (SIDE + 2)];
                for axis in [0, 1] {
                    let place = place >> (16 * axis) & 0xffff;
                    // The outermost edges lead out of the map.
                    if place == 0 || at.iter().any(|&at| !(2..SIDE - 1).contains(&at)) {
                        continue;
                    }
                    let truth = placed.crossing(at, axis);
                    own.add(place, truth);
                    middles.add(32_768, truth);
                    mirrored.add(65_536 - place, truth);
                }
            }
        }
        println!(
            "{body:?}: {} edges, {:.4} off in the mean, {:.4} their middles",
            own.edges,
            own.mean(),
            middles.mean()
        );
        assert_eq!(own.check(body), Ok(()));
        assert!(middles.check(body).is_err(), "{body:?}: the middles of edges went unnoticed");
        assert!(mirrored.check(body).is_err(), "{body:?}: the other side of edges went unnoticed");
    }
}
