//! Skinned figures that walk, and lamps that reach few of them.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec3};
use rimline::{Geometry, GeometryOptions, Influences, Instance, InstancePose, Light, Model, ModelError, Pose};
use rimline_measure::models::rows;
use rimline_measure::random::Random;

use super::setting::{Casters, Setting};
use crate::render::camera::Camera;
use crate::shadow::frame::shadow_camera;

pub(super) const LAMPS: usize = 32;
/// One pair of figure and lamp in so many is within the lamp's range.
const ONE_PAIR_IN: usize = 20;
/// The ground for each figure, in square metres.
const GROUND: f32 = 9.0;
/// The height of lamps above the ground.
const LAMP: f32 = 4.0;
/// Metres and steps a second.
const SPEED: f32 = 1.25;
const STEPS: f32 = 0.9;
/// Frames a second.
const FRAMES: f32 = 30.0;

/// The model, and where each figure begins.
pub(super) struct Walk {
    pub(super) model: Model,
    figures: Vec<Walker>,
}

struct Walker {
    at: Vec3,
    /// About +Y, from +Z.
    heading: f32,
    /// How far into its cycle it begins.
    phase: f32,
}

impl Walk {
    /// For each figure a box that holds it after so many frames.
    pub(super) fn boxes(&self, frame: usize) -> impl Iterator<Item = [[f32; 3]; 2]> {
        let seconds = frame as f32 / FRAMES;
        self.figures.iter().map(move |walker| {
            let at = walker.at + Quat::from_rotation_y(walker.heading) * Vec3::Z * SPEED * seconds + MIDDLE;
            [(at - RADIUS).to_array(), (at + RADIUS).to_array()]
        })
    }

    /// All figures after so many frames.
    pub(super) fn pose(&self, frame: usize) -> Result<Pose, ModelError> {
        let seconds = frame as f32 / FRAMES;
        let pose = |walker: &Walker| {
            let turn = Quat::from_rotation_y(walker.heading);
            let at = walker.at + turn * Vec3::Z * SPEED * seconds;
            let palette = joints(walker.phase + STEPS * seconds);
            let place = Affine3A::from_rotation_translation(turn, at);
            InstancePose::new(palette.map(|joint| rows(place * joint)).to_vec(), Vec::new())
        };
        Ok(Pose::new(self.figures.iter().map(pose).collect::<Result<_, _>>()?))
    }
}

pub(super) fn setting(figures: usize) -> Result<Setting, ModelError> {
    let mut random = Random::new(3);
    let width = (GROUND * figures as f32).sqrt();
    let side = (figures as f32).sqrt().ceil().max(1.0) as usize;
    // Somewhere in its own square.
    let mut spot = |number: usize, columns: usize, rows: usize| {
        let mut along =
            |index: usize, count: usize| width * ((index as f32 + random.between(0.2, 0.8)) / count as f32 - 0.5);
        Vec3::new(along(number % columns, columns), 0.0, along(number / columns, rows))
    };
    let places: Vec<Vec3> = (0..figures).map(|number| spot(number, side, figures.div_ceil(side))).collect();
    let lamps: Vec<Vec3> = (0..LAMPS).map(|number| spot(number, 8, LAMPS / 8) + LAMP * Vec3::Y).collect();
    // The range at which the lamps reach as many as they should.
    let mut distances: Vec<f32> =
        lamps.iter().flat_map(|&lamp| places.iter().map(move |&place| from_lamp(lamp, place))).collect();
    distances.sort_by(f32::total_cmp);
    let pairs_in_range = (distances.len() / ONE_PAIR_IN).max(1);
    let range = distances.get(pairs_in_range - 1).map_or(1.0, |distance| distance + 1e-3);
    let walkers = places.iter().map(|&at| {
        let [heading, phase] = [random.between(-PI, PI), random.between(0.0, 1.0)];
        Walker { at, heading, phase }
    });
    let model = Model::new(vec![figure()?], vec![Instance::new(0, None); figures])?;
    // Above the crowd's edge, looking down at its middle.
    let eye = Vec3::new(0.0, 0.25 * width + 2.0, 0.55 * width + 4.0);
    let forward = -eye.normalize();
    let camera = Camera { eye, right: Vec3::X, up: Vec3::X.cross(forward), forward, scale: [1.5; 2], near: 0.1 };
    Ok(Setting {
        pairs_in_range: distances.iter().filter(|distance| **distance <= range).count(),
        casters: Casters::Walking(Walk { model, figures: walkers.collect() }),
        lights: lamps.iter().map(|lamp| Light::point(lamp.to_array()).with_range(range)).collect(),
        camera: shadow_camera(&camera),
        ground: Some(0.0),
    })
}

/// From a lamp to the nearest point of a ball that holds a figure.
fn from_lamp(lamp: Vec3, figure: Vec3) -> f32 {
    ((figure + MIDDLE - lamp).length() - RADIUS).max(0.0)
}

/// A ball around this holds a figure that walks.
const MIDDLE: Vec3 = Vec3::new(0.0, 0.9, 0.0);
const RADIUS: f32 = 1.0;

/// A part of the body: a closed tube from end to end. Its first half moves with the first joint, its second half with the
/// second one.
struct Tube {
    ends: [Vec3; 2],
    radius: f32,
    joints: [u32; 2],
}

/// Joints: the trunk, then for each side thigh, shank, upper arm, forearm.
const JOINTS: usize = 9;
const HIP: f32 = 0.92;
const KNEE: f32 = 0.5;
const SHOULDER: f32 = 1.42;
const ELBOW: f32 = 1.12;
/// From the middle to a leg and to an arm.
const LEG: f32 = 0.11;
const ARM: f32 = 0.27;
/// Corners around a tube, and rings along it: six tubes have 4,032 faces.
const AROUND: u32 = 16;
const RINGS: u32 = 21;

fn tubes() -> Vec<Tube> {
    let tube = |x: f32, [high, low]: [f32; 2], radius: f32, joints| Tube {
        ends: [Vec3::new(x, high, 0.0), Vec3::new(x, low, 0.0)],
        radius,
        joints,
    };
    let mut tubes = vec![tube(0.0, [1.5, 0.82], 0.19, [0, 0]), tube(0.0, [1.78, 1.48], 0.11, [0, 0])];
    for (side, first) in [(1.0, 1), (-1.0, 5)] {
        tubes.push(tube(side * LEG, [HIP + 0.08, 0.02], 0.085, [first, first + 1]));
        tubes.push(tube(side * ARM, [SHOULDER + 0.06, 0.8], 0.055, [first + 2, first + 3]));
    }
    tubes
}

/// The figure at rest, facing +Z.
fn figure() -> Result<Geometry, ModelError> {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    let (mut offsets, mut joints, mut weights) = (vec![0], Vec::new(), Vec::new());
    for Tube { ends, radius, joints: [upper, lower] } in tubes() {
        let first = positions.len() as u32;
        let mut vertex = |along: f32, turn: f32, radius: f32| {
            let at = ends[0].lerp(ends[1], along) + radius * Vec3::new(turn.cos(), 0.0, turn.sin());
            positions.push(at.to_array());
            // It bends within a fifth of its length.
            let share = ((along - 0.5) / 0.2 + 0.5).clamp(0.0, 1.0);
            joints.extend([upper, lower]);
            weights.extend([1.0 - share, share]);
            offsets.push(joints.len() as u32);
        };
        vertex(0.0, 0.0, 0.0);
        vertex(1.0, 0.0, 0.0);
        for ring in 1..=RINGS {
            let along = ring as f32 / (RINGS + 1) as f32;
            let round = (1.0 - (2.0 * along - 1.0).abs().powi(5)).sqrt();
            for corner in 0..AROUND {
                vertex(along, TAU * corner as f32 / AROUND as f32, radius * round);
            }
        }
        let at = |ring: u32, corner: u32| first + 2 + ring * AROUND + corner % AROUND;
        for corner in 0..AROUND {
            faces.push([first, at(0, corner + 1), at(0, corner)]);
            faces.push([first + 1, at(RINGS - 1, corner), at(RINGS - 1, corner + 1)]);
            for ring in 0..RINGS - 1 {
                let [a, b] = [at(ring, corner), at(ring, corner + 1)];
                let [c, d] = [at(ring + 1, corner), at(ring + 1, corner + 1)];
                faces.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    let influences = Some(Influences::new(offsets, joints, weights)?);
    Geometry::new(positions, faces, GeometryOptions { influences, ..GeometryOptions::default() })
}

/// Where the joints take the figure at a part of a cycle.
fn joints(phase: f32) -> [Affine3A; JOINTS] {
    let mut joints = [Affine3A::IDENTITY; JOINTS];
    // A turn about an axis across the body. Forward is a negative angle.
    let turn = |height: f32, angle: f32| {
        let at = Vec3::Y * height;
        Affine3A::from_translation(at) * Affine3A::from_rotation_x(angle) * Affine3A::from_translation(-at)
    };
    joints[0] = Affine3A::from_translation(0.02 * (2.0 * TAU * phase).cos() * Vec3::Y);
    for (first, phase) in [(1, phase), (5, phase + 0.5)] {
        let swing = (TAU * phase).sin();
        joints[first] = joints[0] * turn(HIP, -0.45 * swing);
        joints[first + 1] = joints[first] * turn(KNEE, 0.35 + 0.35 * (TAU * phase).cos());
        joints[first + 2] = joints[0] * turn(SHOULDER, 0.4 * swing);
        joints[first + 3] = joints[first + 2] * turn(ELBOW, -0.3);
    }
    joints
}

#[cfg(test)]
mod tests {
    use rimline::cpu::Threads;
    use rimline::mesh::Mesh;
    use rimline_measure::shapes::Shape;

    use super::super::tests::volume;
    use super::*;

    #[test]
    fn a_figure_is_closed_and_wound_outwards_however_it_walks() {
        let figure = figure().expect("a figure");
        let mesh = Mesh::from_faces(figure.positions().len(), figure.faces().to_vec()).expect("a mesh");
        assert!(mesh.is_closed());
        assert_eq!(figure.faces().len(), 4032);
        let Setting { casters: Casters::Walking(walk), .. } = setting(3).expect("three figures") else {
            panic!("the crowd walks")
        };
        let begin = walk.pose(0).expect("a pose");
        for frame in 0..40 {
            let pose = walk.pose(frame).expect("a pose");
            assert_eq!(begin == pose, frame == 0, "they walk");
            let deformed = rimline::cpu::deform(&walk.model, &pose, 0.0, None, Threads::default()).expect("it fits");
            for (number, walker) in walk.figures.iter().enumerate() {
                let count = figure.positions().len();
                let positions = deformed[number * count..][..count].to_vec();
                let seconds = frame as f32 / FRAMES;
                let at = walker.at + Quat::from_rotation_y(walker.heading) * Vec3::Z * SPEED * seconds;
                for &position in &positions {
                    assert!((Vec3::from(position) - at - MIDDLE).length() < RADIUS, "{position:?} of frame {frame}");
                }
                let shape = Shape { positions, faces: figure.faces().to_vec() };
                assert!(volume(&shape) > 0.1, "{}", volume(&shape));
            }
        }
    }

    #[test]
    fn a_twentieth_of_the_pairs_matters() {
        for figures in [20, 100, 1000] {
            let Setting { pairs_in_range, lights, casters, .. } = setting(figures).expect("figures");
            assert_eq!([lights.len(), casters.count()], [LAMPS, figures]);
            let share = pairs_in_range as f32 / (figures * LAMPS) as f32;
            assert!((0.045..=0.055).contains(&share), "{figures} figures: {share}");
        }
    }
}
