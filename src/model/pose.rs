//! Poses: where each instance of a model stands at one time, and how it is bent.

use super::{Geometry, ModelError, PoseMismatch};

/// A row-major 3×4 matrix that maps `(x, y, z, 1)`.
pub type Matrix3x4 = [[f32; 4]; 3];

/// The state of one instance at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstancePose {
    palette: Vec<Matrix3x4>,
    morph_weights: Vec<f32>,
    turned: bool,
}

impl InstancePose {
    /// `palette` takes mesh space to world space: a matrix a joint where the geometry has influences, else exactly one.
    /// `morph_weights` has a weight a morph target; weights may be negative, and larger than 1.
    ///
    /// The faces are turned if more matrices mirror (negative determinant) than do not, so that they stay
    /// counter-clockwise outside; [`InstancePose::with_turned`] sets this otherwise.
    ///
    /// # Errors
    /// [`ModelError`] for a matrix or weight that is not finite.
    pub fn new(palette: Vec<Matrix3x4>, morph_weights: Vec<f32>) -> Result<Self, ModelError> {
        let mirroring = palette.iter().filter(|matrix| determinant(matrix) < 0.0).count();
        let keeping = palette.iter().filter(|matrix| determinant(matrix) > 0.0).count();
        Self::with(palette, morph_weights, mirroring > keeping)
    }

    /// The same with faces turned or not, whatever the matrices: for skins that have joints which no vertex follows, and
    /// for meshes that are wound inwards.
    #[must_use]
    pub fn with_turned(self, turned: bool) -> Self {
        Self { turned, ..self }
    }

    /// Checks that all is finite.
    pub(crate) fn with(palette: Vec<Matrix3x4>, morph_weights: Vec<f32>, turned: bool) -> Result<Self, ModelError> {
        let entries = palette.as_flattened().as_flattened();
        if let Some(at) = entries.iter().position(|entry| !entry.is_finite()) {
            let (joint, row, column) = (at / 12, at / 4 % 3, at % 4);
            return Err(ModelError::Matrix { joint, row, column, value: entries[at] });
        }
        if let Some(target) = morph_weights.iter().position(|weight| !weight.is_finite()) {
            return Err(ModelError::MorphWeight { target, weight: morph_weights[target] });
        }
        Ok(Self { palette, morph_weights, turned })
    }

    /// Mesh space to world space, a matrix a joint; finite.
    pub fn palette(&self) -> &[Matrix3x4] {
        &self.palette
    }

    /// A weight a morph target; finite.
    pub fn morph_weights(&self) -> &[f32] {
        &self.morph_weights
    }

    /// The transform mirrors, so the faces are turned to stay counter-clockwise outside.
    pub fn turned(&self) -> bool {
        self.turned
    }

    /// Whether this poses instance `instance`, which is of `geometry`.
    pub(super) fn check(&self, instance: usize, geometry: &Geometry) -> Result<(), PoseMismatch> {
        self.check_counts(instance, geometry.joints_needed(), geometry.morph_targets().len())
    }

    /// Whether there are as many matrices and weights as instance `instance` needs.
    pub(crate) fn check_counts(&self, instance: usize, joints: usize, targets: usize) -> Result<(), PoseMismatch> {
        let (given, needed) = (self.palette.len(), joints);
        if given < needed {
            return Err(PoseMismatch::Palette { instance, given, needed });
        }
        let (given, needed) = (self.morph_weights.len(), targets);
        if given != needed {
            return Err(PoseMismatch::MorphWeights { instance, given, needed });
        }
        Ok(())
    }
}

/// Of the matrix's first three columns, in `f64`, where nothing finite in `f32` overflows.
fn determinant(matrix: &Matrix3x4) -> f64 {
    let [a, b, c] = matrix.map(|[x, y, z, _]| [x, y, z].map(f64::from));
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// The state of a whole model at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    instances: Vec<InstancePose>,
    mixed_determinants: usize,
}

impl Pose {
    /// A pose of each of [`Model::instances`](super::Model::instances), in their order. Whatever takes a pose of a model
    /// compares the two and reports a [`PoseMismatch`].
    pub fn new(instances: Vec<InstancePose>) -> Self {
        Self { instances, mixed_determinants: 0 }
    }

    #[cfg(feature = "gltf")]
    pub(crate) fn with_mixed_determinants(self, mixed_determinants: usize) -> Self {
        Self { mixed_determinants, ..self }
    }

    /// One for each of [`Model::instances`](super::Model::instances).
    pub fn instances(&self) -> &[InstancePose] {
        &self.instances
    }

    /// Skinned instances of a file of which some joint matrices mirror and some do not; they are turned by the majority.
    pub fn mixed_determinants(&self) -> usize {
        self.mixed_determinants
    }
}
