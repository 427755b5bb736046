//! Faces in batches, so that few of a batch lie over each other as seen from any light.

use std::collections::BTreeMap;

use rimline::Light;

use super::deepest::deepest;
use crate::render::coincident::Joined;

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
    use super::*;

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
