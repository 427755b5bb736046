//! Facing: one bit for each face and light, set if the light lies strictly on the face's counter-clockwise side.

use super::batch::{Batch, LANES};
use super::exact_facing::ExactFace;
use crate::cpu::common::determinant::{cross_product, difference, local_form, local_mask, normal, plane_mask};
use crate::cpu::common::filter;
use crate::cpu::common::parallel::Threads;
use crate::cpu::common::positions::{is_finite, position};
use crate::layout::{LightBatch, bits};
use crate::light::Light;
use crate::mesh::is_degenerate;
use crate::method::Predicate;

/// Statistics of facing. All are 0 without lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FacingStatistics {
    /// Faces with a vertex that is infinite, NaN or missing. They face no light. A polygon counts as a face.
    pub non_finite_faces: u32,
    /// Pairs of face and light that the filter left to exact arithmetic: none but for
    /// [`Predicate::Exact`](crate::Predicate::Exact). With polygons, by any predicate: pairs whose polygon is neither strictly
    /// convex as seen from the light nor a quadrilateral without a turn of 0. The number wraps at 2³².
    pub undecided_pairs: u32,
    /// The undecided pairs whose determinant is exactly zero: the light is in the face's plane, or the face has no area.
    pub exact_zeros: u32,
}

impl FacingStatistics {
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            non_finite_faces: self.non_finite_faces + other.non_finite_faces,
            undecided_pairs: self.undecided_pairs.wrapping_add(other.undecided_pairs),
            exact_zeros: self.exact_zeros.wrapping_add(other.exact_zeros),
        }
    }
}

/// Facing masks of `faces` for `lights`: ⌈N/32⌉ planes with one `u32` for each face. A vertex that `positions` lacks
/// counts as non-finite. The lights must be finite; [`crate::light::check_lights`] checks this. The arithmetic is that
/// of `wgsl/extract/facing.wgsl` and `wgsl/extract/exact_facing.wgsl`. See docs/numerics/facing.md, "Error band" and
/// "Filter".
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

/// Like [`facing`], into a vector that is reused and whose length is adapted. Returns the statistics.
pub fn facing_into(
    masks: &mut Vec<u32>,
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    lights: &[Light],
    predicate: Predicate,
    threads: Threads,
) -> FacingStatistics {
    masks.resize(faces.len() * crate::light::batches(lights.len()), 0);
    let largest = largest_magnitude(positions, threads);
    let mut total = FacingStatistics::default();
    for (lights, plane) in lights.chunks(32).zip(masks.chunks_mut(faces.len().max(1))) {
        let light_batch = LightBatch::new(lights, 0, 3);
        let statistics = threads.share(plane, |first, masks| {
            let range = FaceRange { positions, faces: &faces[first..], light_batch: &light_batch, largest };
            match (predicate, lights.len()) {
                (Predicate::Exact, 1) => range.fill_exactly_for_one_light(masks),
                (Predicate::Exact, _) => range.fill_exactly(masks),
                (Predicate::Fast, 1) => range.fill_fast_for_one_light(masks),
                (Predicate::Fast, _) => range.fill_fast(masks),
                (Predicate::Plane, _) => range.fill_by_plane(masks),
            }
        });
        let statistics = statistics.into_iter().fold(FacingStatistics::default(), FacingStatistics::plus);
        // Every batch sees the same faces.
        total = FacingStatistics { non_finite_faces: 0, ..total }.plus(statistics);
    }
    total
}

/// For each face, whether the filter leaves it to exact arithmetic for any of at most 32 finite lights.
pub fn undecided_faces(positions: &[[f32; 3]], faces: &[[u32; 3]], lights: &[Light]) -> Vec<bool> {
    let light_batch = LightBatch::new(lights, 0, 3);
    let is_undecided = |&corners: &[u32; 3]| {
        let face = Face::new(positions, corners);
        face.may_face(&mut FacingStatistics::default()) && face.filter_lights(&light_batch).undecided != 0
    };
    faces.iter().map(is_undecided).collect()
}

/// A range of faces that one thread decides.
struct FaceRange<'a> {
    positions: &'a [[f32; 3]],
    faces: &'a [[u32; 3]],
    light_batch: &'a LightBatch,
    /// The mesh's largest absolute coordinate.
    largest: f32,
}

impl FaceRange<'_> {
    fn fill_exactly(&self, masks: &mut [u32]) -> FacingStatistics {
        let mut statistics = FacingStatistics::default();
        for (masks, faces) in masks.chunks_mut(LANES).zip(self.faces.chunks(LANES)) {
            let batch = Batch::new(self.positions, faces, self.light_batch);
            let certain = batch.certain(self.largest, self.light_batch);
            for (lane, (mask, &corners)) in masks.iter_mut().zip(faces).enumerate() {
                *mask = if certain[lane] {
                    batch.masks[lane]
                } else {
                    Face::new(self.positions, corners).decide(self.light_batch, &mut statistics)
                };
            }
        }
        statistics
    }

    fn fill_fast(&self, masks: &mut [u32]) -> FacingStatistics {
        let mut statistics = FacingStatistics::default();
        for (masks, faces) in masks.chunks_mut(LANES).zip(self.faces.chunks(LANES)) {
            let batch = Batch::new(self.positions, faces, self.light_batch);
            let finite = batch.finite();
            for (lane, (mask, &corners)) in masks.iter_mut().zip(faces).enumerate() {
                *mask = if finite[lane] && !is_degenerate(corners) {
                    batch.masks[lane]
                } else {
                    Face::new(self.positions, corners).mask_by_f32(self.light_batch, &mut statistics)
                };
            }
        }
        statistics
    }

    fn fill_fast_for_one_light(&self, masks: &mut [u32]) -> FacingStatistics {
        let mut statistics = FacingStatistics::default();
        let light = self.light_batch.lights[0];
        for (mask, &corners) in masks.iter_mut().zip(self.faces) {
            let face = Face::new(self.positions, corners);
            let n = normal(face.a, face.b, face.c);
            *mask = u32::from(local_form(n, face.a, light) > 0.0);
            // `Batch::finite` has the same test.
            if !(n[0] + n[1] + n[2]).is_finite() || is_degenerate(corners) {
                *mask = face.mask_by_f32(self.light_batch, &mut statistics);
            }
        }
        statistics
    }

    /// This is for comparison only, so it is as plain as possible.
    fn fill_by_plane(&self, masks: &mut [u32]) -> FacingStatistics {
        let mut statistics = FacingStatistics::default();
        for (mask, &corners) in masks.iter_mut().zip(self.faces) {
            let face = Face::new(self.positions, corners);
            *mask =
                if face.may_face(&mut statistics) { plane_mask(face.a, face.b, face.c, self.light_batch) } else { 0 };
        }
        statistics
    }

    /// One light is common. Gathering faces for it costs more than deciding them at once.
    fn fill_exactly_for_one_light(&self, masks: &mut [u32]) -> FacingStatistics {
        let mut statistics = FacingStatistics::default();
        let light = self.light_batch.lights[0];
        let (relative, least) = filter::face_bound(self.largest, self.light_batch.magnitudes);
        // |v|₁ is at most six times the largest coordinate, and |u|₁ at most its largest value in a batch. So loose a
        // bound leaves a few faces in a thousand to be decided again, and saves most of the bound's cost for the
        // others.
        let relative = relative * (6.0 * self.largest);
        let relative = if self.largest < filter::LARGE { relative } else { f32::INFINITY };
        for (masks, faces) in masks.chunks_mut(LANES).zip(self.faces.chunks(LANES)) {
            let (mut determinants, mut longest) = ([f32::INFINITY; LANES], [0.0_f32; 3]);
            for (d, &corners) in determinants.iter_mut().zip(faces) {
                let face = Face::new(self.positions, corners);
                let [u, v] = [difference(face.b, face.a), difference(face.c, face.a)];
                *d = local_form(cross_product(u, v), face.a, light);
                for (longest, side) in longest.iter_mut().zip(u) {
                    *longest = if side.abs() > *longest { side.abs() } else { *longest };
                }
            }
            let bound = relative * (longest[0] + longest[1] + longest[2]) + least;
            for (mask, d) in masks.iter_mut().zip(determinants) {
                *mask = u32::from(d > 0.0);
            }
            // A NaN on either side is not certain.
            let is_certain = |d: f32| d.abs() > bound;
            if !determinants.iter().all(|&d| is_certain(d)) {
                for ((mask, &corners), d) in masks.iter_mut().zip(faces).zip(determinants) {
                    if !is_certain(d) {
                        *mask = Face::new(self.positions, corners).decide(self.light_batch, &mut statistics);
                    }
                }
            }
        }
        statistics
    }
}

/// The largest absolute coordinate, or infinity if a coordinate is infinite. NaNs are ignored.
pub(crate) fn largest_magnitude(positions: &[[f32; 3]], threads: Threads) -> f32 {
    let larger = |a: f32, b: f32| if b > a { b } else { a };
    let largest_of_ranges = threads.map(positions, |positions| {
        let coordinates: &[f32] = positions.as_flattened();
        // Sixteen at a time, for the vector registers.
        let (groups, rest) = coordinates.as_chunks::<16>();
        let largest = groups.iter().fold([0.0; 16], |mut largest, group| {
            for (largest, coordinate) in largest.iter_mut().zip(group) {
                *largest = larger(*largest, coordinate.abs());
            }
            largest
        });
        largest.into_iter().chain(rest.iter().map(|c| c.abs())).fold(0.0, larger)
    });
    largest_of_ranges.into_iter().fold(0.0, larger)
}

/// A face and the positions of its corners.
#[derive(Clone, Copy)]
struct Face {
    corners: [u32; 3],
    a: [f32; 3],
    b: [f32; 3],
    c: [f32; 3],
}

impl Face {
    fn new(positions: &[[f32; 3]], corners: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|v| position(positions, v));
        Self { corners, a, b, c }
    }

    /// The bits that `f32` gives.
    fn mask_by_f32(&self, light_batch: &LightBatch, statistics: &mut FacingStatistics) -> u32 {
        if self.may_face(statistics) { local_mask(self.a, self.b, self.c, light_batch) } else { 0 }
    }

    /// Whether the face can face a light: its vertices are finite and different. Counts faces with vertices that are
    /// not finite.
    fn may_face(&self, statistics: &mut FacingStatistics) -> bool {
        if ![self.a, self.b, self.c].into_iter().all(is_finite) {
            statistics.non_finite_faces += 1;
            return false;
        }
        !is_degenerate(self.corners)
    }

    /// The bits of a face that one bound leaves uncertain, as `wgsl/extract/exact_facing.wgsl` computes them.
    #[cold]
    fn decide(&self, light_batch: &LightBatch, statistics: &mut FacingStatistics) -> u32 {
        if !self.may_face(statistics) {
            return 0;
        }
        let Decision { mut facing, undecided } = self.filter_lights(light_batch);
        if undecided == 0 {
            return facing;
        }
        let exact = ExactFace::new(self.a, self.b, self.c);
        for light in bits(undecided) {
            let sign = exact.sign(light_batch.light_bits[light as usize].map(f32::from_bits));
            facing |= u32::from(sign > 0) << light;
            statistics.exact_zeros = statistics.exact_zeros.wrapping_add(u32::from(sign == 0));
        }
        statistics.undecided_pairs = statistics.undecided_pairs.wrapping_add(undecided.count_ones());
        facing
    }

    /// Decides lights by `f32` if the bound of the light allows it.
    fn filter_lights(&self, light_batch: &LightBatch) -> Decision {
        let Self { a, b, c, .. } = *self;
        let largest = [a, b, c].iter().flatten().fold(0.0_f32, |largest, coordinate| largest.max(coordinate.abs()));
        let mut decision = Decision { facing: 0, undecided: light_batch.active_bits };
        if largest >= filter::LARGE {
            return decision;
        }
        let [u, v] = [difference(b, a), difference(c, a)];
        let n = cross_product(u, v);
        let [u, v] = [u.map(f32::abs), v.map(f32::abs)];
        let n_abs = [u[1] * v[2] + u[2] * v[1], u[2] * v[0] + u[0] * v[2], u[0] * v[1] + u[1] * v[0]];
        let underflow = filter::underflow_bound(largest);
        for bit in bits(light_batch.active_bits) {
            let light = bit as usize;
            let l = light_batch.lights[light];
            let d = local_form(n, a, l);
            let inexact_w = light_batch.inexact_w[light / 4][light % 4];
            let sizes = [0, 1, 2].map(|axis| (l[axis] - l[3] * a[axis]).abs() + inexact_w * a[axis].abs());
            let bound = filter::RELATIVE * (n_abs[0] * sizes[0] + n_abs[1] * sizes[1] + n_abs[2] * sizes[2])
                + underflow * (1.0 + sizes[0] + sizes[1] + sizes[2]);
            if d.abs() > bound {
                decision.undecided &= !(1 << bit);
                decision.facing |= u32::from(d > 0.0) << bit;
            }
        }
        decision
    }
}

/// The bits of facing lights and those of undecided lights.
struct Decision {
    facing: u32,
    undecided: u32,
}
