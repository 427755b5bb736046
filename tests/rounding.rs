//! The band of NUMERICS.md, "Facing", holds for any arithmetic that WGSL allows: every rounding up or down, subnormals
//! flushed or not, products fused or not, sums in either order, all at random.

mod common;

use common::band::{Bound, facing_bound, facing_bound_without_q, is_outside, scaled};
use common::oracle::ExactFace;
use common::random::Random;
use common::{is_long, must_fail};
use rimline::Light;

/// Arithmetic of an implementation that takes every liberty by chance.
struct Liberties(Random);

impl Liberties {
    fn chance(&mut self) -> bool {
        self.0.next() >> 63 != 0
    }

    fn flush(&mut self, value: f32) -> f32 {
        if value.is_subnormal() && self.chance() { 0.0 } else { value }
    }

    /// One of the two neighbours of an exact value.
    fn round(&mut self, exact: f64) -> f32 {
        let near = exact as f32;
        let rounded = match f64::from(near).partial_cmp(&exact) {
            Some(std::cmp::Ordering::Less) if self.chance() => near.next_up(),
            Some(std::cmp::Ordering::Greater) if self.chance() => near.next_down(),
            _ => near,
        };
        self.flush(rounded)
    }

    fn sum(&mut self, x: f32, y: f32) -> f32 {
        let (x, y) = (self.flush(x), self.flush(y));
        self.round(f64::from(x) + f64::from(y))
    }

    /// x·y + z, fused or not.
    fn product_sum(&mut self, x: f32, y: f32, z: f32) -> f32 {
        let (x, y) = (self.flush(x), self.flush(y));
        let product = f64::from(x) * f64::from(y);
        if self.chance() {
            let z = self.flush(z);
            self.round(product + f64::from(z))
        } else {
            let product = self.round(product);
            self.sum(product, z)
        }
    }

    fn cross(&mut self, [a, b]: [f32; 2], [c, d]: [f32; 2]) -> f32 {
        // a·d − b·c, either product rounded first.
        if self.chance() {
            let second = self.product_sum(-b, c, 0.0);
            self.product_sum(a, d, second)
        } else {
            let first = self.product_sum(a, d, 0.0);
            self.product_sum(-b, c, first)
        }
    }

    fn determinant(&mut self, [a, b, c]: [[f32; 3]; 3], light: Light) -> f32 {
        // Scaled as the stage has it; components that are tiny beside the largest are rounded once.
        let [x, y, z, w] = scaled(light).map(|c| c as f32);
        let l = [x, y, z];
        let u: [f32; 3] = std::array::from_fn(|i| self.sum(b[i], -a[i]));
        let v: [f32; 3] = std::array::from_fn(|i| self.sum(c[i], -a[i]));
        let t: [f32; 3] = std::array::from_fn(|i| self.product_sum(-w, a[i], l[i]));
        let first = self.0.below(3);
        let mut sum = 0.0;
        for axis in [first, (first + 1) % 3, (first + 2) % 3] {
            let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
            let n = self.cross([u[y], u[z]], [v[y], v[z]]);
            sum = self.product_sum(n, t[axis], sum);
        }
        self.flush(sum)
    }
}

/// The filter's full bound, computed with the same liberties: `wgsl/exact_facing.wgsl`, `filter_lights`, whose own
/// underflow term is no smaller.
impl Liberties {
    fn product(&mut self, x: f32, y: f32) -> f32 {
        self.product_sum(x, y, 0.0)
    }

    /// One bound for all lights, here of this one: `wgsl/filter.wgsl`, `face_bound`.
    fn face_bound(&mut self, [a, b, c]: [[f32; 3]; 3], light: Light, relative: f32) -> f32 {
        let [x, y, z, w] = scaled(light).map(|c| (c as f32).abs());
        let sizes = [b, c].map(|corner| {
            let side: [f32; 3] = std::array::from_fn(|i| self.sum(corner[i], -a[i]).abs());
            let sum = self.sum(side[0], side[1]);
            self.sum(sum, side[2])
        });
        let size = self.product(sizes[0], sizes[1]);
        let largest = [a, b, c].as_flattened().iter().fold(0.0_f32, |largest, c| largest.max(c.abs()));
        let reach = (2.0 * largest).max(1.0);
        let to_light = self.product_sum(largest, w, x.max(y).max(z));
        let least = self.product(2.0_f32.powi(-115), reach);
        let least = self.product(least, reach);
        let far = self.sum(1.0, to_light);
        let factor = self.product(relative, to_light);
        let size = self.product(factor, size);
        self.product_sum(least, far, size)
    }

    fn filter_bound(&mut self, [a, b, c]: [[f32; 3]; 3], light: Light, relative: f32) -> f32 {
        let [x, y, z, w] = scaled(light).map(|c| c as f32);
        let l = [x, y, z];
        let inexact = if w.to_bits() << 9 == 0 { 0.0 } else { w.abs() };
        let u: [f32; 3] = std::array::from_fn(|i| self.sum(b[i], -a[i]).abs());
        let v: [f32; 3] = std::array::from_fn(|i| self.sum(c[i], -a[i]).abs());
        let t: [f32; 3] = std::array::from_fn(|i| self.product_sum(-w, a[i], l[i]).abs());
        let q: [f32; 3] = std::array::from_fn(|i| self.product(inexact, a[i].abs()));
        let mut size = 0.0;
        for axis in 0..3 {
            let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
            let n = self.cross([u[y], u[z]], [-v[y], v[z]]);
            let reach = self.sum(t[axis], q[axis]);
            size = self.product_sum(n, reach, size);
        }
        let largest = |v: [f32; 3]| v.into_iter().fold(0.0, f32::max);
        let reach = largest(u).max(largest(v)).max(1.0);
        let least = self.product(2.0_f32.powi(-115), reach);
        let least = self.product(least, reach);
        let sum = self.sum(largest(t), largest(q));
        let sum = self.sum(sum, 1.0);
        let size = self.product(relative, size);
        self.product_sum(least, sum, size)
    }
}

/// A triangle, and a light that is nearly in its plane or nearly at a corner.
fn hard_pair(random: &mut Random) -> ([[f32; 3]; 3], Light) {
    let scale = random.between(-36.0, 30.0).exp2();
    let centre = random.direction().map(|c| c * scale * random.between(0.0, 12.0).exp2());
    let flat = random.below(4) == 0;
    let corners = [0; 3].map(|_| {
        let [x, y, z] = random.direction().map(|c| c * scale);
        [x + centre[0], if flat { centre[1] } else { y + centre[1] }, z + centre[2]]
    });
    let [a, b, c] = corners;
    let w = [0.0, 1.0, random.between(0.2, 5.0), random.between(-3.0, -0.1)][random.below(4)];
    let (s, t) = match random.below(2) {
        0 => (random.between(-2.0, 2.0), random.between(-2.0, 2.0)),
        _ => (random.between(-1e-5, 1e-5), random.between(-1e-5, 1e-5)),
    };
    let mut l: [f32; 3] = std::array::from_fn(|i| w * a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]));
    for _ in 0..random.below(4) {
        let at = random.below(3);
        l[at] = if random.below(2) == 0 { l[at].next_up() } else { l[at].next_down() };
    }
    (corners, Light::homogeneous([l[0], l[1], l[2], w]))
}

fn certificates_hold(seed: u64, rounds: usize, bound: Bound) -> Result<usize, String> {
    let mut random = Random::new(seed);
    let mut liberties = Liberties(Random::new(seed + 1));
    let mut outside = 0;
    for round in 0..rounds {
        let (corners, light) = hard_pair(&mut random);
        if !is_outside(corners, light, bound) {
            continue;
        }
        outside += 1;
        let exact = ExactFace::new(&corners, [0, 1, 2]).ok_or("no face")?.sign(light);
        for _ in 0..4 {
            let determinant = liberties.determinant(corners, light);
            if (determinant > 0.0) != (exact > 0) {
                return Err(format!("round {round}: {corners:?}, {light:?}: {determinant:e}, exactly {exact}"));
            }
        }
    }
    Ok(outside)
}

#[test]
fn the_band_holds_for_any_rounding() -> Result<(), String> {
    let seed = 101;
    println!("seed {seed}");
    let rounds = if is_long() { 3_000_000 } else { 60_000 };
    let outside = certificates_hold(seed, rounds, facing_bound)?;
    println!("{outside} of {rounds} pairs outside the band");
    if outside * 20 < rounds || outside > rounds / 20 * 19 {
        return Err(format!("{outside} of {rounds} outside: neither side of the band is tried enough"));
    }
    must_fail("a bound without the term in Q", &certificates_hold(seed, rounds, facing_bound_without_q))
}

/// An ordinary triangle with a light from far above its plane to so near that `f32` cannot tell.
fn grazing_pair(random: &mut Random) -> ([[f32; 3]; 3], Light) {
    let corners: [[f32; 3]; 3] = [(); 3].map(|()| random.direction());
    let (s, t) = (random.between(-2.0, 2.0), random.between(-2.0, 2.0));
    let up = random.direction();
    let height = 10.0_f32.powf(random.between(-8.5, 0.0));
    let light = std::array::from_fn(|i| {
        let [a, b, c] = corners.map(|corner| corner[i]);
        a + s * (b - a) + t * (c - a) + height * up[i]
    });
    (corners, Light::point(light))
}

/// Makes a face and a light.
type PairOf = fn(&mut Random) -> ([[f32; 3]; 3], Light);
/// A bound of the filter at some units of the last place.
type FilterBound = fn(&mut Liberties, [[f32; 3]; 3], Light, f32) -> f32;

/// Pairs that the filter decides, and decides wrongly, at a relative bound of `units` of the last place.
fn filter_errors(seed: u64, rounds: usize, units: f32, bound_of: FilterBound, pair_of: PairOf) -> (usize, usize) {
    let mut random = Random::new(seed);
    let mut liberties = Liberties(Random::new(seed + 1));
    let (mut decided, mut wrong) = (0, 0);
    for _ in 0..rounds {
        let (corners, light) = pair_of(&mut random);
        let w = scaled(light)[3];
        let is_large = corners.iter().flatten().any(|c| c.abs() >= 2.0_f32.powi(40));
        let Some(face) = ExactFace::new(&corners, [0, 1, 2]) else {
            continue;
        };
        if is_large || (w != 0.0 && w.abs() < 2.0_f64.powi(-60)) {
            continue;
        }
        let determinant = liberties.determinant(corners, light);
        let bound = bound_of(&mut liberties, corners, light, units * f32::EPSILON);
        if determinant.abs() > bound {
            decided += 1;
            wrong += usize::from((determinant > 0.0) != (face.sign(light) > 0));
        }
    }
    (decided, wrong)
}

/// Ten units, as NUMERICS.md, "Filter", has it, decide nothing wrongly; a bound that is too small does.
#[test]
fn the_filter_decides_rightly_for_any_rounding() -> Result<(), String> {
    let seed = 103;
    println!("seed {seed}");
    let rounds = if is_long() { 3_000_000 } else { 100_000 };
    // The bound that is too small, for the negative control: a face's bound has more slack.
    let bounds: [(&str, FilterBound, PairOf, f32); 2] = [
        ("a light's", Liberties::filter_bound, hard_pair, 0.5),
        ("a face's", Liberties::face_bound, grazing_pair, 0.01),
    ];
    for (name, bound_of, pair_of, too_small) in bounds {
        let (decided, wrong) = filter_errors(seed, rounds, 10.0, bound_of, pair_of);
        println!("{name} bound: {decided} of {rounds} pairs decided");
        if wrong != 0 || decided * 20 < rounds {
            return Err(format!("{name} bound: {wrong} of {decided} decided wrongly, of {rounds} in all"));
        }
        if filter_errors(seed, rounds, too_small, bound_of, pair_of).1 == 0 {
            return Err(format!("negative control: {name} bound at {too_small} units decides as well"));
        }
    }
    Ok(())
}
