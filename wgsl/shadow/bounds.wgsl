// Bounds: computes the box of a caster's finite faces, for `choose`, and whether the caster has other faces. Floats are
// compared as integers of the same order.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<storage, read> positions: array<u32>;
@group(0) @binding(2) var<storage, read> faces: array<u32>;
// The lowest x, y, z, and the highest. The last element is 1 if a face has a corner that is not finite.
@group(0) @binding(3) var<storage, read_write> box: array<atomic<u32>, 7>;

// The bits of a float as an integer with the same order as the floats.
fn ordered(bits: vec3<u32>) -> vec3<u32> {
  return select(bits | vec3<u32>(0x80000000u), ~bits, bits >= vec3<u32>(0x80000000u));
}

@compute @workgroup_size(64)
fn bounds(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  var low = vec3<u32>(0xffffffffu);
  var high = vec3<u32>(0u);
  var has_holes = false;
  for (var face = id.x; face < shape.faces; face += 64u * groups.x) {
    let corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
    let a = caster_bits(corners.x);
    let b = caster_bits(corners.y);
    let c = caster_bits(corners.z);
    if (is_finite(bitcast<vec3<f32>>(a)) && is_finite(bitcast<vec3<f32>>(b)) && is_finite(bitcast<vec3<f32>>(c))) {
      low = min(low, min(ordered(a), min(ordered(b), ordered(c))));
      high = max(high, max(ordered(a), max(ordered(b), ordered(c))));
    } else if (corners.x != corners.y && corners.y != corners.z && corners.z != corners.x) {
      has_holes = true;
    }
  }
  if (has_holes) {
    atomicMax(&box[6], 1u);
  }
  if (low.x <= high.x) {
    for (var axis = 0u; axis < 3u; axis++) {
      atomicMin(&box[axis], low[axis]);
      atomicMax(&box[3u + axis], high[axis]);
    }
  }
}
