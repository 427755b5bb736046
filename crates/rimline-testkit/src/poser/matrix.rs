//! Affine matrices in `f64`.

/// Rows of a 3×4 matrix that maps `(x, y, z, 1)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine(pub [[f64; 4]; 3]);

impl Affine {
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// The matrix of 16 values, column by column (3.5.3).
    pub(super) fn from_columns(columns: &[f64]) -> Self {
        Self([0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| columns[4 * column + row])))
    }

    /// First scaled, then turned, then moved (3.5.3); the quaternion `(x, y, z, w)` is brought to length 1.
    pub(super) fn from_trs(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Self {
        let length = rotation.iter().map(|c| c * c).sum::<f64>().sqrt();
        let [x, y, z, w] = rotation.map(|c| c / length);
        let turned = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Self([0, 1, 2].map(|row| {
            let [x, y, z] = turned[row];
            [x * scale[0], y * scale[1], z * scale[2], translation[row]]
        }))
    }

    /// `self` after `first`.
    pub(super) fn after(&self, first: &Self) -> Self {
        Self(self.0.map(|row| {
            [0, 1, 2, 3].map(|column| {
                let product: f64 = (0..3).map(|k| row[k] * first.0[k][column]).sum();
                product + if column == 3 { row[3] } else { 0.0 }
            })
        }))
    }
}
