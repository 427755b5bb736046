//! The samples of a depth map on a lattice that has one row and column more on each side, which are far.

use crate::layout::DepthMapShape;

/// A sample of the lattice. The order is that from near to far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Key {
    /// It casts. The number counts the steps between depths from the near plane on.
    Steps(u32),
    /// It casts nothing.
    Far,
}

impl Key {
    /// The number that the shaders have for it.
    pub fn code(self) -> u32 {
        match self {
            Self::Steps(steps) => steps,
            Self::Far => 0x7fff_ffff,
        }
    }
}

/// A depth map: its shape, and a depth for each texel, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// The shape.
    pub shape: &'a DepthMapShape,
    /// The depths.
    pub depths: &'a [f32],
    /// The objects, if edges between them are marked.
    pub objects: &'a [u32],
}

impl Samples<'_> {
    /// The sample of a depth.
    pub(super) fn key(&self, depth: f32) -> Key {
        let unit = match depth {
            depth if depth.is_nan() => return Key::Far,
            depth if depth >= 1.0 => 1.0_f32,
            depth if depth >= f32::MIN_POSITIVE => depth,
            _ => 0.0,
        };
        let (far, near) = if self.shape.is_reversed == 1 { (0.0, 1.0_f32) } else { (1.0, 0.0_f32) };
        if unit == far { Key::Far } else { Key::Steps(unit.to_bits().abs_diff(near.to_bits())) }
    }

    /// The sample at a place of the lattice. Texel (0, 0) is at (1, 1). In a cube, the maps have no border, and lie three in a
    /// row.
    pub fn at(&self, [x, y]: [u32; 2]) -> Key {
        let [width, height] = self.shape.size;
        if self.shape.faces > 1 {
            return self.depths.get((y * 3 * width + x) as usize).map_or(Key::Far, |&depth| self.key(depth));
        }
        if x == 0 || y == 0 || x > width || y > height {
            return Key::Far;
        }
        let depth = self.depths.get((y - 1) as usize * width as usize + (x - 1) as usize);
        depth.map_or(Key::Far, |&depth| self.key(depth))
    }

    /// The object at a place of the lattice that is not far.
    pub fn object(&self, [x, y]: [u32; 2]) -> u32 {
        if self.shape.faces > 1 {
            return self.objects.get((y * 3 * self.shape.size[0] + x) as usize).copied().unwrap_or(0);
        }
        let texel = (y as usize).saturating_sub(1) * self.shape.size[0] as usize + (x as usize).saturating_sub(1);
        self.objects.get(texel).copied().unwrap_or(0)
    }

    /// The depth of any sample.
    pub fn depth_of(&self, key: Key) -> f32 {
        match key {
            Key::Steps(steps) => self.depth(steps),
            Key::Far => f32::from(self.shape.is_reversed != 1),
        }
    }

    /// The depth of a sample that casts.
    pub fn depth(&self, steps: u32) -> f32 {
        f32::from_bits(if self.shape.is_reversed == 1 { 1.0_f32.to_bits() - steps } else { steps })
    }
}
