//! The sides and caps of what casts, by whole numbers: how often, and which way, the casting faces at each edge record
//! go along it, and the faces in each list of caps. The box of what casts.

use rimline::Mesh;
use rimline::internals::cpu;
use rimline::internals::layout::ShadowLight;
use rimline::internals::shadow::{CAST_BACK_FACING, CAST_EVERY, COUNT_Z_FAIL, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};
use rimline::mesh::{INCONSISTENT_BIT, NO_FACE};

/// The share of a face in the shadow of a light: 0 or ±1, from its masks and the light's choice alone.
fn share(light: &ShadowLight, facing: bool, excluded: bool) -> i32 {
    match (light.casting, facing) {
        _ if excluded && light.excludes == 1 => 0,
        (CAST_EVERY, true) => 1,
        (CAST_EVERY | CAST_BACK_FACING, false) => -1,
        _ => 0,
    }
}

/// The share of each face for light `number`, from planes of masks of 32 lights.
fn shares(light: &ShadowLight, number: usize, [facing, excluded]: [&[u32]; 2], faces: usize) -> Vec<i32> {
    let bit = |masks: &[u32], face: usize| masks[number / 32 * faces + face] >> (number % 32) & 1 != 0;
    (0..faces).map(|face| share(light, bit(facing, face), bit(excluded, face))).collect()
}

/// The lists of cap faces: near caps that count up on their front and on their back, then other caps likewise. Near
/// caps are of every face that casts, also of those that are not between light and near rectangle.
pub(crate) fn caps(
    mesh: &Mesh,
    positions: &[[f32; 3]],
    (number, light): (usize, &ShadowLight),
    masks: [&[u32]; 2],
    in_depth: bool,
) -> [Vec<u32>; 4] {
    let shares = shares(light, number, masks, mesh.faces().len());
    let has_near = matches!(light.counting, COUNT_ZP_PLUS | COUNT_ZP_PLUS_2005);
    let has_far = light.counting == COUNT_Z_FAIL || light.end > 0.0 || !in_depth;
    let mut lists: [Vec<u32>; 4] = Default::default();
    for ((index, &[a, b, c]), share) in (0..).zip(mesh.faces()).zip(shares) {
        let is_finite = [a, b, c].iter().all(|&vertex| positions[vertex as usize].iter().all(|c| c.is_finite()));
        if share == 0 || a == b || b == c || c == a || !is_finite {
            continue;
        }
        // The front of a face that faces the light is seen on the near plane if the light is on the eye's side.
        let is_back = (share > 0) != (light.height < 0.0);
        lists[usize::from(is_back)].extend(has_near.then_some(index));
        lists[if share > 0 { 2 } else { 3 }].extend(has_far.then_some(index));
    }
    lists
}

/// The box of the faces whose corners are all finite, in words that grow with the coordinates: the lowest corner,
/// inverted, and the highest. The last word is 1 if another face does not name a vertex twice.
pub(crate) fn box_words(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> [u32; 7] {
    let key = |c: f32| if c.is_sign_negative() { !c.to_bits() } else { c.to_bits() | 0x8000_0000 };
    let mut words = [0; 7];
    for &[a, b, c] in faces {
        let corners = [a, b, c].map(|vertex| positions[vertex as usize]);
        if !corners.as_flattened().iter().all(|c| c.is_finite()) {
            words[6] |= u32::from(a != b && b != c && c != a);
            continue;
        }
        for (axis, key) in corners.iter().flat_map(|corner| (0..3).zip(corner.map(key))) {
            words[axis] = words[axis].max(!key);
            words[3 + axis] = words[3 + axis].max(key);
        }
    }
    words
}

/// The lowest and the highest of some positions.
pub(crate) fn box_of(positions: impl IntoIterator<Item = [f32; 3]>) -> [[f32; 3]; 2] {
    let empty = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    positions.into_iter().fold(empty, |[low, high], p| {
        [std::array::from_fn(|axis| p[axis].min(low[axis])), std::array::from_fn(|axis| p[axis].max(high[axis]))]
    })
}

/// Whether a face has an edge from its first vertex to its second one, or the other way round.
fn turn([a, b, c]: [u32; 3], edge: [u32; 2]) -> i32 {
    if [[a, b], [b, c], [c, a]].contains(&edge) { 1 } else { -1 }
}

/// The entries of sides, in the order of the edge records: an index, with bit 31 if the side is along its edge. A
/// record with the sum 2 or -2 has two entries.
fn sides(mesh: &Mesh, shares: &[i32]) -> Vec<u32> {
    let records = (0..).zip(mesh.edges().vertices()).zip(mesh.edges().packed_faces());
    let entries = records.flat_map(|((edge, &ends), faces)| {
        let present = faces.iter().filter(|face| **face != NO_FACE).map(|face| (face & !INCONSISTENT_BIT) as usize);
        let sum: i32 = present.map(|face| shares[face] * turn(mesh.faces()[face], ends)).sum();
        std::iter::repeat_n(edge | if sum > 0 { cpu::WINDING } else { 0 }, sum.unsigned_abs() as usize)
    });
    entries.collect()
}

/// The sides of a light: plain ones, and those that end on the near plane.
pub(crate) fn lists(
    mesh: &Mesh,
    (number, light): (usize, &ShadowLight),
    masks: [&[u32]; 2],
    capped: bool,
) -> [Vec<u32>; 2] {
    let all = sides(mesh, &shares(light, number, masks, mesh.faces().len()));
    if is_clipped(light, capped) { [Vec::new(), all] } else { [all, Vec::new()] }
}

/// Whether the light's sides end on the near plane. With ZP+ they do if the caster has a near cap.
fn is_clipped(light: &ShadowLight, capped: bool) -> bool {
    (light.counting == COUNT_ZP_PLUS && capped) || light.counting == COUNT_ZP_PLUS_2005
}
