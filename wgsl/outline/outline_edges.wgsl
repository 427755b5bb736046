// Stage `outline_edges`: vertex shaders that draw edges of an extraction as lines of a width in pixels, or in the variant SCENE
// those of a group of a scene's casters. Each line is a quad that the fragment shader trims to a line with round ends.
// `outline_silhouette`: an instance for each entry of the light's list, by the indirect draw of that list. `outline_feature`: an
// instance for each edge; it leaves out what the other one draws. Four vertices an instance, as a strip. Group 0 has the edges
// (interface/outlined.wgsl); group 1 is here.
// Reads: silhouettes, facing masks, positions, faces, marks, and the depth of what may hide lines.
// A line is hidden where the depth at its own place says so, not at the place of the pixel: half of an outline lies before what
// is behind the surface, and the other half on it.
#import extract/results
#import interface/outlined

struct OutlineView {
  // The camera's matrix, by columns, and the point that positions are relative to.
  columns: array<vec4<f32>, 4>,
  origin: vec3<f32>,
  // Half the width of a line, in pixels.
  half_width: f32,
  // Colours, not premultiplied.
  silhouette: vec4<f32>,
  boundary: vec4<f32>,
  crease: vec4<f32>,
  marked: vec4<f32>,
  // Pixels of the picture, each way.
  size: vec2<f32>,
  // How far behind what is seen a line may lie, as depth.
  depth_bias: f32,
  // Faces whose normals have a smaller cosine meet at a crease.
  crease_cosine: f32,
  // The light's number.
  light: u32,
  // The classes that are drawn: bits 0 silhouettes, 1 boundaries, 2 creases, 3 marked edges.
  classes: u32,
  // 1 if the larger depth is nearer.
  is_reversed: u32,
  reserved: u32,
}

@group(1) @binding(0) var<uniform> outline: OutlineView;
// Depth, as floats: OpenGL loads no texels of depth textures.
#if SAMPLES
@group(1) @binding(1) var outline_depth: texture_multisampled_2d<f32>;
#else
@group(1) @binding(1) var outline_depth: texture_2d<f32>;
#endif
// Three vertices a face. Only `outline_feature` reads them.
@group(1) @binding(2) var<storage, read> outline_faces: array<u32>;
const NO_EDGE: u32 = 3u; // The kind of an edge that is not there.

struct OutlinePoint {
  @builtin(position) clip: vec4<f32>,
  // The ends of the line, in pixels.
  @location(0) @interpolate(flat) ends: vec4<f32>,
  // Their depths, which are linear between them on the screen.
  @location(1) @interpolate(flat) depths: vec2<f32>,
  @location(2) @interpolate(flat) color: vec4<f32>,
}

// A vertex of a line that is not drawn.
fn outline_nothing() -> OutlinePoint {
  return OutlinePoint(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec4<f32>(), vec2<f32>(), vec4<f32>());
}

// How far a point is on the inner side of a plane that bounds lines: near, left, right, bottom, top. Beyond the sides there is
// room for the width.
fn outline_inside(plane: u32, clip: vec4<f32>) -> f32 {
  if (plane == 0u) {
    return select(clip.z, clip.w - clip.z, outline.is_reversed == 1u);
  }
  let axis = (plane - 1u) >> 1u;
  let room = 1.0 + 2.0 * (outline.half_width + 2.0) / outline.size[axis];
  return clip.w * room + select(clip[axis], -clip[axis], (plane & 1u) == 0u);
}

fn outline_pixel(clip: vec4<f32>) -> vec2<f32> {
  return (vec2<f32>(0.5) + vec2<f32>(0.5, -0.5) * clip.xy / clip.w) * outline.size;
}

// A vertex of the quad around the line between two mesh vertices.
fn outline_point(corner: u32, a: u32, b: u32, color: vec4<f32>) -> OutlinePoint {
  let columns = mat4x4<f32>(outline.columns[0], outline.columns[1], outline.columns[2], outline.columns[3]);
  var from_clip = rimline_clip(columns, vec3<f32>(), outlined_offset(a));
  var to_clip = rimline_clip(columns, vec3<f32>(), outlined_offset(b));
  // Turns: 5.
  for (var plane = 0u; plane < 5u; plane++) {
    let inside = vec2<f32>(outline_inside(plane, from_clip), outline_inside(plane, to_clip));
    // Also where a position is not finite.
    if (!(inside.x > 0.0 || inside.y > 0.0)) {
      return outline_nothing();
    }
    let cut = mix(from_clip, to_clip, saturate(inside.x / (inside.x - inside.y)));
    if (inside.x < 0.0) {
      from_clip = cut;
    } else if (inside.y < 0.0) {
      to_clip = cut;
    }
  }
  let from_pixel = outline_pixel(from_clip);
  let to_pixel = outline_pixel(to_clip);
  let span = to_pixel - from_pixel;
  let along = select(vec2<f32>(1.0, 0.0), span / length(span), length(span) > 0.0);
  let across = vec2<f32>(-along.y, along.x);
  let is_end = (min(corner, 3u) & 1u) == 1u;
  let is_left = min(corner, 3u) >= 2u;
  // Half a pixel fades out, and half a pixel is room for rounding.
  let reach = outline.half_width + 1.0;
  let place = select(from_pixel - reach * along, to_pixel + reach * along, is_end) + select(-reach, reach, is_left) * across;
  let ndc = (2.0 * place / outline.size - vec2<f32>(1.0)) * vec2<f32>(1.0, -1.0);
  let depths = vec2<f32>(from_clip.z / from_clip.w, to_clip.z / to_clip.w);
  return OutlinePoint(vec4<f32>(ndc, 0.5, 1.0), vec4<f32>(from_pixel, to_pixel), depths, color);
}

@vertex
fn outline_silhouette(
  @builtin(vertex_index) corner: u32,
  @builtin(instance_index) instance: u32,
) -> OutlinePoint {
  let edge = outlined_silhouette(instance);
  let is_boundary = edge.kind == 2u;
  if (!edge.valid || ((outline.classes >> u32(is_boundary)) & 1u) == 0u) {
    return outline_nothing();
  }
  return outline_point(corner, edge.a, edge.b, select(outline.silhouette, outline.boundary, is_boundary));
}

// The normal of a face, as long as twice its area.
fn outline_normal(face: u32) -> vec3<f32> {
  let at = 3u * (outlined_first_face() + face);
  let a = outlined_position(outline_faces[at]);
  let b = outlined_position(outline_faces[at + 1u]);
  let c = outlined_position(outline_faces[at + 2u]);
  return cross(b - a, c - a);
}

// Whether the two faces of an edge meet at a crease. A face without area makes none.
fn outline_is_crease(edge: u32, is_inconsistent: bool) -> bool {
  let faces = outlined_faces(edge);
  let one = outline_normal(faces.x & 0x7fffffffu);
  let given = outline_normal(faces.y);
  let other = select(given, -given, is_inconsistent);
  return dot(one, other) < outline.crease_cosine * length(one) * length(other);
}

@vertex
fn outline_feature(@builtin(vertex_index) corner: u32, @builtin(instance_index) slot: u32) -> OutlinePoint {
  let found = outlined_record(slot);
  if (found.valid || found.kind == NO_EDGE) {
    return outline_nothing();
  }
  if ((outline.classes & 4u) != 0u && found.kind != 2u && outline_is_crease(found.edge, found.kind == 1u)) {
    return outline_point(corner, found.a, found.b, outline.crease);
  }
  if ((outline.classes & 8u) != 0u && outlined_is_marked(found.edge)) {
    return outline_point(corner, found.a, found.b, outline.marked);
  }
  return outline_nothing();
}

// The depth of what is seen at a pixel, turned so that the larger one is farther.
fn outline_seen(pixel: vec2<i32>) -> f32 {
  let last = vec2<i32>(outline.size) - vec2<i32>(1);
  let depth = textureLoad(outline_depth, clamp(pixel, vec2<i32>(0), last), 0).x;
  return select(depth, -depth, outline.is_reversed == 1u);
}

// The steepest of two steps from a pixel towards one side.
fn outline_steepest(here: f32, next: f32, after: f32) -> f32 {
  return max(abs(next - here), abs(after - next));
}

// Whether something hides a point of a line. It does if it is nearer at the point's pixel and at the eight around it, by more than
// the surface there slopes over a pixel each way: towards the side where it slopes less, for on the other one it may end. Beyond the
// picture's border there is no side.
fn outline_is_hidden(place: vec2<f32>, depth: f32) -> bool {
  let last = vec2<i32>(outline.size) - vec2<i32>(1);
  let pixel = clamp(vec2<i32>(floor(place)), vec2<i32>(0), last);
  let here = outline_seen(pixel);
  var farthest = here;
  var slopes = 0.0;
  // Turns: 2.
  for (var axis = 0; axis < 2; axis++) {
    let step = vec2<i32>(1 - axis, axis);
    let before = outline_seen(pixel - step);
    let after = outline_seen(pixel + step);
    let diagonal = vec2<i32>(1, 1 - 2 * axis);
    let corners = max(outline_seen(pixel - diagonal), outline_seen(pixel + diagonal));
    farthest = max(farthest, max(max(before, after), corners));
    let slope_before = outline_steepest(here, before, outline_seen(pixel - 2 * step));
    let slope_after = outline_steepest(here, after, outline_seen(pixel + 2 * step));
    var slope = min(slope_before, slope_after);
    if (pixel[axis] < 2) {
      slope = slope_after;
    } else if (pixel[axis] > last[axis] - 2) {
      slope = slope_before;
    }
    slopes += slope;
  }
  let own = select(depth, -depth, outline.is_reversed == 1u);
  return own > farthest + slopes + outline.depth_bias;
}

@fragment
fn outline_ink(in: OutlinePoint) -> @location(0) vec4<f32> {
  let span = in.ends.zw - in.ends.xy;
  let part = saturate(dot(in.clip.xy - in.ends.xy, span) / max(dot(span, span), 1e-12));
  let nearest = in.ends.xy + part * span;
  let coverage = saturate(outline.half_width + 0.5 - distance(in.clip.xy, nearest));
  if (coverage <= 0.0 || outline_is_hidden(nearest, mix(in.depths.x, in.depths.y, part))) {
    discard;
  }
  return vec4<f32>(in.color.rgb, in.color.a * coverage);
}
