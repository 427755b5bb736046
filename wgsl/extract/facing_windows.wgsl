// Reads the facing masks of a single mesh, which may span up to four bindings of equal length.

@group(0) @binding(2) var<storage, read> facing_0: array<u32>;
@group(0) @binding(3) var<storage, read> facing_1: array<u32>;
@group(0) @binding(4) var<storage, read> facing_2: array<u32>;
@group(0) @binding(5) var<storage, read> facing_3: array<u32>;
// The number of faces in each binding except the last. 0: all are in the first.
override WINDOW_WORDS: u32 = 0u;

fn facing_mask(face: u32) -> u32 {
  if (WINDOW_WORDS == 0u) {
    return facing_0[face];
  }
  let at = face % max(WINDOW_WORDS, 1u);
  switch (face / max(WINDOW_WORDS, 1u)) {
    case 0u: { return facing_0[at]; }
    case 1u: { return facing_1[at]; }
    case 2u: { return facing_2[at]; }
    default: { return facing_3[at]; }
  }
}
