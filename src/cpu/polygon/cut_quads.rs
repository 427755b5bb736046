//! Cut quads: the pieces of a quadrilateral whose turns are known.

use super::cut_edges::{Piece, PieceEnd};

/// The pieces of a quadrilateral that is L-twisted, with the turns at its corners as seen from the light: two neighbours are
/// positive, and the others negative. `None` for other turns. Where both cut edges are cut is left at 0.5.
pub fn cut_quads(turns: [i32; 4]) -> Option<Vec<Piece>> {
    let first =
        (0..4).find(|&corner| turns[corner] == turns[(corner + 1) % 4] && turns[corner] != turns[(corner + 2) % 4])?;
    let is_split = turns[(first + 2) % 4] == turns[(first + 3) % 4] && !turns.contains(&0);
    let edge = |corner: usize| (first + corner) % 4;
    let cut = |other: usize| PieceEnd::Crossing { edge: edge(other), at: 0.5 };
    // Two whole edges, and both parts of the others.
    let of_lobe = |lobe: usize| {
        let is_turned = turns[edge(2 * lobe)] < 0;
        let (own, next, before) = (2 * lobe, (2 * lobe + 1) % 4, (2 * lobe + 3) % 4);
        let piece = |corner: usize, ends| Piece { edge: edge(corner), ends, is_turned };
        [
            piece(own, [PieceEnd::Corner, PieceEnd::Corner]),
            piece(next, [PieceEnd::Corner, cut(before)]),
            piece(before, [cut(next), PieceEnd::Corner]),
        ]
    };
    is_split.then(|| [of_lobe(0), of_lobe(1)].concat())
}
