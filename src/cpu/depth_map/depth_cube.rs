//! A cube of six maps: which samples of two or three maps lie on the same ray.

use glam::IVec3;

use super::samples::{Key, Samples};
use crate::layout::DepthMapShape;

/// The axis that a face looks along, the one to its right, and the one up.
const AXES: [[IVec3; 3]; 6] = [
    [IVec3::X, IVec3::Z, IVec3::Y],
    [IVec3::NEG_X, IVec3::NEG_Z, IVec3::Y],
    [IVec3::Y, IVec3::X, IVec3::Z],
    [IVec3::NEG_Y, IVec3::X, IVec3::NEG_Z],
    [IVec3::Z, IVec3::NEG_X, IVec3::Y],
    [IVec3::NEG_Z, IVec3::X, IVec3::Y],
];

/// A sample of a map of a cube: the number of the map, and the place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CubeSample {
    /// The number of the map.
    pub face: u32,
    /// Texels from the left and the top.
    pub at: [u32; 2],
}

impl CubeSample {
    /// The sample at a place of the texture that has all maps.
    pub fn in_texture([x, y]: [u32; 2], side: u32) -> Self {
        Self { face: x / side + 3 * (y / side), at: [x % side, y % side] }
    }

    /// Its place in the texture that has all maps.
    pub fn place(self, side: u32) -> [u32; 2] {
        [self.face % 3 * side + self.at[0], self.face / 3 * side + self.at[1]]
    }

    /// The samples on its ray, in the order of the maps.
    pub fn on_ray(self, side: u32) -> impl Iterator<Item = Self> {
        let most = side as i32 - 1;
        let [forward, right, up] = AXES[self.face as usize % 6];
        let [x, y] = self.at.map(|place| place as i32);
        let direction = most * forward + (2 * x - most) * right + (most - 2 * y) * up;
        (0..).zip(AXES).filter(move |(_, axes)| axes[0].dot(direction) == most).map(move |(face, [_, right, up])| {
            let at = [direction.dot(right), -direction.dot(up)].map(|steps| i32::midpoint(most, steps));
            Self { face, at: at.map(|place| place as u32) }
        })
    }
}

/// Puts six maps into one, three in a row. `None`: the map casts nothing.
pub fn depth_cube(shape: &DepthMapShape, maps: [Option<&[f32]>; 6]) -> Vec<f32> {
    depth_cube_of_objects(shape, maps, [&[]; 6]).0
}

/// Puts six maps into one, and their objects. A sample has the object of the first map that has its depth, and 0 if it is far.
pub fn depth_cube_of_objects(
    shape: &DepthMapShape,
    maps: [Option<&[f32]>; 6],
    objects: [&[u32]; 6],
) -> (Vec<f32>, Vec<u32>) {
    let side = shape.size[0];
    let one = DepthMapShape { faces: 1, ..*shape };
    let key = |CubeSample { face, at: [x, y] }| {
        let depths = maps[face as usize % 6].unwrap_or(&[]);
        Samples { shape: &one, depths, objects: &[] }.at([x + 1, y + 1])
    };
    let places = (0..2 * side).flat_map(|y| (0..3 * side).map(move |x| [x, y]));
    let object = |CubeSample { face, at: [x, y] }: CubeSample| {
        objects[face as usize % 6].get((y * side + x) as usize).copied().unwrap_or(0)
    };
    let nearest = places.map(|place| {
        // The first of several.
        let nearest = CubeSample::in_texture(place, side).on_ray(side).min_by_key(|&sample| key(sample));
        let key = nearest.map_or(Key::Far, key);
        let object = if key == Key::Far { 0 } else { nearest.map_or(0, object) };
        (Samples { shape, depths: &[], objects: &[] }.depth_of(key), object)
    });
    nearest.unzip()
}
