//! Faces that coincide with faces of the opposite direction: one with the same corners, or flat patches with one
//! outline that are cut into triangles along other diagonals. Rasterisers give the two depths that differ in their last
//! bits, so which of them is nearer changes from pixel to pixel. The one towards the eye is to be seen in any case.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::{DVec3, Vec3};

type Corners = [[f32; 3]; 3];

pub(crate) fn corners<'a>(
    positions: &'a [[f32; 3]],
    faces: &'a [[u32; 3]],
) -> impl Iterator<Item = Corners> + Clone + 'a {
    faces.iter().map(|face| face.map(|v| positions[v as usize]))
}

/// Whether a face has all of its corners, and all are finite.
pub(crate) fn is_finite(positions: &[[f32; 3]], face: &[u32; 3]) -> bool {
    let mut corners = face.iter().map(|&v| positions.get(v as usize));
    corners.all(|corner| corner.is_some_and(|corner| corner.iter().all(|c| c.is_finite())))
}

/// Faces that coincide with others that run the other way around.
pub(crate) struct Coincident {
    /// For each face that coincides with a turned one, that one.
    turned: Vec<Option<u32>>,
    /// Faces that coincide with an earlier one, in either direction.
    later: Vec<bool>,
}

impl Coincident {
    /// `None` if no face coincides with a turned one.
    pub(crate) fn of(faces: impl Iterator<Item = Corners> + Clone) -> Option<Self> {
        let count = faces.clone().count();
        let mut found = Self::by_corners(faces.clone());
        for [first, second] in turned_patches(faces) {
            let coincident = found.get_or_insert_with(|| Self { turned: vec![None; count], later: vec![false; count] });
            for (of, others, is_later) in [(&first, &second, false), (&second, &first, true)] {
                for (at, &face) in of.iter().enumerate() {
                    coincident.turned[face as usize] = Some(others[at % others.len()]);
                    coincident.later[face as usize] = is_later;
                }
            }
        }
        found
    }

    fn by_corners(faces: impl Iterator<Item = Corners> + Clone) -> Option<Self> {
        // Most faces have a key of their own, and need no closer look.
        let key = |face: Corners| mixed(sorted(face).0.as_flattened());
        let repeated = repeated(faces.clone().map(key).collect());
        let mut by_corners: HashMap<_, [Option<u32>; 2]> = HashMap::new();
        for (number, face) in (0..).zip(faces.clone()).filter(|&(_, face)| repeated.contains(&key(face))) {
            let (corners, is_odd) = sorted(face);
            by_corners.entry(corners).or_default()[usize::from(is_odd)].get_or_insert(number);
        }
        by_corners.retain(|_, firsts| firsts.iter().all(Option::is_some));
        if by_corners.is_empty() {
            return None;
        }
        let (mut turned, mut later) = (Vec::new(), Vec::new());
        for (number, face) in (0..).zip(faces) {
            let (corners, is_odd) = sorted(face);
            let firsts = by_corners.get(&corners).map(|firsts| firsts.map(|first| first.unwrap_or(number)));
            turned.push(firsts.map(|firsts| firsts[usize::from(!is_odd)]));
            later.push(firsts.is_some_and(|[even, odd]| even.min(odd) != number));
        }
        Some(Self { turned, later })
    }

    /// Whether a face is the first of those that coincide, or coincides with no turned one.
    pub(crate) fn is_first(&self, number: usize) -> bool {
        !self.later.get(number).is_some_and(|&later| later)
    }

    /// The face that is seen instead of this one: the turned one if that is towards the eye and this is not.
    pub(crate) fn seen_instead(&self, number: usize, face: Corners, eye: Vec3) -> Option<usize> {
        let turned = self.turned.get(number).copied().flatten()?;
        let (corners, is_odd) = sorted(face);
        is_back_facing(corners, is_odd, eye).then_some(turned as usize)
    }
}

/// The bits of a face's corners in order, where −0 is 0, and whether this turns it around.
fn sorted(face: Corners) -> ([PositionBits; 3], bool) {
    let [mut a, mut b, mut c] = face.map(position_bits);
    let mut is_odd = false;
    let mut order = |p: &mut PositionBits, q: &mut PositionBits| {
        if *q < *p {
            std::mem::swap(p, q);
            is_odd = !is_odd;
        }
    };
    order(&mut a, &mut b);
    order(&mut b, &mut c);
    order(&mut a, &mut b);
    ([a, b, c], is_odd)
}

/// Numbers that are there more than once.
fn repeated(mut numbers: Vec<u64>) -> HashSet<u64> {
    numbers.sort_unstable();
    numbers.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect()
}

/// An odd number without a pattern: multiples of it differ in their high bits.
const ODD: u64 = 0x9e37_79b9_7f4a_7c15;

fn mixed(words: &[u32]) -> u64 {
    words.iter().fold(0, |sum: u64, &word| {
        let mixed = (sum ^ u64::from(word)).wrapping_mul(ODD);
        mixed ^ (mixed >> 32)
    })
}

/// Whether the eye is behind a face. The eye is behind one of two opposite faces that coincide, because their corners
/// are taken in the same order. It is behind neither if it is in their plane as far as rounding tells.
fn is_back_facing(corners: [PositionBits; 3], is_odd: bool, eye: Vec3) -> bool {
    let [a, b, c] = corners.map(|bits| DVec3::from(bits.map(|bits| f64::from(f32::from_bits(bits)))) - eye.as_dvec3());
    // An eye on the front side sees the corners counter-clockwise.
    let volume = a.dot((b - a).cross(c - a));
    if is_odd { volume < 0.0 } else { volume > 0.0 }
}

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

fn position_bits(position: [f32; 3]) -> PositionBits {
    position.map(|c| (c + 0.0).to_bits())
}

/// A side of a face, which it walks from one end to the other.
struct Side {
    ends: [PositionBits; 2],
    face: u32,
    /// The corner opposite.
    third: [f32; 3],
    /// Whether it is inside of a patch.
    is_inner: bool,
}

/// The faces of either direction, in patches that coincide, the earlier patch first.
fn turned_patches(faces: impl Iterator<Item = Corners>) -> Vec<[Vec<u32>; 2]> {
    let faces: Vec<Corners> = faces.take(MOST_FACES + 1).collect();
    if faces.len() > MOST_FACES || !may_fold(&faces) {
        return Vec::new();
    }
    let mut sides: Vec<Side> = (0..).zip(&faces).flat_map(|(number, &face)| sides_of(number, face)).collect();
    sides.sort_unstable_by_key(|side| undirected(side.ends));
    let (mut patches, mut folds) = (Joined::new(faces.len()), false);
    let meeting = sides.chunk_by_mut(|a, b| undirected(a.ends) == undirected(b.ends));
    for meeting in meeting.filter(|meeting| meeting.len() <= MOST_MEETING) {
        let count = meeting.len();
        for (i, j) in (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))) {
            let (one, other) = (&meeting[i], &meeting[j]);
            if one.ends == other.ends {
                continue;
            }
            match fold(faces[one.face as usize], faces[other.face as usize], other.third) {
                Fold::None => {}
                Fold::Flat => {
                    patches.join(one.face, other.face);
                    meeting[i].is_inner = true;
                    meeting[j].is_inner = true;
                }
                Fold::Back => folds = true,
            }
        }
    }
    if folds { with_one_outline(&mut patches, &sides) } else { Vec::new() }
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
        let ends = face.map(|corner| mixed(&position_bits(corner)));
        for (from, to) in [(ends[0], ends[1]), (ends[1], ends[2]), (ends[2], ends[0])] {
            let way = if from < to { up } else { down };
            keys.push((from.wrapping_add(to) ^ way.wrapping_mul(ODD)).wrapping_mul(ODD) >> 8);
        }
    }
    !repeated(keys).is_empty()
}

/// Patches of several faces, one of each two whose outlines are the same but for the direction.
fn with_one_outline(patches: &mut Joined, sides: &[Side]) -> Vec<[Vec<u32>; 2]> {
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for face in 0..patches.0.len() as u32 {
        members.entry(patches.root(face)).or_default().push(face);
    }
    let mut outlines: BTreeMap<u32, Vec<[PositionBits; 2]>> = BTreeMap::new();
    for side in sides.iter().filter(|side| !side.is_inner) {
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
    let ends = corners.map(position_bits);
    [0, 1, 2].map(|at| Side {
        ends: [ends[at], ends[(at + 1) % 3]],
        face,
        third: corners[(at + 2) % 3],
        is_inner: false,
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

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: [[f32; 3]; 5] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

    fn instead(faces: &[[u32; 3]], eye: [f32; 3]) -> Option<Vec<Option<usize>>> {
        let all = || corners(&POSITIONS, faces);
        let found = Coincident::of(all())?;
        Some(all().enumerate().map(|(number, face)| found.seen_instead(number, face, eye.into())).collect())
    }

    #[test]
    fn of_two_that_coincide_the_one_towards_the_eye_is_seen() {
        // The second names another vertex at the same position, and begins elsewhere.
        let faces = [[0, 1, 2], [2, 1, 3], [0, 1, 4], [1, 2, 0]];
        assert_eq!(instead(&faces, [0.2, 0.2, 3.0]), Some(vec![None, Some(0), None, None]));
        assert_eq!(instead(&faces, [0.2, 0.2, -3.0]), Some(vec![Some(1), None, None, Some(1)]));
        assert_eq!(instead(&faces, [5.0, 5.0, 0.0]), Some(vec![None; 4]), "in the plane");
        let found = Coincident::of(corners(&POSITIONS, &faces)).expect("two coincide");
        assert_eq!([0, 1, 2, 3].map(|number| found.is_first(number)), [true, false, true, false]);
    }

    #[test]
    fn a_square_and_its_back_along_the_other_diagonal_coincide() {
        let square =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 2.0, 1.0], [0.0, 1.0, 0.001]];
        let seen = |faces: &[[u32; 3]], eye: [f32; 3]| {
            let all = || corners(&square, faces);
            let found = Coincident::of(all())?;
            let instead: Vec<bool> = all()
                .enumerate()
                .map(|(number, face)| found.seen_instead(number, face, eye.into()).is_some())
                .collect();
            Some((instead, (0..faces.len()).map(|number| found.is_first(number)).collect::<Vec<_>>()))
        };
        // A face at an edge of it, the front, and the back, cut from 1 to 3.
        let faces = [[2, 3, 4], [0, 1, 2], [0, 2, 3], [3, 1, 0], [3, 2, 1]];
        let front = vec![true, true, true, false, false];
        let (above, below) = ([0.3, 0.4, 5.0], [0.3, 0.4, -5.0]);
        assert_eq!(seen(&faces, above), Some((vec![false, false, false, true, true], front.clone())));
        assert_eq!(seen(&faces, below), Some((vec![false, true, true, false, false], front)));
        // It is not flat, and only a part of it has a back.
        assert_eq!(seen(&[[0, 1, 2], [0, 2, 5], [5, 1, 0], [5, 2, 1]], above), None);
        assert_eq!(seen(&[[0, 1, 2], [0, 2, 3], [3, 1, 0]], above), None);
    }

    /// Rounded corners, in planes of all directions: the quick look at all sides overlooks none.
    #[test]
    fn squares_in_any_plane_have_backs_along_the_other_diagonal() {
        for number in 0..5000 {
            let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.37 * number as f32, 1.13 * number as f32, 0.71);
            let shift = Vec3::new(3.0, -2.0, 0.1 * number as f32);
            let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[x, y]| (shift + turn * Vec3::new(x, y, 0.0)).to_array());
            let found = Coincident::of(corners(&square, &[[0, 1, 2], [0, 2, 3], [3, 1, 0], [3, 2, 1]]));
            assert!(found.is_some(), "square {number}");
        }
    }

    #[test]
    fn faces_that_are_not_turned_copies_are_seen_themselves() {
        // A copy that is not turned, another face at an edge, and nothing.
        for faces in [&[[0, 1, 2], [1, 2, 0]][..], &[[0, 1, 2], [1, 0, 4]], &[]] {
            assert_eq!(instead(faces, [0.2, 0.2, -3.0]), None);
        }
    }
}
