//! Boxes of poses from boxes of joints, before anything is deformed. docs/numerics/deform.md, "Bounds before deforming".

use std::collections::BTreeMap;

use super::{Geometry, InstancePose, Model, ModelError, Pose};

/// A box by its lowest and its highest corner.
pub type Box3 = [[f32; 3]; 2];

/// Bounds on the positions of the instances of a model in a pose, without looking at vertices. For each joint there is the
/// box of the vertices that it moves, and for each morph target the box of its offsets.
///
/// The boxes hold for the positions that [`gpu::Deformer`](crate::gpu::Deformer) and [`cpu::deform`](crate::cpu::deform)
/// compute in this pose, rounding included. The box of a model at rest does not. They are for
/// [`Scene::set_bounds`](crate::gpu::Scene::set_bounds); a scene states those of its own models itself.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelBounds {
    geometries: Vec<GeometryBounds>,
    /// The geometry of each instance.
    instances: Vec<usize>,
}

/// The boxes of a geometry: at rest, for each joint, and for each morph target.
#[derive(Clone, Debug, PartialEq)]
struct GeometryBounds {
    /// Numbers that a pose must have.
    joints_needed: usize,
    targets_needed: usize,
    /// The box of all vertices at rest. `None`: there is no vertex, or one is not finite.
    rest: Option<[Span; 3]>,
    /// The joints that move vertices, with the boxes of these vertices.
    joints: Vec<(usize, [Span; 3])>,
    /// The offsets of each morph target. `None`: one is not finite.
    targets: Vec<Option<[Span; 3]>>,
    weights: Weights,
    /// The largest number of influences of a vertex.
    most_influences: usize,
}

/// Bounds on the weights of all vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weights {
    sums: Span,
    /// The largest sum of absolute weights, and of those of negative weights.
    absolute: f64,
    negative: f64,
}

/// A range of numbers. It is empty where low is above high.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    low: f64,
    high: f64,
}

impl Span {
    const EMPTY: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };
    const ZERO: Self = Self { low: 0.0, high: 0.0 };

    fn of(low: f64, high: f64) -> Self {
        Self { low: low.min(high), high: low.max(high) }
    }

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn plus(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }
    }

    fn times(self, factor: f64) -> Self {
        Self::of(factor * self.low, factor * self.high)
    }

    /// All products of a number of each.
    fn times_span(self, factors: Self) -> Self {
        self.times(factors.low).with(self.times(factors.high))
    }

    fn widened(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    fn length(self) -> f64 {
        self.high - self.low
    }

    /// The largest absolute value.
    fn size(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

fn spans(point: [f32; 3]) -> [Span; 3] {
    point.map(|c| Span::of(c.into(), c.into()))
}

fn axes(of: impl FnMut(usize) -> Span) -> [Span; 3] {
    let axes = [0, 1, 2];
    axes.map(of)
}

/// The box of some points. `None` if one is not finite, or there are none.
fn hull(points: impl IntoIterator<Item = [f32; 3]>) -> Option<[Span; 3]> {
    let mut hull = [Span::EMPTY; 3];
    for point in points {
        if point.iter().any(|c| !c.is_finite()) {
            return None;
        }
        let of_point = spans(point);
        hull = axes(|axis| hull[axis].with(of_point[axis]));
    }
    (hull[0].low <= hull[0].high).then_some(hull)
}

/// One unit in the last place, relative: WGSL names no direction of rounding.
const UNIT: f64 = 1.0 / 8_388_608.0;
/// The most that flushing takes off each term: 2⁻¹²¹.
const FLUSHED: f64 = f64::from_bits((1023 - 121) << 52);
/// No sum of absolute values may exceed this, so that nothing overflows: 2¹²⁶.
const LARGEST: f64 = f64::from_bits((1023 + 126) << 52);

impl ModelBounds {
    /// Goes over the vertices of the model, once.
    pub fn new(model: &Model) -> Self {
        let instances = model.instances().iter().map(super::Instance::geometry).collect();
        Self { geometries: model.geometries().iter().map(GeometryBounds::new).collect(), instances }
    }

    /// For each instance a box, in world space, that holds all of its vertices in this pose: its lowest and its highest
    /// corner. The work is that of some joints and morph targets, for any number of vertices.
    ///
    /// `displaced_by` is the most by which the caller's displacement moves any coordinate of a vertex, with its own
    /// rounding. It is 0 without a displacement. Infinity: no bound is known.
    ///
    /// An instance has no box if it has no vertices, a number that its pose uses is not finite, or numbers are so
    /// large that something may overflow.
    ///
    /// # Errors
    /// [`ModelError`] if the pose does not fit the model.
    pub fn boxes(&self, pose: &Pose, displaced_by: f32) -> Result<Vec<Option<Box3>>, ModelError> {
        pose.check_instances(self.instances.len())?;
        let instances = self.instances.iter().zip(pose.instances()).enumerate();
        let box_of_instance = |(number, (&geometry, pose)): (usize, (&usize, &InstancePose))| {
            let geometry = &self.geometries[geometry];
            pose.check_counts(number, geometry.joints_needed, geometry.targets_needed)?;
            Ok(geometry.posed(pose, displaced_by.into()))
        };
        instances.map(box_of_instance).collect()
    }
}

impl GeometryBounds {
    fn new(geometry: &Geometry) -> Self {
        let positions = geometry.positions();
        let rest = hull(positions.iter().copied());
        let targets = geometry.morph_targets().iter().map(|target| hull(target.iter().copied())).collect();
        let mut weights = Weights { sums: Span::of(1.0, 1.0), absolute: 1.0, negative: 0.0 };
        let mut joints: Vec<_> = rest.iter().map(|&rest| (0, rest)).collect();
        if let Some(influences) = geometry.influences() {
            weights = Weights { sums: Span::EMPTY, absolute: 0.0, negative: 0.0 };
            let mut boxes = BTreeMap::new();
            for (vertex, &position) in positions.iter().enumerate() {
                let (mut positive, mut negative) = (0.0, 0.0);
                let range = influences.range(vertex);
                for (&joint, &weight) in influences.joints()[range.clone()].iter().zip(&influences.weights()[range]) {
                    if weight != 0.0 {
                        let (span, position) =
                            (boxes.entry(joint as usize).or_insert([Span::EMPTY; 3]), spans(position));
                        *span = axes(|axis| span[axis].with(position[axis]));
                    }
                    positive += f64::from(weight.max(0.0));
                    negative += f64::from((-weight).max(0.0));
                }
                let sum = positive - negative;
                weights.sums = weights.sums.with(Span::of(sum, sum));
                weights.absolute = weights.absolute.max(positive + negative);
                weights.negative = weights.negative.max(negative);
            }
            joints = boxes.into_iter().collect();
        }
        Self {
            joints_needed: geometry.joints_needed(),
            targets_needed: geometry.morph_targets().len(),
            rest,
            joints,
            targets,
            weights,
            most_influences: geometry.influences().map_or(0, super::Influences::most_per_vertex),
        }
    }

    /// The box of a pose that has as many joints and targets as are needed.
    fn posed(&self, pose: &InstancePose, displaced_by: f64) -> Option<Box3> {
        let rest = self.rest?;
        let mut moved = [Span::ZERO; 3];
        let mut moved_size = [0.0; 3];
        let mut active = 0.0;
        // Above all inputs and all sums of absolute values.
        let mut largest = 1.0_f64;
        for (target, &weight) in self.targets.iter().zip(pose.morph_weights()).filter(|(_, weight)| **weight != 0.0) {
            let (offsets, weight) = ((*target)?, f64::from(weight));
            for axis in 0..3 {
                moved[axis] = moved[axis].plus(offsets[axis].times(weight));
                moved_size[axis] += weight.abs() * offsets[axis].size();
                largest = largest.max(offsets[axis].size());
            }
            active += 1.0;
            largest = largest.max(weight.abs());
        }
        let morphed_size = |rest: &[Span; 3]| [0, 1, 2].map(|axis| rest[axis].size() + moved_size[axis]);
        let size_of_all = morphed_size(&rest);
        for row in pose.palette().iter().take(self.joints_needed).flat_map(|matrix| matrix.rows()) {
            largest = row.iter().fold(largest, |largest, c| largest.max(f64::from(c.abs())));
            largest = largest.max(terms(&row, size_of_all));
        }
        largest = size_of_all.into_iter().fold(largest, f64::max);
        largest = largest.max(self.weights.absolute).max(self.weights.absolute * largest);
        let is_bounded = largest <= LARGEST && displaced_by >= 0.0 && displaced_by.is_finite();
        if !is_bounded {
            return None;
        }
        let mut placed = [Span::EMPTY; 3];
        let mut placed_size = [0.0_f64; 3];
        for (joint, rest) in &self.joints {
            let rows = pose.palette().get(*joint)?.rows();
            let (morphed, size) = (axes(|axis| rest[axis].plus(moved[axis])), morphed_size(rest));
            for (axis, row) in rows.iter().enumerate() {
                let [x, y, z, shift] = row.map(f64::from);
                let span = Span::of(shift, shift).plus(morphed[0].times(x));
                placed[axis] = placed[axis].with(span.plus(morphed[1].times(y)).plus(morphed[2].times(z)));
                placed_size[axis] = placed_size[axis].max(terms(row, size));
            }
        }
        if self.joints.is_empty() {
            // No joint moves any vertex: all sums are 0.
            placed = [Span::ZERO; 3];
        }
        let influences = self.most_influences as f64;
        let relative = ((active + influences + 7.0) * UNIT).exp_m1();
        let flushed = FLUSHED * influences.max(1.0) * (active + 1.0) * largest.powi(3);
        let Weights { sums, absolute, negative } = self.weights;
        let spans = axes(|axis| {
            let weighted = placed[axis].times_span(sums).widened(negative * placed[axis].length());
            weighted.widened(relative * absolute * placed_size[axis] + flushed + displaced_by)
        });
        let corners = [spans.map(|span| below(span.low)), spans.map(|span| -below(-span.high))];
        corners.iter().flatten().all(|c| c.is_finite()).then_some(corners)
    }
}

/// The sum of absolute values of a row times a position whose coordinates are at most `size`, and 1.
fn terms(row: &[f32; 4], size: [f64; 3]) -> f64 {
    let [x, y, z, shift] = row.map(|c| f64::from(c.abs()));
    x * size[0] + y * size[1] + z * size[2] + shift
}

/// A number that is not above `value`, and that no device flushes upwards.
fn below(value: f64) -> f32 {
    // A cast rounds to nearest.
    let rounded = (value as f32).next_down();
    if rounded != 0.0 && !rounded.is_normal() && rounded.is_finite() {
        return if rounded < 0.0 { -f32::MIN_POSITIVE } else { 0.0 };
    }
    rounded
}
