// Silhouette edges as lines of even width on the screen: a quad an edge, read from the list by an indirect draw.
//
// Hidden lines: a fragment is drawn where the nearest point of its edge is in front of what lies to one of the edge's
// two sides there. At a silhouette one side is always open, so lines keep their whole width, which a plain depth test
// would halve.

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

// Depth at a place in the picture, from the pixel's nearest sample; the four lie where all APIs put them.
fn depth_near(place: vec2<f32>) -> f32 {
  let inside = clamp(place, vec2<f32>(0.0), frame.size - 0.5);
  let f = fract(inside);
  let distances = vec4<f32>(
    distance(f, vec2<f32>(0.375, 0.125)),
    distance(f, vec2<f32>(0.875, 0.375)),
    distance(f, vec2<f32>(0.125, 0.625)),
    distance(f, vec2<f32>(0.625, 0.875)));
  var best = select(0, 1, distances.y < distances.x);
  best = select(best, 2, distances.z < min(distances.x, distances.y));
  best = select(best, 3, distances.w < min(min(distances.x, distances.y), distances.z));
  return textureLoad(depth, vec2<i32>(inside), best);
}

@fragment fn lines_fragment(in: Line) -> @location(0) vec4<f32> {
  let span = in.b - in.a;
  let t = saturate(dot(in.clip.xy - in.a, span) / max(dot(span, span), 1e-12));
  let nearest = in.a + t * span;
  // One over the distance is linear on the screen.
  let line_depth = frame.near * mix(in.nearness.x, in.nearness.y, t);
  let aside = 0.7 * normalize(select(vec2<f32>(1.0, 0.0), vec2<f32>(-span.y, span.x), dot(span, span) > 1e-12));
  let farthest = min(depth_near(nearest + aside), depth_near(nearest - aside));
  if (line_depth * 1.0001 < farthest) {
    discard;
  }
  let coverage = saturate(frame.half_line + 0.5 - distance(in.clip.xy, nearest));
  let ink = select(vec3<f32>(0.014, 0.011, 0.016), vec3<f32>(0.80, 0.12, 0.01), in.boundary == 1u);
  return vec4<f32>(ink, coverage);
}
