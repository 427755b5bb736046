//! Setting of a scene of skipping: casters, lights, a camera, and the ground.

use rimline::{Light, Matrix3x4, ShadowCamera};
use rimline_bench::shapes::Shape;

use super::walk::Walk;

/// Casters, lights and a view. The same each time.
pub(super) struct Setting {
    pub(super) casters: Casters,
    pub(super) lights: Vec<Light>,
    pub(super) camera: ShadowCamera,
    /// Height of the ground, an infinite plane that receives and does not cast. `None`: there is none.
    pub(super) ground: Option<f32>,
    /// By how much lights turn about the y axis from frame to frame, in radians.
    pub(super) turn: f32,
    /// How far rigid casters move to and fro from frame to frame. Receivers stay where they are.
    pub(super) drift: f32,
    /// Pairs of caster and light of which the light's range reaches the caster, where casters begin.
    pub(super) pairs_in_range: usize,
}

impl Setting {
    /// The version of what is seen: casters that do not move look the same in each frame.
    pub(super) fn still_receivers(&self) -> Option<u64> {
        (matches!(self.casters, Casters::Rigid { .. }) && self.drift == 0.0).then_some(0)
    }
}

pub(super) enum Casters {
    /// Shapes, and for each caster its shape and where it stands.
    Rigid { shapes: Vec<Shape>, placed: Vec<(usize, Matrix3x4)> },
    /// Figures that walk.
    Walking(Walk),
}

impl Casters {
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Rigid { placed, .. } => placed.len(),
            Self::Walking(walk) => walk.model.instances().len(),
        }
    }

    /// Faces of all casters together.
    pub(super) fn faces(&self) -> usize {
        match self {
            Self::Rigid { shapes, placed } => placed.iter().map(|(shape, _)| shapes[*shape].faces.len()).sum(),
            Self::Walking(walk) => walk.model.placed_geometries().map(|geometry| geometry.faces().len()).sum(),
        }
    }
}
