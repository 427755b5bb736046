// Bounds: a compute stage that finds the box of each caster's finite faces, and whether a caster has faces that are not
// finite. A caster is a mesh that throws shadows. Dispatched between `relist` and `choose`, for each group of casters in world
// space; invocations take chunks of 64 face slots in turn. Rigid casters have a box in mesh space already, in the table. It
// reads positions and faces, and `lit` and the bits FRESH that `relist` wrote, by which it skips groups and casters whose
// boxes nothing reads. `choose`, `stencil_pencil` and the stages of crossings read `boxes`, which are zeros before. Boxes are
// exact, the same bits in any order: floats are compared as keys, integers of the same order, so that atomics can join them
// and no device can flush them.

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;
@group(0) @binding(3) var<storage, read> faces: array<u32>;
// For each caster the keys of the lowest x, y, z, inverted, and the highest, so that zeros are an empty box. The last word is
// 1 if a face that names three different vertices has a corner that is not finite.
@group(0) @binding(4) var<storage, read_write> boxes: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read> choices: array<u32>;
// For each batch and caster the lights that matter.
@group(0) @binding(6) var<storage, read> lit: array<u32>;

// Whether any box of the group is read.
fn is_needed() -> bool {
  var fresh = shape.needs_boxes;
  // Turns: BOUND_PLACES.
  for (var place = 0u; place < shape.views * shape.batches; place++) {
    fresh |= choices[CHOICE_WORDS * (place * shape.casters + shape.first_caster) + FRESH];
  }
  return fresh != 0u;
}

// Whether any light matters to a caster. If not, nothing reads its box.
fn has_light(caster: u32) -> bool {
  var matter = 0u;
  // Turns: 32.
  for (var batch = 0u; batch < shape.batches; batch++) {
    matter |= lit[batch * shape.casters + caster];
  }
  return matter != 0u;
}

// The box of some faces of a caster.
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
      low = min(low, min(ordered(a), min(ordered(b), ordered(c))));
      high = max(high, max(ordered(a), max(ordered(b), ordered(c))));
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
  if (!is_needed()) {
    return;
  }
  // Turns: BOUND_CHUNKS.
  for (var chunk = id.x; chunk * CHUNK < shape.faces; chunk += 64u * groups.x) {
    let caster = caster_of(shape.face_chunks_at, chunk * CHUNK);
    let run = face_run(caster);
    let first = chunk * CHUNK - run.x;
    if ((caster_flags(caster) & RIGID) == 0u && first < run.y && has_light(caster)) {
      bound_faces(caster, run.z + first, run.z + min(first + CHUNK, run.y));
    }
  }
}
