// Polygon facing: the first stage for a mesh of polygons; it stands where `facing` does for triangles. Dispatched for each batch
// (up to 32 lights), one invocation a polygon, after the head of `undecided` is reset. It decides pairs of polygon and light: a
// triangle or quadrilateral whose turns at all corners are certain and 1 faces the light, one whose turns are certain and -1 is
// averted. A turn is 1 if the light sees three corners counter-clockwise, -1 if clockwise. It writes a bit for each light, 0
// where it is undecided, to the masks of all triangles of a polygon. A polygon with an undecided light gets a record in
// `undecided`, in any order, for `polygon_turns`, which computes all its bits anew. Bits that are decided are those of exact
// arithmetic, so bounds must not shrink. Facing masks are complete after `polygon_masks`; `edges` and others read them then.
// src/compose.rs expands `#import`; `Turns:` is the most turns of the loop below it. docs/numerics/polygons.md, "Four turns".

#import extract/one_caster
#import polygon/outlines
#import polygon/quads

// Facing masks of all triangles, and after them as many words in which `polygon_masks` writes for which lights they are twisted.
@group(0) @binding(8) var<storage, read_write> facing_masks: array<u32>;

// The lights for which all turns are certain and 1, and those for which they are certain and -1.
struct Convex {
  facing: u32,
  averted: u32,
}

// The outline must be a triangle or quadrilateral; a triangle has four equal turns (polygon/quads.wgsl). None if f32 is not
// certain of the positions, which is tested last: the loop is the same for all invocations.
fn convex_quad(outline: OutlineRange) -> Convex {
  var convex = Convex(0u, 0u);
  let quad = quad_of(outline);
  let bound = vec4<f32>(quad.bound);
  // Turns: 8.
  for (var place = 0u; place < light_places(); place += 4u) {
    let turns = turns_of(quad, place);
    let low = min(min(turns[0], turns[1]), min(turns[2], turns[3]));
    let high = max(max(turns[0], turns[1]), max(turns[2], turns[3]));
    convex.facing |= together(bits_of(low > bound)) << place;
    convex.averted |= together(bits_of(high < -bound)) << place;
  }
  if (!quad.is_certain) {
    return Convex(0u, 0u);
  }
  return convex;
}

// `chunk.count` is the number of polygons.
@compute @workgroup_size(256)
fn polygon_facing(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x >= chunk.count) {
    return;
  }
  let outline = outline_of(id.x);
  // The polygon walks each edge both ways, so none is left in its outline, and no edge record names it. No stage writes its
  // masks: they keep the zeros of a new buffer.
  if (outline.count == 0u) {
    return;
  }
  var convex = Convex(0u, 0u);
  if (outline.is_loop && (outline.count == 3u || outline.count == 4u)) {
    convex = convex_quad(outline);
  }
  // Turns: POLYGON_TRIANGLES.
  for (var triangle = outline.first_triangle; triangle < outline.end_triangle; triangle++) {
    facing_masks[triangle] = convex.facing & live_lights();
  }
  if ((live_lights() & ~(convex.facing | convex.averted)) != 0u) {
    // There is room for a record of every polygon. `polygon_turns` writes its other words.
    let number = atomicAdd(&undecided[RECORD_COUNT], 1u);
    atomicStore(&undecided[record_at(number) + POLYGON], id.x);
    // `polygon_turns` has an invocation a record. Its workgroups lie in rows (x) of at most ENTRY_ROW; y counts rows, and z is 1
    // from the reset.
    let workgroup = number / OUTLINE_LANES;
    atomicMax(&undecided[RECORD_WORKGROUPS], min(workgroup + 1u, ENTRY_ROW));
    atomicMax(&undecided[RECORD_WORKGROUPS + 1u], workgroup / ENTRY_ROW + 1u);
  }
}
