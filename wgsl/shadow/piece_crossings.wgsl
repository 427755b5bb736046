// Piece crossings: a compute stage that adds the sides of pieces of L-twisted polygons (see shadow/lists.wgsl) to the bins of
// half planes that they cross (shadow/pencil.wgsl), each with the weight 1. Dispatched after `stencil_crossings`, if the caller
// asks for a bound and the only caster is a mesh of polygons, for each batch (up to 32 lights) and view; a row of workgroups
// shares the pieces of a light. `stencil_bound` reads the bins. Where a list of pieces overflowed, all of them cross every half
// plane, so that bounds are never too small. docs/numerics/receivers.md, "Bound on counts".

#import shadow/caster
#import shadow/choices
#import shadow/lists
#import shadow/pencil
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> boxes: array<u32>;
@group(0) @binding(4) var<storage, read> pieces: array<u32>;
@group(0) @binding(7) var<storage, read> pencils: array<StencilPencil>;
@group(0) @binding(8) var<storage, read_write> crossings: array<atomic<u32>>; // The rows of the pencils.

fn place_at(word: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(vec3<u32>(pieces[word], pieces[word + 1u], pieces[word + 2u]));
}

// A workgroup takes a share of one light's pieces.
@compute @workgroup_size(64)
fn piece_crossings(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  let number = draw.first_light + bit;
  let casts = (choice_part(0u, number / 32u, draw.view, 0u)[CASTS] >> (number % 32u)) & 1u;
  if (casts == 0u) {
    return;
  }
  let by = pencils[draw.view * shape.lights + number];
  if (by.kind == AROUND) {
    let own = world_box(0u);
    if (axis_meets(by.place, axis_of(by), own.low, own.high)) {
      return;
    }
  }
  let row = row_of(draw.view, number, 0u);
  let capacity = piece_capacity();
  if (pieces[bit] > capacity) {
    if (group.x == 0u && thread == 0u) {
      cross_bins(row, 0u, BINS - 1u, pieces[bit]);
    }
    return;
  }
  // Turns: LISTED_ITEMS.
  for (var piece = group.x * 64u + thread; piece < pieces[bit]; piece += 64u * groups.x) {
    let at = PIECE_COUNTS + PIECE_WORDS * (bit * capacity + piece);
    cross_edge(by, row, place_at(at), place_at(at + 3u), 1u);
  }
}
