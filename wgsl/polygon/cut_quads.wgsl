// Cut quads: lists the pieces of L-twisted quadrilaterals that `polygon_turns` decided. L-twisted: the outline crosses itself as
// seen from light L; a piece is a part of the border of what it darkens. Two neighbouring corners turn to the left and the others
// to the right, so the two edges between them cross, and each of the two lobes has the sense of its corners. Dispatched after the
// passes of `cut_edges`, if the extractor has lists, one invocation a record of `undecided`. It appends six pieces for each light
// behind those of `cut_edges`, in no particular order, for the same readers (polygon/list_pieces.wgsl). It must come last: the
// passes of `cut_edges` take all that is listed for their cuts. Both lobes share one crossing point, bit for bit.
// docs/numerics/twisted-polygons.md.

#import polygon/list_pieces
#import polygon/outlines

// Lists the pieces of a quadrilateral for a light: two lobes of three. `first` is a corner that turns as the one after it does, 0
// or 3; `is_positive` says that corner 0, which is one of these two, turns to the left. Edges `first` + 1 and `first` + 3 cross.
fn cut_quad(outline: OutlineRange, light: u32, first: u32, is_positive: bool) {
  var corners: array<vec3<u32>, 4>;
  for (var corner = 0u; corner < 4u; corner++) {
    corners[corner] = place_of(outlines[outline.first + (first + corner) % 4u].x);
  }
  let crossing = crossing_point(outline, (first + 1u) % 4u, (first + 3u) % 4u, light);
  let middle = middle_of(outline);
  let place = take_room(light, 6u);
  // The lobe of corners 0 and 1, and that of corners 2 and 3.
  for (var lobe = 0u; lobe < 2u; lobe++) {
    let a = corners[2u * lobe];
    let b = corners[2u * lobe + 1u];
    let is_turned = is_positive == (lobe == 1u);
    write_piece(light, place + 3u * lobe, a, b, is_turned, middle);
    write_piece(light, place + 3u * lobe + 1u, b, crossing, is_turned, middle);
    write_piece(light, place + 3u * lobe + 2u, crossing, a, is_turned, middle);
  }
}

@compute @workgroup_size(64)
fn cut_quads(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let records = atomicLoad(&undecided[RECORD_COUNT]);
  let row = OUTLINE_LANES * groups.x;
  // Turns: 1.
  for (var number = id.y * row + id.x; number < records; number += groups.y * row) {
    let at = record_at(number);
    let outline = outline_of(polygon_of(at));
    let turn_0 = atomicLoad(&undecided[at + TURN_0]);
    let turn_1 = atomicLoad(&undecided[at + TURN_1]);
    // Turns: 32.
    for (var rest = atomicLoad(&undecided[at + TWISTED_QUAD]); rest != 0u; rest &= rest - 1u) {
      let light = firstTrailingBit(rest);
      let is_positive = ((turn_0 >> light) & 1u) != 0u;
      let is_next_alike = ((turn_1 >> light) & 1u) == select(0u, 1u, is_positive);
      // If corner 1 is not alike, corner 3 is, which comes before corner 0.
      cut_quad(outline, light, select(3u, 0u, is_next_alike), is_positive);
    }
  }
}
