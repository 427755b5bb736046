//! Rooms between walls, with a lamp in each: what a lamp lights is in its own room.

use glam::Vec3;
use rimline::{Light, Matrix3x4};

use crate::casters::CasterMesh;
use crate::record::{Camera, Setting};
use crate::shapes;

/// The most figures in a room.
const CASTERS_A_ROOM: usize = 12;
/// Rooms along a side of the house. Each has a lamp. The sides of all walls are as many as a scene tries as occluders.
const ROOMS: usize = 3;
/// The most figures.
pub(super) const MOST: usize = CASTERS_A_ROOM * ROOMS * ROOMS;
/// From the middle of a room to that of the next, and from the floor to the ceiling, in metres.
const PITCH: f32 = 8.0;
const HEIGHT: f32 = 3.0;
/// Half the thickness of walls.
const THICK: f32 = 0.1;

/// A house of square rooms with so many figures of 4,000 faces, seen from its middle room.
pub(super) fn setting(casters: usize) -> Setting {
    let line = |index: usize| PITCH * (index as f32 - 0.5 * (ROOMS - 1) as f32);
    let middles: Vec<Vec3> =
        (0..ROOMS * ROOMS).map(|room| Vec3::new(line(room % ROOMS), 0.0, line(room / ROOMS))).collect();
    // Walls first, all of the same box.
    let mut placed: Vec<(usize, Matrix3x4)> = Vec::new();
    for across in 0..=ROOMS {
        for along in 0..ROOMS {
            let (across, along) = (line(across) - 0.5 * PITCH, line(along));
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
    Setting { ground: Some(0.0), occluders: Some((0, sides())), ..setting }
}

/// A wall from the floor to the ceiling: the cube from −1 to 1 at a place on the ground, with half its widths.
fn slab(at: [f32; 2], half: [f32; 2]) -> Matrix3x4 {
    let height = 0.5 * HEIGHT;
    [[half[0], 0.0, 0.0, at[0]], [0.0, height, 0.0, height], [0.0, 0.0, half[1], at[1]]]
}

/// The four upright sides of the cube, counter-clockwise from outside.
fn sides() -> Vec<[[f32; 3]; 4]> {
    let turned = |corners: [[f32; 3]; 4]| corners.map(|[x, y, z]| [z, y, -x]);
    let front = [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]];
    let mut sides = vec![front];
    for _ in 0..3 {
        sides.push(turned(sides[sides.len() - 1]));
    }
    sides
}
