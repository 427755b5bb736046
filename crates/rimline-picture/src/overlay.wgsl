// A sketch of shadow volumes: a side of tinted glass from each silhouette edge to infinity, and its outline. It stands
// after common.wgsl, scene.wgsl and the library's include (extract/results.wgsl). Each side is an instance of the light's
// indirect draw, which must have four vertices. depth_overlay.wgsl of the command uses `Edge` and the fragment shaders.

// A vertex of an outline.
struct Edge {
  @builtin(position) clip: vec4<f32>,
  @location(0) @interpolate(flat) opacity: f32,
}

// The light's colour, as bright as it can be.
fn tint() -> vec3<f32> {
  let brightest = max(max(shaded.color.r, shaded.color.g), max(shaded.color.b, 1e-6));
  return shaded.color / brightest;
}

@fragment fn volumes_fragment() -> @location(0) vec4<f32> {
  let glass = mix(vec3<f32>(0.9, 0.62, 0.18), tint(), 0.75) * vec3<f32>(0.8, 0.62, 0.36);
  return vec4<f32>(glass / frame.exposure, 0.14 * shaded.density);
}

@fragment fn edges_fragment(in: Edge) -> @location(0) vec4<f32> {
  return vec4<f32>(vec3<f32>(0.35, 0.14, 0.02) * tint() / frame.exposure, in.opacity * shaded.density);
}

@vertex fn volumes_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32)
  -> @builtin(position) vec4<f32> {
  // Corners of a triangle strip.
  return corner(instance, (vertex & 1u) != 0u, vertex >= 2u);
}

@vertex fn edges_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Edge {
  // Outlines of more than 100 sides are fainter, so that they do not hide everything.
  let opacity = 0.4 * min(1.0, 100.0 / f32(rimline_silhouettes(rimline_info.first_light + shaded.silhouettes)));
  // Corners of a line strip: from infinity along one ray, along the edge, and out along the other.
  return Edge(corner(instance, vertex >= 2u, vertex == 0u || vertex == 3u), opacity);
}

// A corner of a side: at the first or second end of the edge, on the edge or at infinity. All corners are one point, so that
// nothing is drawn, if the instance is no silhouette edge or a position is not finite.
fn corner(instance: u32, second: bool, far: bool) -> vec4<f32> {
  let edge = rimline_silhouette(rimline_info.first_light + shaded.silhouettes, instance);
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
