// Silhouette edges as lines of even width on the screen: a quad an edge, read from the list by an indirect draw.
// Expects common.wgsl of rimline-picture, frame.wgsl and `gpu::include_wgsl(2)` before it (outline_picture.rs).
//
// Hidden lines: a fragment is drawn if the nearest point of its edge is seen. The survey (model.wgsl) is a texture of the
// faces that are seen, with one or two texels along a pixel's side. The point is hidden if a face seen within `reach()`
// texels covers it and lies strictly in front, or if all of them lie in front and no texel is empty. A face that contains
// the point hides nothing: the edge's own faces do not, nor those that touch the edge there. Most hidden lines and points
// are found by veils (veil.wgsl): depths behind which everything in a square of the survey is hidden.

@group(1) @binding(0) var seen: texture_2d<u32>;
// The buffers that the survey was drawn with. Only fragment shaders may read them.
@group(1) @binding(1) var<storage, read> positions: array<f32>;
@group(1) @binding(2) var<storage, read> faces: array<u32>;
// The veils that `veil.wgsl` makes; each level has squares twice as large.
@group(3) @binding(0) var veils: texture_2d<u32>;

struct Line {
  @builtin(position) clip: vec4<f32>,
  // The ends: in pixels, relative to the eye in world space, and one over their depths along the view (1 if orthographic).
  @location(0) @interpolate(flat) a: vec2<f32>,
  @location(1) @interpolate(flat) b: vec2<f32>,
  @location(2) @interpolate(flat) from_a: vec3<f32>,
  @location(3) @interpolate(flat) from_b: vec3<f32>,
  @location(4) @interpolate(flat) nearness: vec2<f32>,
  // 1: the line has the colour of boundary edges.
  @location(5) @interpolate(flat) boundary: u32,
}

fn nothing() -> Line {
  let zero = vec3<f32>(0.0);
  return Line(vec4<f32>(zero, 1.0), zero.xy, zero.xy, zero, zero, zero.xy, 0u);
}

fn to_pixels(view: vec3<f32>) -> vec2<f32> {
  let ndc = view.xy * vec2<f32>(frame.scale_x, frame.scale_y) / shrinking(view.z);
  return (ndc * vec2<f32>(0.5, -0.5) + 0.5) * frame.size;
}

// The base-2 logarithm of the side of a square of the finest level, in texels: SQUARE in veil.wgsl and outline_picture.rs.
const SQUARE_BITS = 3u;

fn last_texel() -> vec2<i32> {
  return frame.survey_scale * vec2<i32>(frame.size) - 1;
}

// The point at a share of the way from `p` to `q`, which are relative to the eye. It is measured from `q` if `p` is many times
// farther away: the rounding of such a long way would move a point near `q` off the line.
fn between(p: vec3<f32>, q: vec3<f32>, share: f32) -> vec3<f32> {
  if (64.0 * dot(q, q) < dot(p, p)) {
    return q + (1.0 - share) * (p - q);
  }
  return p + share * (q - p);
}

// How far from a point's texel, along x and y, the faces of other texels count for it, in texels.
fn reach() -> i32 {
  return 3 * frame.survey_scale / 2;
}

// Subtracts a bound on rounding errors from the depth `ahead`, which was computed from a vector with these magnitudes.
fn certainly_ahead(ahead: f32, size: vec3<f32>) -> f32 {
  return ahead - 1e-5 * (size.x + size.y + size.z);
}

// Whether certainly all texels from `low` to `high`, and those within `reach()` of them, show faces in front of the depth
// `ahead`. All points there are then hidden from this depth on.
fn is_veiled(low: vec2<i32>, high: vec2<i32>, ahead: f32) -> bool {
  let from_texel = max(low - reach(), vec2<i32>(0));
  let to_texel = min(high + reach(), last_texel());
  let span = max(to_texel.x - from_texel.x, to_texel.y - from_texel.y);
  var level = 0u;
  // Turns: 16.
  while (level < 16u && (span >> (SQUARE_BITS + level)) > 3) {
    level++;
  }
  let shift = vec2<u32>(SQUARE_BITS + level);
  let last = to_texel >> shift;
  // Turns: 5.
  for (var y = from_texel.y >> shift.y; y <= last.y; y++) {
    // Turns: 5.
    for (var x = from_texel.x >> shift.x; x <= last.x; x++) {
      if (!(ahead > bitcast<f32>(textureLoad(veils, vec2<i32>(x, y), i32(level)).r))) {
        return false;
      }
    }
  }
  return true;
}

// The texel of the survey at a position in pixels, or the nearest one in the picture.
fn texel_at(at: vec2<f32>) -> vec2<i32> {
  return vec2<i32>(clamp(floor(f32(frame.survey_scale) * at), vec2<f32>(0.0), vec2<f32>(last_texel())));
}

@vertex fn lines_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Line {
  let edge = rimline_silhouette(0u, instance);
  var p = rimline_position(edge.a);
  var q = rimline_position(edge.b);
  if (!edge.valid || !is_finite(p) || !is_finite(q)) {
    return nothing();
  }
  var a = to_view(p);
  var b = to_view(q);
  p -= frame.eye;
  q -= frame.eye;
  // Clip at the near plane.
  if (a.z < frame.near && b.z < frame.near) {
    return nothing();
  }
  if (a.z < frame.near) {
    let t = (frame.near - a.z) / (b.z - a.z);
    p = between(p, q, t);
    a = between(a, b, t);
    a.z = frame.near;
  } else if (b.z < frame.near) {
    let t = (frame.near - b.z) / (a.z - b.z);
    q = between(q, p, t);
    b = between(b, a, t);
    b.z = frame.near;
  }
  let start = to_pixels(a);
  let stop = to_pixels(b);
  // A texel more, for rounding.
  let low = texel_at(min(start, stop)) - 1;
  let high = texel_at(max(start, stop)) + 1;
  if (is_veiled(low, high, certainly_ahead(min(a.z, b.z), abs(p) + abs(q)))) {
    return nothing();
  }
  let span = stop - start;
  let along = select(vec2<f32>(1.0, 0.0), normalize(span), dot(span, span) > 1e-12);
  // A pixel of room for the soft edge.
  let radius = frame.half_line + 1.0;
  let end = select(-1.0, 1.0, (vertex & 1u) == 1u);
  let side = select(-1.0, 1.0, (vertex & 2u) == 2u);
  let corner = select(start, stop, end > 0.0) + radius * (end * along + side * vec2<f32>(-along.y, along.x));
  let ndc = corner / frame.size * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
  return Line(vec4<f32>(ndc, 0.5, 1.0), start, stop, p, q, 1.0 / vec2<f32>(shrinking(a.z), shrinking(b.z)), u32(edge.kind == 2u) & frame.show_boundary);
}

fn position(face: u32, corner: u32) -> vec3<f32> {
  let first = 3u * faces[3u * face + corner];
  return vec3<f32>(positions[first], positions[first + 1u], positions[first + 2u]);
}

// A bound on the rounding error of a product of lengths, as a share of it. In units of 2^-23 a position relative to the eye is
// off by 2, the point by 5 (its length is at most the square root of 3), a normal by 6 of the product of its sides, the last
// product by 3. A point amid an edge that is many times longer is off by more, but so long are the sides of the edge's faces,
// too.
const ERROR = 12.0 / 8388608.0;

// Whether the ray to `p` certainly passes an edge on its inner side. It does not for faces seen edge-on, as many are at a
// contour: they look thinner than the rounding error.
fn is_within(corner: vec3<f32>, along: vec3<f32>, p: vec3<f32>, turn: f32) -> bool {
  let towards = ray(corner);
  let wall = cross(towards, along);
  let r = p - corner;
  let error = ERROR * (length(wall) * (1.0 + length(corner)) + length(towards) * length(along) * length(r));
  return turn * dot(wall, r) > error;
}

// Verdicts. The face is not certainly in front of the point.
const BEYOND = 0u;
// It is in front, but does not cover the point.
const BESIDE = 1u;
// It is in front and covers the point.
const HIDES = 2u;

// The verdict for a face and a point, which is relative to the eye.
fn verdict_of(face: u32, point: vec3<f32>) -> u32 {
  // Units in which the point is about 1 away.
  let per_unit = 1.0 / max(max(abs(point.x), abs(point.y)), max(abs(point.z), 1e-37));
  let p = point * per_unit;
  let world = array<vec3<f32>, 3>(position(face, 0u), position(face, 1u), position(face, 2u));
  let a = (world[0] - frame.eye) * per_unit;
  let b = (world[1] - frame.eye) * per_unit;
  let c = (world[2] - frame.eye) * per_unit;
  let ab = (world[1] - world[0]) * per_unit;
  let ac = (world[2] - world[0]) * per_unit;
  let bc = (world[2] - world[1]) * per_unit;
  let normal = cross(ab, ac);
  let r = p - a;
  let turn = sign(dot(normal, ray(a)));
  let error = ERROR * (length(normal) * (1.0 + length(a)) + length(ab) * length(ac) * length(r));
  // False where the point lies on the face's plane, or on the eye's side of it.
  let is_behind = turn * dot(normal, r) > error;
  if (is_behind && is_within(a, ab, p, turn) && is_within(b, bc, p, turn) && is_within(c, -ac, p, turn)) {
    return HIDES;
  }
  // If the plane is nearly edge-on, the test above fails. The face then counts as in front if all of it is far in front.
  let farthest = max(max(dot(a, frame.forward), dot(b, frame.forward)), dot(c, frame.forward));
  let gap = dot(p, frame.forward) - farthest;
  let is_far_behind = gap > 2.0 * max(length(ab), max(length(ac), length(bc)));
  return select(BEYOND, BESIDE, is_behind || is_far_behind);
}

// The most faces that are gathered before their verdicts are computed.
const GATHERED = 8u;

// The index of the face that is seen in a texel, plus 1; 0 if none is.
fn face_at(texel: vec2<i32>) -> u32 {
  let halves = textureLoad(seen, texel, 0).rg;
  return halves.x | (halves.y << 16u);
}

// A point is hidden if one face seen around it hides it, or if all texels there show faces in front of it. The second is for
// faces smaller than pixels, and for faces whose common edge covers the point within the rounding error.
fn is_hidden(point: vec3<f32>, at: vec2<f32>) -> bool {
  let middle = texel_at(at);
  if (is_veiled(middle, middle, certainly_ahead(dot(point, frame.forward), abs(point)))) {
    return true;
  }
  // The face seen at the point decides most cases. The result does not depend on the order of the faces.
  let face_here = face_at(middle);
  var is_open = face_here == 0u;
  if (!is_open) {
    let verdict = verdict_of(face_here - 1u, point);
    if (verdict == HIDES) {
      return true;
    }
    is_open = verdict == BEYOND;
  }
  let first = max(middle - reach(), vec2<i32>(0));
  let last = min(middle + reach(), last_texel());
  // Faces are gathered first, so that invocations of neighbouring points compute verdicts at the same time.
  var last_faces = vec4<u32>(face_here, 0u, 0u, 0u);
  var texel = first;
  // Each turn but the last reads at least GATHERED of the 49 texels.
  // Turns: 7.
  while (texel.y <= last.y) {
    var gathered: array<u32, GATHERED>;
    var count = 0u;
    // Turns: 49.
    while (texel.y <= last.y && count < GATHERED) {
      let face = face_at(texel);
      let is_end = texel.x == last.x;
      texel = vec2<i32>(select(texel.x + 1, first.x, is_end), texel.y + i32(is_end));
      is_open = is_open || face == 0u;
      if (face != 0u && !any(last_faces == vec4<u32>(face))) {
        last_faces = vec4<u32>(face, last_faces.xyz);
        gathered[count] = face;
        count++;
      }
    }
    // Turns: GATHERED.
    for (var index = 0u; index < count; index++) {
      let verdict = verdict_of(gathered[index] - 1u, point);
      if (verdict == HIDES) {
        return true;
      }
      is_open = is_open || verdict == BEYOND;
    }
  }
  return !is_open;
}

@fragment fn lines_fragment(in: Line) -> @location(0) vec4<f32> {
  let span = in.b - in.a;
  let t = saturate(dot(in.clip.xy - in.a, span) / max(dot(span, span), 1e-12));
  let nearest = in.a + t * span;
  let coverage = saturate(frame.half_line + 0.5 - distance(in.clip.xy, nearest));
  // The tested point keeps away from the ends. Else the end of a hidden edge, where it is seen, would be drawn as a dot.
  let inset = min(0.5, frame.half_line / max(length(span), 1e-6));
  let seen_at = clamp(t, inset, 1.0 - inset);
  // One over the depth is linear on the screen.
  let along = seen_at * in.nearness.y / mix(in.nearness.x, in.nearness.y, seen_at);
  var is_drawn = coverage > 0.0;
  // A branch skips the costly test, because the invocation may go on after `discard`.
  if (is_drawn) {
    is_drawn = !is_hidden(between(in.from_a, in.from_b, along), in.a + seen_at * span);
  }
  if (!is_drawn) {
    discard;
  }
  let ink = select(vec3<f32>(0.014, 0.011, 0.016), vec3<f32>(0.80, 0.12, 0.01), in.boundary == 1u);
  return vec4<f32>(ink, coverage);
}
