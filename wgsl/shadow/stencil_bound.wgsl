// Stencil bound: computes for each light an upper bound of this caster's stencil counts, so that a caller learns where
// 8 bits may not suffice. Take a pencil of half planes whose axis goes through the light and misses the caster. A half
// plane begins and ends outside every volume. In between its count changes by the weights of the sides that it crosses,
// so it never exceeds half their sum. The pencil is cut into bins. A workgroup takes one light of the batch.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
// The first light of this batch, and the view.
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: array<SeenLight>;
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> boxes: array<u32>;
@group(0) @binding(5) var<storage, read> positions: array<u32>;
@group(0) @binding(6) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read> sides: array<u32>;
@group(0) @binding(8) var<storage, read_write> shadow_statistics: ShadowStatistics;

const BINS: u32 = 256u;

// The weights that begin in a bin, and those that ended in the bin before.
var<workgroup> begun: array<atomic<u32>, 256>;
var<workgroup> ended: array<atomic<u32>, 257>;

fn unordered(bits: vec3<u32>) -> vec3<f32> {
  return bitcast<vec3<f32>>(select(~bits, bits & vec3<u32>(0x7fffffffu), bits >= vec3<u32>(0x80000000u)));
}

fn box_corner(low: vec3<f32>, high: vec3<f32>, number: u32) -> vec3<f32> {
  return select(low, high, (vec3<u32>(number) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
}

// The pencil, which says in which half plane a position is.
struct Pencil {
  // The direction from the light to the nearest point of the box, and one at right angles to it and to the axis.
  forward: vec3<f32>,
  aside: vec3<f32>,
  // The position of the light, if it is not at infinity.
  place: vec3<f32>,
  is_point: bool,
}

// All values except the light's position are scaled.
fn pencil(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> Pencil {
  let is_point = light.light.w > 0.0;
  var place = vec3<f32>(0.0);
  var forward = -light.light.xyz;
  if (is_point) {
    place = light.light.xyz / light.light.w;
    forward = clamp(place, low, high) - place;
  }
  let size = max(max(abs(forward.x), abs(forward.y)), abs(forward.z));
  // A light at the box has no pencil.
  let slack = 4e-6 * max(max(abs(low), abs(high)), abs(place));
  if (is_point && size <= 4.0 * max(max(slack.x, slack.y), slack.z)) {
    return Pencil(vec3<f32>(0.0), vec3<f32>(0.0), place, is_point);
  }
  forward = forward / size;
  // The axis of the coordinates that is farthest from `forward`.
  let a = abs(forward);
  var aside = vec3<f32>(0.0, forward.z, -forward.y);
  if (a.y <= a.x && a.y <= a.z) {
    aside = vec3<f32>(-forward.z, 0.0, forward.x);
  } else if (a.z <= a.x) {
    aside = vec3<f32>(forward.y, -forward.x, 0.0);
  }
  return Pencil(forward, aside, place, is_point);
}

fn half_plane(by: Pencil, position: vec3<f32>) -> f32 {
  let d = position - by.place;
  return dot_3(by.aside, d) / select(1.0, dot_3(by.forward, d), by.is_point);
}

// The edge of one of the light's sides. Where the lists overflowed, of any edge.
fn count_edge(by: Pencil, edge: u32, weight: u32, first: f32, last: f32) {
  let ends = edge_vertices[edge];
  let a = vertex_position(0u, ends.x);
  let b = vertex_position(0u, ends.y);
  if (!is_finite(a) || !is_finite(b)) {
    return;
  }
  let scale = f32(BINS) / max(last - first, 1e-30);
  let p = (half_plane(by, a) - first) * scale;
  let q = (half_plane(by, b) - first) * scale;
  let most = f32(BINS - 1u);
  atomicAdd(&begun[u32(clamp(min(p, q), 0.0, most))], weight);
  atomicAdd(&ended[u32(clamp(max(p, q), 0.0, most)) + 1u], weight);
}

// It is for a single caster, the first.
@compute @workgroup_size(64)
fn stencil_bound(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
  let bit = group.x;
  let number = draw.first_light + bit;
  let light = chosen_light(0u, seen[draw.view * shape.lights + number].light, number, draw.view);
  let low = unordered(~vec3<u32>(boxes[0], boxes[1], boxes[2]));
  let high = unordered(vec3<u32>(boxes[3], boxes[4], boxes[5]));
  let by = pencil(light, low, high);
  let has_pencil = any(by.forward != vec3<f32>(0.0));
  var first = half_plane(by, low);
  var last = first;
  for (var corner = 1u; corner < 8u; corner++) {
    let at = half_plane(by, box_corner(low, high, corner));
    first = min(first, at);
    last = max(last, at);
  }
  let plain = sides[2u * bit];
  let clipped = sides[2u * bit + 1u];
  // Lists that overflowed do not say which edges have sides, so every edge counts, with the largest weight.
  let overflowed = plain + clipped > shape.side_capacity;
  var items = select(plain + clipped, shape.edges, overflowed);
  if (light.casting == CAST_NOTHING || !has_pencil) {
    items = 0u;
  }
  for (var item = thread; item < items; item += 64u) {
    if (overflowed) {
      count_edge(by, item, select(1u, 2u, light.casting == CAST_EVERY), first, last);
    } else {
      let is_plain = item < plain;
      let entry = sides[side_place(bit, select(CLIPPED, PLAIN, is_plain), select(item - plain, item, is_plain))];
      count_edge(by, entry & ~WINDING, 1u, first, last);
    }
  }
  workgroupBarrier();
  if (thread == 0u && light.casting != CAST_NOTHING) {
    var bound = shape.faces;
    if (has_pencil) {
      var crossed = 0u;
      var most = 0u;
      for (var bin = 0u; bin < BINS; bin++) {
        crossed += atomicLoad(&begun[bin]) - atomicLoad(&ended[bin]);
        most = max(most, crossed);
      }
      bound = min(bound, (most + 1u) / 2u);
    }
    atomicMax(&shadow_statistics.count_bound, bound);
    if (bound > 255u) {
      atomicAdd(&shadow_statistics.may_wrap, 1u);
    }
  }
}
