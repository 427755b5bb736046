//! Occluded: finds the lights for which a caster's box lies wholly behind an occluder. docs/numerics/scene.md, "Occluders".

use super::table::SceneTable;
use crate::layout::{SceneCaster, SceneDispatch};

type Vector = [f32; 3];

/// Rigid, or with a box that the caller states.
const BOXED: u32 = 4 | 256;
const MOST_CORNERS: usize = 8;
const LARGE: f32 = f32::from_bits((127 + 36) << 23);
const LEAST: f32 = f32::from_bits((127 - 100) << 23);

/// 32 units in the last place: the part of sizes by which a box must be behind.
pub const SLACK: f32 = f32::from_bits((127 - 18) << 23);

/// Occluders that are tried. Others hide nothing.
const MOST_OCCLUDERS: u32 = 128;

/// The lights, out of some, from which a caster is hidden by occluders. WGSL leaves a GPU some freedom in rounding, so a GPU
/// may decide pairs at the very end of the proof differently. `slack` bounds this rounding, [`SLACK`] outside of tests.
pub fn occluded(table: SceneTable<'_>, group: &SceneDispatch, caster: u32, batch: u32, lights: u32, slack: f32) -> u32 {
    let own = table.caster(caster);
    if own.flags & BOXED == 0 || own.low[0] > own.high[0] {
        return 0;
    }
    let body = Body::new(&own, f32::from_bits(table.word(group.ranges_at + 16 * group.batches, 2)));
    let hides = |light: &u32| {
        (0..group.occluders.min(MOST_OCCLUDERS)).any(|number| {
            let [usable, facing, of, at] = table.part(group.occluders_at + batch * group.occluders + number);
            let place = group.world_lights_at + 32 * batch + light;
            of != caster && usable >> light & 1 != 0 && {
                let count = (table.part(at)[3] as usize).min(MOST_CORNERS);
                let corner = |number: usize| {
                    let [x, y, z, _] = table.part(at + number as u32).map(f32::from_bits);
                    [x, y, z]
                };
                let corners: Vec<Vector> = (0..count).map(corner).collect();
                body.is_behind(&corners, table.part(place).map(f32::from_bits), facing >> light & 1 != 0, slack)
            }
        })
    };
    (0..32).filter(|light| lights >> light & 1 != 0).filter(hides).fold(0, |hidden, light| hidden | 1 << light)
}

/// A box in world space.
struct Body {
    middle: Vector,
    /// Half of each of its edges.
    halves: [Vector; 3],
    /// The sum of the absolute coordinates of places, at most, and of the camera's origin.
    size: f32,
    reach: f32,
}

fn sum([x, y, z]: Vector) -> f32 {
    x.abs() + y.abs() + z.abs()
}

fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn times(factor: f32, v: Vector) -> Vector {
    v.map(|c| factor * c)
}

impl Body {
    fn new(caster: &SceneCaster, origin: f32) -> Self {
        let SceneCaster { row_0, row_1, row_2, low, high, .. } = *caster;
        let rows = [row_0, row_1, row_2];
        let linear = rows.map(|[x, y, z, _]| [x, y, z]);
        let at: Vector = std::array::from_fn(|axis| 0.5 * low[axis] + 0.5 * high[axis]);
        let half: Vector = std::array::from_fn(|axis| 0.5 * high[axis] - 0.5 * low[axis]);
        let sizes: Vector = std::array::from_fn(|axis| low[axis].abs().max(high[axis].abs()));
        let product = |row: Vector| sum([row[0] * sizes[0], row[1] * sizes[1], row[2] * sizes[2]]);
        let [x, y, z] = linear.map(product);
        let size = x + y + z + row_0[3].abs() + row_1[3].abs() + row_2[3].abs();
        let halves: [Vector; 3] = std::array::from_fn(|axis| times(half[axis], linear.map(|row| row[axis])));
        Self {
            middle: std::array::from_fn(|axis| dot(linear[axis], at) + rows[axis][3]),
            halves,
            size: size + 3.0 * origin,
            reach: sum(halves[0]) + sum(halves[1]) + sum(halves[2]),
        }
    }

    /// The least of `normal·(p − on)` for all `p` of the box.
    fn least(&self, normal: Vector, on: Vector) -> f32 {
        self.halves.iter().fold(dot(normal, minus(self.middle, on)), |least, half| least - dot(normal, *half).abs())
    }

    /// Whether all of it is strictly behind the polygon, as seen from the scaled light. `is_facing`: the light sees the corners
    /// counter-clockwise.
    fn is_behind(&self, corners: &[Vector], [x, y, z, w]: [f32; 4], is_facing: bool, slack: f32) -> bool {
        let Some(&first) = corners.first() else { return false };
        let side = if is_facing { 1.0 } else { -1.0 };
        let light = [x, y, z];
        corners.iter().enumerate().all(|(number, &a)| {
            let b = corners[(number + 1) % corners.len()];
            let (e, t) = (minus(b, a), minus(light, times(w, a)));
            let apart = sum(minus(self.middle, a)) + self.reach;
            let size = self.size + sum(a) + sum(b);
            let toward = sum(light) + w * size;
            let error = slack * toward * (size * (sum(e) + apart) + 2.0 * sum(e) * apart) + LEAST;
            let is_within = self.least(times(side, cross(t, e)), a) > error && size < LARGE;
            let is_inner = number > 0 && number + 1 < corners.len();
            is_within && (!is_inner || self.is_beyond([first, a, b], size, side, slack))
        })
    }

    /// Whether all of it is on the other side of a plane.
    fn is_beyond(&self, [first, a, b]: [Vector; 3], size: f32, side: f32, slack: f32) -> bool {
        let (u, v) = (minus(a, first), minus(b, first));
        let apart = sum(minus(self.middle, first)) + self.reach;
        let (size, spread) = (size + sum(first), sum(u) * sum(v));
        let error = slack * (size * (spread + (sum(u) + sum(v)) * apart) + 2.0 * spread * apart) + LEAST;
        self.least(times(-side, cross(u, v)), first) > error
    }
}
