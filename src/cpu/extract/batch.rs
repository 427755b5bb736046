//! Decides several faces at a time, so that the compiler can use a CPU's vector registers.

use crate::cpu::common::filter;
use crate::layout::LightBatch;

/// The number of faces at a time.
pub(crate) const LANES: usize = 16;

type Lanes = [f32; LANES];

/// The `f32` determinants of some faces for a batch of lights, as `wgsl/extract/facing.wgsl` computes them.
pub(crate) struct Batch {
    /// The bits of the determinants above zero.
    pub(crate) masks: [u32; LANES],
    /// The smallest absolute determinant, or NaN if a corner has a NaN. Infinite corners give no meaning.
    smallest: Lanes,
    normals: [Lanes; 3],
    /// |u|₁ |v|₁.
    sizes: Lanes,
}

impl Batch {
    /// `faces` has at most [`LANES`] faces. Unused lanes hold zeros: no determinant is above zero.
    #[inline]
    pub(crate) fn new(positions: &[[f32; 3]], faces: &[[u32; 3]], light_batch: &LightBatch) -> Self {
        let mut corners = [[[0.0; LANES]; 3]; 3];
        for (lane, face) in faces.iter().take(LANES).enumerate() {
            for (corner, &vertex) in corners.iter_mut().zip(face) {
                let position = positions.get(vertex as usize).copied().unwrap_or([f32::NAN; 3]);
                for (axis, coordinate) in corner.iter_mut().zip(position) {
                    axis[lane] = coordinate;
                }
            }
        }
        let [a, b, c] = &corners;
        let [u, v] = [difference(b, a), difference(c, a)];
        let n = [cross(&u, &v, 1, 2), cross(&u, &v, 2, 0), cross(&u, &v, 0, 1)];
        let (mut masks, mut smallest) = ([0; LANES], [f32::INFINITY; LANES]);
        for (bit, &[x, y, z, w]) in light_batch.lights.iter().take(light_batch.count as usize).enumerate() {
            for lane in 0..LANES {
                let to_light = [x - w * a[0][lane], y - w * a[1][lane], z - w * a[2][lane]];
                let d = n[0][lane] * to_light[0] + n[1][lane] * to_light[1] + n[2][lane] * to_light[2];
                masks[lane] |= u32::from(d > 0.0) << bit;
                // With a NaN in a corner all determinants are NaN. `certain` refuses infinite corners by `largest`.
                smallest[lane] = if smallest[lane] < d.abs() { smallest[lane] } else { d.abs() };
            }
        }
        let mut sizes = [0.0; LANES];
        for (lane, size) in sizes.iter_mut().enumerate() {
            let [u, v] = [&u, &v].map(|side| side[0][lane].abs() + side[1][lane].abs() + side[2][lane].abs());
            *size = u * v;
        }
        Self { masks, smallest, normals: n, sizes }
    }

    /// Which faces one bound makes certain. The WGSL uses the largest coordinate of the face. This uses that of the
    /// mesh, `largest`, which is infinite if a coordinate is. So other faces may be certain, but the bits are the same.
    #[inline]
    pub(crate) fn certain(&self, largest: f32, light_batch: &LightBatch) -> [bool; LANES] {
        let is_possible = largest < filter::LARGE;
        let (relative, least) = filter::face_bound(largest, light_batch.magnitudes);
        std::array::from_fn(|lane| is_possible && self.smallest[lane] > relative * self.sizes[lane] + least)
    }

    /// Which faces have finite normals. A coordinate that is not finite makes two components of the normal not finite,
    /// so this one test replaces nine. It also fails for finite coordinates whose normal overflows.
    #[inline]
    pub(crate) fn finite(&self) -> [bool; LANES] {
        let [x, y, z] = &self.normals;
        std::array::from_fn(|lane| (x[lane] + y[lane] + z[lane]).is_finite())
    }
}

fn difference(p: &[Lanes; 3], q: &[Lanes; 3]) -> [Lanes; 3] {
    let mut difference = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for lane in 0..LANES {
            difference[axis][lane] = p[axis][lane] - q[axis][lane];
        }
    }
    difference
}

/// A component of the cross product.
fn cross(u: &[Lanes; 3], v: &[Lanes; 3], second: usize, third: usize) -> Lanes {
    let mut component = [0.0; LANES];
    for lane in 0..LANES {
        component[lane] = u[second][lane] * v[third][lane] - u[third][lane] * v[second][lane];
    }
    component
}
