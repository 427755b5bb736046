// Which face each sample of the picture shows, and how deep. In a colour attachment, since OpenGL's shaders cannot read a
// multisampled depth buffer; in integers, since it need not draw onto floats.

@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;

struct Seen {
  @builtin(position) clip: vec4<f32>,
  // Where the face covers it: its plane may lead anywhere beside it.
  @location(0) @interpolate(perspective, centroid) distance: f32,
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
