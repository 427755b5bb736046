//! Arithmetic with the freedoms of rounding that WGSL leaves an implementation, and the stages' `f32` formulas in it.

use rimline::Light;

use rimline::internals::cpu::UNDERFLOW;
use rimline::internals::layout::LightBatch;
use rimline_testkit::random::Random;

/// The two floats around a number, the same twice where it is one.
pub(crate) fn neighbours(exact: f64) -> [f32; 2] {
    let near = exact as f32;
    match f64::from(near).partial_cmp(&exact) {
        Some(std::cmp::Ordering::Less) => [near, near.next_up()],
        Some(std::cmp::Ordering::Greater) => [near.next_down(), near],
        _ => [near, near],
    }
}

/// Which neighbour of an exact value is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rounding {
    Up,
    Down,
    TowardsZero,
    Nearest,
    ByChance,
    /// The one that makes the result larger, or smaller: the worst that can be, operation by operation.
    Larger,
    Smaller,
}

/// Whether a liberty is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Taken {
    Never,
    Always,
    ByChance,
}

/// An implementation: how it rounds, fuses and flushes.
pub(crate) struct RoundingModels {
    random: Random,
    rounding: Rounding,
    fusing: Taken,
    flushing: Taken,
}

impl RoundingModels {
    pub(crate) fn new(seed: u64) -> Self {
        let random = Random::new(seed);
        Self { random, rounding: Rounding::ByChance, fusing: Taken::ByChance, flushing: Taken::ByChance }
    }

    /// Another implementation.
    pub(crate) fn change(&mut self) {
        use Rounding::{ByChance, Down, Larger, Nearest, Smaller, TowardsZero, Up};
        const ROUNDINGS: [Rounding; 9] = [Up, Down, TowardsZero, Nearest, ByChance, Larger, Larger, Smaller, Smaller];
        const TAKEN: [Taken; 3] = [Taken::Never, Taken::Always, Taken::ByChance];
        self.rounding = ROUNDINGS[self.random.below(ROUNDINGS.len())];
        self.fusing = TAKEN[self.random.below(3)];
        self.flushing = TAKEN[self.random.below(3)];
    }

    fn takes(&mut self, liberty: Taken) -> bool {
        match liberty {
            Taken::Never => false,
            Taken::Always => true,
            Taken::ByChance => self.random.next_u64() >> 63 != 0,
        }
    }

    fn flush(&mut self, value: f32) -> f32 {
        if value.is_subnormal() && self.takes(self.flushing) { 0.0 } else { value }
    }

    /// Whether the upper neighbour of an exact value is taken, on whose growth the result depends with the sign of `effect`.
    fn rounds_up(&mut self, exact: f64, above: f32, effect: f64) -> bool {
        match self.rounding {
            Rounding::Up => true,
            Rounding::Down => false,
            Rounding::TowardsZero => exact < 0.0,
            Rounding::Nearest => exact as f32 == above,
            Rounding::ByChance => self.takes(Taken::ByChance),
            Rounding::Larger => effect > 0.0,
            Rounding::Smaller => effect < 0.0,
        }
    }

    fn round(&mut self, exact: f64, effect: f64) -> f32 {
        let [below, above] = neighbours(exact);
        let rounded = if self.rounds_up(exact, above, effect) { above } else { below };
        self.flush(rounded)
    }

    /// x / y, of numbers that are not negative. It may be off by 2.5 units in the last place.
    pub(crate) fn quotient(&mut self, x: f32, y: f32, effect: f64) -> f32 {
        let (x, y) = (self.flush(x), self.flush(y));
        if x == 0.0 {
            return 0.0;
        }
        let exact = f64::from(x) / f64::from(y);
        let [below, above] = neighbours(exact);
        let is_up = self.rounds_up(exact, above, effect);
        let beyond = |near: f32| if is_up { near.next_up() } else { near.next_down() };
        let once = beyond(if is_up { above } else { below });
        let unit = f64::from((exact as f32).next_up()) - f64::from(exact as f32);
        let is_allowed = |found: f32| (f64::from(found) - exact).abs() <= 2.5 * unit;
        self.flush(if is_allowed(beyond(once)) { beyond(once) } else { once })
    }

    pub(crate) fn sum(&mut self, x: f32, y: f32, effect: f64) -> f32 {
        let (x, y) = (self.flush(x), self.flush(y));
        self.round(f64::from(x) + f64::from(y), effect)
    }

    /// x·y + z, fused or not; its growth and its product's have the same effect.
    pub(crate) fn product_sum(&mut self, x: f32, y: f32, z: f32, effect: f64) -> f32 {
        let (x, y) = (self.flush(x), self.flush(y));
        let product = f64::from(x) * f64::from(y);
        if self.takes(self.fusing) {
            let z = self.flush(z);
            self.round(product + f64::from(z), effect)
        } else {
            let product = self.round(product, effect);
            self.sum(product, z, effect)
        }
    }

    /// a·d − b·c, either product first.
    fn cross(&mut self, [a, b]: [f32; 2], [c, d]: [f32; 2], effect: f64) -> f32 {
        if self.random.next_u64() >> 63 != 0 {
            let second = self.product_sum(-b, c, 0.0, effect);
            self.product_sum(a, d, second, effect)
        } else {
            let first = self.product_sum(a, d, 0.0, effect);
            self.product_sum(-b, c, first, effect)
        }
    }

    /// The determinant of the facing stage, `wgsl/extract/facing.wgsl`; the light scaled as there.
    pub(crate) fn determinant(&mut self, [a, b, c]: [[f32; 3]; 3], light: Light) -> f32 {
        let [x, y, z, w] = LightBatch::new(&[light], 0, 3).lights[0];
        let l = [x, y, z];
        // The result is u · (v × t) = v · (t × u) = t · (u × v): what each is multiplied by is its effect.
        let exact = |p: [f32; 3], factor: f32, q: [f32; 3]| -> [f64; 3] {
            std::array::from_fn(|i| f64::from(p[i]) - f64::from(factor) * f64::from(q[i]))
        };
        let [u, v, t] = [exact(b, 1.0, a), exact(c, 1.0, a), exact(l, w, a)];
        let [for_u, for_v, for_t] = [cross_product(v, t), cross_product(t, u), cross_product(u, v)];
        let for_n = t;
        let u: [f32; 3] = std::array::from_fn(|i| self.sum(b[i], -a[i], for_u[i]));
        let v: [f32; 3] = std::array::from_fn(|i| self.sum(c[i], -a[i], for_v[i]));
        let t: [f32; 3] = std::array::from_fn(|i| self.product_sum(-w, a[i], l[i], for_t[i]));
        let mut sum = 0.0;
        for axis in self.axes() {
            let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
            let n = self.cross([u[y], u[z]], [v[y], v[z]], for_n[axis]);
            sum = self.product_sum(n, t[axis], sum, 1.0);
        }
        self.flush(sum)
    }

    /// The axes, in the order in which a sum takes them.
    pub(crate) fn axes(&mut self) -> [usize; 3] {
        let first = self.random.below(3);
        [first, (first + 1) % 3, (first + 2) % 3]
    }

    /// Runs with every rounding of a bound against it, where they are not at random: smaller is worse.
    pub(crate) fn as_bound<T>(&mut self, run: impl FnOnce(&mut Self) -> T) -> T {
        let rounding = self.rounding;
        if matches!(rounding, Rounding::Larger | Rounding::Smaller) {
            self.rounding = Rounding::TowardsZero;
        }
        let result = run(self);
        self.rounding = rounding;
        result
    }

    pub(crate) fn add(&mut self, x: f32, y: f32) -> f32 {
        self.sum(x, y, 1.0)
    }

    pub(crate) fn product(&mut self, x: f32, y: f32) -> f32 {
        self.product_sum(x, y, 0.0, 1.0)
    }

    /// One bound for all lights, here of this one: `wgsl/common/determinant.wgsl`, `face_bound`. `relative` is 10u there.
    pub(crate) fn face_bound(&mut self, [a, b, c]: [[f32; 3]; 3], light: Light, relative: f32) -> f32 {
        let [to_light, w] = LightBatch::new(&[light], 0, 3).magnitudes;
        let sizes = [b, c].map(|corner| {
            let side: [f32; 3] = std::array::from_fn(|i| self.add(corner[i], -a[i]).abs());
            let sum = self.add(side[0], side[1]);
            self.add(sum, side[2])
        });
        let size = self.product(sizes[0], sizes[1]);
        let largest = [a, b, c].as_flattened().iter().fold(0.0_f32, |largest, c| largest.max(c.abs()));
        let reach = (2.0 * largest).max(1.0);
        let to_light = self.product_sum(largest, w, to_light, 1.0);
        let least = self.product(UNDERFLOW, reach);
        let least = self.product(least, reach);
        let far = self.add(1.0, to_light);
        let factor = self.product(relative, to_light);
        let size = self.product(factor, size);
        self.product_sum(least, far, size, 1.0)
    }

    /// A light's own bound: `wgsl/extract/exact_facing.wgsl`, `filter_lights`, whose own underflow term is no smaller.
    pub(crate) fn light_bound(&mut self, [a, b, c]: [[f32; 3]; 3], light: Light, relative: f32) -> f32 {
        let batch = LightBatch::new(&[light], 0, 3);
        let ([x, y, z, w], inexact) = (batch.lights[0], batch.inexact_w[0][0]);
        let l = [x, y, z];
        let u: [f32; 3] = std::array::from_fn(|i| self.add(b[i], -a[i]).abs());
        let v: [f32; 3] = std::array::from_fn(|i| self.add(c[i], -a[i]).abs());
        let t: [f32; 3] = std::array::from_fn(|i| self.product_sum(-w, a[i], l[i], 1.0).abs());
        let q: [f32; 3] = std::array::from_fn(|i| self.product(inexact, a[i].abs()));
        let mut size = 0.0;
        for axis in 0..3 {
            let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
            let n = self.cross([u[y], u[z]], [-v[y], v[z]], 1.0);
            let reach = self.add(t[axis], q[axis]);
            size = self.product_sum(n, reach, size, 1.0);
        }
        let largest = |v: [f32; 3]| v.into_iter().fold(0.0, f32::max);
        let reach = largest(u).max(largest(v)).max(1.0);
        let least = self.product(UNDERFLOW, reach);
        let least = self.product(least, reach);
        let sum = self.add(largest(t), largest(q));
        let sum = self.add(sum, 1.0);
        let size = self.product(relative, size);
        self.product_sum(least, sum, size, 1.0)
    }
}

fn cross_product(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}
