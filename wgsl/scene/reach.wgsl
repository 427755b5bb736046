// Reach: the first compute stage of a scene's encode, an invocation a caster (a mesh that throws shadows) and batch of up to
// 32 lights. It finds the lights that matter to the caster, `lit`: those that are allowed, whose range and cone have the
// caster's box, if it is rigid or the caller states one, and from which no occluder hides it. Among these it finds the ones
// whose bits are to be computed, `taken`, because caster or light changed since; the others keep their bits. `clusters`,
// `facing` and `exact_facing` read `taken`; `chunks`, `edges`, `bounds` and `choose` read `lit`. It also notes which lists
// must be made anew, in `work`, and updates `kept`, what the masks are computed from. It never leaves out a light that
// matters: where numbers are too large or rounding leaves it open, the light stays. docs/numerics/scene.md, "Occluders",
// "Cones of lights" and "Cached results".

#import common/casters
#import scene/table

@group(0) @binding(3) var<storage, read_write> lit: array<u32>; // For each batch and caster the bits of these lights.
@group(0) @binding(4) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> taken: array<u32>;
@group(0) @binding(6) var<storage, read_write> kept: array<u32>;
@group(0) @binding(7) var<storage, read_write> statistics: SceneStatistics;
const TOO_LARGE: f32 = 0x1p60; // Above this size squares may overflow, and nothing is said.
// 32 units in the last place. Rounding, division and root add fewer to a distance, relative to the largest coordinate.
const SLACK: f32 = 0x1p-18;

// Whether the light may reach the box. It is never false for a light that does. Both are in one space; `scale` is at most
// the smallest factor by which lengths there grow in the world, where `range` is measured.
fn may_reach(light: vec4<f32>, range: f32, low: vec3<f32>, high: vec3<f32>, scale: f32) -> bool {
  if (range == 0.0 || abs(light.w) < 0x1p-30 || low.x > high.x) {
    return true;
  }
  let point = light.xyz / light.w;
  let sizes = max(max(abs(low), abs(high)), abs(point));
  let size = max(max(sizes.x, sizes.y), sizes.z);
  if (!(size < TOO_LARGE)) {
    return true;
  }
  let apart = point - clamp(point, low, high);
  let distance = sqrt(apart.x * apart.x + apart.y * apart.y + apart.z * apart.z);
  return !(scale * (distance - SLACK * size) > range * (1.0 + SLACK));
}

// The box of a caster in world space, and a bound on the terms of its ends.
struct PlacedBox {
  low: vec3<f32>,
  high: vec3<f32>,
  terms: f32,
}

// The box around a box that the caster's matrix moves.
fn placed_box(caster: u32, low: vec3<f32>, high: vec3<f32>) -> PlacedBox {
  var own: PlacedBox;
  for (var axis = 0u; axis < 3u; axis++) {
    let row = bitcast<vec4<f32>>(caster_part(caster, axis));
    let begin = min(row.xyz * low, row.xyz * high);
    let end = max(row.xyz * low, row.xyz * high);
    let sizes = max(abs(begin), abs(end));
    own.low[axis] = begin.x + begin.y + begin.z + row.w;
    own.high[axis] = end.x + end.y + end.z + row.w;
    own.terms = max(own.terms, sizes.x + sizes.y + sizes.z + abs(row.w));
  }
  return own;
}

// The allowed lights whose range and cone may have the caster's box; all, if it has none that is known here.
fn lights_that_matter(caster: u32, batch: u32) -> u32 {
  let lights = caster_lights(caster, batch);
  let low = caster_part(caster, 3u);
  let high = caster_part(caster, 4u);
  if ((high.w & (RIGID | BOUNDED)) == 0u) {
    return lights.allowed;
  }
  let placed = placed_box(caster, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz));
  var matter = 0u;
  var at = lights.first;
  for (var rest = lights.allowed; rest != 0u; rest &= rest - 1u) {
    let light = firstTrailingBit(rest);
    let range = bitcast<f32>(table[group.ranges_at + 8u * batch + light / 4u][light % 4u]);
    let scaled = bitcast<vec4<f32>>(table[at + 1u]);
    if (may_reach(scaled, range, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz), bitcast<f32>(low.w)) &&
      may_be_in_cone(light_cone(batch, light), placed.low, placed.high, placed.terms)) {
      matter |= 1u << light;
    }
    at += 2u;
  }
  return matter;
}

// The state of a caster's positions: computed, not needed by the frame, as `needs` found of a figure (a caster whose
// vertices may be deformed), or never computed, since an encoder that should have deformed the figures was dropped.
const COMPUTED: u32 = 2u;
const UNNEEDED: u32 = 1u;
const NEVER: u32 = 0u;

fn positions_of(caster: u32) -> u32 {
  let figure = caster_part(caster, 7u).w;
  let at = table[group.ranges_at + 16u * group.batches].y;
  let is_rigid = (caster_part(caster, 4u).w & RIGID) != 0u;
  if (is_rigid || figure == 0u || at == 0u) {
    return COMPUTED;
  }
  return atomicLoad(&work[at + figure - 1u]);
}

// The bits of `lights` that did not change since the masks were computed.
fn unchanged(batch: u32, lights: u32) -> u32 {
  var same = 0u;
  for (var rest = lights; rest != 0u; rest &= rest - 1u) {
    let light = firstTrailingBit(rest);
    if (kept[cached_light_offset(batch) + light] == light_version(batch, light)) {
      same |= 1u << light;
    }
  }
  return same;
}

// Finds the lights of a caster in a batch, and writes all that follows from them.
fn take_pair(pair: u32, caster: u32, batch: u32) {
  let state = positions_of(caster);
  let unneeded = state == UNNEEDED;
  // For a figure that was not deformed nothing is computed, and no bits are kept.
  let reaching = select(lights_that_matter(caster, batch), 0u, unneeded);
  let hidden = occluded(caster, batch, reaching);
  let matter = reaching & ~hidden;
  let last = caster_part(caster, 7u);
  let at = cached_pair_offset(pair);
  // Lists of lights are made anew where the caster's bits are, and where it is no longer in them.
  var keeps = 0u;
  var anew = 0xffffffffu;
  if (group.keeps != 0u && kept[0] == group.structure) {
    let before = kept[at + 1u];
    if (kept[at] == last.x && state != NEVER && (caster_part(caster, 4u).w & (CHANGING | GIVEN)) == 0u) {
      keeps = unchanged(batch, matter & before);
    }
    anew = (matter & ~keeps) | (before & ~matter);
  }
  lit[pair] = matter;
  taken[pair] = matter & ~keeps;
  kept[at] = select(last.x, 0u, state == NEVER);
  kept[at + 1u] = matter;
  let words = 4u * (last.y * group.batches + batch);
  atomicOr(&work[words + 2u], anew);
  atomicOr(&work[words + 3u], keeps);
  atomicAdd(&statistics.pairs, countOneBits(matter));
  atomicAdd(&statistics.kept_pairs, countOneBits(keeps));
  atomicAdd(&statistics.unreached_pairs, select(countOneBits(caster_lights(caster, batch).allowed & ~reaching), 0u, unneeded));
  atomicAdd(&statistics.occluded_pairs, countOneBits(hidden));
  if (unneeded && batch == 0u) {
    atomicAdd(&statistics.unneeded, 1u);
  }
}

@compute @workgroup_size(64)
fn reach(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let row = 64u * groups.x;
  // Turns: 1.
  for (var pair = id.y * row + id.x; pair < group.casters * group.batches; pair += groups.y * row) {
    take_pair(pair, pair % group.casters, pair / group.casters);
  }
}

// The most corners of an occluder.
const MOST_CORNERS: u32 = 8u;
// Occluders that are tried.
const MOST_OCCLUDERS: u32 = 128u;
const TOO_LARGE_TO_HIDE: f32 = 0x1p36; // Above this size products may overflow, and nothing is hidden.
const LOST: f32 = 0x1p-100; // The most that is lost where small numbers are flushed.

// A box in world space, whose edges need not be parallel to the axes.
struct TurnedBox {
  middle: vec3<f32>,
  // Half of each of its edges.
  half_x: vec3<f32>,
  half_y: vec3<f32>,
  half_z: vec3<f32>,
  size: f32, // Bounds the sum of the terms of any of its points, also relative to a camera.
  reach: f32, // Bounds |x| + |y| + |z| from the middle to any of its points.
}

fn sum_of(v: vec3<f32>) -> f32 { return abs(v.x) + abs(v.y) + abs(v.z); }

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
    vec3<f32>(dot_3(x.xyz, middle) + x.w, dot_3(y.xyz, middle) + y.w, dot_3(z.xyz, middle) + z.w),
    half_x, half_y, half_z,
    size + 3.0 * origin,
    sum_of(half_x) + sum_of(half_y) + sum_of(half_z),
  );
}

// The least of normal * (p - on) for all p of the box.
fn least(box: TurnedBox, normal: vec3<f32>, on: vec3<f32>) -> f32 {
  return dot_3(normal, box.middle - on) - abs(dot_3(normal, box.half_x)) - abs(dot_3(normal, box.half_y)) - abs(dot_3(normal, box.half_z));
}

fn corner_of(at: u32, number: u32) -> vec3<f32> { return bitcast<vec3<f32>>(table[at + number].xyz); }

// Whether the box lies wholly behind an occluder: behind its plane, and within the planes through the light and its edges.
// `side` is 1 if the light sees the corners counter-clockwise, else -1.
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

// The bits of `lights` from which an occluder hides the caster's box wholly.
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
  // Occluders past the first MOST_OCCLUDERS hide nothing.
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
