//! Faces, edges and cells as rays from a light see them.

use glam::DVec3;
use rimline::Light;

/// Bound on rounding errors, as a share of the computed value.
const SLACK: f64 = 1e-11;

/// Faces as rays from the light see them: a place stands for all on its ray. With a light at infinity rays are parallel, and a place
/// is where its ray meets a plane before the light.
pub(super) struct Rays {
    pub(super) places: Vec<DVec3>,
    pub(super) faces: Vec<[u32; 3]>,
}

/// A projected edge at which the number of faces changes by up to `weight`.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub(super) ends: [u32; 2],
    pub(super) weight: u32,
}

/// Rays `ahead + u·right + v·up` with `u` and `v` between these bounds.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    ahead: DVec3,
    right: DVec3,
    up: DVec3,
    low: [f64; 2],
    high: [f64; 2],
}

impl Cell {
    fn whole(ahead: DVec3, right: DVec3, up: DVec3) -> Self {
        Self { ahead, right, up, low: [-1.0; 2], high: [1.0; 2] }
    }

    fn ray(&self, [u, v]: [f64; 2]) -> DVec3 {
        self.ahead + u * self.right + v * self.up
    }

    /// A ray in its middle that few edges pass through by design.
    pub(super) fn middle(&self) -> DVec3 {
        let between = |axis: usize, part: f64| self.low[axis] + part * (self.high[axis] - self.low[axis]);
        self.ray([between(0, 0.487_13), between(1, 0.533_91)])
    }

    pub(super) fn corners(&self) -> [DVec3; 4] {
        let ([a, b], [c, d]) = (self.low, self.high);
        [[a, b], [c, b], [c, d], [a, d]].map(|at| self.ray(at))
    }

    /// Planes through the light, the cell in front of all.
    pub(super) fn planes(&self) -> [DVec3; 5] {
        let Self { ahead, right, up, low, high } = *self;
        [ahead, right - low[0] * ahead, high[0] * ahead - right, up - low[1] * ahead, high[1] * ahead - up]
    }

    pub(super) fn quarters(&self) -> [Self; 4] {
        let [a, b] = [0, 1].map(|axis| 0.5 * (self.low[axis] + self.high[axis]));
        let ([left, bottom], [right, top]) = (self.low, self.high);
        let part = |low, high| Self { low, high, ..*self };
        [
            part([left, bottom], [a, b]),
            part([a, bottom], [right, b]),
            part([left, b], [a, top]),
            part([a, b], [right, top]),
        ]
    }
}

impl Rays {
    /// And cells that hold all rays.
    pub(super) fn new(light: Light, positions: &[[f32; 3]], faces: Vec<[u32; 3]>) -> (Self, Vec<Cell>) {
        let [x, y, z, w] = light.to_array().map(f64::from);
        let world = positions.iter().map(|&[x, y, z]| DVec3::new(x.into(), y.into(), z.into()));
        let (i, j, k) = (DVec3::X, DVec3::Y, DVec3::Z);
        if w != 0.0 {
            let place = DVec3::new(x, y, z) / w;
            let places = world.map(|p| p - place).collect();
            let sides = [[i, j, k], [-i, j, k], [j, k, i], [-j, k, i], [k, i, j], [-k, i, j]];
            return (Self { places, faces }, sides.map(|[ahead, right, up]| Cell::whole(ahead, right, up)).to_vec());
        }
        let towards = (DVec3::new(x, y, z) / x.abs().max(y.abs()).max(z.abs())).normalize_or(j);
        let (right, up) = towards.any_orthonormal_pair();
        let mut places: Vec<DVec3> = world.map(|p| DVec3::new(right.dot(p), up.dot(p), 1.0)).collect();
        let used = || faces.iter().flatten().map(|&v| v as usize);
        let low = used().fold(DVec3::INFINITY, |low, v| low.min(places[v]));
        let high = used().fold(DVec3::NEG_INFINITY, |high, v| high.max(places[v]));
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        // A little more, so that nothing lies on the border.
        let scale = 1.001 * half.x.max(half.y).max(f64::MIN_POSITIVE);
        for place in &mut places {
            *place = ((*place - middle) / scale).with_z(1.0);
        }
        (Self { places, faces }, vec![Cell::whole(k, i, j)])
    }

    pub(super) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.faces[face as usize].map(|v| self.places[v as usize])
    }

    /// Which way a face turns to the light, 1 or −1; 0 if rounding leaves it open.
    fn facing(&self, face: u32) -> i32 {
        let [a, b, c] = self.corners(face);
        let turn = a.dot((b - a).cross(c - a));
        let open = SLACK * a.length() * (b - a).length() * (c - a).length();
        if turn.abs() <= open { 0 } else { turn.signum() as i32 }
    }

    /// The edges at which faces that all turn to the light begin or end, or may.
    pub(super) fn sides(&self) -> Vec<Side> {
        let mut half_edges = Vec::with_capacity(3 * self.faces.len());
        for (number, &[a, b, c]) in (0..).zip(&self.faces) {
            let facing = self.facing(number);
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let way = if from < to { facing } else { -facing };
                half_edges.push(([from.min(to), from.max(to)], way));
            }
        }
        half_edges.sort_unstable();
        let edges = half_edges.chunk_by(|(one, _), (other, _)| one == other);
        let side = |edge: &[([u32; 2], i32)]| {
            let sum: i32 = edge.iter().map(|(_, way)| way).sum();
            let open = edge.iter().filter(|(_, way)| *way == 0).count() as u32;
            let (ends, _) = *edge.first()?;
            Some(Side { ends, weight: sum.unsigned_abs() + open })
        };
        edges.filter_map(side).filter(|side| side.weight > 0 && side.ends[0] != side.ends[1]).collect()
    }

    /// Whether a ray meets a face, or rounding leaves it open.
    pub(super) fn meets(&self, ray: DVec3, face: u32) -> bool {
        let [a, b, c] = self.corners(face);
        let within = |way: f64| {
            [(a, b), (b, c), (c, a)]
                .into_iter()
                .all(|(p, q)| way * p.cross(q).dot(ray) >= -SLACK * p.length() * q.length() * ray.length())
        };
        match self.facing(face) {
            0 => within(1.0) || within(-1.0),
            way => within(f64::from(way)),
        }
    }
}

/// Whether a face, or an edge, may meet rays of a cell.
pub(super) fn may_meet<const N: usize>(places: [DVec3; N], planes: &[DVec3; 5], corners: &[DVec3; 4]) -> bool {
    let sizes = places.map(DVec3::length);
    let is_outside = |plane: &DVec3| {
        places.iter().zip(sizes).all(|(place, size)| plane.dot(*place) < -SLACK * size * plane.length())
    };
    if planes.iter().any(is_outside) {
        return false;
    }
    let pairs = if N == 2 { 1 } else { N };
    for first in 0..pairs {
        let (a, b) = (places[first], places[(first + 1) % N]);
        let plane = a.cross(b);
        let open = SLACK * a.length() * b.length();
        let turns = corners.map(|ray| plane.dot(ray) / ray.length());
        let [before, after] = [turns.iter().all(|&t| t < -open), turns.iter().all(|&t| t > open)];
        if N == 2 && (before || after) {
            return false;
        }
        if N == 3 {
            let third = places[(first + 2) % N];
            let own = plane.dot(third);
            let open = open * third.length();
            if (own > open && before) || (own < -open && after) {
                return false;
            }
        }
    }
    true
}
