// Stage `bounds`: computes the box around the finite faces of each caster, and whether a face with three different
// vertices is not finite. The scene table already has both for rigid casters.
// Dispatched between `relist` and `counting_methods`, once for all light batches, for each group of casters in world
// space; an invocation has chunks of 64 face slots. Reads: positions, faces, the scene table, the relevant lights of
// casters, CHOICE_DIRTY. Writes: `boxes`, which must be zeros before, for `counting_methods`, `stencil_pencil`,
// `stencil_crossings` and `piece_crossings`. Groups and casters whose boxes no stage reads are skipped: theirs stay empty.
// Boxes are exact and have the same bits in any order. Floats are compared as keys, integers of the same order. So atomics
// can join them, and no device flushes them to zero.

#import common/casters
#import common/order_keys
#import shadow/caster
#import shadow/choices
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;
@group(0) @binding(3) var<storage, read> faces: array<u32>;
// Seven words for each caster. 0 to 2: keys of the lowest x, y, z, inverted. 3 to 5: keys of the highest. So zeros are an
// empty box. 6: whether a face with three different vertices has a corner that is not finite.
@group(0) @binding(4) var<storage, read_write> boxes: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read> choices: array<u32>;
@group(0) @binding(6) var<storage, read> relevant_lights: array<u32>; // By batch and caster.

// Whether a stage may read a box of the group: some list is dirty, or counts are bounded.
fn is_any_box_read() -> bool {
  var is_read = shape.needs_boxes;
  // Turns: BOUND_CHOICES.
  for (var index = 0u; index < shape.views * shape.batches; index++) {
    is_read |= choices[CHOICE_WORDS * (index * shape.casters + shape.first_caster) + CHOICE_DIRTY];
  }
  return is_read != 0u;
}

// Whether any light is relevant to the caster. If none is, no stage reads its box.
fn has_relevant_light(caster: u32) -> bool {
  var lights = 0u;
  // Turns: 32.
  for (var batch = 0u; batch < shape.batches; batch++) {
    lights |= relevant_lights[batch * shape.casters + caster];
  }
  return lights != 0u;
}

// Adds the faces from `first` to before `end`, indices in the page, to the words of a caster in `boxes`.
fn bound_faces(caster: u32, first: u32, end: u32) {
  var low = vec3<u32>(0xffffffffu);
  var high = vec3<u32>(0u);
  var has_holes = false;
  // Turns: BOUND_CHUNKS * CHUNK in all.
  for (var face = first; face < end; face++) {
    let corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
    let a = vertex_bits(caster, corners.x);
    let b = vertex_bits(caster, corners.y);
    let c = vertex_bits(caster, corners.z);
    if (is_finite(bitcast<vec3<f32>>(a)) && is_finite(bitcast<vec3<f32>>(b)) && is_finite(bitcast<vec3<f32>>(c))) {
      low = min(low, min(order_keys(a), min(order_keys(b), order_keys(c))));
      high = max(high, max(order_keys(a), max(order_keys(b), order_keys(c))));
    } else if (corners.x != corners.y && corners.y != corners.z && corners.z != corners.x) {
      has_holes = true;
    }
  }
  if (has_holes) {
    atomicMax(&boxes[7u * caster + 6u], 1u);
  }
  if (low.x <= high.x) {
    for (var axis = 0u; axis < 3u; axis++) {
      atomicMax(&boxes[7u * caster + axis], ~low[axis]);
      atomicMax(&boxes[7u * caster + 3u + axis], high[axis]);
    }
  }
}

@compute @workgroup_size(64)
fn bounds(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  if (!is_any_box_read()) {
    return;
  }
  // Turns: BOUND_CHUNKS.
  for (var chunk = id.x; chunk * CHUNK < shape.faces; chunk += 64u * groups.x) {
    let caster = caster_of_slot(shape.face_chunks_offset, chunk * CHUNK);
    let range = face_range(caster);
    let first = chunk * CHUNK - range.x;
    if ((caster_flags(caster) & RIGID) == 0u && first < range.y && has_relevant_light(caster)) {
      bound_faces(caster, range.z + first, range.z + min(first + CHUNK, range.y));
    }
  }
}
