//! The order of faces in space: by the axis that the normal is nearest to, and then along a Hilbert curve.
//!
//! The direction of an axis counts, too. So the two sides of a thin wall lie far apart in the order, and so do those of a
//! sharp edge. At most five clusters have normals near different axes, which makes bounds narrow.

use super::plane::{Batch, Kind, LANES, LARGE, Plane};
use crate::cpu::Threads;
use crate::cpu::common::positions::position;

/// Cells of the curve along each axis: 2 to this power.
const LEVELS: u32 = 10;
/// The last cell along an axis.
const LAST_CELL: u32 = (1 << LEVELS) - 1;
/// Bits of a face's index. [`crate::mesh::MAX_FACES`] is below 2³⁰.
const INDEX_BITS: u32 = 30;

/// Instead of an axis: faces of [`Kind::Irregular`], which come after those of the six axes.
const IRREGULAR: u32 = 6;
/// Instead of an axis: faces of [`Kind::Degenerate`], which come last.
const DEGENERATE: u32 = 7;

/// Planes in the order of the mesh, and the order of faces in space.
pub(super) struct Order {
    pub(super) planes: Vec<Plane>,
    /// For each slot the face. Faces with equal keys keep the order of the mesh.
    pub(super) faces: Vec<u32>,
}

impl Order {
    pub(super) fn new(positions: &[[f32; 3]], faces: &[[u32; 3]], threads: Threads) -> Self {
        let grid = Grid::of(positions, faces);
        let mut planes = vec![[[0.0; 3]; 2]; faces.len()];
        let keys = threads.share(&mut planes, |first, planes| {
            let mut keys = Vec::with_capacity(planes.len());
            for (planes, faces) in planes.chunks_mut(LANES).zip(faces[first..].chunks(LANES)) {
                let batch = Batch::new(positions, faces);
                let cells = grid.cells(&batch);
                for (lane, plane) in planes.iter_mut().enumerate() {
                    *plane = batch.plane(lane);
                    let key = u64::from(axis(plane)) << (3 * LEVELS) | u64::from(hilbert(cells[lane]));
                    keys.push(key << INDEX_BITS | (first + keys.len()) as u64);
                }
            }
            keys
        });
        let mut keys = keys.concat();
        keys.sort_unstable();
        Self { planes, faces: keys.into_iter().map(|key| (key & ((1 << INDEX_BITS) - 1)) as u32).collect() }
    }
}

/// The axis that the normal is nearest to, with its direction: 0 to 5. Else [`IRREGULAR`] or [`DEGENERATE`].
fn axis(plane: &Plane) -> u32 {
    let [[x, y, z], _] = *plane;
    // The largest component of a regular plane's normal is 1 or −1.
    let axis = if x.abs() == 1.0 { 0 } else { 1 + u32::from(z.abs() == 1.0) };
    match Kind::of(plane) {
        Kind::Regular => 2 * axis + u32::from([x, y, z][axis as usize] < 0.0),
        Kind::Irregular => IRREGULAR,
        Kind::Degenerate => DEGENERATE,
    }
}

/// Cubic cells of a box around first corners of faces: of all, or of each eighth face in a large mesh.
struct Grid {
    low: [f32; 3],
    cells_per_unit: f32,
}

impl Grid {
    fn of(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Self {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        // Some of the faces are enough: centres outside the box are in the outermost cells.
        let step = if faces.len() > 4096 { 8 } else { 1 };
        for &[first, ..] in faces.iter().step_by(step) {
            let corner = position(positions, first);
            for (axis, &c) in corner.iter().enumerate().filter(|(_, c)| c.abs() < LARGE) {
                low[axis] = if c < low[axis] { c } else { low[axis] };
                high[axis] = if c > high[axis] { c } else { high[axis] };
            }
        }
        let longest = (0..3).fold(0.0_f32, |longest, axis| longest.max(high[axis] - low[axis]));
        Self { low, cells_per_unit: (1 << LEVELS) as f32 / longest }
    }

    /// The cells of the centres of faces, as three bits for each level. Masks do not depend on them, only the order of
    /// slots and the speed. So any cell will do for numbers that are too large or not finite.
    fn cells(&self, batch: &Batch) -> [u32; LANES] {
        let [a, b, c] = &batch.corners;
        let mut cells = [0; LANES];
        for axis in 0..3 {
            for lane in 0..LANES {
                let centre = (a[axis][lane] + b[axis][lane] + c[axis][lane]) * (1.0 / 3.0);
                cells[lane] |= spread(self.cell(axis, centre)) << axis;
            }
        }
        cells
    }

    #[inline]
    fn cell(&self, axis: usize, centre: f32) -> u32 {
        let cell = (centre - self.low[axis]) * self.cells_per_unit;
        // A NaN becomes 0.
        let cell = if cell > 0.0 { cell } else { 0.0 };
        let cell = if cell < LAST_CELL as f32 { cell } else { LAST_CELL as f32 };
        // The sum with 2²³ has the number, rounded, in its lowest bits. This is quicker than a cast.
        (cell + 8_388_608.0).to_bits() & LAST_CELL
    }
}

/// The index of a cell along a Hilbert curve, two levels at a time. `octants` has three bits for each level.
fn hilbert(octants: u32) -> u32 {
    let (mut along, mut state) = (0, 0);
    for pair in (0..LEVELS / 2).rev() {
        let step = PAIRS[(state << 6 | octants >> (6 * pair) & 63) as usize];
        along = along << 6 | u32::from(step & 63);
        state = u32::from(step >> 6);
    }
    along
}

/// Bit i of the lowest ten goes to bit 3·i.
fn spread(bits: u32) -> u32 {
    let bits = (bits | bits << 16) & 0x0300_00ff;
    let bits = (bits | bits << 8) & 0x0300_f00f;
    let bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}

/// For each state of the curve and two octants, the second within the first: their numbers along the curve, and from bit 6
/// on the state within the second.
static PAIRS: [u16; 24 << 6] = {
    let mut pairs = [0; 24 << 6];
    let mut index = 0;
    while index < pairs.len() {
        let (first, state) = step((index >> 6) as u8, (index >> 3 & 7) as u8);
        let (second, state) = step(state, (index & 7) as u8);
        pairs[index] = (state as u16) << 6 | (first as u16) << 3 | second as u16;
        index += 1;
    }
    pairs
};

/// The number of an octant along the curve, and the state of the curve within. C. Hamilton, "Compact Hilbert Indices"
/// (2006), section 2: a state is the corner where the curve enters, and the axis that leads from there to the corner where it
/// leaves.
const fn step(state: u8, octant: u8) -> (u8, u8) {
    let (entry, axis) = (state / 3, state % 3);
    // The inverse of a Gray code, of bits that are rotated back.
    let code = rotate_left(octant ^ entry, 2 - axis);
    let number = code ^ code >> 1 ^ code >> 2;
    let entry = entry ^ rotate_left(entry_of(number), axis + 1);
    (number, 3 * entry + (axis + axis_of(number) + 1) % 3)
}

const fn rotate_left(bits: u8, by: u8) -> u8 {
    let by = by % 3;
    (bits << by | bits >> (3 - by)) & 7
}

/// The corner where the curve enters octant `number`.
const fn entry_of(number: u8) -> u8 {
    if number == 0 {
        return 0;
    }
    let even = (number - 1) / 2 * 2;
    even ^ even >> 1
}

/// The axis that leads from the corner where the curve enters octant `number` to the corner where it leaves it.
const fn axis_of(number: u8) -> u8 {
    match number {
        0 => 0,
        _ if number.is_multiple_of(2) => ((number - 1).trailing_ones() % 3) as u8,
        _ => (number.trailing_ones() % 3) as u8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octants([x, y, z]: [u32; 3]) -> u32 {
        spread(x) | spread(y) << 1 | spread(z) << 2
    }

    #[test]
    fn the_curve_goes_from_cell_to_neighbour_and_visits_each_once() {
        let side = 1 << LEVELS;
        // The first 32³ cells of the curve are a cube, too.
        let cube = 32;
        let mut cells = vec![None; cube * cube * cube];
        for index in 0..cells.len() {
            let cell = [index % cube, index / cube % cube, index / cube / cube].map(|c| c as u32);
            let along = hilbert(octants(cell)) as usize;
            assert!(along < cells.len() && cells[along].is_none(), "{cell:?} at {along}");
            cells[along] = Some(cell);
        }
        let cells: Vec<_> = cells.into_iter().flatten().collect();
        for pair in cells.windows(2) {
            let distance: u32 = (0..3).map(|axis| pair[0][axis].abs_diff(pair[1][axis])).sum();
            assert_eq!(distance, 1, "{pair:?}");
        }
        assert!(hilbert(octants([side - 1; 3])) < 1 << (3 * LEVELS));
    }
}
