//! Facing: for each face one bit a light, set where the light lies strictly on the face's counter-clockwise side.

use super::Threads;
use super::exact_facing::determinant_sign;
use crate::layout::LightWord;
use crate::light::Light;
use crate::mesh::is_degenerate;
use crate::method::Predicate;

/// What facing counts besides its masks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FacingCounts {
    /// Faces with an infinite or NaN vertex, or one that is not there: they face no light.
    pub non_finite_faces: u32,
    /// Pairs of face and light that the filter left to exact arithmetic.
    pub undecided_pairs: u32,
    /// Those of them whose determinant is exactly zero.
    pub exact_zeros: u32,
}

impl FacingCounts {
    fn plus(self, other: Self) -> Self {
        Self {
            non_finite_faces: self.non_finite_faces + other.non_finite_faces,
            undecided_pairs: self.undecided_pairs.wrapping_add(other.undecided_pairs),
            exact_zeros: self.exact_zeros.wrapping_add(other.exact_zeros),
        }
    }
}

/// Facing masks of `faces` for `lights`: ⌈N/32⌉ planes of one `u32` a face. Vertices that `positions` lacks count as
/// non-finite. `f32` arithmetic in the order of `wgsl/facing.wgsl`; see NUMERICS.md, "Facing".
pub fn facing(
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    lights: &[Light],
    predicate: Predicate,
    threads: Threads,
) -> Vec<u32> {
    let mut masks = Vec::new();
    facing_into(&mut masks, positions, faces, lights, predicate, threads);
    masks
}

/// The same into a vector that may be used again.
pub(super) fn facing_into(
    masks: &mut Vec<u32>,
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    lights: &[Light],
    predicate: Predicate,
    threads: Threads,
) -> FacingCounts {
    masks.resize(faces.len() * crate::light::words(lights.len()), 0);
    let mut total = FacingCounts::default();
    for (lights, plane) in lights.chunks(32).zip(masks.chunks_mut(faces.len().max(1))) {
        let word = LightWord::new(lights, 0, 3);
        let counts = threads.share(plane, |first, masks| {
            let mut counts = FacingCounts::default();
            for (mask, &corners) in masks.iter_mut().zip(&faces[first..]) {
                *mask = match predicate {
                    Predicate::Exact => face_mask::<true>(positions, corners, &word, &mut counts),
                    Predicate::Fast => face_mask::<false>(positions, corners, &word, &mut counts),
                };
            }
            counts
        });
        let word = counts.into_iter().fold(FacingCounts::default(), FacingCounts::plus);
        // Every word sees the same faces.
        total = FacingCounts { non_finite_faces: 0, ..total }.plus(word);
    }
    total
}

/// All three coordinates are finite.
pub fn is_finite(position: [f32; 3]) -> bool {
    position.iter().all(|c| c.is_finite())
}

/// `(b − a) × (c − a)`, counter-clockwise outside.
pub(super) fn normal(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let [u, v] = [difference(b, a), difference(c, a)];
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn difference(p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

/// The bits of one face for a word of lights.
#[inline]
fn face_mask<const EXACT: bool>(
    positions: &[[f32; 3]],
    corners: [u32; 3],
    word: &LightWord,
    counts: &mut FacingCounts,
) -> u32 {
    let [Some(&a), Some(&b), Some(&c)] = corners.map(|v| positions.get(v as usize)) else {
        counts.non_finite_faces += 1;
        return 0;
    };
    let side = Side::new(a, b, c);
    // A non-finite coordinate makes two components of the normal non-finite, so this one test stands for nine. Finite
    // ones may overflow it, too.
    if !(side.n[0] + side.n[1] + side.n[2]).is_finite() && ![a, b, c].into_iter().all(is_finite) {
        counts.non_finite_faces += 1;
        return 0;
    }
    if is_degenerate(corners) {
        return 0;
    }
    let Decision { facing, doubt } = side.decide::<EXACT>(word);
    if doubt == 0 { facing } else { settle(&side, [a, b, c], word, Decision { facing, doubt }, counts) }
}

/// Ten units of the last place, 10 · 2⁻²³.
const RELATIVE: f32 = 10.0 / 8_388_608.0;
/// What underflow may add, 2⁻¹¹⁵.
const UNDERFLOW: f32 = f32::from_bits((127 - 115) << 23);
/// A coordinate from 2⁴⁰ on could overflow the determinant, so its face is undecided.
const LARGE: f32 = 1_099_511_627_776.0;

/// A face as the filter sees it.
struct Side {
    a: [f32; 3],
    n: [f32; 3],
    /// The normal's components with absolute values throughout.
    n_abs: [f32; 3],
    /// Error of the determinant a unit of |l| and of |w|, and by itself: the cheap bound.
    per_l: f32,
    per_w: f32,
    least: f32,
    is_large: bool,
}

/// Bits of facing lights and of undecided ones.
#[derive(Clone, Copy)]
struct Decision {
    facing: u32,
    doubt: u32,
}

impl Side {
    #[inline]
    fn new(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Self {
        let [u, v] = [difference(b, a), difference(c, a)];
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let [u, v] = [u.map(f32::abs), v.map(f32::abs)];
        let n_abs = [u[1] * v[2] + u[2] * v[1], u[2] * v[0] + u[0] * v[2], u[0] * v[1] + u[1] * v[0]];
        let reach = largest(u).max(largest(v)).max(1.0);
        let least = UNDERFLOW * reach * reach;
        let per_l = RELATIVE * (n_abs[0] + n_abs[1] + n_abs[2]) + least;
        let [a_largest, b_largest, c_largest] = [a, b, c].map(|p| largest(p.map(f32::abs)));
        let is_large = a_largest.max(b_largest).max(c_largest) >= LARGE;
        Self { a, n, n_abs, per_l, per_w: per_l * a_largest, least, is_large }
    }

    fn determinant(&self, [x, y, z, w]: [f32; 4]) -> f32 {
        let to_light = [x - w * self.a[0], y - w * self.a[1], z - w * self.a[2]];
        self.n[0] * to_light[0] + self.n[1] * to_light[1] + self.n[2] * to_light[2]
    }

    /// All lights by the cheap bound.
    #[inline]
    fn decide<const EXACT: bool>(&self, word: &LightWord) -> Decision {
        let mut decision = Decision { facing: 0, doubt: 0 };
        let lights = word.lights.iter().zip(&word.bounds).take(word.count as usize);
        for (bit, (&light, bounds)) in lights.enumerate() {
            let d = self.determinant(light);
            if EXACT {
                let bound = self.per_l * bounds[0] + (self.per_w * bounds[1] + self.least);
                decision.facing |= u32::from(d > bound) << bit;
                decision.doubt |= u32::from(!(d.abs() > bound)) << bit;
            } else {
                decision.facing |= u32::from(d > 0.0) << bit;
            }
        }
        match EXACT {
            false => decision,
            true if self.is_large => Decision { facing: 0, doubt: word.live },
            true => Decision { facing: decision.facing & !word.doubtful, doubt: decision.doubt | word.doubtful },
        }
    }

    /// Lights in doubt by the full bound, whose terms are the light's own.
    fn decide_again(&self, word: &LightWord, before: Decision) -> Decision {
        let mut decision = before;
        for bit in bits(before.doubt & !word.doubtful) {
            let (light, bounds) = (word.lights[bit], word.bounds[bit]);
            let [x, y, z, w] = light;
            let a = self.a;
            let to_light = [x - w * a[0], y - w * a[1], z - w * a[2]].map(f32::abs);
            let a_abs = a.map(|c| bounds[2] * c.abs());
            let size = self.n_abs[0] * (to_light[0] + a_abs[0])
                + self.n_abs[1] * (to_light[1] + a_abs[1])
                + self.n_abs[2] * (to_light[2] + a_abs[2]);
            let d = self.determinant(light);
            let bound = RELATIVE * size + self.least * (1.0 + largest(to_light) + largest(a_abs));
            if d.abs() > bound {
                decision.doubt &= !(1 << bit);
                decision.facing |= u32::from(d > 0.0) << bit;
            }
        }
        decision
    }
}

/// Decides what the cheap bound left: by the full bound, by coplanarity along the axes, exactly.
#[cold]
fn settle(side: &Side, corners: [[f32; 3]; 3], word: &LightWord, before: Decision, counts: &mut FacingCounts) -> u32 {
    let decision = if side.is_large { before } else { side.decide_again(word, before) };
    let doubt = leave_out_coplanar(decision.doubt, corners.map(|p| p.map(f32::to_bits)), word);
    let [a, b, c] = corners;
    let mut facing = decision.facing;
    for bit in bits(doubt) {
        let sign = determinant_sign(a, b, c, word.light_bits[bit].map(f32::from_bits));
        facing |= u32::from(sign > 0) << bit;
        counts.exact_zeros = counts.exact_zeros.wrapping_add(u32::from(sign == 0));
    }
    counts.undecided_pairs = counts.undecided_pairs.wrapping_add(doubt.count_ones());
    facing
}

/// A point light in the plane of a face that lies along two axes is on neither side, nor is any of a face that is a
/// line.
fn leave_out_coplanar(doubt: u32, [a, b, c]: [[u32; 3]; 3], word: &LightWord) -> u32 {
    if a == b || a == c || b == c {
        return 0;
    }
    let flat = [0, 1, 2].map(|axis| a[axis] == b[axis] && a[axis] == c[axis]);
    let is_coplanar = |bit: &usize| {
        let light = word.light_bits[*bit];
        light[3] == 1.0_f32.to_bits() && (0..3).any(|axis| flat[axis] && light[axis] == a[axis])
    };
    bits(doubt).filter(is_coplanar).fold(doubt, |left, bit| left & !(1 << bit))
}

fn largest(v: [f32; 3]) -> f32 {
    v[0].max(v[1]).max(v[2])
}

/// The set bits, lowest first.
fn bits(mut word: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (bit < 32).then_some(bit as usize)
    })
}
