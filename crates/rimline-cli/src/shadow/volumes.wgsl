// The shadow volumes themselves: sides as tinted glass, and the lines they are made of.

@vertex fn volumes_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32)
  -> @builtin(position) vec4<f32> {
  // Corners of a triangle strip.
  return corner(instance, (vertex & 1u) != 0u, vertex >= 2u);
}

@vertex fn edges_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Edge {
  // Many lines would hide everything.
  let opacity = 0.4 * min(1.0, 100.0 / f32(rimline_silhouettes(rimline_info.first_light + shaded.bit)));
  // Corners of a line strip: from infinity along one ray, along the edge, and out along the other.
  return Edge(corner(instance, vertex >= 2u, vertex == 0u || vertex == 3u), opacity);
}

fn is_finite(p: vec3<f32>) -> bool {
  let exponents = bitcast<vec3<u32>>(p) & vec3<u32>(0x7f800000u);
  return all(exponents != vec3<u32>(0x7f800000u));
}

fn corner(instance: u32, second: bool, far: bool) -> vec4<f32> {
  let edge = rimline_silhouette(rimline_info.first_light + shaded.bit, instance);
  let a = rimline_position(edge.a);
  let b = rimline_position(edge.b);
  if (!edge.valid || !is_finite(a) || !is_finite(b)) {
    return vec4<f32>(0.0, 0.0, 0.0, 1.0);
  }
  let p = select(a, b, second);
  if (far) {
    return direction_to_clip(shaded.light.w * from_eye(p) - shaded.light.xyz);
  }
  return to_clip(p);
}
