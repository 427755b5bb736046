// The pieces of L-twisted polygons, as `cut_edges` lists them: for each light of the batch their number, then lists of pieces of
// nine words each. A piece begins at a place and ends at another, and its polygon has a middle, from which a fan is drawn
// where there are caps. What is dark is on the left of a piece as seen from the light.
//
// Expects: `shape`, `draw`, and `pieces`, the lists of pieces.
const PIECE_COUNTS: u32 = 32u;
const PIECE_WORDS: u32 = 9u;

// Pieces of a light that there is room for.
fn piece_capacity() -> u32 {
  return (arrayLength(&pieces) - PIECE_COUNTS) / (PIECE_WORDS * min(32u, shape.lights - draw.first_light));
}
