//! A point near the models that positions in `f32` are relative to. docs/numerics/origin.md.

use crate::{Light, Transform};

/// The share of the smallest edge that positions in `f32` may be off by before an origin is chosen.
const SHARE: f64 = 1e-3;

/// A point near the models, in `f64`. Positions, lights and cameras in `f32` are relative to it.
///
/// Coordinates of surveys have six or seven digits before the point. In `f32` they are a tenth of a metre to half a metre
/// apart, and edges of that size collapse. Take all coordinates in `f64`, choose one origin for everything that is seen
/// together, and move it all there before it becomes `f32`:
///
/// ```
/// use rimline::mesh::Weld;
/// use rimline::{Mesh, Origin};
///
/// // A step of 0.2, far away.
/// let [x, z] = [392_143.517, -5_820_467.702];
/// let world = [[x, 34.1, z], [x + 0.2, 34.1, z], [x, 34.3, z]];
/// let faces = [[0, 1, 2]];
/// let origin = Origin::of(&world, &faces);
/// let positions: Vec<[f32; 3]> = world.iter().map(|&p| origin.position(p)).collect();
/// let mesh = Mesh::new(&positions, &faces, Weld::Position)?;
/// let lamp = origin.light([x, 40.0, z - 3.0, 1.0]);
/// let eye = origin.position([x + 8.0, 36.0, z + 5.0]);
///
/// assert!((positions[1][0] - positions[0][0] - 0.2).abs() < 1e-6);
/// // In `f32` without an origin, the step has another width.
/// assert!(((x + 0.2) as f32 - x as f32 - 0.2).abs() > 0.01);
/// # let _ = (mesh, lamp, eye);
/// # Ok::<(), rimline::MeshError>(())
/// ```
///
/// A [`Model`](crate::Model) takes it in its poses: [`Self::transform`] makes the matrices of an
/// [`InstancePose`](crate::InstancePose). A [`Scene`](crate::gpu::Scene) takes it in the positions or matrices of its
/// casters, its lights and its cameras. glTF files have a function for it: `gltf::Asset::set_origin`.
///
/// An origin is zero for models whose coordinates `f32` holds well. Then nothing changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Origin([f64; 3]);

impl Origin {
    /// No origin: coordinates are rounded to `f32` as they are.
    pub const ZERO: Self = Self([0.0; 3]);

    /// This origin, for example one that an archive states. A component that is not finite counts as 0.
    pub fn new(xyz: [f64; 3]) -> Self {
        // The sum turns −0 into 0.
        Self(xyz.map(|c| if c.is_finite() { c + 0.0 } else { 0.0 }))
    }

    /// The origin for triangles. Vertices that no face names do not count, nor do those whose coordinates `f32` cannot hold.
    pub fn of(positions: &[[f64; 3]], faces: &[[u32; 3]]) -> Self {
        let corner = |&v: &u32| positions.get(v as usize).copied();
        let bounds = Self::bounds(faces.iter().flatten().filter_map(corner));
        let edges = || {
            let edges = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
            Self::smallest_edge(edges.filter_map(|[a, b]| Some([corner(&a)?, corner(&b)?])))
        };
        bounds.map_or(Self::ZERO, |bounds| Self::near(bounds, edges))
    }

    /// The origin for what lies between a lowest and a highest corner. It is zero unless `f32` loses more than a
    /// thousandth of the smallest edge there: half the distance of two neighbouring numbers is more than that. Else each
    /// component is a multiple of one power of two, at least twice the largest side of the box, and the nearest to the
    /// box's middle. So a component is zero where the box contains or nearly contains the world's zero.
    ///
    /// `smallest_edge` is the length of the smallest edge that has one. It is called only if the result depends on it.
    pub fn near([low, high]: [[f64; 3]; 2], smallest_edge: impl FnOnce() -> f64) -> Self {
        let axes = [0, 1, 2];
        let extent = axes.iter().map(|&axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let farthest = low.iter().chain(&high).fold(0.0, |most: f64, c| most.max(c.abs()));
        if !(extent.is_finite() && farthest.is_finite()) {
            return Self::ZERO;
        }
        // No finer than `f32` is there, so most of what `f32` holds stays exact: docs/numerics/origin.md.
        let grid = power_of_two_from(2.0 * extent).max(2.0 * half_step(farthest));
        let origin = Self::new(axes.map(|axis| (low[axis].midpoint(high[axis]) / grid).round_ties_even() * grid));
        if origin == Self::ZERO || half_step(farthest) <= SHARE * smallest_edge() {
            return Self::ZERO;
        }
        origin
    }

    /// The lowest and the highest corner of the points that `f32` can hold, for [`Self::near`]. `None` if there are none.
    pub fn bounds(points: impl IntoIterator<Item = [f64; 3]>) -> Option<[[f64; 3]; 2]> {
        let mut bounds: Option<[[f64; 3]; 2]> = None;
        for point in points.into_iter().filter(is_held) {
            let [low, high] = bounds.get_or_insert([point; 2]);
            for (axis, c) in point.into_iter().enumerate() {
                low[axis] = low[axis].min(c);
                high[axis] = high[axis].max(c);
            }
        }
        bounds
    }

    /// The length of the smallest edge that has one, for [`Self::near`]. Infinity if there is none.
    pub fn smallest_edge(edges: impl IntoIterator<Item = [[f64; 3]; 2]>) -> f64 {
        let edges = edges.into_iter().filter(|ends| ends.iter().all(is_held));
        let square = |[a, b]: [[f64; 3]; 2]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        edges.map(square).filter(|&square| square > 0.0).fold(f64::INFINITY, f64::min).sqrt()
    }

    /// The point in the world.
    pub fn to_array(self) -> [f64; 3] {
        self.0
    }

    /// Whether this is no origin.
    pub fn is_zero(self) -> bool {
        self == Self::ZERO
    }

    /// A position relative to the origin: computed in `f64`, rounded once.
    pub fn position(self, [x, y, z]: [f64; 3]) -> [f32; 3] {
        let [ox, oy, oz] = self.0;
        [x - ox, y - oy, z - oz].map(|c| c as f32)
    }

    /// A light `(x, y, z, w)` relative to the origin, which is `(x, y, z) − w·origin`: computed in `f64`, rounded once. A
    /// light at infinity stays as it is.
    pub fn light(self, [x, y, z, w]: [f64; 4]) -> Light {
        let [ox, oy, oz] = self.0.map(|c| w * c);
        let [x, y, z] = [x - ox, y - oy, z - oz].map(|c| c as f32);
        Light::homogeneous([x, y, z, w as f32])
    }

    /// A transform from mesh space to the world, by columns, as one from mesh space to positions relative to the origin:
    /// computed in `f64`, rounded once.
    pub fn transform(self, [x, y, z, translation]: [[f64; 3]; 4]) -> Transform {
        let translation = std::array::from_fn(|axis| translation[axis] - self.0[axis]);
        [x, y, z, translation].map(|column| column.map(|c| c as f32)).into()
    }

    /// The most by which the position of a point between these corners may be off, once it is relative to the origin and
    /// rounded: half the distance of two neighbouring numbers.
    pub fn rounding(self, corners: [[f64; 3]; 2]) -> f64 {
        let offsets = corners.iter().flat_map(|corner| corner.iter().zip(self.0)).map(|(c, origin)| (c - origin).abs());
        half_step(offsets.fold(0.0, f64::max))
    }

    /// A position that is relative to the origin, in the world.
    pub fn to_world(self, position: [f32; 3]) -> [f64; 3] {
        let mut axis = self.0.iter();
        position.map(|c| f64::from(c) + axis.next().copied().unwrap_or(0.0))
    }
}

/// The most by which rounding to `f32` moves a number of this size: half the distance of two neighbouring ones.
pub(crate) fn half_step(size: f64) -> f64 {
    let least = f64::from(f32::MIN_POSITIVE);
    power_of_two_below(size.abs().max(least)) / f64::from(1 << 24)
}

fn is_held(point: &[f64; 3]) -> bool {
    point.iter().all(|&c| (c as f32).is_finite())
}

/// The largest power of two that is not above the absolute value of `size`, which is normal and finite.
pub(crate) fn power_of_two_below(size: f64) -> f64 {
    f64::from_bits(size.to_bits() & 0x7ff0_0000_0000_0000)
}

/// The smallest power of two that is not below `size`, or the least normal number.
fn power_of_two_from(size: f64) -> f64 {
    let size = size.max(f64::MIN_POSITIVE);
    let below = power_of_two_below(size);
    if below < size { 2.0 * below } else { below }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UTM: [f64; 3] = [392_143.517, 34.128, -5_820_467.702];

    fn boxed(at: [f64; 3], size: f64) -> [[f64; 3]; 2] {
        [at, at.map(|c| c + size)]
    }

    #[test]
    fn what_f32_holds_well_has_no_origin() {
        for (bounds, edge) in [
            // Around the world's zero, and near it, edges have little effect.
            (boxed([-1.0; 3], 2.0), 1e-12),
            (boxed([0.0, 0.9, -2.9], 2.0), 1e-12),
            // Numbers are 6e-8 apart there, and 0.03 apart.
            (boxed([1.0, 0.0, 9.0], 0.5), 1e-3),
            (boxed(UTM, 10.0), 250.1),
            // Nothing has an edge, or it is everywhere.
            (boxed(UTM, 0.0), f64::INFINITY),
            ([[f64::MIN; 3], [f64::MAX; 3]], 1.0),
        ] {
            assert_eq!(Origin::near(bounds, || edge), Origin::ZERO, "{bounds:?}, {edge}");
        }
        // It is called only if needed.
        Origin::near(boxed([-1.0; 3], 2.0), || panic!("no edge has an effect around zero"));
    }

    #[test]
    fn far_away_it_is_a_multiple_of_a_power_of_two_near_the_box() {
        let origin = Origin::near(boxed(UTM, 10.0), || 0.2);
        assert_eq!(origin.to_array(), [392_160.0, 32.0, -5_820_448.0]);
        // Half the distance of two numbers is a quarter there, a thousandth of 250.
        assert!(!Origin::near(boxed(UTM, 10.0), || 249.9).is_zero());
        // A narrow axis at zero has none, and −0 is none.
        let [x, y, z] = Origin::near([[1e6, -4.0, 0.0], [1e6 + 1.0, 3.0, 1.0]], || 1e-3).to_array();
        assert_eq!((x, y.to_bits(), z.to_bits()), (1e6, 0, 0));
        // Never finer than numbers are there: these have exact differences.
        let small = Origin::near(boxed([16_777_216.0; 3], 1e-3), || 1e-4).to_array();
        assert_eq!(small, [16_777_216.0; 3]);
    }

    #[test]
    fn vertices_without_faces_and_beyond_numbers_do_not_count() {
        let [x, y, z] = UTM;
        let triangle = [UTM, [x + 0.2, y, z], [x, y + 0.3, z]];
        let expected = Origin::of(&triangle, &[[0, 1, 2]]);
        assert!(!expected.is_zero());
        let mut positions = triangle.to_vec();
        positions.extend([[0.0; 3], [f64::NAN, 0.0, 0.0], [1e300, 0.0, 0.0]]);
        assert_eq!(Origin::of(&positions, &[[0, 1, 2]]), expected);
        assert_eq!(Origin::of(&positions, &[[0, 1, 2], [0, 4, 5], [0, 0, 99]]), expected);
        assert_eq!(Origin::of(&[], &[]), Origin::ZERO);
        assert_eq!(Origin::of(&positions, &[[0, 0, 0]]), Origin::ZERO);
        assert_eq!(Origin::new([f64::NAN, -0.0, 2.0]).to_array(), [0.0, 0.0, 2.0]);
    }

    #[test]
    fn everything_moves_by_the_same() {
        let origin = Origin::near(boxed(UTM, 10.0), || 0.2);
        let [ox, oy, oz] = origin.to_array();
        let position = [ox + 1.25, oy - 0.1, oz + 3.0];
        assert_eq!(origin.position(position), [1.25, -0.1, 3.0].map(|c: f64| c as f32));
        let [x, y, z] = position;
        assert_eq!(origin.light([x, y, z, 1.0]).xyz, origin.position(position));
        assert_eq!(
            origin.light([2.0 * x, 2.0 * y, 2.0 * z, 2.0]).to_array()[..3],
            [2.5, -0.2, 6.0].map(|c: f64| c as f32)
        );
        // A direction stays, bit for bit.
        assert_eq!(origin.light([0.1, 7.0, -3.0, 0.0]).to_array(), [0.1, 7.0, -3.0, 0.0].map(|c: f64| c as f32));
        let moved = origin.transform([[0.5, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], position]);
        assert_eq!(moved.columns()[3], origin.position(position));
        assert_eq!(moved.columns()[1], [0.0, 2.0, 0.0]);
        assert_eq!(origin.to_world([1.25, 0.0, 3.0]), [ox + 1.25, oy, oz + 3.0]);
    }
}
