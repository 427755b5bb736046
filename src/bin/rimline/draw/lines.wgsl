// Silhouette edges as lines of even width on the screen: a quad an edge, read from the list by an indirect draw.
//
// Hidden lines: a fragment is drawn where the nearest point of its edge is in front of the farthest surface among the
// pixels around that point. At a silhouette one side is always open, so lines keep their whole width, which a plain
// depth test would halve.

@group(1) @binding(0) var depth: texture_depth_multisampled_2d;

struct Line {
  @builtin(position) clip: vec4<f32>,
  // The ends in pixels, and one over their distances.
  @location(0) @interpolate(flat) a: vec2<f32>,
  @location(1) @interpolate(flat) b: vec2<f32>,
  @location(2) @interpolate(flat) nearness: vec2<f32>,
  @location(3) @interpolate(flat) boundary: u32,
}

const NOTHING = Line(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(0.0), 0u);

fn is_finite(p: vec3<f32>) -> bool {
  let exponents = bitcast<vec3<u32>>(p) & vec3<u32>(0x7f800000u);
  return all(exponents != vec3<u32>(0x7f800000u));
}

fn to_pixels(view: vec3<f32>) -> vec2<f32> {
  let ndc = view.xy * vec2<f32>(frame.scale_x, frame.scale_y) / view.z;
  return (ndc * vec2<f32>(0.5, -0.5) + 0.5) * frame.size;
}

@vertex fn lines_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Line {
  let edge = rimline_silhouette(0u, instance);
  let p = rimline_position(edge.a);
  let q = rimline_position(edge.b);
  if (!edge.valid || !is_finite(p) || !is_finite(q)) {
    return NOTHING;
  }
  // Cut off what is behind the eye.
  var a = to_view(p);
  var b = to_view(q);
  if (a.z < frame.near && b.z < frame.near) {
    return NOTHING;
  }
  if (a.z < frame.near) {
    a = mix(a, b, (frame.near - a.z) / (b.z - a.z));
    a.z = frame.near;
  } else if (b.z < frame.near) {
    b = mix(b, a, (frame.near - b.z) / (a.z - b.z));
    b.z = frame.near;
  }
  let start = to_pixels(a);
  let stop = to_pixels(b);
  let span = stop - start;
  let along = select(vec2<f32>(1.0, 0.0), normalize(span), dot(span, span) > 1e-12);
  // A pixel of room for the soft edge.
  let reach = frame.half_line + 1.0;
  let end = select(-1.0, 1.0, (vertex & 1u) == 1u);
  let side = select(-1.0, 1.0, (vertex & 2u) == 2u);
  let corner = select(start, stop, end > 0.0) + reach * (end * along + side * vec2<f32>(-along.y, along.x));
  let ndc = corner / frame.size * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
  return Line(vec4<f32>(ndc, 0.5, 1.0), start, stop, 1.0 / vec2<f32>(a.z, b.z), u32(edge.kind == 2u));
}

@fragment fn lines_fragment(in: Line) -> @location(0) vec4<f32> {
  let span = in.b - in.a;
  let t = saturate(dot(in.clip.xy - in.a, span) / max(dot(span, span), 1e-12));
  let nearest = in.a + t * span;
  // One over the distance is linear on the screen.
  let line_depth = frame.near * mix(in.nearness.x, in.nearness.y, t);
  let last = vec2<i32>(frame.size) - 1;
  var farthest = 1.0;
  for (var y = -1; y <= 1; y++) {
    for (var x = -1; x <= 1; x++) {
      let pixel = clamp(vec2<i32>(floor(nearest)) + vec2<i32>(x, y), vec2<i32>(0), last);
      farthest = min(farthest, textureLoad(depth, pixel, 0));
    }
  }
  if (line_depth * 1.001 < farthest) {
    discard;
  }
  let coverage = saturate(frame.half_line + 0.5 - distance(in.clip.xy, nearest));
  let ink = select(vec3<f32>(0.012, 0.012, 0.018), vec3<f32>(0.86, 0.155, 0.012), in.boundary == 1u);
  return vec4<f32>(ink, coverage);
}
