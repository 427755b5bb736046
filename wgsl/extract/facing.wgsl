// Facing: computes one bit for each face and light, set if the light lies strictly on the face's counter-clockwise
// side. The bit is the sign of det[b - a, c - a, l - w a] (NUMERICS.md, "Facing"). One bound for each face tells
// whether all its signs are certain ("Filter"). If not, the face is listed for exact_facing.wgsl, which sets its mask.

@group(0) @binding(0) var<uniform> batch: LightBatch;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(6) var<storage, read> faces: array<u32>;
@group(0) @binding(7) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> record: FacingRecord;
// As in exact_facing.wgsl, which writes it if signs are exact.
@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;

// If false, signs are those that f32 gives.
override EXACT: bool = true;

// The determinant for one light of the batch.
fn determinant(n: vec3<f32>, a: vec3<f32>, light: u32) -> f32 {
  if (PLANE) {
    return plane_form(plane_through(n, a), bitcast<vec4<f32>>(batch.light_bits[light]));
  }
  return local_form(n, a, batch.lights[light]);
}

// The bits of all lights, and the smallest absolute determinant.
struct Signs {
  mask: u32,
  smallest: f32,
}

// Four lights at a time: the loop itself costs about as much as a test of a dozen operations. Entries past `count`
// repeat the last light.
fn signs_of(n: vec3<f32>, a: vec3<f32>) -> Signs {
  var signs = Signs(0u, 0x1p127);
  for (var light = 0u; light < batch.count; light += 4u) {
    let d = vec4<f32>(
      determinant(n, a, light),
      determinant(n, a, light + 1u),
      determinant(n, a, light + 2u),
      determinant(n, a, light + 3u),
    );
    let bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), d > vec4<f32>(0.0));
    signs.mask |= (bits.x | bits.y | bits.z | bits.w) << light;
    if (EXACT) {
      let size = abs(d);
      signs.smallest = min(signs.smallest, min(min(size.x, size.y), min(size.z, size.w)));
    }
  }
  signs.mask &= batch.live;
  return signs;
}

fn list(face: u32) {
  let place = atomicAdd(&record.undecided_count, 1u);
  if (place < arrayLength(&record.undecided)) {
    record.undecided[place] = face;
  }
}

@compute @workgroup_size(256)
fn facing(@builtin(global_invocation_id) id: vec3<u32>) {
  let face = id.x;
  if (face >= chunk.count) {
    return;
  }
  let corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
  let a_bits = position_bits(corners.x, batch.position_offset, batch.position_stride);
  let b_bits = position_bits(corners.y, batch.position_offset, batch.position_stride);
  let c_bits = position_bits(corners.z, batch.position_offset, batch.position_stride);
  let a = bitcast<vec3<f32>>(a_bits);
  let u = bitcast<vec3<f32>>(b_bits) - a;
  let v = bitcast<vec3<f32>>(c_bits) - a;
  let signs = signs_of(cross_product(u, v), a);
  let magnitude = largest_magnitude(a_bits, b_bits, c_bits);
  if (EXACT) {
    let size = (abs(u.x) + abs(u.y) + abs(u.z)) * (abs(v.x) + abs(v.y) + abs(v.z));
    facing_masks[face] = signs.mask;
    let bound = face_bound(size, bitcast<f32>(magnitude), batch.reach);
    // A large magnitude also covers numbers that are not finite.
    if (signs.smallest <= bound || magnitude >= LARGE) {
      list(face);
    }
  } else if (magnitude >= INFINITE) {
    facing_masks[face] = 0u;
    if (face < arrayLength(&excluded_masks)) {
      excluded_masks[face] = batch.live;
    }
    if (chunk.first_light == 0u) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
  } else {
    let is_degenerate = corners.x == corners.y || corners.y == corners.z || corners.z == corners.x;
    facing_masks[face] = select(signs.mask, 0u, is_degenerate);
  }
}
