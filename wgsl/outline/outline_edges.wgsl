// Stage `outline_edges`: draws edges of an extraction, or in the variant SCENE of a group of a scene's casters, as lines of
// a width in pixels. Each instance is an edge and four vertices, a strip: a quad around the line, which the fragment shader
// trims to a line with round ends. The entry points are two vertex shaders and the fragment shader `outline_ink`.
// `outline_silhouette` draws silhouettes, which include edges with one face, by the indirect draw of the light's list.
// `outline_feature` draws creases and marked edges, with an instance for each edge. It draws a silhouette only if it is
// marked and the class of silhouettes, or of edges with one face, is not drawn. Group 0 has the edges
// (interface/outlined.wgsl), group 1 what is declared below. Reads: silhouettes, facing masks, positions, faces, marks,
// and the caller's depth, which hides lines. The depth test is at the nearest point of the line, not at the pixel. Half
// of an outline's width lies outside the surface, where the depth is that of what is behind.

#import extract/results
#import interface/outlined

struct OutlineView {
  // The camera's matrix, by columns, and the point that positions are relative to.
  columns: array<vec4<f32>, 4>,
  origin: vec3<f32>,
  // Half the width of a line, in pixels, at least 0.5.
  half_width: f32,
  // Colours, not premultiplied. Lines of less than a pixel have a smaller alpha instead.
  silhouette: vec4<f32>,
  boundary: vec4<f32>,
  crease: vec4<f32>,
  marked: vec4<f32>,
  // The size of the image in pixels.
  size: vec2<f32>,
  // A line is visible up to this much behind the depth of the image.
  depth_bias: f32,
  // The edge of two faces is a crease if the cosine between their normals is smaller.
  crease_cosine: f32,
  // The index of the light that stands for the eye, in an extraction only: `OutlinedGroup` has it for scenes.
  light: u32,
  // A bit for each class that is drawn, from bit 0 on: silhouettes, boundaries, creases, marked edges.
  classes: u32,
  // 1 if a larger depth is nearer.
  is_reversed: u32,
  reserved: u32,
}

@group(1) @binding(0) var<uniform> outline: OutlineView;
// The caller's depth, of which sample 0 is read. It is bound as floats, because naga writes no loads of depth textures for
// OpenGL.
#if SAMPLES
@group(1) @binding(1) var outline_depth: texture_multisampled_2d<f32>;
#else
@group(1) @binding(1) var outline_depth: texture_2d<f32>;
#endif
// The vertices of faces, three each. Only `outline_feature` reads them.
@group(1) @binding(2) var<storage, read> outline_faces: array<u32>;
const NO_EDGE: u32 = 3u; // The kind of a slot without an edge, or of a caster for which the light is not relevant.
// Bits of `classes`.
const CREASES: u32 = 4u;
const MARKED: u32 = 8u;
// The kind of an edge with one face.
const BOUNDARY: u32 = 2u;

struct OutlinePoint {
  @builtin(position) clip: vec4<f32>,
  // The ends of the line, in pixels.
  @location(0) @interpolate(flat) ends: vec4<f32>,
  // The depths of the ends. Depth is linear between them on the screen.
  @location(1) @interpolate(flat) depths: vec2<f32>,
  @location(2) @interpolate(flat) color: vec4<f32>,
}

// A vertex of an edge that is not drawn. Four equal vertices cover no pixel.
fn no_line() -> OutlinePoint {
  return OutlinePoint(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec4<f32>(), vec2<f32>(), vec4<f32>());
}

// The distance, in clip space, of a point from a plane that clips lines: near, left, right, bottom, top. Inside it is
// positive. The four side planes lie outside the frustum by half the width of a line and two pixels.
fn clip_distance(plane: u32, clip: vec4<f32>) -> f32 {
  if (plane == 0u) {
    return select(clip.z, clip.w - clip.z, outline.is_reversed == 1u);
  }
  let axis = (plane - 1u) >> 1u;
  let scale = 1.0 + 2.0 * (outline.half_width + 2.0) / outline.size[axis];
  return clip.w * scale + select(clip[axis], -clip[axis], (plane & 1u) == 0u);
}

// A point in clip space, in pixels from the upper left corner.
fn to_pixels(clip: vec4<f32>) -> vec2<f32> {
  return (vec2<f32>(0.5) + vec2<f32>(0.5, -0.5) * clip.xy / clip.w) * outline.size;
}

// A corner of the quad around the line between mesh vertices `a` and `b`. Larger indices give corner 3, because the draw of
// an extraction with triangle lists has six vertices: the strip then ends in triangles without area.
fn line_corner(corner: u32, a: u32, b: u32, color: vec4<f32>) -> OutlinePoint {
  let columns = mat4x4<f32>(outline.columns[0], outline.columns[1], outline.columns[2], outline.columns[3]);
  var from_clip = rimline_clip(columns, vec3<f32>(), outlined_offset(a));
  var to_clip = rimline_clip(columns, vec3<f32>(), outlined_offset(b));
  // Turns: 5.
  for (var plane = 0u; plane < 5u; plane++) {
    let inside = vec2<f32>(clip_distance(plane, from_clip), clip_distance(plane, to_clip));
    // NaN is not inside. A line with one end that is not finite may pass: its pixels have no meaning.
    if (!(inside.x > 0.0 || inside.y > 0.0)) {
      return no_line();
    }
    let cut = mix(from_clip, to_clip, saturate(inside.x / (inside.x - inside.y)));
    if (inside.x < 0.0) {
      from_clip = cut;
    } else if (inside.y < 0.0) {
      to_clip = cut;
    }
  }
  let from_pixel = to_pixels(from_clip);
  let to_pixel = to_pixels(to_clip);
  let span = to_pixel - from_pixel;
  let along = select(vec2<f32>(1.0, 0.0), span / length(span), length(span) > 0.0);
  let across = vec2<f32>(-along.y, along.x);
  let is_end = (min(corner, 3u) & 1u) == 1u;
  // On the right of the line as seen on the screen, because rows of pixels go down.
  let is_right = min(corner, 3u) >= 2u;
  // Coverage fades out over half a pixel. The other half pixel covers rounding.
  let radius = outline.half_width + 1.0;
  let pixel = select(from_pixel - radius * along, to_pixel + radius * along, is_end)
    + select(-radius, radius, is_right) * across;
  let ndc = (2.0 * pixel / outline.size - vec2<f32>(1.0)) * vec2<f32>(1.0, -1.0);
  let depths = vec2<f32>(from_clip.z / from_clip.w, to_clip.z / to_clip.w);
  return OutlinePoint(vec4<f32>(ndc, 0.5, 1.0), vec4<f32>(from_pixel, to_pixel), depths, color);
}

// Whether the class of a silhouette of this kind is drawn: that of silhouettes, or of edges with one face.
fn is_class_drawn(kind: u32) -> bool { return ((outline.classes >> u32(kind == BOUNDARY)) & 1u) != 0u; }

@vertex
fn outline_silhouette(
  @builtin(vertex_index) corner: u32,
  @builtin(instance_index) instance: u32,
) -> OutlinePoint {
  let edge = outlined_silhouette(instance);
  if (!edge.valid || !is_class_drawn(edge.kind)) {
    return no_line();
  }
  return line_corner(corner, edge.a, edge.b, select(outline.silhouette, outline.boundary, edge.kind == BOUNDARY));
}

// The normal of a face. Its length is twice the area.
fn face_normal(face: u32) -> vec3<f32> {
  let first = 3u * (outlined_first_face() + face);
  let a = outlined_position(outline_faces[first]);
  let b = outlined_position(outline_faces[first + 1u]);
  let c = outlined_position(outline_faces[first + 2u]);
  return cross(b - a, c - a);
}

// Whether an edge with two faces is a crease. It is none if a face has no area.
fn is_crease(edge: u32, is_inconsistent: bool) -> bool {
  let faces = outlined_faces(edge);
  // Bit 31 of the first face is set if the edge is inconsistent.
  let normal_0 = face_normal(faces.x & 0x7fffffffu);
  let normal = face_normal(faces.y);
  let normal_1 = select(normal, -normal, is_inconsistent);
  return dot(normal_0, normal_1) < outline.crease_cosine * length(normal_0) * length(normal_1);
}

@vertex
fn outline_feature(@builtin(vertex_index) corner: u32, @builtin(instance_index) slot: u32) -> OutlinePoint {
  let edge = outlined_record(slot);
  // `valid`: the edge is a silhouette for the light, so `outline_silhouette` draws it if its class is drawn.
  if (edge.kind == NO_EDGE || (edge.valid && is_class_drawn(edge.kind))) {
    return no_line();
  }
  if (!edge.valid && (outline.classes & CREASES) != 0u && edge.kind != BOUNDARY && is_crease(edge.edge, edge.kind == 1u)) {
    return line_corner(corner, edge.a, edge.b, outline.crease);
  }
  if ((outline.classes & MARKED) != 0u && outlined_is_marked(edge.edge)) {
    return line_corner(corner, edge.a, edge.b, outline.marked);
  }
  return no_line();
}

// A device depth as one that grows with the distance, for both directions of depth. The next two functions return and take
// such depths, and `is_hidden` takes a device depth.
fn forward_depth(depth: f32) -> f32 { return select(depth, -depth, outline.is_reversed == 1u); }

// The caller's depth at a pixel. Pixels outside the image have that of the border.
fn depth_at_pixel(pixel: vec2<i32>) -> f32 {
  let last = vec2<i32>(outline.size) - vec2<i32>(1);
  let depth = textureLoad(outline_depth, clamp(pixel, vec2<i32>(0), last), 0).x;
  return forward_depth(depth);
}

// The larger of the two steps between the depths of three pixels in a row.
fn largest_step(depth: f32, next: f32, after: f32) -> f32 {
  return max(abs(next - depth), abs(after - next));
}

// Whether the caller's depth hides a point of a line. It does if it is nearer at the point's pixel and at the eight around
// it. The slope of the surface over one pixel each way is allowed for. The slope is that of the flatter side, because the
// surface may end on the other one. Beyond the image's border there is no side.
fn is_hidden(point: vec2<f32>, depth: f32) -> bool {
  let last = vec2<i32>(outline.size) - vec2<i32>(1);
  let pixel = clamp(vec2<i32>(floor(point)), vec2<i32>(0), last);
  let center = depth_at_pixel(pixel);
  var farthest = center;
  var slopes = 0.0;
  // Turns: 2.
  for (var axis = 0; axis < 2; axis++) {
    let step = vec2<i32>(1 - axis, axis);
    let before = depth_at_pixel(pixel - step);
    let after = depth_at_pixel(pixel + step);
    let diagonal = vec2<i32>(1, 1 - 2 * axis);
    let corners = max(depth_at_pixel(pixel - diagonal), depth_at_pixel(pixel + diagonal));
    farthest = max(farthest, max(max(before, after), corners));
    let slope_before = largest_step(center, before, depth_at_pixel(pixel - 2 * step));
    let slope_after = largest_step(center, after, depth_at_pixel(pixel + 2 * step));
    var slope = min(slope_before, slope_after);
    if (pixel[axis] < 2) {
      slope = slope_after;
    } else if (pixel[axis] > last[axis] - 2) {
      slope = slope_before;
    }
    slopes += slope;
  }
  return forward_depth(depth) > farthest + slopes + outline.depth_bias;
}

// Lines share the pixels around their ends with the next line, and ink must not add up there: round ends have the share
// of which two make the coverage.
@fragment
fn outline_ink(in: OutlinePoint) -> @location(0) vec4<f32> {
  let span = in.ends.zw - in.ends.xy;
  let along = dot(in.clip.xy - in.ends.xy, span) / max(dot(span, span), 1e-12);
  let fraction = saturate(along);
  let nearest = in.ends.xy + fraction * span;
  var coverage = saturate(outline.half_width + 0.5 - distance(in.clip.xy, nearest));
  if (coverage <= 0.0 || is_hidden(nearest, mix(in.depths.x, in.depths.y, fraction))) {
    discard;
  }
  coverage = select(1.0 - sqrt(1.0 - coverage), coverage, fraction == along);
  return vec4<f32>(in.color.rgb, in.color.a * coverage);
}
