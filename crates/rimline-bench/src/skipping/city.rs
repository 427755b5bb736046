//! Buildings in a grid of streets, a sun, and a camera in a street.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};
use rimline::{Light, Matrix3x4};

use crate::random::Random;
use crate::record::{Camera, Setting};
use crate::shapes::Shape;

/// From the middle of a building to the middle of the next, in metres.
const PITCH: f32 = 28.0;
/// Half the widths of buildings. Streets are what is left.
const HALF_WIDTHS: [f32; 2] = [7.0, 9.5];
/// How deep buildings stand in the ground, so that no face of theirs lies in it.
const DEPTH: f32 = 1.0;
/// The height of the eye above the ground.
const EYE: f32 = 1.7;
/// Degrees from the direction of the street, to the right.
pub(super) const ALONG: f32 = 0.0;
pub(super) const OBLIQUE: f32 = 35.0;

/// The city with the camera turned by so many degrees.
pub(super) fn setting(buildings: usize, degrees: f32) -> Setting {
    let mut random = Random::new(2);
    let columns = (buildings as f32).sqrt().ceil().max(1.0) as usize;
    let rows = buildings.div_ceil(columns);
    // Where the middle of row or column number `index` of `count` lies.
    let line = |index: usize, count: usize| PITCH * (index as f32 - 0.5 * (count - 1) as f32);
    let placed = (0..buildings).map(|number| {
        let at = [line(number % columns, columns), line(number / columns, rows)];
        // Most are boxes.
        let shape = random.below(10).saturating_sub(6);
        let height = if random.below(12) == 0 { random.between(50.0, 110.0) } else { random.between(9.0, 36.0) };
        let [x, z] = [(); 2].map(|()| random.between(HALF_WIDTHS[0], HALF_WIDTHS[1]));
        (shape, building([x, height, z], at))
    });
    let placed = placed.collect();
    // The street beside the middle column, a quarter of the city before its end.
    let street = line(columns / 2, columns) - 0.5 * PITCH;
    let eye = Vec3::new(street, EYE, 0.25 * PITCH * rows as f32);
    let turn = Quat::from_rotation_y(-degrees.to_radians());
    let camera = Camera::level(eye, turn * Vec3::NEG_Z, 1.5, 0.1);
    let setting = Setting::rigid(shapes(), placed, vec![Light::directional([0.55, 0.7, 0.25])], &camera);
    Setting { ground: Some(0.0), ..setting }
}

/// A building of these half widths and this height at a place on the ground.
fn building([x, height, z]: [f32; 3], at: [f32; 2]) -> Matrix3x4 {
    [[x, 0.0, 0.0, at[0]], [0.0, height + DEPTH, 0.0, -DEPTH], [0.0, 0.0, z, at[1]]]
}

/// Prisms over what a building may stand on, from −1 to 1 and as high as 1: boxes of 12 faces, and others of up to 92.
fn shapes() -> Vec<Shape> {
    let round = |corners: u8| -> Vec<[f32; 2]> {
        let corner = |number| TAU * f32::from(number) / f32::from(corners);
        (0..corners).map(|number| [corner(number).cos(), corner(number).sin()]).collect()
    };
    let square = vec![[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    // All of it is seen from its first corner.
    let angle = vec![[0.1, 0.1], [0.1, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 0.1]];
    [square, angle, round(8), round(24)].iter().map(|outline| prism(outline)).collect()
}

/// Over an outline of x and z that runs from x to z and is seen whole from its first corner.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Casters;

    #[test]
    fn the_eye_stands_in_a_street() {
        for buildings in [1, 2, 7, 100, 10_000] {
            let Setting { casters, camera, .. } = setting(buildings, ALONG);
            let Casters::Rigid { placed, .. } = &casters else { panic!("buildings do not walk") };
            assert_eq!(casters.count(), buildings);
            for (_, [x, _, _]) in placed {
                assert!((camera.origin[0] - x[3]).abs() > x[0] + 1.0, "{buildings} buildings: {x:?}");
            }
        }
        // Most buildings have 12 faces.
        assert!((12..24).contains(&(setting(1000, OBLIQUE).casters.faces() / 1000)));
    }
}
