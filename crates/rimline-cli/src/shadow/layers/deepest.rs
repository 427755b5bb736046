//! How many faces lie over each other as seen from a light: a bound that holds for every ray, where every face casts.
//!
//! The number N(r) of faces that a ray r meets is at least any count along it. If r moves, N changes only where r crosses an
//! edge at which faces begin or end, all turned to the light: by at most the sum of their signs there. So in a convex
//! cell of rays N is at most N of one of them, plus these sums for the edges that touch the cell, and at most the faces
//! that touch it. A cell with too large a bound is cut into four. A ray that meets too many faces ends the search.
//! Signs and touching are decided in `f64` with a slack; what is undecided counts. Around a vertex with many faces that
//! share no edges, the bound is their number. A bound for 8 bits of stencil: docs/numerics/receivers.md, "Bound on
//! counts".

use std::collections::BTreeMap;

use glam::DVec3;
use rimline::Light;

use crate::coincident::{Joined, is_finite};

/// Cells are cut into four so many times.
const MOST_CUTS: u32 = 24;
/// Faces and edges that are looked at for a light, beside some turns over all of them.
const MOST_WORK: usize = 1 << 26;

/// At most so many faces meet any ray from the light. If that is not above `enough`, it holds; else more may be there
/// than that, or it is not known.
pub(super) fn deepest(light: Light, positions: &[[f32; 3]], faces: &[[u32; 3]], enough: u32) -> u32 {
    let is_drawn = |face: &&[u32; 3]| is_finite(positions, face);
    let faces: Vec<[u32; 3]> = faces.iter().filter(is_drawn).copied().collect();
    if faces.len() <= enough as usize {
        return faces.len() as u32;
    }
    let (mut rays, roots) = Rays::new(light, positions, faces);
    // The light is in the plane of a face that it is a corner of, and such faces count nowhere.
    let positions = &rays.positions;
    rays.faces.retain(|face| face.iter().all(|&v| positions[v as usize] != glam::DVec3::ZERO));
    let all: Vec<u32> = (0..rays.faces.len() as u32).collect();
    let sides = rays.sides();
    let mut search = Search { rays, enough, left: MOST_WORK + 64 * (all.len() + sides.len()), most: 0 };
    for cell in roots {
        if search.most > enough {
            break;
        }
        search.cut(cell, &all, &sides, 0);
    }
    search.most
}

struct Search {
    rays: Rays,
    enough: u32,
    /// Work that may still be done.
    left: usize,
    /// The largest bound of a cell that was not cut.
    most: u32,
}

impl Search {
    /// Bounds the faces over each other in a cell, which may meet these faces and sides. From the middle ray to any
    /// other the number changes at sides alone.
    fn cut(&mut self, cell: Cell, faces: &[u32], sides: &[Side], cuts: u32) {
        let ray = cell.middle();
        let met = faces.iter().filter(|&&face| self.rays.meets(ray, face)).count();
        let crossed: usize = sides.iter().map(|side| side.weight as usize).sum();
        let bound = u32::try_from(faces.len().min(met + crossed)).unwrap_or(u32::MAX);
        let is_deep = met > self.enough as usize;
        let work = 4 * (faces.len() + sides.len());
        if bound <= self.enough || is_deep || cuts == MOST_CUTS || self.left < work {
            self.most = self.most.max(bound);
            return;
        }
        self.left -= work;
        for quarter in cell.quarters() {
            if self.most > self.enough {
                return;
            }
            let (planes, corners) = (quarter.planes(), quarter.corners());
            let rays = &self.rays;
            let near = |face: &u32| may_meet(rays.corners(*face), &planes, &corners);
            let faces: Vec<u32> = faces.iter().copied().filter(near).collect();
            let near = |side: &Side| may_meet(side.ends.map(|v| rays.positions[v as usize]), &planes, &corners);
            let sides: Vec<Side> = sides.iter().copied().filter(near).collect();
            self.cut(quarter, &faces, &sides, cuts + 1);
        }
    }
}

/// Bound on rounding errors, as a share of the computed value.
const SLACK: f64 = 1e-11;

/// Faces as rays from the light see them: a point stands for all on its ray. With a light at infinity rays are
/// parallel, and a point is where its ray meets a plane before the light.
struct Rays {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

/// A projected edge at which the number of faces changes by up to `weight`.
#[derive(Clone, Copy)]
struct Side {
    ends: [u32; 2],
    weight: u32,
}

/// Rays `ahead + u·right + v·up` with `u` and `v` between these bounds.
#[derive(Clone, Copy)]
struct Cell {
    ahead: DVec3,
    right: DVec3,
    up: DVec3,
    low: [f64; 2],
    high: [f64; 2],
}

impl Cell {
    fn whole([ahead, right, up]: [DVec3; 3]) -> Self {
        Self { ahead, right, up, low: [-1.0; 2], high: [1.0; 2] }
    }

    fn ray(&self, [u, v]: [f64; 2]) -> DVec3 {
        self.ahead + u * self.right + v * self.up
    }

    /// A ray in its middle that few edges pass through by design.
    fn middle(&self) -> DVec3 {
        let between = |axis: usize, part: f64| self.low[axis] + part * (self.high[axis] - self.low[axis]);
        self.ray([between(0, 0.487_13), between(1, 0.533_91)])
    }

    fn corners(&self) -> [DVec3; 4] {
        let ([a, b], [c, d]) = (self.low, self.high);
        [[a, b], [c, b], [c, d], [a, d]].map(|at| self.ray(at))
    }

    /// Planes through the light, the cell in front of all.
    fn planes(&self) -> [DVec3; 5] {
        let Self { ahead, right, up, low, high } = *self;
        [ahead, right - low[0] * ahead, high[0] * ahead - right, up - low[1] * ahead, high[1] * ahead - up]
    }

    fn quarters(&self) -> [Self; 4] {
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
    fn new(light: Light, positions: &[[f32; 3]], faces: Vec<[u32; 3]>) -> (Self, Vec<Cell>) {
        let [x, y, z, w] = light.to_array().map(f64::from);
        let world = positions.iter().map(|&[x, y, z]| DVec3::new(x.into(), y.into(), z.into()));
        let (i, j, k) = (DVec3::X, DVec3::Y, DVec3::Z);
        if w != 0.0 {
            let apex = DVec3::new(x, y, z) / w;
            let positions = world.map(|p| p - apex).collect();
            let sides = [[i, j, k], [-i, j, k], [j, k, i], [-j, k, i], [k, i, j], [-k, i, j]];
            return (Self { positions, faces }, sides.map(Cell::whole).to_vec());
        }
        let towards = (DVec3::new(x, y, z) / x.abs().max(y.abs()).max(z.abs())).normalize_or(j);
        let (right, up) = towards.any_orthonormal_pair();
        let mut positions: Vec<DVec3> = world.map(|p| DVec3::new(right.dot(p), up.dot(p), 1.0)).collect();
        let used = || faces.iter().flatten().map(|&v| v as usize);
        let low = used().fold(DVec3::INFINITY, |low, v| low.min(positions[v]));
        let high = used().fold(DVec3::NEG_INFINITY, |high, v| high.max(positions[v]));
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        // A little more, so that nothing lies on the border.
        let scale = 1.001 * half.x.max(half.y).max(f64::MIN_POSITIVE);
        for position in &mut positions {
            *position = ((*position - middle) / scale).with_z(1.0);
        }
        (Self { positions, faces }, vec![Cell::whole([k, i, j])])
    }

    fn corners(&self, face: u32) -> [DVec3; 3] {
        self.faces[face as usize].map(|v| self.positions[v as usize])
    }

    /// Which way a face turns to the light, 1 or −1; 0 if rounding leaves it open.
    fn facing(&self, face: u32) -> i32 {
        let [a, b, c] = self.corners(face);
        let turn = a.dot((b - a).cross(c - a));
        let open = SLACK * a.length() * (b - a).length() * (c - a).length();
        if turn.abs() <= open { 0 } else { turn.signum() as i32 }
    }

    /// The edges at which faces that all turn to the light begin or end, or may.
    fn sides(&self) -> Vec<Side> {
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
    fn meets(&self, ray: DVec3, face: u32) -> bool {
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
fn may_meet<const N: usize>(positions: [DVec3; N], planes: &[DVec3; 5], corners: &[DVec3; 4]) -> bool {
    let sizes = positions.map(DVec3::length);
    let is_outside = |plane: &DVec3| {
        positions.iter().zip(sizes).all(|(position, size)| plane.dot(*position) < -SLACK * size * plane.length())
    };
    if planes.iter().any(is_outside) {
        return false;
    }
    let pairs = if N == 2 { 1 } else { N };
    for first in 0..pairs {
        let (a, b) = (positions[first], positions[(first + 1) % N]);
        let plane = a.cross(b);
        let open = SLACK * a.length() * b.length();
        let turns = corners.map(|ray| plane.dot(ray) / ray.length());
        let [before, after] = [turns.iter().all(|&t| t < -open), turns.iter().all(|&t| t > open)];
        if N == 2 && (before || after) {
            return false;
        }
        if N == 3 {
            let third = positions[(first + 2) % N];
            let third_distance = plane.dot(third);
            let open = open * third.length();
            if (third_distance > open && before) || (third_distance < -open && after) {
                return false;
            }
        }
    }
    true
}

/// Batches that may be tried.
const MOST_BATCHES: usize = 1024;

/// The faces of each batch, by index: each light meets at most `most` of a batch. Returns `None` if `MOST_BATCHES`
/// batches are not enough. Connected faces stay together where they can, so that closed bodies stay closed.
pub(super) fn batches(
    lights: &[Light],
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    most: u32,
) -> Option<Vec<Vec<u32>>> {
    let is_within = |of: &[u32]| {
        let part: Vec<[u32; 3]> = of.iter().map(|&face| faces[face as usize]).collect();
        lights.iter().all(|&light| deepest(light, positions, &part, most) <= most)
    };
    let mut pieces = Vec::new();
    let mut waiting: Vec<Vec<u32>> = components(positions.len(), faces);
    waiting.reverse();
    while let Some(mut piece) = waiting.pop() {
        if piece.len() <= most as usize || is_within(&piece) {
            pieces.push(piece);
        } else {
            let half = piece.split_off(piece.len() / 2);
            waiting.extend([half, piece]);
        }
    }
    let mut count = 2;
    while count <= MOST_BATCHES {
        let mut batches = vec![Vec::new(); count];
        pieces.iter().enumerate().for_each(|(number, piece)| batches[number % count].extend(piece));
        if batches.iter().all(|batch| is_within(batch)) {
            return Some(batches);
        }
        count *= 2;
    }
    None
}

/// Faces that share vertices, directly or by way of others, in the order of the first of each.
fn components(vertices: usize, faces: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut joined = Joined::new(vertices);
    for &[a, b, c] in faces {
        joined.join(a, b);
        joined.join(a, c);
    }
    let mut numbers = BTreeMap::new();
    let mut components: Vec<Vec<u32>> = Vec::new();
    for (face, &[a, ..]) in (0..).zip(faces) {
        let number = *numbers.entry(joined.root(a)).or_insert(components.len());
        if number == components.len() {
            components.push(Vec::new());
        }
        components[number].push(face);
    }
    components
}

#[cfg(test)]
mod tests {
    use rimline_testkit::shapes::{Shape, globe, plane_grid};

    use super::*;

    #[test]
    fn bounds_hold_and_are_not_far_off() {
        let above = [Light::point([0.1, 30.0, 0.2]), Light::directional([0.1, 1.0, 0.05])];
        for light in above {
            for layers in [1, 40, 300] {
                let sheet = |layer: u32| plane_grid(3, 3).placed(|[x, _, z]| [x, layer as f32 / 256.0, z]);
                let Shape { positions, faces } = Shape::joined(&(0..layers).map(sheet).collect::<Vec<_>>());
                let found = deepest(light, &positions, &faces, 255);
                // A bound of at most 255 is valid, although a smaller one may exist.
                assert!(found >= layers, "{light:?}, {layers} layers: {found}");
                assert_eq!(found > 255, layers > 255, "{light:?}, {layers} layers: {found}");
            }
        }
    }

    #[test]
    fn poles_and_lights_within_are_no_layers() {
        // Many faces lie around each of two poles.
        let Shape { positions, faces } = globe(300, 30).placed(|[x, y, z]| [y, z, x]);
        for light in [[0.0, 3.0, 0.0], [0.0, 0.0, 0.0], [0.3, -0.2, 0.1], [0.0, 1.0, 0.0]] {
            let found = deepest(Light::point(light), &positions, &faces, 255);
            assert!((1..=255).contains(&found), "{light:?}: {found}");
        }
        // Every third face is left out: full of holes, around the light and beside it.
        let leaky: Vec<_> = faces.iter().enumerate().filter(|(n, _)| n % 3 != 0).map(|(_, face)| *face).collect();
        for light in [Light::point([0.0; 3]), Light::point([0.2, 0.9, 0.1]), Light::directional([0.3, 1.0, 0.2])] {
            let found = deepest(light, &positions, &leaky, 255);
            assert!((1..=255).contains(&found), "{light:?}: {found}");
        }
    }

    #[test]
    fn random_faces_take_as_many_batches_as_they_need() {
        // 16,000 triangles over each other, of which a batch holds 127 at most.
        let positions: Vec<[f32; 3]> =
            (0..16_000).flat_map(|y| [[0.0, y as f32, 0.0], [0.0, y as f32, 4.0], [4.0, y as f32, 0.0]]).collect();
        let faces: Vec<[u32; 3]> = (0..16_000).map(|face: u32| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        let found = batches(&[Light::directional([0.0, 1.0, 0.0])], &positions, &faces, 127).expect("enough batches");
        assert_eq!((found.len(), found.concat().len()), (128, 16_000));
    }

    #[test]
    fn what_hangs_together_stays_together_and_deep_pieces_are_cut() {
        // 300 squares over each other, each by itself; then the same as one sheet, folded to and fro.
        let corner = |layer: usize, c: usize| [(c & 1) as f32, layer as f32 / 256.0, (c >> 1) as f32];
        let apart: Vec<[f32; 3]> = (0..300).flat_map(|layer| (0..4).map(move |c| corner(layer, c))).collect();
        let faces = |v: &dyn Fn(u32, u32) -> u32| -> Vec<[u32; 3]> {
            (0..300).flat_map(|l| [[v(l, 0), v(l, 2), v(l, 1)], [v(l, 1), v(l, 2), v(l, 3)]]).collect()
        };
        let alone = faces(&|layer, c| 4 * layer + c);
        assert_eq!(components(apart.len(), &alone).len(), 300);
        let folded: Vec<[f32; 3]> = (0..=300)
            .flat_map(|layer| [0.0, 1.0].map(|z| [f32::from(u8::from(layer % 2 == 1)), layer as f32 / 256.0, z]))
            .collect();
        let hanging: Vec<[u32; 3]> =
            (0..300).flat_map(|l: u32| [[2 * l, 2 * l + 1, 2 * l + 2], [2 * l + 2, 2 * l + 1, 2 * l + 3]]).collect();
        assert_eq!(components(folded.len(), &hanging).len(), 1);
        let lights = [Light::point([0.4, 30.0, 0.6]), Light::directional([0.01, 1.0, 0.02])];
        for (positions, faces) in [(&apart, &alone), (&folded, &hanging)] {
            assert!(lights.iter().all(|&light| deepest(light, positions, faces, 255) > 255));
            let found = batches(&lights, positions, faces, 127).expect("a few batches do");
            assert!((3..=8).contains(&found.len()), "{} batches", found.len());
            let mut all: Vec<u32> = found.concat();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..600), "each face once");
        }
    }
}
