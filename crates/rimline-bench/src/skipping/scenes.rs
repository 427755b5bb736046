//! The scenes of skipping.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};
use rimline::{Instance, Light, Matrix3x4, Model, ModelError};

use super::walk::{MIDDLE, RADIUS, Walker, pose, walker_mesh};
use crate::casters::{CasterMesh, field};
use crate::random::Random;
use crate::record::{Camera, Casters, IDENTITY, Setting};
use crate::shapes::{self, Shape};
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
    /// Faces of the only mesh, or 0.
    faces: usize,
    /// By the number of casters, or of the mesh's faces.
    make: fn(usize) -> Result<Setting, ModelError>,
}

const fn of(
    [name, view, caster, rest]: [&'static str; 4],
    usual: [usize; 2],
    most: usize,
    make: fn(usize) -> Result<Setting, ModelError>,
) -> SkipScene {
    SkipScene { name, view, titles: [caster, rest], usual, most, faces: 0, make }
}

const fn big(faces: usize) -> SkipScene {
    let scene = of([BIG, "whole", "", ""], [1; 2], 1, |faces| Ok(sphere(faces)));
    SkipScene { faces, ..scene }
}

const BIG: &str = "big";
const QUICK_BIG: SkipScene = big(1 << 16);

/// All scenes, in the order of a run.
const SCENES: [SkipScene; 11] = [
    // Figures among which nothing moves.
    of(["still", "whole", "figure", ""], [1000, 20], 1000, |all| Ok(field(CasterMesh::Character.shape(), all))),
    of(["city", "along-street", "building", ", along a street"], [10_000, 100], usize::MAX, |all| Ok(city(all, 0.0))),
    of(["city", "oblique", "building", ", obliquely"], [10_000, 100], usize::MAX, |all| Ok(city(all, 35.0))),
    // Skinned figures that walk, seen as a whole, and by one of them.
    of(["crowd", "whole", "walking figure", ""], [1000, 20], 1000, |all| crowd(all, false)),
    of(["crowd", "within", "walking figure", ", from within"], [1000, 20], 1000, |all| crowd(all, true)),
    of(["moving", "whole", "caster", " of which all matters"], [200, 20], 1000, |all| Ok(moving(all))),
    // Rooms with a lamp and figures in each, and walls between them.
    of(["house", "within", "figure", " in rooms"], [100, 20], CASTERS_A_ROOM * ROOMS * ROOMS, |all| Ok(house(all))),
    big(16 << 16),
    big(64 << 16),
    big(168 << 16),
    big(256 << 16),
];

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
        let Self { name, titles: [caster, rest], faces, .. } = self;
        let s = if casters == 1 { "" } else { "s" };
        if self.is_one_mesh() {
            return format!("{name}, a mesh of {} faces", grouped(*faces));
        }
        format!("{name}, {} {caster}{s}{rest}", grouped(casters))
    }

    /// Whether it always has one caster.
    pub(crate) fn is_one_mesh(&self) -> bool {
        self.faces > 0
    }

    pub(super) fn setting(&self, casters: usize) -> Result<Setting, ModelError> {
        (self.make)(if self.is_one_mesh() { self.faces } else { casters })
    }
}

/// A sphere of radius 1 with about so many faces, and a light that circles above it.
fn sphere(faces: usize) -> Setting {
    let shape = shapes::sphere((faces as f64 / 8.0).sqrt().round() as u32);
    // So high that the eye is never in shadow.
    let lights = vec![Light::point([0.0, 5.0, -3.0])];
    let camera = Camera::level(Vec3::new(0.0, 0.0, 3.5), Vec3::NEG_Z, 2.0, 0.1);
    Setting { turn: 0.05, ..Setting::rigid(vec![shape], vec![(0, IDENTITY)], lights, &camera) }
}

/// Where cell `index` of `count` in a line around 0 lies.
fn line(pitch: f32, index: usize, count: usize) -> f32 {
    pitch * (index as f32 - 0.5 * (count - 1) as f32)
}

/// Columns and rows of a grid of so many cells.
fn grid(cells: usize) -> [usize; 2] {
    let columns = (cells as f32).sqrt().ceil().max(1.0) as usize;
    [columns, cells.div_ceil(columns)]
}

/// Casters on the ground that all move, under lights that reach them all, before an eye that sees all shadows: what skipping
/// costs where it spares nothing.
fn moving(casters: usize) -> Setting {
    // A caster is 3 wide.
    const PITCH: f32 = 6.0;
    // 4,000 faces, and 5,832, which are in clusters.
    let shapes = vec![CasterMesh::Character.shape(), shapes::blob(27, 0.4, 3)];
    let [columns, rows] = grid(casters);
    let placed = (0..casters).map(|number| {
        let [x, z] = [line(PITCH, number % columns, columns), line(PITCH, number / columns, rows)];
        (number % 2, [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, z]])
    });
    let lights = [[0.2, 1.0, 0.3], [-0.3, 1.0, 0.1], [0.1, 1.0, -0.3], [-0.2, 1.0, -0.2], [0.0, 1.0, 0.1]];
    let lights = lights.map(Light::directional).into();
    let width = PITCH * columns as f32;
    let eye = Vec3::new(0.0, width + 6.0, 0.3 * width + 2.0);
    let setting = Setting::rigid(shapes, placed.collect(), lights, &Camera::level(eye, -eye, 1.4, 0.1));
    Setting { ground: Some(0.0), drift: 0.01, ..setting }
}

/// Buildings in a grid of streets, a sun, and a camera in a street, turned by so many degrees to the right. In metres.
fn city(buildings: usize, degrees: f32) -> Setting {
    const PITCH: f32 = 28.0;
    // How deep buildings stand in the ground, so that no face of theirs lies in it.
    const DEPTH: f32 = 1.0;
    let mut random = Random::new(2);
    let [columns, rows] = grid(buildings);
    let placed = (0..buildings).map(|number| {
        let at = [line(PITCH, number % columns, columns), line(PITCH, number / columns, rows)];
        // Most are boxes.
        let shape = random.below(10).saturating_sub(6);
        let height = if random.below(12) == 0 { random.between(50.0, 110.0) } else { random.between(9.0, 36.0) };
        let [x, z] = [(); 2].map(|()| random.between(7.0, 9.5));
        (shape, [[x, 0.0, 0.0, at[0]], [0.0, height + DEPTH, 0.0, -DEPTH], [0.0, 0.0, z, at[1]]])
    });
    let placed = placed.collect();
    // Outlines of x and z that run from x to z and are seen whole from their first corners: boxes of 12 faces, and others
    // of up to 92.
    let round = |corners: u8| -> Vec<[f32; 2]> {
        let corner = |number| TAU * f32::from(number) / f32::from(corners);
        (0..corners).map(|number| [corner(number).cos(), corner(number).sin()]).collect()
    };
    let square = vec![[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let angle = vec![[0.1, 0.1], [0.1, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 0.1]];
    let shapes = [square, angle, round(8), round(24)].iter().map(|outline| prism(outline)).collect();
    // The street beside the middle column, a quarter of the city before its end.
    let street = line(PITCH, columns / 2, columns) - 0.5 * PITCH;
    let eye = Vec3::new(street, 1.7, 0.25 * PITCH * rows as f32);
    let turn = Quat::from_rotation_y(-degrees.to_radians());
    let camera = Camera::level(eye, turn * Vec3::NEG_Z, 1.5, 0.1);
    let setting = Setting::rigid(shapes, placed, vec![Light::directional([0.55, 0.7, 0.25])], &camera);
    Setting { ground: Some(0.0), ..setting }
}

/// From 0 to 1 over an outline.
fn prism(outline: &[[f32; 2]]) -> Shape {
    let count = outline.len() as u32;
    let mut shape = Shape::default();
    for y in [0.0, 1.0] {
        shape.positions.extend(outline.iter().map(|&[x, z]| [x, y, z]));
    }
    for corner in 0..count {
        let next = (corner + 1) % count;
        shape.faces.extend([[corner, count + next, next], [corner, count + corner, count + next]]);
    }
    for corner in 1..count - 1 {
        shape.faces.extend([[0, corner, corner + 1], [count, count + corner + 1, count + corner]]);
    }
    shape
}

/// Rooms along a side of the house. Each has a lamp. The sides of all walls are 96; a scene tries at most 128 occluders.
const ROOMS: usize = 3;
const CASTERS_A_ROOM: usize = 12;

/// A house of square rooms with so many figures of 4,000 faces, seen from its middle room: what a lamp lights is in its
/// own room.
fn house(casters: usize) -> Setting {
    // In metres; walls are twice as thick.
    const PITCH: f32 = 8.0;
    const HEIGHT: f32 = 3.0;
    const THICK: f32 = 0.1;
    let middles: Vec<Vec3> = (0..ROOMS * ROOMS)
        .map(|room| Vec3::new(line(PITCH, room % ROOMS, ROOMS), 0.0, line(PITCH, room / ROOMS, ROOMS)))
        .collect();
    // The cube from −1 to 1 with these half widths, from the floor to the ceiling.
    let slab = |at: [f32; 2], half: [f32; 2]| -> Matrix3x4 {
        let height = 0.5 * HEIGHT;
        [[half[0], 0.0, 0.0, at[0]], [0.0, height, 0.0, height], [0.0, 0.0, half[1], at[1]]]
    };
    let mut placed: Vec<(usize, Matrix3x4)> = Vec::new();
    for across in 0..=ROOMS {
        for along in 0..ROOMS {
            let (across, along) = (line(PITCH, across, ROOMS) - 0.5 * PITCH, line(PITCH, along, ROOMS));
            placed.push((0, slab([across, along], [THICK, 0.5 * PITCH])));
            placed.push((0, slab([along, across], [0.5 * PITCH, THICK])));
        }
    }
    placed.extend((0..casters).map(|caster| {
        let (room, slot) = (caster % middles.len(), caster / middles.len());
        // Four side by side.
        let [x, z] = [(slot % 4) as f32, (slot / 4) as f32];
        let at = middles[room] + Vec3::new(1.5 * x - 2.25, 1.0, 1.5 * z - 1.5);
        (1, [[0.3, 0.0, 0.0, at.x], [0.0, 0.3, 0.0, at.y], [0.0, 0.0, 0.3, at.z]])
    }));
    // Beside the middle of rooms, so that no wall is in a lamp's plane.
    let lights = middles.iter().map(|at| Light::point([at.x + 0.3, HEIGHT - 0.5, at.z + 0.2])).collect();
    let eye = middles[middles.len() / 2] + Vec3::new(-3.0, 1.7, 3.0);
    let camera = Camera::level(eye, Vec3::new(1.0, -0.2, -1.0), 1.5, 0.1);
    let setting = Setting::rigid(vec![shapes::cube(), CasterMesh::Character.shape()], placed, lights, &camera);
    // The four upright sides of the cube, counter-clockwise from outside.
    let front = [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]];
    let turned = |corners: &[[f32; 3]; 4]| Some(corners.map(|[x, y, z]| [z, y, -x]));
    let sides = std::iter::successors(Some(front), turned).take(4).collect();
    Setting { ground: Some(0.0), occluders: Some((0, sides)), ..setting }
}

const LAMPS: usize = 32;

/// Figures that walk, each with 9 m² of ground, and lamps of which each reaches a twentieth. Seen from above the crowd's edge,
/// or from its middle, level.
fn crowd(walker_count: usize, is_within: bool) -> Result<Setting, ModelError> {
    let mut random = Random::new(3);
    let width = (9.0 * walker_count as f32).sqrt();
    let [side, rows] = grid(walker_count);
    // Somewhere in its own square.
    let mut spot = |number: usize, columns: usize, rows: usize| {
        let mut along =
            |index: usize, count: usize| width * ((index as f32 + random.between(0.2, 0.8)) / count as f32 - 0.5);
        Vec3::new(along(number % columns, columns), 0.0, along(number / columns, rows))
    };
    let spots: Vec<Vec3> = (0..walker_count).map(|number| spot(number, side, rows)).collect();
    let lamps: Vec<Vec3> = (0..LAMPS).map(|number| spot(number, 8, LAMPS / 8) + 4.0 * Vec3::Y).collect();
    // From each lamp to the nearest point of a ball that holds a figure: the range at which lamps reach as many as they
    // should.
    let from_lamp = |lamp: Vec3, foot: Vec3| ((foot + MIDDLE - lamp).length() - RADIUS).max(0.0);
    let mut distances: Vec<f32> =
        lamps.iter().flat_map(|&lamp| spots.iter().map(move |&at| from_lamp(lamp, at))).collect();
    distances.sort_by(f32::total_cmp);
    let reached = (distances.len() / 20).max(1);
    let range = distances.get(reached - 1).map_or(1.0, |distance| distance + 1e-3);
    let walkers = spots.iter().map(|&at| {
        let [heading, phase] = [random.between(-PI, PI), random.between(0.0, 1.0)];
        Walker { at, heading, phase }
    });
    let walkers: Vec<Walker> = walkers.collect();
    let model = Model::new(vec![walker_mesh()?], vec![Instance::new(0, None); walker_count])?;
    let above = Vec3::new(0.0, 0.25 * width + 2.0, 0.55 * width + 4.0);
    // Where four squares meet.
    let within = Vec3::new(width * ((side / 2) as f32 / side as f32 - 0.5), 1.6, 0.0);
    let (eye, forward) = if is_within { (within, Vec3::NEG_Z) } else { (above, -above) };
    let pairs_in_range = distances.iter().filter(|distance| **distance <= range).count();
    let casters = Casters::Walking { model, pose: Box::new(move |frame| pose(&walkers, frame)) };
    let lights = lamps.iter().map(|lamp| Light::point(lamp.to_array()).with_range(range)).collect();
    let camera = Camera::level(eye, forward, 1.5, 0.1).shadow();
    Ok(Setting { pairs_in_range, ground: Some(0.0), ..Setting::new(casters, lights, camera) })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rimline::cpu::{Threads, deform};

    use super::*;

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
                    let deformed = [0, 10, 25].map(|frame| {
                        let pose = pose(frame).expect("a pose");
                        deform(&model, &pose, 0.0, None, Threads::default()).expect("it fits")
                    });
                    assert_ne!(deformed[0], deformed[1], "they walk");
                    let geometry = &model.geometries()[0];
                    let faces = geometry.faces().to_vec();
                    let shape = |all: &[[f32; 3]]| Shape { positions: all.to_vec(), faces: faces.clone() };
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

    #[test]
    fn buildings_have_the_faces_and_volumes_of_their_outlines() {
        let Casters::Rigid { shapes, .. } = city(1, 0.0).casters else { panic!("buildings do not walk") };
        let faces: Vec<usize> = shapes.iter().map(|shape| shape.faces.len()).collect();
        assert_eq!(faces, [12, 20, 28, 92]);
        for (shape, expected) in shapes.iter().zip([4.0, 4.0 - 0.81, 2.828, 3.106]) {
            assert!((volume(shape) - expected).abs() < 1e-3, "{}", volume(shape));
        }
    }

    #[test]
    fn the_eye_stands_in_a_street() {
        for buildings in [1, 2, 7, 100, 10_000] {
            let Setting { casters, camera, .. } = city(buildings, 0.0);
            let Casters::Rigid { placed, .. } = &casters else { panic!("buildings do not walk") };
            assert_eq!(casters.count(), buildings);
            for (_, [x, _, _]) in placed {
                assert!((camera.origin[0] - x[3]).abs() > x[0] + 1.0, "{buildings} buildings: {x:?}");
            }
        }
        // Most buildings have 12 faces.
        assert!((12..24).contains(&(city(1000, 35.0).casters.faces() / 1000)));
    }

    #[test]
    fn a_twentieth_of_the_pairs_matters() {
        for count in [20, 100, 1000] {
            let Setting { pairs_in_range, lights, casters, .. } = crowd(count, false).expect("figures");
            assert_eq!([lights.len(), casters.count()], [LAMPS, count]);
            let share = pairs_in_range as f32 / (count * LAMPS) as f32;
            assert!((0.045..=0.055).contains(&share), "{count} figures: {share}");
        }
    }
}
