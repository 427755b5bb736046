//! Subjects of measurements: smooth closed meshes of growing size, the stress scenes, and the user's own model.

use std::time::Instant;

use glam::Vec3;
use rimline::Light;
use rimline::mesh::{Mesh, MeshError};

use crate::shapes::{self, Shape};
use crate::stress;

/// The class of the meshes that are not hard.
pub(crate) const ORDINARY: &str = "ordinary";
/// The class of the user's own model.
pub(crate) const OF_USER: &str = "own";

#[derive(Clone, Debug)]
pub(crate) enum Subject {
    /// A torus of about so many faces.
    Torus(usize),
    Scene(&'static str, usize),
    OfUser(Box<Model>),
}

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
    /// The time to make the edge records.
    pub(crate) topology_ms: f64,
    /// So many lights of a scene, or all of the user's, for any number.
    lights: Option<Box<dyn Fn(usize) -> Vec<Light>>>,
}

pub(crate) struct Case<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) mesh: &'a Mesh,
    pub(crate) lights: &'a [Light],
}

impl Subject {
    pub(crate) fn make(&self) -> Result<Made, MeshError> {
        let mut made = match self {
            Self::Torus(faces) => {
                let Shape { positions, faces } = torus(*faces);
                let name = format!("torus-{}", faces.len());
                let mesh = Mesh::from_faces(positions.len(), faces)?;
                Made { name, class: ORDINARY, mesh, positions, topology_ms: 0.0, lights: None }
            }
            Self::Scene(name, faces) => {
                let scene = stress::scene(name, *faces).ok_or(MeshError::NoFaces)?;
                let (mesh, positions, class) = (scene.mesh()?, scene.positions.clone(), scene.class);
                let lights: Box<dyn Fn(_) -> _> = Box::new(move |count| scene.lights(count));
                Made { name: (*name).to_owned(), class, mesh, positions, topology_ms: 0.0, lights: Some(lights) }
            }
            Self::OfUser(model) => {
                let Model { name, positions, mesh, lights } = (**model).clone();
                let is_lit = !lights.is_empty();
                let lights = is_lit.then(|| -> Box<dyn Fn(_) -> _> { Box::new(move |_| lights.clone()) });
                Made { name, class: OF_USER, mesh, positions, topology_ms: 0.0, lights }
            }
        };
        let faces = made.mesh.faces().to_vec();
        let begin = Instant::now();
        let _again = Mesh::from_faces(made.positions.len(), faces)?;
        made.topology_ms = begin.elapsed().as_secs_f64() * 1e3;
        Ok(made)
    }
}

impl Made {
    /// Its lights, or so many points and directions all around, above its middle.
    pub(crate) fn lights(&self, count: usize) -> Vec<Light> {
        if let Some(lights) = &self.lights {
            return lights(count);
        }
        let (middle, size) = if self.class == OF_USER { extent(&self.positions) } else { ([0.0; 3], 1.0) };
        let around = |index: usize| {
            let angle = index as f32 * 0.61;
            let towards = [3.0 * angle.cos(), 2.0 + 0.1 * index as f32, 3.0 * angle.sin()];
            // Beside a huge model it would be infinite.
            let at = std::array::from_fn(|axis| (middle[axis] + size * towards[axis]).clamp(f32::MIN, f32::MAX));
            if index.is_multiple_of(2) { Light::point(at) } else { Light::directional(towards) }
        };
        (0..count).map(around).collect()
    }
}

/// A torus of about so many faces.
pub(crate) fn torus(faces: usize) -> Shape {
    // Twice as many rings as segments, two faces each.
    let segments = ((faces as f64 / 4.0).sqrt().round() as u32).max(3);
    shapes::torus(2 * segments, segments, 1.0, 0.4)
}

/// The middle of the finite positions, and half their largest width.
pub(crate) fn extent(positions: &[[f32; 3]]) -> ([f32; 3], f32) {
    let finite = positions.iter().filter(|position| position.iter().all(|c| c.is_finite())).map(|p| Vec3::from(*p));
    let bounds = (Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY));
    let (low, high) = finite.fold(bounds, |(low, high), position| (low.min(position), high.max(position)));
    let size = (0.5 * (high - low)).max_element();
    // glam's midpoint is of a sum, which may overflow.
    let middle = std::array::from_fn(|axis| f32::midpoint(low[axis], high[axis]));
    if size > 0.0 && size.is_finite() { (middle, size) } else { ([0.0; 3], 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_around_a_huge_model_are_lights() {
        let positions = vec![[-1.5e38, 0.0, 0.0], [1.5e38, 0.0, 0.0], [0.0, 1.5e38, 0.0]];
        let mesh = Mesh::from_faces(positions.len(), vec![[0, 1, 2]]).expect("a face");
        let model = Model { name: String::new(), positions, mesh, lights: Vec::new() };
        let made = Subject::OfUser(Box::new(model)).make().expect("the same face");
        assert_eq!(rimline::check_lights(&made.lights(1024), 1024), Ok(()));
    }

    #[test]
    fn extents_are_finite() {
        let far = 2.0_f32.powi(127);
        let positions = [[far, -1.0, 0.0], [f32::NAN; 3], [1.5 * far, 1.0, 0.0]];
        assert_eq!(extent(&positions), ([1.25 * far, 0.0, 0.0], 0.25 * far));
        for positions in [[[1.0; 3]].as_slice(), &[], &[[-3e38; 3], [3e38; 3]], &[[f32::INFINITY; 3]]] {
            assert_eq!(extent(positions), ([0.0; 3], 1.0), "{positions:?}");
        }
    }
}
