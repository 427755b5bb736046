//! Samples of lights that have an area, for soft shadows.
//!
//! Up to 32 samples are one batch of lights, so their shadows share one extraction. Placement is deterministic: n-rooks
//! sampling (Shirley 1991), with the golden ratio's sequence as the permutation, which also keeps samples apart.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::{DVec2, DVec3};

use crate::Light;

/// The shape of an area light. Lengths are in the unit of the positions. For a light at infinity they are those at
/// distance 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaShape {
    /// A rectangle whose width is horizontal: at right angles to +Y.
    Rectangle {
        /// Its width.
        width: f32,
        /// Its height.
        height: f32,
    },
    /// A flat disc.
    Disc {
        /// Its radius.
        radius: f32,
    },
    /// A sphere that looks evenly bright from all sides.
    Sphere {
        /// Its radius.
        radius: f32,
    },
}

/// A light with an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// The centre, with `w`, range and cone.
    pub light: Light,
    /// Its shape and size.
    pub shape: AreaShape,
    /// The direction that rectangles and discs face, of any length above 0. It has no meaning for spheres, and for a light at
    /// infinity: that one always faces the scene.
    pub normal: [f32; 3],
}

impl AreaLight {
    /// Spreads `count` lights over the shape. Each stands for an equal share of the light. A single one lies at the
    /// centre. The lights have the range of [`Self::light`], and its cone with each sample as the apex; `w` is 0 for a light
    /// at infinity, else 1, also where it is negative there. Every run gives the same lights.
    pub fn samples(&self, count: usize) -> Vec<Light> {
        self.pattern_samples(count, 0, 1)
    }

    /// The samples of the pattern with the index `pattern` of `patterns`; larger indices start again from 0. All patterns
    /// are equally good, and together they are spread more evenly. Give neighbouring pixels different patterns, so that
    /// soft shadows show no steps. Every run gives the same lights.
    pub fn pattern_samples(&self, count: usize, pattern: usize, patterns: usize) -> Vec<Light> {
        let patterns = patterns.max(1);
        let shift = Shift::new(pattern % patterns, patterns);
        let Light { xyz, w, range, cone } = self.light;
        let xyz = DVec3::from_array(xyz.map(f64::from));
        let (middle, normal) = if w == 0.0 {
            let towards = xyz.normalize_or_zero();
            (towards, towards)
        } else {
            (xyz / f64::from(w), DVec3::from_array(self.normal.map(f64::from)).normalize_or_zero())
        };
        let right = DVec3::Y.cross(normal).try_normalize().unwrap_or(DVec3::X);
        let up = normal.cross(right).try_normalize().unwrap_or(DVec3::Z);
        let light = |(sample, (row, radius)): (usize, (usize, usize))| {
            let offset = match self.shape {
                AreaShape::Rectangle { width, height } => {
                    let at = shift.square([sample, row], count) - 0.5;
                    right * at.x * f64::from(width) + up * at.y * f64::from(height)
                }
                AreaShape::Disc { radius } => {
                    let at = disc(shift.square([sample, row], count)) * f64::from(radius);
                    right * at.x + up * at.y
                }
                AreaShape::Sphere { radius: most } => shift.ball([sample, row], radius, count) * f64::from(most),
            };
            let xyz = (middle + offset).as_vec3().to_array();
            let at = if w == 0.0 { Light::directional(xyz) } else { Light::point(xyz) };
            Light { range, cone, ..at }
        };
        ranks(count, GOLDEN).into_iter().zip(ranks(count, PLASTIC)).enumerate().map(light).collect()
    }
}

/// How far a pattern moves its samples in the unit cube. A sample that leaves the cube on one side enters on the other.
#[derive(Clone, Copy, Debug)]
struct Shift {
    /// Within a sample's column. The patterns divide the column among them.
    column: f64,
    /// Over all rows, and over all radii of a sphere.
    rows: [f64; 2],
    is_only: bool,
}

impl Shift {
    fn new(pattern: usize, patterns: usize) -> Self {
        let rows = [2, 3].map(|base| radical_inverse(pattern, base));
        Self { column: cell(pattern, patterns) - 0.5, rows, is_only: patterns == 1 }
    }

    /// The position in the unit square of the sample in a column and a row. No other sample of the pattern is in either,
    /// like rooks that do not attack each other.
    fn square(self, [column, row]: [usize; 2], count: usize) -> DVec2 {
        let across = cell(column, count) + self.column / count as f64;
        DVec2::new(across, (cell(row, count) + self.rows[0]).fract())
    }

    /// The position in the unit ball of the sample in a column, a row and the shell of number `radius`. The density is
    /// proportional to 1 / √(1 − r²), so the ball's picture is even from every side.
    fn ball(self, square: [usize; 2], radius: usize, count: usize) -> DVec3 {
        if count == 1 && self.is_only {
            return DVec3::ZERO;
        }
        // With r = sin t, the share of samples within r is (2t − sin 2t) / π. Bisection solves it.
        let share = (cell(radius, count) + self.rows[1]).fract();
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        for _ in 0..60 {
            let t: f64 = 0.5 * (low + high);
            if 2.0 * t - (2.0 * t).sin() < share * PI { low = t } else { high = t }
        }
        let at = self.square(square, count);
        let height = 2.0 * at.x - 1.0;
        let around = (1.0 - height * height).sqrt() * DVec2::from_angle(TAU * at.y);
        DVec3::new(around.x, height, around.y) * low.sin()
    }
}

/// The radical inverse: the index's digits after the point in reverse order (van der Corput 1935).
fn radical_inverse(mut index: usize, base: usize) -> f64 {
    let (mut value, mut digit_value) = (0.0, 1.0);
    while index > 0 {
        digit_value /= base as f64;
        value += digit_value * (index % base) as f64;
        index /= base;
    }
    value
}

/// The centre of one of `count` parts of the unit interval.
fn cell(index: usize, count: usize) -> f64 {
    (index as f64 + 0.5) / count as f64
}

/// The reciprocal of the golden ratio. `PLASTIC` is that of the plastic number's square, its counterpart in one more
/// dimension.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
const PLASTIC: f64 = 0.569_840_290_998_053_3;

/// For each of `count` multiples of `step` how many of them have a smaller fraction.
fn ranks(count: usize, step: f64) -> Vec<usize> {
    let fractions: Vec<f64> = (0..count).map(|index| (index as f64 * step).fract()).collect();
    let mut sorted = fractions.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    fractions.iter().map(|fraction| sorted.partition_point(|other| other < fraction)).collect()
}

/// Maps the unit square onto the unit disc and keeps areas and neighbours (Shirley and Chiu 1997).
fn disc(at: DVec2) -> DVec2 {
    let DVec2 { x, y } = 2.0 * at - 1.0;
    if x == 0.0 && y == 0.0 {
        return DVec2::ZERO;
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    radius * DVec2::from_angle(angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cone;

    fn light(shape: AreaShape) -> AreaLight {
        AreaLight { light: Light::homogeneous([2.0, 4.0, 6.0, 2.0]), shape, normal: [0.0, -3.0, 0.1] }
    }

    fn offsets(shape: AreaShape, count: usize) -> Vec<DVec3> {
        let samples = light(shape).samples(count);
        assert!(samples.iter().all(|sample| sample.w == 1.0));
        samples.iter().map(|s| DVec3::from_array(s.xyz.map(f64::from)) - DVec3::new(1.0, 2.0, 3.0)).collect()
    }

    #[test]
    fn rooks_do_not_threaten_each_other() {
        for count in 1..=64 {
            for step in [GOLDEN, PLASTIC] {
                let mut ranks = ranks(count, step);
                ranks.sort_unstable();
                assert!(ranks.into_iter().eq(0..count), "{count} samples");
            }
        }
    }

    /// Pair by pair, a million would take hours.
    #[test]
    fn ranks_count_smaller_fractions_of_many_samples() {
        for step in [GOLDEN, PLASTIC] {
            let fraction = |index: usize| (index as f64 * step).fract();
            for count in [1, 5, 32, 1 << 20] {
                for (sample, &rank) in ranks(count, step).iter().enumerate().take(8) {
                    let smaller = (0..count).filter(|&other| fraction(other) < fraction(sample)).count();
                    assert_eq!(rank, smaller, "sample {sample} of {count}");
                }
            }
        }
    }

    /// The square's map onto the disc fills it evenly, by angle and by distance, and keeps neighbours.
    #[test]
    fn the_disc_is_filled_evenly_and_without_seams() {
        const STEPS: usize = 240;
        let at = |x: usize, y: usize| disc(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / STEPS as f64);
        let mut sectors = [[0_usize; 24]; 4];
        let mut farthest = 0.0_f64;
        for x in 0..STEPS {
            for y in 0..STEPS {
                let point = at(x, y);
                let angle = (point.y.atan2(point.x) / TAU).rem_euclid(1.0);
                // Rings of equal area.
                sectors[(4.0 * point.length_squared()) as usize][(24.0 * angle) as usize] += 1;
                if x > 0 {
                    farthest = farthest.max(point.distance(at(x - 1, y)));
                }
                if y > 0 {
                    farthest = farthest.max(point.distance(at(x, y - 1)));
                }
            }
        }
        let even = STEPS * STEPS / (4 * 24);
        for &found in sectors.as_flattened() {
            assert!(found.abs_diff(even) < even / 10, "{found} places in a part for {even}: {sectors:?}");
        }
        // A step is 2 / STEPS in the square, and the map turns and stretches it by no more than 1.6.
        assert!(farthest < 3.2 / STEPS as f64, "neighbours are {farthest} apart");
    }

    #[test]
    fn samples_lie_within_their_shapes_and_fill_them() {
        let count = 32;
        let flat = DVec3::new(0.0, -3.0, 0.1).normalize();
        for at in offsets(AreaShape::Rectangle { width: 2.0, height: 1.0 }, count) {
            assert!(at.dot(flat).abs() < 1e-6 && at.x.abs() < 1.0 && at.z.abs() < 0.5);
        }
        let disc = offsets(AreaShape::Disc { radius: 0.5 }, count);
        assert!(disc.iter().all(|at| at.dot(flat).abs() < 1e-6 && at.length() < 0.5));
        // Half of a disc's area lies within 0.71 of its radius.
        let inner = disc.iter().filter(|at| at.length() < 0.5 * 0.5_f64.sqrt()).count();
        assert!(inner.abs_diff(count / 2) <= 2, "{inner}");
        // The picture of a ball: half of its area, too.
        for axis in [DVec3::X, DVec3::Y, DVec3::new(0.6, 0.0, 0.8)] {
            let ball = offsets(AreaShape::Sphere { radius: 0.5 }, 512);
            assert!(ball.iter().all(|at| at.length() <= 0.5 + 1e-6));
            let inner = ball.iter().filter(|at| at.reject_from(axis).length() < 0.5 * 0.5_f64.sqrt()).count();
            assert!(inner.abs_diff(256) <= 26, "{axis}: {inner}");
        }
    }

    #[test]
    fn the_middle_of_all_samples_is_that_of_the_shape() {
        let shapes = [
            AreaShape::Rectangle { width: 1.0, height: 1.0 },
            AreaShape::Disc { radius: 0.5 },
            AreaShape::Sphere { radius: 0.5 },
        ];
        for shape in shapes {
            for count in [1, 5, 16, 32] {
                let middle = offsets(shape, count).into_iter().sum::<DVec3>() / count as f64;
                assert!(middle.length() < 0.4 / count as f64, "{shape:?}, {count}: {middle}");
            }
            assert_eq!(light(shape).samples(7), light(shape).samples(7));
        }
    }

    #[test]
    fn patterns_are_spread_together() {
        // The largest difference between `share` and the share of samples on one side of a line, over many lines
        // through the shape.
        let worst = |shape, patterns: usize, share: &dyn Fn(f64) -> f64| {
            let all: Vec<DVec3> = (0..patterns)
                .flat_map(|pattern| light(shape).pattern_samples(32, pattern, patterns))
                .map(|sample| DVec3::from_array(sample.xyz.map(f64::from)) - DVec3::new(1.0, 2.0, 3.0))
                .collect();
            let mut worst = 0.0_f64;
            for degrees in 0..180 {
                let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
                for step in -9..=9 {
                    let line = 0.1 * f64::from(step);
                    let below = all.iter().filter(|at| at.x * cosine + at.z * sine < line).count();
                    worst = worst.max((below as f64 / all.len() as f64 - share(line)).abs());
                }
            }
            worst
        };
        let chord = |x: f64| 0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / PI;
        for shape in [AreaShape::Disc { radius: 1.0 }, AreaShape::Sphere { radius: 1.0 }] {
            let (one, together) = (worst(shape, 1, &chord), worst(shape, 16, &chord));
            assert!(together < 0.03, "{shape:?}: {together} of the samples are on the wrong side");
            assert!(one > 0.05, "{shape:?}: one pattern alone is as even: {one}");
        }
    }

    #[test]
    fn samples_have_the_range_and_the_cone() {
        let cone = Cone::new([0.0, -1.0, 0.0], 0.5);
        let spot = Light::point([0.0, 4.0, 0.0]).with_range(9.0).with_cone(cone);
        let lamp = AreaLight { light: spot, shape: AreaShape::Disc { radius: 0.1 }, normal: [0.0, -1.0, 0.0] };
        for sample in lamp.samples(8) {
            assert_eq!((sample.range, sample.cone), (9.0, Some(cone)));
        }
    }

    #[test]
    fn lights_at_infinity_stay_there() {
        let shape = AreaShape::Disc { radius: 0.1 };
        let sun = AreaLight { light: Light::directional([0.0, 9.0, 0.0]), shape, normal: [1.0, 0.0, 0.0] };
        for sample in sun.samples(8) {
            let [x, y, z] = sample.xyz;
            assert!(sample.w == 0.0 && (y - 1.0).abs() < 1e-6 && x.hypot(z) < 0.1);
        }
    }
}
