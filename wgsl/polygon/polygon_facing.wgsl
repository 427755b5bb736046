// Polygon facing: computes one bit for each polygon and light, set if the polygon faces the light. A quadrilateral or triangle whose
// turns at all corners are certain and alike is decided here (docs/numerics/polygons.md, "Four turns"). Others are listed for
// polygon_turns.wgsl: at most a few, where surfaces are smooth. Each triangle of a polygon has the polygon's bits. The first
// stage of polygons in a frame; `edges` and shadow volumes read the masks.

#import extract/one_caster
#import polygon/outlines
#import polygon/quads

// Facing masks of all triangles, and after them their twisted masks.
@group(0) @binding(8) var<storage, read_write> facing_masks: array<u32>;

// The lights for which all turns are certain and positive, and those for which they are certain and negative.
struct Convex {
  facing: u32,
  averted: u32,
}

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

@compute @workgroup_size(256)
fn polygon_facing(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x >= chunk.count) {
    return;
  }
  let outline = outline_of(id.x);
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
    let number = atomicAdd(&undecided[RECORD_COUNT], 1u);
    atomicStore(&undecided[record_at(number) + POLYGON], id.x);
    let workgroup = number / OUTLINE_LANES;
    atomicMax(&undecided[RECORD_WORKGROUPS], min(workgroup + 1u, ENTRY_ROW));
    atomicMax(&undecided[RECORD_WORKGROUPS + 1u], workgroup / ENTRY_ROW + 1u);
  }
}
