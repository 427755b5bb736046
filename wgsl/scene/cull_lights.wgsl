// Stage `cull_lights`, the first of a scene's encode: an invocation a caster (a mesh that throws shadows) and batch of up to
// 32 lights. It finds the relevant lights of the caster: allowed lights that are culled neither by range or cone nor by an
// occluder. Both need a known box (rigid, or stated by the caller). Casters that `needs` culled have no relevant light.
// Among the relevant lights it finds the active ones: caster or light changed since their bits were computed, or their bits
// are never cached. Other bits are cached.
// Read by: `clusters`, `facing` and `exact_facing` (active lights); `chunks`, `edges`, `bounds`, `counting_methods` and
// `outline_edges` (relevant ones). It also notes in `work`, in words that are 0 before, which lists are dirty. It updates the
// versions of casters in `cache`; `chunks` updates those of lights.
// These tests cull no light that affects the caster. If numbers are too large or rounding leaves one open, the light stays.
// Claims: docs/numerics/scene.md, "Occluders", "Cones of lights" and "Cached results".

#import common/casters
#import scene/table

@group(0) @binding(3) var<storage, read_write> relevant_lights: array<u32>; // The relevant lights of each batch and caster.
@group(0) @binding(4) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> active_lights: array<u32>; // The active lights, likewise.
@group(0) @binding(6) var<storage, read_write> cache: array<u32>;
@group(0) @binding(7) var<storage, read_write> statistics: SceneStatistics;
const TOO_LARGE: f32 = 0x1p60; // Above this size squares may overflow. The light then stays.
// 32 units in the last place. Rounding, division and root add less to a distance, relative to the largest coordinate.
const SLACK: f32 = 0x1p-18;

// Whether the box may be within the light's range; false only if it is not. Both are in one space. `scale` is at most the
// smallest factor from lengths in this space to lengths in the world, where `range` is measured.
fn may_be_in_range(light: vec4<f32>, range: f32, low: vec3<f32>, high: vec3<f32>, scale: f32) -> bool {
  if (range == 0.0 || abs(light.w) < 0x1p-30 || low.x > high.x) {
    return true;
  }
  let point = light.xyz / light.w;
  let sizes = max(max(abs(low), abs(high)), abs(point));
  let size = max(max(sizes.x, sizes.y), sizes.z);
  if (!(size < TOO_LARGE)) {
    return true;
  }
  let separation = point - clamp(point, low, high);
  let distance = sqrt(separation.x * separation.x + separation.y * separation.y + separation.z * separation.z);
  return !(scale * (distance - SLACK * size) > range * (1.0 + SLACK));
}

// The box of a caster in world space. `term_bound` bounds the terms of the sums that its corners are.
struct WorldBox {
  low: vec3<f32>,
  high: vec3<f32>,
  term_bound: f32,
}

// The axis-aligned box around a box that the caster's matrix transforms.
fn world_box(caster: u32, low: vec3<f32>, high: vec3<f32>) -> WorldBox {
  var box: WorldBox;
  for (var axis = 0u; axis < 3u; axis++) {
    let row = bitcast<vec4<f32>>(caster_part(caster, axis));
    let low_terms = min(row.xyz * low, row.xyz * high);
    let high_terms = max(row.xyz * low, row.xyz * high);
    let sizes = max(abs(low_terms), abs(high_terms));
    box.low[axis] = low_terms.x + low_terms.y + low_terms.z + row.w;
    box.high[axis] = high_terms.x + high_terms.y + high_terms.z + row.w;
    box.term_bound = max(box.term_bound, sizes.x + sizes.y + sizes.z + abs(row.w));
  }
  return box;
}

// The allowed lights that are not culled by range or cone: all, if the caster has no known box.
fn lights_in_range(caster: u32, batch: u32) -> u32 {
  let lights = caster_lights(caster, batch);
  let low = caster_part(caster, 3u);
  let high = caster_part(caster, 4u);
  if ((high.w & (RIGID | BOUNDED)) == 0u) {
    return lights.allowed;
  }
  let box = world_box(caster, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz));
  var in_range = 0u;
  var offset = lights.first;
  for (var remaining = lights.allowed; remaining != 0u; remaining &= remaining - 1u) {
    let light = firstTrailingBit(remaining);
    let range = bitcast<f32>(table[group.ranges_offset + 8u * batch + light / 4u][light % 4u]);
    let scaled = bitcast<vec4<f32>>(table[offset + 1u]);
    if (may_be_in_range(scaled, range, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz), bitcast<f32>(low.w)) &&
      may_be_in_cone(light_cone(batch, light), box.low, box.high, box.term_bound)) {
      in_range |= 1u << light;
    }
    offset += 2u;
  }
  return in_range;
}

// The state of a caster's positions: computed; culled, because `needs` found that the frame does not need the deforming
// caster; or missing, because an encoder that should have deformed it was dropped.
const POSITIONS_COMPUTED: u32 = 2u;
const POSITIONS_CULLED: u32 = 1u;
const POSITIONS_MISSING: u32 = 0u;

fn position_state(caster: u32) -> u32 {
  let deforming_index = caster_part(caster, 7u).w;
  let first_word = table[group.ranges_offset + 16u * group.batches].y;
  let is_rigid = (caster_part(caster, 4u).w & RIGID) != 0u;
  if (is_rigid || deforming_index == 0u || first_word == 0u) {
    return POSITIONS_COMPUTED;
  }
  return atomicLoad(&work[first_word + deforming_index - 1u]);
}

// The lights that did not change since their bits were computed.
fn unchanged_lights(batch: u32, lights: u32) -> u32 {
  var result = 0u;
  for (var remaining = lights; remaining != 0u; remaining &= remaining - 1u) {
    let light = firstTrailingBit(remaining);
    if (cache[cached_light_offset(batch) + light] == light_version(batch, light)) {
      result |= 1u << light;
    }
  }
  return result;
}

// Finds the relevant and active lights of a caster in a batch, and which lists are dirty.
fn process_pair(pair: u32, caster: u32, batch: u32) {
  let state = position_state(caster);
  let is_culled = state == POSITIONS_CULLED;
  // A caster that `needs` culled has no relevant light, so no bit of it is cached.
  let in_range = select(lights_in_range(caster, batch), 0u, is_culled);
  let occluded = occluded_lights(caster, batch, in_range);
  let relevant = in_range & ~occluded;
  // x: the caster's version; y: its group.
  let version_and_group = caster_part(caster, 7u);
  let pair_offset = cached_pair_offset(pair);
  // A list is dirty if bits of a caster in it are computed again, or if a caster leaves it.
  var cached = 0u;
  var dirty = 0xffffffffu;
  if (group.uses_cache != 0u && cache[0] == group.structure) {
    let cached_before = cache[pair_offset + 1u];
    let has_valid_positions = cache[pair_offset] == version_and_group.x && state != POSITIONS_MISSING;
    if (has_valid_positions && (caster_part(caster, 4u).w & (UNCACHED | GROUP_EXCLUDES)) == 0u) {
      cached = unchanged_lights(batch, relevant & cached_before);
    }
    dirty = (relevant & ~cached) | (cached_before & ~relevant);
  }
  relevant_lights[pair] = relevant;
  active_lights[pair] = relevant & ~cached;
  cache[pair_offset] = select(version_and_group.x, 0u, state == POSITIONS_MISSING);
  cache[pair_offset + 1u] = relevant;
  let words = 4u * (version_and_group.y * group.batches + batch);
  atomicOr(&work[words + 2u], dirty);
  atomicOr(&work[words + 3u], cached);
  atomicAdd(&statistics.pairs, countOneBits(relevant));
  atomicAdd(&statistics.cached_pairs, countOneBits(cached));
  let out_of_range = caster_lights(caster, batch).allowed & ~in_range;
  atomicAdd(&statistics.pairs_culled_by_range, select(countOneBits(out_of_range), 0u, is_culled));
  atomicAdd(&statistics.pairs_culled_by_occluders, countOneBits(occluded));
  if (is_culled && batch == 0u) {
    atomicAdd(&statistics.culled_casters, 1u);
  }
}

@compute @workgroup_size(64)
fn cull_lights(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let row = 64u * groups.x;
  // Turns: 1.
  for (var pair = id.y * row + id.x; pair < group.casters * group.batches; pair += groups.y * row) {
    process_pair(pair, pair % group.casters, pair / group.casters);
  }
}

// The most corners of an occluder.
const MOST_CORNERS: u32 = 8u;
// The most occluders that are tested. Later ones cull nothing. If there are more, the largest come first.
const MOST_OCCLUDERS: u32 = 128u;
const TOO_LARGE_TO_OCCLUDE: f32 = 0x1p36; // Above this size products may overflow. Nothing is then culled.
const MOST_FLUSHED: f32 = 0x1p-100; // The most that flushing of small numbers loses.

// A box in world space with any orientation.
struct OrientedBox {
  middle: vec3<f32>,
  // Half of each edge.
  half_x: vec3<f32>,
  half_y: vec3<f32>,
  half_z: vec3<f32>,
  term_bound: f32, // The largest sum of terms of any of its points, also relative to a camera.
  extent: f32, // The largest |x| + |y| + |z| from the middle to any of its points.
}

fn l1_norm(v: vec3<f32>) -> f32 { return abs(v.x) + abs(v.y) + abs(v.z); }

fn oriented_box(caster: u32) -> OrientedBox {
  let low = bitcast<vec3<f32>>(caster_part(caster, 3u).xyz);
  let high = bitcast<vec3<f32>>(caster_part(caster, 4u).xyz);
  let x = bitcast<vec4<f32>>(caster_part(caster, 0u));
  let y = bitcast<vec4<f32>>(caster_part(caster, 1u));
  let z = bitcast<vec4<f32>>(caster_part(caster, 2u));
  let middle = 0.5 * low + 0.5 * high;
  let half = 0.5 * high - 0.5 * low;
  // The largest coordinate of the origins of cameras, a third or more of an l1 norm. Positions are drawn relative to them.
  let origin = bitcast<f32>(table[group.ranges_offset + 16u * group.batches].z);
  let sizes = max(abs(low), abs(high));
  let size = l1_norm(x.xyz * sizes) + l1_norm(y.xyz * sizes) + l1_norm(z.xyz * sizes) + abs(x.w) + abs(y.w) + abs(z.w);
  let half_x = half.x * vec3<f32>(x.x, y.x, z.x);
  let half_y = half.y * vec3<f32>(x.y, y.y, z.y);
  let half_z = half.z * vec3<f32>(x.z, y.z, z.z);
  return OrientedBox(
    vec3<f32>(dot_3(x.xyz, middle) + x.w, dot_3(y.xyz, middle) + y.w, dot_3(z.xyz, middle) + z.w),
    half_x, half_y, half_z,
    size + 3.0 * origin,
    l1_norm(half_x) + l1_norm(half_y) + l1_norm(half_z),
  );
}

// The smallest dot product of `normal` and p - origin over all points p of the box.
fn smallest_height(box: OrientedBox, normal: vec3<f32>, origin: vec3<f32>) -> f32 {
  return dot_3(normal, box.middle - origin) - abs(dot_3(normal, box.half_x)) - abs(dot_3(normal, box.half_y)) -
    abs(dot_3(normal, box.half_z));
}

// A corner of an occluder. The w of the first one is the number of corners.
fn occluder_corner(occluder_offset: u32, corner: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(table[occluder_offset + corner].xyz);
}

// Whether all of the box is behind an occluder: behind its plane, and within the planes through the light and its edges.
// `side` is 1 if the light sees the corners counter-clockwise, else -1.
fn is_behind(box: OrientedBox, occluder_offset: u32, light: vec4<f32>, side: f32) -> bool {
  let count = min(table[occluder_offset].w, MOST_CORNERS);
  let first = occluder_corner(occluder_offset, 0u);
  // Turns: MOST_CORNERS.
  for (var corner = 0u; corner < count; corner++) {
    let a = occluder_corner(occluder_offset, corner);
    let b = occluder_corner(occluder_offset, select(corner + 1u, 0u, corner + 1u == count));
    let separation = l1_norm(box.middle - a) + box.extent;
    let size = box.term_bound + l1_norm(a) + l1_norm(b);
    let e = b - a;
    // Within the plane through the light and the edge.
    let to_light = light.xyz - light.w * a;
    let light_bound = l1_norm(light.xyz) + light.w * size;
    let within = smallest_height(box, side * cross(to_light, e), a);
    let error = SLACK * light_bound * (size * (l1_norm(e) + separation) + 2.0 * l1_norm(e) * separation) + MOST_FLUSHED;
    if (!(within > error) || !(size < TOO_LARGE_TO_OCCLUDE)) {
      return false;
    }
    // Behind the plane of this corner, the next one and the first.
    if (corner > 0u && corner + 1u < count) {
      let v = b - first;
      let u = a - first;
      let behind = smallest_height(box, -side * cross(u, v), first);
      let separation = l1_norm(box.middle - first) + box.extent;
      let size = size + l1_norm(first);
      let spread = l1_norm(u) * l1_norm(v);
      let error = SLACK * (size * (spread + (l1_norm(u) + l1_norm(v)) * separation) + 2.0 * spread * separation) +
        MOST_FLUSHED;
      if (!(behind > error)) {
        return false;
      }
    }
  }
  return true;
}

// The lights for which an occluder hides all of the caster's box.
fn occluded_lights(caster: u32, batch: u32, lights: u32) -> u32 {
  if (group.occluders == 0u || lights == 0u) {
    return 0u;
  }
  let low = caster_part(caster, 3u);
  let high = caster_part(caster, 4u);
  let is_boxed = (high.w & (RIGID | BOUNDED)) != 0u && bitcast<f32>(low.x) <= bitcast<f32>(high.x);
  if (!is_boxed) {
    return 0u;
  }
  let box = oriented_box(caster);
  var occluded = 0u;
  // Turns: MOST_OCCLUDERS.
  for (var index = 0u; index < min(group.occluders, MOST_OCCLUDERS); index++) {
    // x: lights that it can hide; y: those of them that see its corners counter-clockwise; z: its caster; w: the offset of
    // its corners.
    let occluder = table[group.occluders_offset + batch * group.occluders + index];
    if (occluder.z == caster) {
      continue;
    }
    // Turns: 32.
    for (var remaining = occluder.x & lights & ~occluded; remaining != 0u; remaining &= remaining - 1u) {
      let light = firstTrailingBit(remaining);
      let scaled = bitcast<vec4<f32>>(table[group.world_lights_offset + 32u * batch + light]);
      let side = select(-1.0, 1.0, ((occluder.y >> light) & 1u) != 0u);
      if (is_behind(box, occluder.w, scaled, side)) {
        occluded |= 1u << light;
      }
    }
  }
  return occluded;
}
