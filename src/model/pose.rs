//! Poses: the transform and shape of each instance of a model at one time.

use glam::DAffine3;

use super::ModelError;
use crate::Transform;

/// A matrix of three rows and four columns, stored by rows. It maps `(x, y, z, 1)`. Functions take it as a [`Transform`].
pub type Matrix3x4 = [[f32; 4]; 3];

/// The state of one instance at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstancePose {
    palette: Vec<Transform>,
    morph_weights: Vec<f32>,
    faces_turned: bool,
}

impl InstancePose {
    /// Makes a pose. `palette` maps mesh space to world space, by columns, by glam's type or by rows: see [`Transform`]. It
    /// has a matrix for each joint if the geometry has influences, else one. Further ones move nothing, but count below.
    /// `morph_weights` has a weight for each morph target. Weights may be negative or larger than 1.
    ///
    /// The faces are turned if more matrices mirror (negative determinant) than do not, so that they stay
    /// counter-clockwise from outside. [`InstancePose::with_faces_turned`] overrides this.
    ///
    /// # Errors
    /// [`ModelError`] for a matrix or weight that is not finite.
    pub fn new(
        palette: impl IntoIterator<Item = impl Into<Transform>>,
        morph_weights: Vec<f32>,
    ) -> Result<Self, ModelError> {
        let palette: Vec<Transform> = palette.into_iter().map(Into::into).collect();
        let mirroring = palette.iter().filter(|matrix| determinant(matrix) < 0.0).count();
        let keeping = palette.iter().filter(|matrix| determinant(matrix) > 0.0).count();
        Self::with(palette, morph_weights, mirroring > keeping)
    }

    /// The same pose with faces reversed or not, for any matrices. Use it for skins with joints that no vertex
    /// follows, and for meshes that are wound inwards.
    #[must_use]
    pub fn with_faces_turned(self, faces_turned: bool) -> Self {
        Self { faces_turned, ..self }
    }

    /// Makes a pose of these parts. Checks that all numbers are finite.
    pub(crate) fn with(
        palette: Vec<Transform>,
        morph_weights: Vec<f32>,
        faces_turned: bool,
    ) -> Result<Self, ModelError> {
        let entries = palette.iter().flat_map(|matrix| matrix.rows()).flatten();
        if let Some((at, value)) = entries.enumerate().find(|(_, entry)| !entry.is_finite()) {
            let (joint, row, column) = (at / 12, at / 4 % 3, at % 4);
            return Err(ModelError::Matrix { joint, row, column, value });
        }
        if let Some(target) = morph_weights.iter().position(|weight| !weight.is_finite()) {
            return Err(ModelError::MorphWeight { target, weight: morph_weights[target] });
        }
        Ok(Self { palette, morph_weights, faces_turned })
    }

    /// The matrices from mesh space to world space, one for each joint. All are finite.
    pub fn palette(&self) -> &[Transform] {
        &self.palette
    }

    /// One weight for each morph target. All are finite.
    pub fn morph_weights(&self) -> &[f32] {
        &self.morph_weights
    }

    /// Whether [`Model::mesh`](super::Model::mesh) turns the faces, as [`Self::new`] or [`Self::with_faces_turned`] decided.
    pub fn faces_turned(&self) -> bool {
        self.faces_turned
    }

    fn placed(&self, at: &DAffine3) -> Result<Self, ModelError> {
        let palette = self.palette.iter().map(|matrix| (*at * matrix.to_f64()).into()).collect();
        let mirrors = at.matrix3.determinant() < 0.0;
        Self::with(palette, self.morph_weights.clone(), self.faces_turned != mirrors)
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
fn determinant(matrix: &Transform) -> f64 {
    let [a, b, c] = matrix.rows().map(|[x, y, z, _]| [x, y, z].map(f64::from));
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// The state of a whole model at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    pub(crate) instances: Vec<InstancePose>,
    pub(crate) mixed_determinants: usize,
}

impl Pose {
    /// One pose for each of [`Model::instances`](super::Model::instances), in their order. Functions that take a model
    /// and a pose compare the two and return a [`ModelError`] if they do not fit.
    pub fn new(instances: Vec<InstancePose>) -> Self {
        Self { instances, mixed_determinants: 0 }
    }

    /// This pose moved: all instances are transformed by `at`, for example a figure of a file into a level. Matrices are
    /// multiplied in `f64` and rounded once.
    ///
    /// # Errors
    /// [`ModelError::Matrix`] if a result is not finite.
    pub fn placed(&self, at: impl Into<Transform>) -> Result<Self, ModelError> {
        let at = at.into().to_f64();
        let instances = self.instances.iter().map(|instance| instance.placed(&at)).collect::<Result<_, _>>()?;
        Ok(Self { instances, ..*self })
    }

    /// Checks that there are as many instances as a model has.
    pub(crate) fn check_instances(&self, needed: usize) -> Result<(), ModelError> {
        let given = self.instances.len();
        if given == needed { Ok(()) } else { Err(ModelError::PoseInstances { given, needed }) }
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
