//! The sides of what casts, by whole numbers: how often, and which way, the casting faces at each edge record go along it.

use rimline::Mesh;
use rimline::mesh::{INCONSISTENT_BIT, NO_FACE};
use rimline::reference::cpu;
use rimline::reference::layout::ShadowLight;
use rimline::reference::shadow::{CAST_AVERTED, CAST_EVERY, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};

/// The share of a face in the shadow of a light: 0 or ±1, from its masks and the light's choice alone.
pub(crate) fn share(light: &ShadowLight, facing: bool, excluded: bool) -> i32 {
    match (light.casting, facing) {
        _ if excluded && light.excludes == 1 => 0,
        (CAST_EVERY, true) => 1,
        (CAST_EVERY | CAST_AVERTED, false) => -1,
        _ => 0,
    }
}

/// The share of each face for light `number`, from planes of masks of 32 lights.
pub(crate) fn shares(light: &ShadowLight, number: usize, [facing, excluded]: [&[u32]; 2], faces: usize) -> Vec<i32> {
    let bit = |masks: &[u32], face: usize| masks[number / 32 * faces + face] >> (number % 32) & 1 != 0;
    (0..faces).map(|face| share(light, bit(facing, face), bit(excluded, face))).collect()
}

/// Whether a face has an edge from its first vertex to its second one, or the other way round.
fn turn([a, b, c]: [u32; 3], edge: [u32; 2]) -> i32 {
    if [[a, b], [b, c], [c, a]].contains(&edge) { 1 } else { -1 }
}

/// The entries of sides, in the order of the edge records: an index, with bit 31 if the side is along its edge. A record with
/// the sum 2 or -2 has two entries.
fn sides(mesh: &Mesh, shares: &[i32]) -> Vec<u32> {
    let records = (0..).zip(mesh.edges().vertices()).zip(mesh.edges().packed_faces());
    let entries = records.flat_map(|((edge, &ends), faces)| {
        let own = faces.iter().filter(|face| **face != NO_FACE).map(|face| (face & !INCONSISTENT_BIT) as usize);
        let sum: i32 = own.map(|face| shares[face] * turn(mesh.faces()[face], ends)).sum();
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
