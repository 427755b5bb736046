// Occluded: finds the lights for which a caster's box lies wholly behind an occluder: behind its plane, and within the planes
// through the light and its edges. NUMERICS.md, "Occluded casters".

// The most corners of an occluder.
const MOST_CORNERS: u32 = 8u;
// Occluders that are tried.
const MOST_OCCLUDERS: u32 = 128u;
// Above this size products may overflow, and nothing is said.
const TOO_LARGE_TO_HIDE: f32 = 0x1p36;
// What is lost where small numbers are flushed.
const LOST: f32 = 0x1p-100;

// A box in world space: its middle, half of each of its edges, and sizes as sums of absolute values: of places, and of the
// distance from the middle to a corner.
struct TurnedBox {
  middle: vec3<f32>,
  half_x: vec3<f32>,
  half_y: vec3<f32>,
  half_z: vec3<f32>,
  size: f32,
  reach: f32,
}

fn sum_of(v: vec3<f32>) -> f32 {
  return abs(v.x) + abs(v.y) + abs(v.z);
}

fn dot_of(a: vec3<f32>, b: vec3<f32>) -> f32 {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn turned_box(caster: u32) -> TurnedBox {
  let low = bitcast<vec3<f32>>(caster_part(caster, 3u).xyz);
  let high = bitcast<vec3<f32>>(caster_part(caster, 4u).xyz);
  let x = bitcast<vec4<f32>>(caster_part(caster, 0u));
  let y = bitcast<vec4<f32>>(caster_part(caster, 1u));
  let z = bitcast<vec4<f32>>(caster_part(caster, 2u));
  let middle = 0.5 * low + 0.5 * high;
  let half = 0.5 * high - 0.5 * low;
  // The largest |origin| of a camera: positions are drawn relative to it.
  let origin = bitcast<f32>(table[group.ranges_at + 16u * group.batches].z);
  let sizes = max(abs(low), abs(high));
  let size = sum_of(x.xyz * sizes) + sum_of(y.xyz * sizes) + sum_of(z.xyz * sizes) + abs(x.w) + abs(y.w) + abs(z.w);
  let half_x = half.x * vec3<f32>(x.x, y.x, z.x);
  let half_y = half.y * vec3<f32>(x.y, y.y, z.y);
  let half_z = half.z * vec3<f32>(x.z, y.z, z.z);
  return TurnedBox(
    vec3<f32>(dot_of(x.xyz, middle) + x.w, dot_of(y.xyz, middle) + y.w, dot_of(z.xyz, middle) + z.w),
    half_x, half_y, half_z,
    size + 3.0 * origin,
    sum_of(half_x) + sum_of(half_y) + sum_of(half_z),
  );
}

// The least of normal * (p - on) for all p of the box.
fn least(box: TurnedBox, normal: vec3<f32>, on: vec3<f32>) -> f32 {
  return dot_of(normal, box.middle - on) - abs(dot_of(normal, box.half_x)) - abs(dot_of(normal, box.half_y)) - abs(dot_of(normal, box.half_z));
}

fn corner_of(at: u32, number: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(table[at + number].xyz);
}

// Whether the box is hidden. `side` is 1 if the light sees the corners counter-clockwise, else -1.
fn is_behind(box: TurnedBox, at: u32, light: vec4<f32>, side: f32) -> bool {
  let count = min(table[at].w, MOST_CORNERS);
  let first = corner_of(at, 0u);
  // Turns: MOST_CORNERS.
  for (var number = 0u; number < count; number++) {
    let a = corner_of(at, number);
    let b = corner_of(at, select(number + 1u, 0u, number + 1u == count));
    let apart = sum_of(box.middle - a) + box.reach;
    let size = box.size + sum_of(a) + sum_of(b);
    let e = b - a;
    // Within the plane through the light and the edge.
    let t = light.xyz - light.w * a;
    let toward = sum_of(light.xyz) + light.w * size;
    let within = least(box, side * cross(t, e), a);
    let error = SLACK * toward * (size * (sum_of(e) + apart) + 2.0 * sum_of(e) * apart) + LOST;
    if (!(within > error) || !(size < TOO_LARGE_TO_HIDE)) {
      return false;
    }
    // Behind the plane of the corner, the next one and the first.
    if (number > 0u && number + 1u < count) {
      let v = b - first;
      let u = a - first;
      let behind = least(box, -side * cross(u, v), first);
      let apart = sum_of(box.middle - first) + box.reach;
      let size = size + sum_of(first);
      let spread = sum_of(u) * sum_of(v);
      let error = SLACK * (size * (spread + (sum_of(u) + sum_of(v)) * apart) + 2.0 * spread * apart) + LOST;
      if (!(behind > error)) {
        return false;
      }
    }
  }
  return true;
}

// Those of some lights for which the caster is hidden.
fn occluded(caster: u32, batch: u32, lights: u32) -> u32 {
  if (group.occluders == 0u || lights == 0u) {
    return 0u;
  }
  let low = caster_part(caster, 3u);
  let high = caster_part(caster, 4u);
  let is_boxed = (high.w & (RIGID | BOUNDED)) != 0u && bitcast<f32>(low.x) <= bitcast<f32>(high.x);
  if (!is_boxed) {
    return 0u;
  }
  let box = turned_box(caster);
  var hidden = 0u;
  // Others hide nothing: what is said to be hidden is never more than what is.
  // Turns: MOST_OCCLUDERS.
  for (var number = 0u; number < min(group.occluders, MOST_OCCLUDERS); number++) {
    let occluder = table[group.occluders_at + batch * group.occluders + number];
    if (occluder.z == caster) {
      continue;
    }
    // Turns: 32.
    for (var rest = occluder.x & lights & ~hidden; rest != 0u; rest &= rest - 1u) {
      let light = firstTrailingBit(rest);
      let scaled = bitcast<vec4<f32>>(table[group.world_lights_at + 32u * batch + light]);
      let side = select(-1.0, 1.0, ((occluder.y >> light) & 1u) != 0u);
      if (is_behind(box, occluder.w, scaled, side)) {
        hidden |= 1u << light;
      }
    }
  }
  return hidden;
}
