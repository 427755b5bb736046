// Which face each place of the picture shows, and how deep. Not the depth buffer, which OpenGL's shaders cannot read as
// WGSL does; in integers, since OpenGL need not draw onto floats; not multisampled, since Mesa's OpenGL then reads zeros.

@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;

struct Seen {
  @builtin(position) clip: vec4<f32>,
  @location(0) distance: f32,
  // Its number plus 1.
  @location(1) @interpolate(flat) face: u32,
}

@vertex fn survey_vertex(@builtin(vertex_index) corner: u32) -> Seen {
  let first = 3u * faces[corner];
  let view = to_view(vec3<f32>(positions[first], positions[first + 1u], positions[first + 2u]));
  return Seen(to_clip(view), view.z, corner / 3u + 1u);
}

// The face's number plus 1 and the bits of its depth, each in two halves, the lower one first.
@fragment fn survey_fragment(in: Seen) -> @location(0) vec4<u32> {
  let depth = bitcast<u32>(frame.near / max(in.distance, frame.near));
  return vec4<u32>(in.face, in.face >> 16u, depth, depth >> 16u) & vec4<u32>(0xffffu);
}
