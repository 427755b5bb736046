// Facing: for each face one bit a light, set where the light lies strictly on the face's counter-clockwise side.
// Sign of det[b - a, c - a, l - w a] in its local form n . (l - w a); see NUMERICS.md, "Facing".

@group(0) @binding(0) var<uniform> word: LightWord;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(6) var<storage, read> faces: array<u32>;
@group(0) @binding(7) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> statistics: Statistics;

fn faces_light(n: vec3<f32>, a: vec3<f32>, light: vec4<f32>) -> bool {
  let to_light = light.xyz - light.w * a;
  return n.x * to_light.x + n.y * to_light.y + n.z * to_light.z > 0.0;
}

fn mask_of(n: vec3<f32>, a: vec3<f32>) -> u32 {
  var mask = 0u;
  // Four at a time: the loop's own cost counts beside a test of a dozen operations. Lights past `count` are zeros.
  for (var light = 0u; light < word.count; light += 4u) {
    mask |= select(0u, 1u, faces_light(n, a, word.lights[light])) << light;
    mask |= select(0u, 2u, faces_light(n, a, word.lights[light + 1u])) << light;
    mask |= select(0u, 4u, faces_light(n, a, word.lights[light + 2u])) << light;
    mask |= select(0u, 8u, faces_light(n, a, word.lights[light + 3u])) << light;
  }
  return mask;
}

@compute @workgroup_size(256)
fn facing(@builtin(global_invocation_id) id: vec3<u32>) {
  let face = id.x;
  if (face >= chunk.count) {
    return;
  }
  let corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
  let a = position_bits(corners.x, word.position_offset, word.position_stride);
  let b = position_bits(corners.y, word.position_offset, word.position_stride);
  let c = position_bits(corners.z, word.position_offset, word.position_stride);
  var mask = 0u;
  if (!(is_finite(a) && is_finite(b) && is_finite(c))) {
    if (chunk.first_light == 0u) {
      atomicAdd(&statistics.non_finite_faces, 1u);
    }
  } else if (corners.x != corners.y && corners.y != corners.z && corners.z != corners.x) {
    let origin = bitcast<vec3<f32>>(a);
    mask = mask_of(normal(origin, bitcast<vec3<f32>>(b), bitcast<vec3<f32>>(c)), origin);
  }
  facing_masks[face] = mask;
}
