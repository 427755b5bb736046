// Stage `shadow_boxes`, the first of a query of occluder counts. It computes boxes around clusters (CLUSTER = 32 faces) and
// groups (CLUSTER clusters) from the positions of this encode. Dispatched once for all clusters that a binding holds, from
// the first on: it does not read `range.first`. A workgroup is a group, an invocation a cluster. It writes the box of each
// cluster to `clusters`, and the box of a group to the group's first cluster. The CPU wrote the other members once.
// `shadow_depth` and `exact_shadow_depth` cull by them, so a box must contain each face that can count: finite, with three
// different vertices. Floats are compared as integer keys, so no device can flush or round them, and boxes have the same
// bits everywhere. docs/numerics/query.md.

#import common/extraction
#import common/order_keys
#import common/positions
#import query/records

@group(0) @binding(0) var<uniform> batch: LightBatch;
@group(0) @binding(1) var<uniform> range: FaceRange;
@group(0) @binding(6) var<storage, read_write> clusters: array<FaceCluster>;

// The lowest and highest keys, and the bits of the largest absolute coordinate. `any_face`: 1 if a face can count, else 0.
struct Keys {
  low: vec3<u32>,
  largest: u32,
  high: vec3<u32>,
  any_face: u32,
}

var<workgroup> group_keys: array<Keys, CLUSTER>;

fn empty_keys() -> Keys {
  return Keys(vec3<u32>(0xffffffffu), 0u, vec3<u32>(0u), 0u);
}

fn join(a: Keys, b: Keys) -> Keys {
  return Keys(min(a.low, b.low), max(a.largest, b.largest), max(a.high, b.high), a.any_face | b.any_face);
}

fn keys_of_point(bits: vec3<u32>) -> Keys {
  let magnitudes = bits & ~vec3<u32>(SIGN_BIT);
  return Keys(order_keys(bits), max(max(magnitudes.x, magnitudes.y), magnitudes.z), order_keys(bits), 1u);
}

// The keys of a face's corners; empty for a face that cannot count.
fn keys_of_face(cluster: u32, face: u32) -> Keys {
  let corners = vec3<u32>(
    clusters[cluster].corners[3u * face],
    clusters[cluster].corners[3u * face + 1u],
    clusters[cluster].corners[3u * face + 2u],
  );
  let a = position_bits(corners.x, batch.position_offset, batch.position_stride);
  let b = position_bits(corners.y, batch.position_offset, batch.position_stride);
  let c = position_bits(corners.z, batch.position_offset, batch.position_stride);
  let is_degenerate = corners.x == corners.y || corners.y == corners.z || corners.z == corners.x;
  if (is_degenerate || !is_finite(a) || !is_finite(b) || !is_finite(c)) {
    return empty_keys();
  }
  return join(keys_of_point(a), join(keys_of_point(b), keys_of_point(c)));
}

fn low_words(keys: Keys) -> vec4<u32> {
  return select(vec4<u32>(0u), vec4<u32>(bits_of_keys(keys.low), keys.largest), keys.any_face != 0u);
}

fn high_words(keys: Keys) -> vec4<u32> {
  return select(vec4<u32>(0u), vec4<u32>(bits_of_keys(keys.high), 1u), keys.any_face != 0u);
}

@compute @workgroup_size(CLUSTER)
fn shadow_boxes(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
  let cluster = group.x * CLUSTER + lane;
  var keys = empty_keys();
  if (cluster < range.end) {
    for (var face = 0u; face < CLUSTER; face++) {
      keys = join(keys, keys_of_face(cluster, face));
    }
    clusters[cluster].low = low_words(keys);
    clusters[cluster].high = high_words(keys);
  }
  group_keys[lane] = keys;
  workgroupBarrier();
  if (lane == 0u) {
    for (var other_lane = 1u; other_lane < CLUSTER; other_lane++) {
      keys = join(keys, group_keys[other_lane]);
    }
    clusters[cluster].group_low = low_words(keys);
    clusters[cluster].group_high = high_words(keys);
  }
}
