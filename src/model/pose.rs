//! Poses: the place and shape of each instance of a model at one time.

use super::{Geometry, ModelError};

/// A matrix of three rows and four columns, stored by rows. It maps `(x, y, z, 1)`.
pub type Matrix3x4 = [[f32; 4]; 3];

/// The state of one instance at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstancePose {
    palette: Vec<Matrix3x4>,
    morph_weights: Vec<f32>,
    faces_turned: bool,
}

impl InstancePose {
    /// Makes a pose. `palette` maps mesh space to world space. It has a matrix for each joint if the geometry has
    /// influences, else exactly one. `morph_weights` has a weight for each morph target. Weights may be negative or
    /// larger than 1.
    ///
    /// The faces are turned if more matrices mirror (negative determinant) than do not, so that they stay
    /// counter-clockwise from outside. [`InstancePose::with_faces_turned`] overrides this.
    ///
    /// # Errors
    /// [`ModelError`] for a matrix or weight that is not finite.
    pub fn new(palette: Vec<Matrix3x4>, morph_weights: Vec<f32>) -> Result<Self, ModelError> {
        let mirroring = palette.iter().filter(|matrix| determinant(matrix) < 0.0).count();
        let keeping = palette.iter().filter(|matrix| determinant(matrix) > 0.0).count();
        Self::with(palette, morph_weights, mirroring > keeping)
    }

    /// The same pose with faces turned or not, whatever the matrices are. Use it for skins with joints that no vertex
    /// follows, and for meshes that are wound inwards.
    #[must_use]
    pub fn with_faces_turned(self, faces_turned: bool) -> Self {
        Self { faces_turned, ..self }
    }

    /// Checks that all numbers are finite.
    pub(crate) fn with(
        palette: Vec<Matrix3x4>,
        morph_weights: Vec<f32>,
        faces_turned: bool,
    ) -> Result<Self, ModelError> {
        let entries = palette.as_flattened().as_flattened();
        if let Some(at) = entries.iter().position(|entry| !entry.is_finite()) {
            let (joint, row, column) = (at / 12, at / 4 % 3, at % 4);
            return Err(ModelError::Matrix { joint, row, column, value: entries[at] });
        }
        if let Some(target) = morph_weights.iter().position(|weight| !weight.is_finite()) {
            return Err(ModelError::MorphWeight { target, weight: morph_weights[target] });
        }
        Ok(Self { palette, morph_weights, faces_turned })
    }

    /// The matrices from mesh space to world space, one for each joint. All are finite.
    pub fn palette(&self) -> &[Matrix3x4] {
        &self.palette
    }

    /// One weight for each morph target. All are finite.
    pub fn morph_weights(&self) -> &[f32] {
        &self.morph_weights
    }

    /// Whether the faces are turned, because the transform mirrors them. They so stay counter-clockwise from outside.
    pub fn faces_turned(&self) -> bool {
        self.faces_turned
    }

    /// Checks that this pose fits instance number `instance`, which is of `geometry`.
    pub(super) fn check(&self, instance: usize, geometry: &Geometry) -> Result<(), ModelError> {
        self.check_counts(instance, geometry.joints_needed(), geometry.morph_targets().len())
    }

    /// Checks that there are as many matrices and weights as instance number `instance` needs.
    pub(crate) fn check_counts(&self, instance: usize, joints: usize, targets: usize) -> Result<(), ModelError> {
        let (given, needed) = (self.palette.len(), joints);
        if given < needed {
            return Err(ModelError::PosePalette { instance, given, needed });
        }
        let (given, needed) = (self.morph_weights.len(), targets);
        if given != needed {
            return Err(ModelError::PoseMorphWeights { instance, given, needed });
        }
        Ok(())
    }
}

/// The determinant of the first three columns. It is computed in `f64`, where no product of finite `f32` overflows.
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
    /// One pose for each of [`Model::instances`](super::Model::instances), in their order. Functions that take a model
    /// and a pose compare the two and return a [`ModelError`] if they do not fit.
    pub fn new(instances: Vec<InstancePose>) -> Self {
        Self { instances, mixed_determinants: 0 }
    }

    #[cfg(feature = "gltf")]
    pub(crate) fn with_mixed_determinants(self, mixed_determinants: usize) -> Self {
        Self { mixed_determinants, ..self }
    }

    /// One pose for each of [`Model::instances`](super::Model::instances).
    pub fn instances(&self) -> &[InstancePose] {
        &self.instances
    }

    /// The number of skinned instances that have both mirroring and non-mirroring joint matrices. The majority decides
    /// whether they are turned. It is 0 for poses that were not loaded from a file.
    pub fn mixed_determinants(&self) -> usize {
        self.mixed_determinants
    }
}
