//! The scenes of skipping by name.

use glam::Vec3;
use rimline::{Light, ModelError};

use super::crowd::View;
use super::levels::{CLUSTERS, Choice, OCCLUDERS};
use super::{city, crowd, house};
use crate::casters::{CasterMesh, field};
use crate::record::{Camera, IDENTITY, Setting};
use crate::shapes;
use crate::text::grouped;

/// A scene, not made yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SkipScene {
    /// Name on the command line and in the data.
    pub(crate) name: &'static str,
    /// Name of the view in the data.
    pub(crate) view: &'static str,
    /// Name of a caster in the title, and the end of the title.
    titles: [&'static str; 2],
    /// The usual number of casters, of a whole run and of a quick one.
    pub(crate) usual: [usize; 2],
    /// The most casters that it is measured with.
    pub(crate) most: usize,
    of: Of,
}

/// The contents of a scene.
#[derive(Clone, Copy, Debug)]
enum Of {
    Casters(fn(usize) -> Result<Setting, ModelError>),
    /// One mesh of about so many faces.
    OneMesh(usize),
}

const fn of(
    [name, view]: [&'static str; 2],
    titles: [&'static str; 2],
    usual: [usize; 2],
    most: usize,
    make: fn(usize) -> Result<Setting, ModelError>,
) -> SkipScene {
    SkipScene { name, view, titles, usual, most, of: Of::Casters(make) }
}

const fn big(faces: usize) -> SkipScene {
    SkipScene { name: BIG, view: "whole", titles: [""; 2], usual: [1; 2], most: 1, of: Of::OneMesh(faces) }
}

const BIG: &str = "big";

/// All scenes, in the order of a run.
const SCENES: [SkipScene; 11] = [
    // Figures among which nothing moves.
    of(["still", "whole"], ["figure", ""], [1000, 20], 1000, |casters| {
        Ok(field(CasterMesh::Character.shape(), casters))
    }),
    of(["city", "along-street"], ["building", ", along a street"], [10_000, 100], usize::MAX, |buildings| {
        Ok(city::setting(buildings, city::ALONG))
    }),
    of(["city", "oblique"], ["building", ", obliquely"], [10_000, 100], usize::MAX, |buildings| {
        Ok(city::setting(buildings, city::OBLIQUE))
    }),
    // Skinned figures that walk, seen as a whole, and by one of them.
    of(["crowd", "whole"], ["walking figure", ""], [1000, 20], 1000, |walkers| crowd::setting(walkers, View::Whole)),
    of(["crowd", "within"], ["walking figure", ", from within"], [1000, 20], 1000, |walkers| {
        crowd::setting(walkers, View::Within)
    }),
    of(["moving", "whole"], ["caster", " of which all matters"], [200, 20], 1000, |casters| Ok(moving(casters))),
    // Rooms with a lamp and figures in each, and walls between them.
    of(["house", "within"], ["figure", " in rooms"], [100, 20], house::MOST, |figures| Ok(house::setting(figures))),
    big(16 << 16),
    big(64 << 16),
    big(168 << 16),
    big(256 << 16),
];
const QUICK_BIG: SkipScene = big(1 << 16);

impl SkipScene {
    /// The scenes of a name on the command line.
    pub(crate) fn named(name: &str, is_quick: bool) -> Vec<Self> {
        if is_quick && name == BIG {
            return vec![QUICK_BIG];
        }
        SCENES.into_iter().filter(|scene| scene.name == name).collect()
    }

    /// `still, 1,000 figures`.
    pub(crate) fn title(&self, casters: usize) -> String {
        match (self.of, self.titles) {
            (Of::OneMesh(faces), _) => format!("big, a mesh of {} faces", grouped(faces)),
            (_, [caster, rest]) => {
                let s = if casters == 1 { "" } else { "s" };
                format!("{}, {} {caster}{s}{rest}", self.name, grouped(casters))
            }
        }
    }

    /// The choices of levels that are measured. Meshes of many faces take long to prepare, and only clusters matter to them.
    pub(super) fn choices(&self) -> Vec<Choice> {
        let matters = |choice: &Choice| match choice.without {
            Some(OCCLUDERS) => self.name == "house",
            Some(level) => !self.is_one_mesh() || level == CLUSTERS,
            None => true,
        };
        Choice::all().filter(matters).collect()
    }

    /// Whether it always has one caster.
    pub(crate) fn is_one_mesh(&self) -> bool {
        matches!(self.of, Of::OneMesh(_))
    }

    pub(super) fn setting(&self, casters: usize) -> Result<Setting, ModelError> {
        match self.of {
            Of::Casters(make) => make(casters),
            Of::OneMesh(faces) => Ok(sphere(faces)),
        }
    }
}

/// A sphere of radius 1 with at least so many faces, but for rounding, and a light that circles above it.
fn sphere(faces: usize) -> Setting {
    let shape = shapes::sphere((faces as f64 / 8.0).sqrt().round() as u32);
    // So high that the eye is never in shadow.
    let lights = vec![Light::point([0.0, 5.0, -3.0])];
    let camera = Camera::level(Vec3::new(0.0, 0.0, 3.5), Vec3::NEG_Z, 2.0, 0.1);
    Setting { turn: 0.05, ..Setting::rigid(vec![shape], vec![(0, IDENTITY)], lights, &camera) }
}

/// From a caster of [`moving`] to the next, in units of which a caster is 3 wide.
const PITCH: f32 = 6.0;

/// Casters on the ground that all move, under lights that reach them all, before an eye that sees all shadows: what skipping
/// costs where it spares nothing.
fn moving(casters: usize) -> Setting {
    // 4,000 faces, and 5,780, which are in clusters.
    let shapes = vec![CasterMesh::Character.shape(), shapes::blob(27, 0.4, 3)];
    let columns = (casters as f32).sqrt().ceil().max(1.0) as usize;
    let rows = casters.div_ceil(columns);
    let line = |index: usize, count: usize| PITCH * (index as f32 - 0.5 * (count - 1) as f32);
    let placed = (0..casters).map(|number| {
        let [x, z] = [line(number % columns, columns), line(number / columns, rows)];
        (number % 2, [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, z]])
    });
    let lights = [[0.2, 1.0, 0.3], [-0.3, 1.0, 0.1], [0.1, 1.0, -0.3], [-0.2, 1.0, -0.2], [0.0, 1.0, 0.1]];
    let lights = lights.map(Light::directional).into();
    let width = PITCH * columns as f32;
    let eye = Vec3::new(0.0, width + 6.0, 0.3 * width + 2.0);
    let setting = Setting::rigid(shapes, placed.collect(), lights, &Camera::level(eye, -eye, 1.4, 0.1));
    Setting { ground: Some(0.0), drift: 0.01, ..setting }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rimline::cpu::{Threads, deform};

    use super::*;
    use crate::record::Casters;
    use crate::shapes::Shape;

    /// Positive where faces are counter-clockwise seen from outside.
    fn volume(shape: &Shape) -> f64 {
        let corner = |vertex: u32| DVec3::from(shape.positions[vertex as usize].map(f64::from));
        let signed = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c)) / 6.0;
        shape.faces.iter().map(|face| signed(face.map(corner))).sum()
    }

    #[test]
    fn casters_are_closed_and_wound_outwards_however_they_walk() {
        for scene in SCENES.iter().filter(|scene| !scene.is_one_mesh()) {
            let casters = scene.setting(scene.usual[1]).expect("a scene").casters;
            let shapes = match casters {
                Casters::Rigid { shapes, .. } | Casters::InBuffers(shapes) => shapes,
                Casters::Walking { model, pose } => {
                    let deformed = [0, 10, 25]
                        .map(|frame| pose(frame).expect("a pose"))
                        .map(|pose| deform(&model, &pose, 0.0, None, Threads::default()).expect("it fits"));
                    assert_ne!(deformed[0], deformed[1], "they walk");
                    let geometry = &model.geometries()[0];
                    let shape = |positions: &[[f32; 3]]| Shape {
                        positions: positions.to_vec(),
                        faces: geometry.faces().to_vec(),
                    };
                    deformed.concat().chunks(geometry.positions().len()).map(shape).collect()
                }
            };
            for shape in shapes {
                assert!(shape.mesh().expect("a mesh").is_closed(), "{}", scene.name);
                assert!(volume(&shape) > 0.1, "{}: {}", scene.name, volume(&shape));
            }
        }
    }

    #[test]
    fn the_sphere_has_about_as_many_faces_as_asked() {
        for faces in [1 << 16, 100_000, 1 << 20] {
            let found = sphere(faces).casters.faces();
            assert!(found.abs_diff(faces) < faces / 20, "{found} for {faces}");
        }
    }
}
