//! Parts of a picture with soft shadows. Each takes one pixel of every two by two, at one of four places in it, and has a
//! pattern of samples of its own: 16 times as many samples in the end, for as many pixels drawn as with multisampling.

use glam::{Mat4, Vec3};

/// How many there are.
pub(crate) const PARTS: usize = 16;
/// Pixels of the picture from one of a part's to the next.
const PITCH: u32 = 2;
/// Where in a pixel, as multisampling has it.
const PLACES: [[f32; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// Which pixels of the picture are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// Pixels of the picture from one to the next.
    pub(super) pitch: f32,
    /// Where the first one's centre is.
    pub(super) first: [f32; 2],
    /// From the picture's clip space to the part's.
    pub(super) clip: Mat4,
}

impl Part {
    /// All of them.
    pub(crate) const WHOLE: Self = Self { pitch: 1.0, first: [0.5; 2], clip: Mat4::IDENTITY };

    /// Parts that follow each other share a pixel: their patterns are most unlike.
    pub(crate) fn of(size: [u32; 2], part: usize) -> Self {
        let (pixel, place) = (part / 4, PLACES[part % 4]);
        let first = [(pixel & 1) as f32 + place[0], (pixel >> 1) as f32 + place[1]];
        let pitch = PITCH as f32;
        let along = |axis: usize| {
            let (all, drawn) = (size[axis] as f32, Self::size(size)[axis] as f32);
            let scale = all / (pitch * drawn);
            (scale, scale + (1.0 - 2.0 * first[axis] / pitch) / drawn - 1.0)
        };
        let ((scale_x, move_x), (scale_y, move_y)) = (along(0), along(1));
        let clip = Mat4::from_translation(Vec3::new(move_x, -move_y, 0.0))
            * Mat4::from_scale(Vec3::new(scale_x, scale_y, 1.0));
        Self { pitch, first, clip }
    }

    /// Pixels of each part of a picture of this size.
    pub(crate) fn size(size: [u32; 2]) -> [u32; 2] {
        size.map(|pixels| pixels.div_ceil(PITCH))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_drawn_shows_its_place_in_the_picture() {
        for size in [[960, 720], [101, 33], [1, 1]] {
            for number in 0..PARTS {
                let part = Part::of(size, number);
                let drawn = Part::size(size).map(|pixels| pixels as f32);
                for pixel in [[0.0, 0.0], [drawn[0] - 1.0, drawn[1] - 1.0]] {
                    let place = [0, 1].map(|axis| part.pitch * pixel[axis] + part.first[axis]);
                    let [x, y] = [0, 1].map(|axis| 2.0 * place[axis] / size[axis] as f32 - 1.0);
                    let clip = part.clip.project_point3(Vec3::new(x, -y, 0.5));
                    let found = [0.5 * (clip.x + 1.0) * drawn[0] - 0.5, 0.5 * (1.0 - clip.y) * drawn[1] - 0.5];
                    let error = (found[0] - pixel[0]).abs().max((found[1] - pixel[1]).abs());
                    assert!(error < 1e-3, "{size:?}, part {number}: {found:?} instead of {pixel:?}");
                }
            }
        }
    }
}
