// Lists of sides: where they are, and which a side belongs to.

// A light has two lists of sides in one run: from the front those that are drawn plainly, from the back those that are
// clipped at the near plane. A side of weight 2 is there twice.
const PLAIN: u32 = 0u;
const CLIPPED: u32 = 1u;
// The counts of the batch, before the lists.
const SIDE_COUNTS: u32 = 64u;

fn side_place(bit: u32, kind: u32, place: u32) -> u32 {
  return SIDE_COUNTS + bit * shape.side_capacity + select(place, shape.side_capacity - 1u - place, kind == CLIPPED);
}

fn side_kind(light: ShadowLight) -> u32 {
  return select(PLAIN, CLIPPED, light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005);
}
