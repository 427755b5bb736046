// Per edge: the method as Brabec and Seidel published it in 2003, kept for comparison. One thread an edge gathers four
// positions and tests both faces' plane equations against every light, so a face's side is decided again at each of
// its edges: loops may fail to close.

@group(0) @binding(0) var<uniform> word: LightWord;
@group(0) @binding(1) var<uniform> chunk: Chunk;
// (a, b, c, d): face 0 is (a, b, c); face 1 is (b, a, d), or (a, b, d) where bit 31 of a is set; no face 1: d is NO_FACE.
@group(0) @binding(6) var<storage, read> edge_corners: array<vec4<u32>>;

fn position(vertex: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(position_bits(vertex, word.position_offset, word.position_stride));
}

// (b - a) x (c - a), counter-clockwise outside.
fn normal(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
  let u = b - a;
  let v = c - a;
  return vec3<f32>(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
}

fn plane(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec4<f32> {
  let n = normal(a, b, c);
  return vec4<f32>(n, -(n.x * a.x + n.y * a.y + n.z * a.z));
}

fn is_in_front(plane: vec4<f32>, index: u32) -> bool {
  let light = bitcast<vec4<f32>>(word.light_bits[index]);
  return plane.x * light.x + plane.y * light.y + plane.z * light.z + plane.w * light.w > 0.0;
}

fn mask_of(plane: vec4<f32>) -> u32 {
  var mask = 0u;
  for (var light = 0u; light < word.count; light += 4u) {
    mask |= select(0u, 1u, is_in_front(plane, light)) << light;
    mask |= select(0u, 2u, is_in_front(plane, light + 1u)) << light;
    mask |= select(0u, 4u, is_in_front(plane, light + 2u)) << light;
    mask |= select(0u, 8u, is_in_front(plane, light + 3u)) << light;
  }
  return mask & word.live;
}

@compute @workgroup_size(256)
fn per_edge(@builtin(global_invocation_id) id: vec3<u32>) {
  let edge = id.x;
  if (edge >= chunk.count) {
    return;
  }
  let corners = edge_corners[edge];
  let a = position(corners.x & ~INCONSISTENT);
  let b = position(corners.y);
  let winding = mask_of(plane(a, b, position(corners.z)));
  var silhouette = word.live;
  if (corners.w != NO_FACE) {
    let d = position(corners.w);
    if ((corners.x & INCONSISTENT) != 0u) {
      silhouette = ~(winding ^ mask_of(plane(a, b, d))) & word.live;
    } else {
      silhouette = winding ^ mask_of(plane(b, a, d));
    }
  }
  emit(edge, silhouette, winding);
}
