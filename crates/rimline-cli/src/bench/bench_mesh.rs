//! Subjects of measurements: smooth closed meshes of growing size, and the stress scenes.

use rimline::Light;
use rimline::mesh::{Mesh, MeshError};
use rimline_bench::shapes::{self, Shape};
use rimline_bench::stress;

/// The class of the meshes that are not hard.
pub(crate) const ORDINARY: &str = "ordinary";

/// A mesh to be measured, not made yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BenchMesh {
    /// A torus of about so many faces.
    Torus(usize),
    /// A stress scene, by name.
    Scene(&'static str, usize),
}

/// A mesh with its positions and what is known of it.
pub(crate) struct Made {
    pub(crate) name: String,
    pub(crate) class: &'static str,
    pub(crate) mesh: Mesh,
    pub(crate) positions: Vec<[f32; 3]>,
    scene: Option<stress::Scene>,
}

/// Input of one row.
pub(crate) struct Case<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) mesh: &'a Mesh,
    pub(crate) lights: &'a [Light],
}

impl BenchMesh {
    pub(crate) fn make(self) -> Result<Made, MeshError> {
        match self {
            Self::Torus(faces) => {
                // Twice as many rings as segments, two faces each.
                let segments = ((faces as f64 / 4.0).sqrt().round() as u32).max(3);
                let Shape { positions, faces } = shapes::torus(2 * segments, segments, 1.0, 0.4);
                let name = format!("torus-{}", faces.len());
                let mesh = Mesh::from_faces(positions.len(), faces)?;
                Ok(Made { name, class: ORDINARY, mesh, positions, scene: None })
            }
            Self::Scene(name, faces) => {
                let scene = stress::scene(name, faces).ok_or(MeshError::NoFaces)?;
                let (mesh, positions) = (scene.mesh()?, scene.positions.clone());
                Ok(Made { name: name.to_owned(), class: scene.class, mesh, positions, scene: Some(scene) })
            }
        }
    }

    /// Name for a progress line.
    pub(crate) fn title(self) -> String {
        match self {
            Self::Torus(faces) => format!("torus of {} faces", super::grouped::grouped(faces)),
            Self::Scene(name, _) => name.to_owned(),
        }
    }
}

impl Made {
    pub(crate) fn lights(&self, count: usize) -> Vec<Light> {
        match &self.scene {
            Some(scene) => scene.lights(count),
            None => (0..count).map(around).collect(),
        }
    }
}

/// Points and directions all around, above the middle.
fn around(index: usize) -> Light {
    let angle = index as f32 * 0.61;
    let towards = [3.0 * angle.cos(), 2.0 + 0.1 * index as f32, 3.0 * angle.sin()];
    if index.is_multiple_of(2) { Light::point(towards) } else { Light::directional(towards) }
}
