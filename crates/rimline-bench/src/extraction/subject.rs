//! Subjects of measurements: smooth closed meshes of growing size, the stress scenes, and the user's own model.

use rimline::Light;
use rimline::mesh::{Mesh, MeshError};

use crate::shapes::{self, Shape};
use crate::stress;
use crate::text::grouped;

/// The class of the meshes that are not hard.
pub(crate) const ORDINARY: &str = "ordinary";
/// The class of the user's own model.
pub(crate) const OF_USER: &str = "own";

/// A mesh to be measured.
#[derive(Clone, Debug)]
pub(crate) enum Subject {
    /// A torus of about so many faces.
    Torus(usize),
    /// A stress scene, by name.
    Scene(&'static str, usize),
    OfUser(Box<Model>),
}

/// A model of the user.
#[derive(Clone, Debug)]
pub struct Model {
    pub name: String,
    pub positions: Vec<[f32; 3]>,
    pub mesh: Mesh,
    /// None: lights all around.
    pub lights: Vec<Light>,
}

/// A mesh with its positions and what is known of it.
pub(crate) struct Made {
    pub(crate) name: String,
    pub(crate) class: &'static str,
    pub(crate) mesh: Mesh,
    pub(crate) positions: Vec<[f32; 3]>,
    lights: Box<dyn Fn(usize) -> Vec<Light>>,
}

/// Input of one row.
pub(crate) struct Case<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) mesh: &'a Mesh,
    pub(crate) lights: &'a [Light],
}

impl Subject {
    pub(crate) fn make(&self) -> Result<Made, MeshError> {
        match self {
            Self::Torus(faces) => {
                let Shape { positions, faces } = torus(*faces);
                let name = format!("torus-{}", faces.len());
                let mesh = Mesh::from_faces(positions.len(), faces)?;
                let lights = |count| (0..count).map(|index| around([0.0; 3], 1.0, index)).collect();
                Ok(Made { name, class: ORDINARY, mesh, positions, lights: Box::new(lights) })
            }
            Self::Scene(name, faces) => {
                let scene = stress::scene(name, *faces).ok_or(MeshError::NoFaces)?;
                let (mesh, positions, class) = (scene.mesh()?, scene.positions.clone(), scene.class);
                let lights = move |count| scene.lights(count);
                Ok(Made { name: (*name).to_owned(), class, mesh, positions, lights: Box::new(lights) })
            }
            Self::OfUser(model) => {
                let Model { name, positions, mesh, lights } = (**model).clone();
                let ([x, y, z], size) = extent(&positions);
                let lights = move |count| {
                    let all_around = |count| (0..count).map(|index| around([x, y, z], size, index)).collect();
                    if lights.is_empty() { all_around(count) } else { lights.clone() }
                };
                Ok(Made { name, class: OF_USER, mesh, positions, lights: Box::new(lights) })
            }
        }
    }

    /// Name for a progress line.
    pub(crate) fn title(&self) -> String {
        match self {
            Self::Torus(faces) => format!("torus of {} faces", grouped(*faces)),
            Self::Scene(name, _) => (*name).to_owned(),
            Self::OfUser(model) => model.name.clone(),
        }
    }
}

impl Made {
    pub(crate) fn lights(&self, count: usize) -> Vec<Light> {
        (self.lights)(count)
    }
}

/// A torus of about so many faces.
pub(crate) fn torus(faces: usize) -> Shape {
    // Twice as many rings as segments, two faces each.
    let segments = ((faces as f64 / 4.0).sqrt().round() as u32).max(3);
    shapes::torus(2 * segments, segments, 1.0, 0.4)
}

/// Points and directions all around, above the middle of something of this size.
fn around(middle: [f32; 3], size: f32, index: usize) -> Light {
    let angle = index as f32 * 0.61;
    let towards = [3.0 * angle.cos(), 2.0 + 0.1 * index as f32, 3.0 * angle.sin()];
    let at = std::array::from_fn(|axis| middle[axis] + size * towards[axis]);
    if index.is_multiple_of(2) { Light::point(at) } else { Light::directional(towards) }
}

/// The middle of the finite positions, and half their largest width.
pub(crate) fn extent(positions: &[[f32; 3]]) -> ([f32; 3], f32) {
    let finite = positions.iter().filter(|position| position.iter().all(|c| c.is_finite()));
    let [low, high] = finite.fold([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]], |[low, high], position| {
        let of = |bound: [f32; 3], choose: fn(f32, f32) -> f32| {
            std::array::from_fn(|axis| choose(bound[axis], position[axis]))
        };
        [of(low, f32::min), of(high, f32::max)]
    });
    let size = (0..3).map(|axis| 0.5 * (high[axis] - low[axis])).fold(0.0, f32::max);
    let middle = std::array::from_fn(|axis| f32::midpoint(low[axis], high[axis]));
    if size > 0.0 && size.is_finite() { (middle, size) } else { ([0.0; 3], 1.0) }
}
