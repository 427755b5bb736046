//! Flat patches of faces whose outlines run around the same region in opposite directions.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use super::{Corners, ODD, Repeated, mixed};

/// Faces of a mesh that are looked at. The edges of more would take longer than the picture.
const MOST_FACES: usize = 1 << 20;

/// Faces at one side that are looked at: more are no surface.
const MOST_MEETING: usize = 16;

/// How far a corner may be off the plane of a face for a flat patch, in parts of the face's size; and of its distance
/// from the origin, whose rounding it has.
const FLAT: f64 = 1e-6;
const ROUNDED: f64 = 3e-7;

/// The bits of a position, where −0 is 0.
type PositionBits = [u32; 3];

/// A side of a face, which it walks from one end to the other.
struct Side {
    ends: [PositionBits; 2],
    face: u32,
    /// The corner opposite.
    third: [f32; 3],
}

/// The faces of either direction, in patches that coincide, the earlier patch first.
pub(super) fn turned(faces: impl Iterator<Item = Corners>) -> Vec<[Vec<u32>; 2]> {
    let faces: Vec<Corners> = faces.take(MOST_FACES + 1).collect();
    if faces.len() > MOST_FACES || !may_fold(&faces) {
        return Vec::new();
    }
    let mut sides: Vec<Side> = (0..).zip(&faces).flat_map(|(number, &face)| sides_of(number, face)).collect();
    sides.sort_unstable_by_key(|side| undirected(side.ends));
    let mut patches = Joined::new(faces.len());
    // Whether a side is inside of a patch, and whether the surface folds back onto itself there.
    let (mut is_inner, mut folds) = (vec![false; sides.len()], false);
    let mut first = 0;
    for run in sides.chunk_by(|a, b| undirected(a.ends) == undirected(b.ends)) {
        let meeting = if run.len() > MOST_MEETING { &[] } else { run };
        for (i, one) in meeting.iter().enumerate() {
            for (j, other) in meeting.iter().enumerate().skip(i + 1).filter(|(_, other)| other.ends != one.ends) {
                match fold(faces[one.face as usize], faces[other.face as usize], other.third) {
                    Fold::None => {}
                    Fold::Flat => {
                        patches.join(one.face, other.face);
                        is_inner[first + i] = true;
                        is_inner[first + j] = true;
                    }
                    Fold::Back => folds = true,
                }
            }
        }
        first += run.len();
    }
    if folds { with_one_outline(&faces, &mut patches, sides.iter().zip(is_inner)) } else { Vec::new() }
}

/// Whether two faces may lie on each other's backs at a side. Most models have none, and need no closer look. Both
/// sides of a fold have one key: the ends, and the normal of the face that walks up from one to the other, or that of
/// the other turned around. Where the surface goes on smoothly, these are opposite.
fn may_fold(faces: &[Corners]) -> bool {
    let mut keys = Vec::with_capacity(3 * faces.len());
    for &face in faces {
        let [a, b, c] = face.map(Vec3::from);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if normal == Vec3::ZERO {
            continue;
        }
        // Steps of a sixtieth. Neither 0 nor ±1, which are common, is at the end of one.
        let [up, down] = [normal, -normal].map(|way| {
            let [x, y, z] = (61.0 * way + 64.377).to_array().map(|c| c as u64);
            x << 32 | y << 16 | z
        });
        let ends = face.map(|corner| mixed(&corner.map(|c| (c + 0.0).to_bits())));
        for (from, to) in [(ends[0], ends[1]), (ends[1], ends[2]), (ends[2], ends[0])] {
            let way = if from < to { up } else { down };
            keys.push((from.wrapping_add(to) ^ way.wrapping_mul(ODD)).wrapping_mul(ODD) >> 8);
        }
    }
    let repeated = Repeated::of(keys.iter().copied(), keys.len());
    keys.retain(|&key| repeated.may_hold(key));
    keys.sort_unstable();
    keys.windows(2).any(|pair| pair[0] == pair[1])
}

/// Patches of several faces, one of each two whose outlines are the same but for the direction.
fn with_one_outline<'a>(
    faces: &[Corners],
    patches: &mut Joined,
    sides: impl Iterator<Item = (&'a Side, bool)>,
) -> Vec<[Vec<u32>; 2]> {
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for face in 0..faces.len() as u32 {
        members.entry(patches.root(face)).or_default().push(face);
    }
    let mut outlines: BTreeMap<u32, Vec<[PositionBits; 2]>> = BTreeMap::new();
    for (side, _) in sides.filter(|&(_, is_inner)| !is_inner) {
        outlines.entry(patches.root(side.face)).or_default().push(side.ends);
    }
    for outline in outlines.values_mut() {
        outline.sort_unstable();
    }
    let by_outline: BTreeMap<&[[PositionBits; 2]], u32> =
        outlines.iter().map(|(&root, outline)| (outline.as_slice(), root)).collect();
    let mut found = Vec::new();
    for (&root, outline) in &outlines {
        let mut turned: Vec<[PositionBits; 2]> = outline.iter().map(|&[a, b]| [b, a]).collect();
        turned.sort_unstable();
        let other = by_outline.get(turned.as_slice()).copied();
        let both = other.filter(|&other| root < other).and_then(|other| Some([&members[&root], members.get(&other)?]));
        if let Some(both) = both.filter(|both| both.iter().any(|faces| faces.len() > 1)) {
            found.push(both.map(Clone::clone));
        }
    }
    found
}

fn sides_of(face: u32, corners: Corners) -> [Side; 3] {
    let position_bits = |at: usize| corners[at].map(|c| (c + 0.0).to_bits());
    [0, 1, 2].map(|at| Side {
        ends: [position_bits(at), position_bits((at + 1) % 3)],
        face,
        third: corners[(at + 2) % 3],
    })
}

fn undirected([a, b]: [PositionBits; 2]) -> [PositionBits; 2] {
    [a.min(b), a.max(b)]
}

/// How two faces meet at a side that they walk in opposite directions.
enum Fold {
    /// At an angle.
    None,
    /// In one plane.
    Flat,
    /// In one plane, the one lying on the other.
    Back,
}

/// `third` is the corner of the second face that the first does not have.
fn fold(first: Corners, second: Corners, third: [f32; 3]) -> Fold {
    let [a, b, c] = first.map(|corner| DVec3::from(corner.map(f64::from)));
    let third = DVec3::from(third.map(f64::from));
    let normal = (b - a).cross(c - a);
    let size = (b - a).abs().max((c - a).abs()).max((third - a).abs()).max_element();
    let rounding = FLAT * size + ROUNDED * a.abs().max(third.abs()).max_element();
    let [p, q, r] = second.map(|corner| DVec3::from(corner.map(f64::from)));
    let along = normal.dot((q - p).cross(r - p));
    if along == 0.0 || !along.is_finite() || normal.dot(third - a).abs() > rounding * normal.length() {
        Fold::None
    } else if along > 0.0 {
        Fold::Flat
    } else {
        Fold::Back
    }
}

/// Sets of numbers, each with the lowest as its root.
pub(crate) struct Joined(Vec<u32>);

impl Joined {
    /// So many numbers, each by itself.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub(crate) fn root(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            let next = self.0[self.0[number as usize] as usize];
            self.0[number as usize] = next;
            number = next;
        }
        number
    }

    pub(crate) fn join(&mut self, one: u32, other: u32) {
        let [one, other] = [one, other].map(|number| self.root(number));
        self.0[one.max(other) as usize] = one.min(other);
    }
}
