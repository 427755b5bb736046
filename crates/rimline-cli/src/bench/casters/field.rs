//! Recorded scenes: casters of one mesh at integer positions in a cube, with lights and a camera outside it.
//!
//! Positions of vertices and casters have so few digits that their sums are exact. So a caster in the scene has exactly
//! the silhouettes that its part of the merged mesh has.

use glam::Vec3;
use rimline::{Light, Matrix3x4, ShadowCamera};
use rimline_bench::random::Random;
use rimline_bench::shapes::{self, Shape};

use crate::render::camera::Camera;
use crate::shadow::frame::shadow_camera;

/// Lights of each scene.
pub(crate) const LIGHTS: usize = 5;

/// Half the width of the cube that casters stand in.
const HALF_WIDTH: i16 = 50;

/// Positions are multiples of its reciprocal.
const GRID: f32 = 4096.0;

/// The mesh that all casters of a scene have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CasterMesh {
    /// 12 faces.
    Cube,
    /// A torus of 4,000 faces, about what a figure in a crowd has.
    Figure,
}

impl CasterMesh {
    /// Name in the data.
    pub(crate) fn id(self) -> &'static str {
        match self {
            Self::Cube => "box",
            Self::Figure => "figure",
        }
    }

    /// `1 box`, `200 figures`.
    pub(crate) fn counted(self, casters: usize) -> String {
        let one = self.id();
        let many = match self {
            Self::Cube => "boxes",
            Self::Figure => "figures",
        };
        format!("{} {}", super::super::grouped::grouped(casters), if casters == 1 { one } else { many })
    }

    pub(in super::super) fn shape(self) -> Shape {
        match self {
            Self::Cube => shapes::cube(),
            Self::Figure => on_grid(shapes::torus(50, 40, 1.0, 0.4)),
        }
    }
}

fn on_grid(mut shape: Shape) -> Shape {
    for position in &mut shape.positions {
        *position = position.map(|c| (c * GRID).round() / GRID);
    }
    shape
}

/// Casters, lights and a camera. The same each time.
pub(in super::super) struct Field {
    pub(in super::super) shape: Shape,
    /// Where casters stand.
    pub(in super::super) places: Vec<[f32; 3]>,
    /// Where they may move to, turned.
    pub(super) turned: Vec<Matrix3x4>,
    pub(in super::super) lights: Vec<Light>,
    /// It sees about half of the cube.
    pub(in super::super) camera: ShadowCamera,
}

impl Field {
    pub(in super::super) fn new(shape: Shape, casters: usize) -> Self {
        let mut random = Random::new(1);
        let mut whole = |from: i16, to: i16| f32::from(from) + random.below((to - from) as usize + 1) as f32;
        let lights = (0..LIGHTS).map(|_| {
            let at = [whole(-HALF_WIDTH, HALF_WIDTH), whole(70, 90), whole(-HALF_WIDTH, HALF_WIDTH)];
            Light::point(at)
        });
        let lights = lights.collect();
        // A single caster is seen.
        let place = |index| if index == 0 { [0.0; 3] } else { [(); 3].map(|()| whole(-HALF_WIDTH, HALF_WIDTH)) };
        let places: Vec<[f32; 3]> = (0..casters).map(place).collect();
        let turned = places.iter().rev().map(|&[x, y, z]| {
            let (s, c) = random.between(-3.0, 3.0).sin_cos();
            [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z]]
        });
        let turned = turned.collect();
        let camera = Camera {
            eye: Vec3::new(0.0, 0.0, f32::from(HALF_WIDTH) + 4.0),
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            scale: [1.5; 2],
            near: 0.1,
        };
        Self { shape, places, turned, lights, camera: shadow_camera(&camera) }
    }

    /// Where a caster stands, as a matrix.
    pub(in super::super) fn transform(&[x, y, z]: &[f32; 3]) -> Matrix3x4 {
        [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]
    }

    /// The casters in world space, a shape each.
    pub(super) fn placed(&self) -> impl Iterator<Item = Shape> {
        self.places.iter().map(|place| {
            let at = |position: &[f32; 3]| std::array::from_fn(|axis| position[axis] + place[axis]);
            Shape { positions: self.shape.positions.iter().map(at).collect(), faces: self.shape.faces.clone() }
        })
    }

    /// All casters as one mesh. Their vertices are not welded.
    pub(super) fn merged(&self) -> Shape {
        let mut merged = Shape::default();
        for shape in self.placed() {
            let first = merged.positions.len() as u32;
            merged.positions.extend(shape.positions);
            merged.faces.extend(shape.faces.iter().map(|face| face.map(|vertex| first + vertex)));
        }
        merged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_exact_and_about_half_of_them_are_seen() {
        let field = Field::new(CasterMesh::Figure.shape(), 1000);
        for (place, shape) in field.places.iter().zip(field.placed()).step_by(50) {
            for (own, world) in field.shape.positions.iter().zip(&shape.positions) {
                let sum: [f64; 3] = std::array::from_fn(|axis| f64::from(own[axis]) + f64::from(place[axis]));
                assert_eq!(world.map(f64::from), sum);
            }
        }
        let (columns, origin) = (field.camera.view_projection, field.camera.origin);
        let seen = field.places.iter().filter(|place| {
            let at: [f32; 3] = std::array::from_fn(|axis| place[axis] - origin[axis]);
            let clip = (0..3)
                .fold(columns[3], |clip, axis| std::array::from_fn(|row| clip[row] + columns[axis][row] * at[axis]));
            clip[0].abs() < clip[3] && clip[1].abs() < clip[3]
        });
        let seen = seen.count();
        assert!((400..650).contains(&seen), "{seen}");
    }

    #[test]
    fn faces_of_casters_stay_apart_when_merged() {
        let field = Field::new(CasterMesh::Cube.shape(), 7);
        let mesh = field.merged().mesh().expect("boxes are a mesh");
        assert_eq!([mesh.faces().len(), mesh.edges().len()], [7 * 12, 7 * 18]);
        assert!(mesh.is_closed());
    }
}
