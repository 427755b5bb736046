//! Where a mesh is placed, given by columns, by rows, or by glam's type.

use glam::{DAffine3, DVec3};

use crate::model::Matrix3x4;

/// A transform of positions, from mesh space to world space. Functions with a mesh transform accept all of these:
///
/// * four columns of three, the last one the translation, as `to_cols_array_2d` of any glam's `Affine3A` gives them,
/// * `Affine3A` of glam 0.34 itself, or `DAffine3`, which is rounded,
/// * three rows of four, [`Matrix3x4`].
///
/// The types differ, so none can be confused with another.
///
/// ```
/// use rimline::Transform;
///
/// let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [5.0, 6.0, 7.0_f32]];
/// let transform = Transform::from(columns);
/// assert_eq!(transform, Transform::from(glam::Affine3A::from_translation(glam::vec3a(5.0, 6.0, 7.0).into())));
/// assert_eq!(transform.rows()[0], [1.0, 0.0, 0.0, 5.0]);
/// assert_eq!(transform.columns(), columns);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    rows: Matrix3x4,
}

impl Transform {
    /// The rows of a transform that moves nothing.
    #[cfg(feature = "gpu")]
    pub(crate) const UNIT: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

    /// The rows: each axis of world space from `(x, y, z, 1)`.
    pub const fn rows(self) -> Matrix3x4 {
        self.rows
    }

    pub(crate) fn to_f64(self) -> DAffine3 {
        let [x, y, z, translation] = self.columns().map(|column| DVec3::from(column.map(f64::from)));
        DAffine3::from_cols(x, y, z, translation)
    }

    /// The columns: the images of the axes of mesh space, and of its origin.
    pub fn columns(self) -> [[f32; 3]; 4] {
        std::array::from_fn(|column| self.rows.map(|row| row[column]))
    }
}

impl From<Matrix3x4> for Transform {
    fn from(rows: Matrix3x4) -> Self {
        Self { rows }
    }
}

impl From<[[f32; 3]; 4]> for Transform {
    fn from(columns: [[f32; 3]; 4]) -> Self {
        Self { rows: std::array::from_fn(|row| columns.map(|column| column[row])) }
    }
}

impl From<glam::Affine3A> for Transform {
    fn from(transform: glam::Affine3A) -> Self {
        transform.to_cols_array_2d().into()
    }
}

/// Rounds to `f32`.
impl From<DAffine3> for Transform {
    fn from(transform: DAffine3) -> Self {
        transform.to_cols_array_2d().map(|column| column.map(|c| c as f32)).into()
    }
}

impl From<Transform> for glam::Affine3A {
    fn from(transform: Transform) -> Self {
        Self::from_cols_array_2d(&transform.columns())
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat, Vec3, vec3};

    use super::*;

    #[test]
    fn each_form_moves_points_alike() {
        let rotation = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-1.1);
        let affine = Affine3A::from_scale_rotation_translation(vec3(2.0, -0.5, 3.0), rotation, vec3(4.0, 5.0, -6.0));
        let transform = Transform::from(affine);
        assert_eq!(Affine3A::from(transform), affine);
        assert_eq!(Transform::from(transform.columns()), transform);
        assert_eq!(Transform::from(transform.rows()), transform);
        let point = vec3(0.3, -1.2, 2.5);
        let by_rows = transform.rows().map(|[x, y, z, w]| vec3(x, y, z).dot(point) + w);
        let [x, y, z, w] = transform.columns().map(Vec3::from);
        for found in [Vec3::from(by_rows), x * point.x + y * point.y + z * point.z + w] {
            assert!(found.distance(affine.transform_point3(point)) < 1e-5, "{found}");
        }
        // Rows read as columns would move it elsewhere.
        let columns: [[f32; 3]; 4] = std::array::from_fn(|at| transform.rows().as_flattened().as_chunks::<3>().0[at]);
        let moved = Affine3A::from(Transform::from(columns)).transform_point3(point);
        assert!(moved.distance(affine.transform_point3(point)) > 0.1);
    }
}
