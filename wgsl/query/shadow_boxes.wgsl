// Shadow boxes: the first stage of a shadow depth query. It computes the boxes around clusters of 32 faces and groups of 32
// clusters, from the positions of this encode. Dispatched once for each run of clusters that a binding holds; a workgroup
// takes a group, an invocation a cluster. It writes them into `clusters`, whose faces the CPU wrote once; `shadow_depth` and
// `exact_shadow_depth` leave out clusters and groups by them. A box must hold every face that counts: those that are finite
// and name three different vertices. Floats are compared as keys, integers in their order, so that no device can flush or
// round them; so boxes have the same bits everywhere. docs/numerics/query.md.

#import common/extraction
#import common/positions
#import query/records

@group(0) @binding(0) var<uniform> batch: LightBatch;
@group(0) @binding(1) var<uniform> range: FaceRange;
@group(0) @binding(6) var<storage, read_write> clusters: array<FaceCluster>;

const SIGN: u32 = 0x80000000u;

// The lowest and the highest keys, and the bits of the largest absolute coordinate. `any_face` is 1 if a face counts, else
// 0.
struct Keys {
  low: vec3<u32>,
  largest: u32,
  high: vec3<u32>,
  any_face: u32,
}

var<workgroup> group_keys: array<Keys, CLUSTER>;

// An integer for each float, in the order of floats.
fn key(bits: vec3<u32>) -> vec3<u32> {
  return select(bits | vec3<u32>(SIGN), ~bits, bits >= vec3<u32>(SIGN));
}

// The bits of the float of a key.
fn unkey(keys: vec3<u32>) -> vec3<u32> {
  return select(~keys, keys & ~vec3<u32>(SIGN), keys >= vec3<u32>(SIGN));
}

fn empty() -> Keys {
  return Keys(vec3<u32>(0xffffffffu), 0u, vec3<u32>(0u), 0u);
}

fn join(a: Keys, b: Keys) -> Keys {
  return Keys(min(a.low, b.low), max(a.largest, b.largest), max(a.high, b.high), a.any_face | b.any_face);
}

fn around(bits: vec3<u32>) -> Keys {
  let magnitudes = bits & ~vec3<u32>(SIGN);
  return Keys(key(bits), max(max(magnitudes.x, magnitudes.y), magnitudes.z), key(bits), 1u);
}

// The keys of a face's corners, or none for a face that does not count.
fn around_face(cluster: u32, face: u32) -> Keys {
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
    return empty();
  }
  return join(around(a), join(around(b), around(c)));
}

fn low_of(keys: Keys) -> vec4<u32> {
  return select(vec4<u32>(0u), vec4<u32>(unkey(keys.low), keys.largest), keys.any_face != 0u);
}

fn high_of(keys: Keys) -> vec4<u32> {
  return select(vec4<u32>(0u), vec4<u32>(unkey(keys.high), 1u), keys.any_face != 0u);
}

@compute @workgroup_size(CLUSTER)
fn shadow_boxes(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let cluster = group.x * CLUSTER + local;
  var keys = empty();
  if (cluster < range.end) {
    for (var face = 0u; face < CLUSTER; face++) {
      keys = join(keys, around_face(cluster, face));
    }
    clusters[cluster].low = low_of(keys);
    clusters[cluster].high = high_of(keys);
  }
  group_keys[local] = keys;
  workgroupBarrier();
  if (local == 0u) {
    for (var other = 1u; other < CLUSTER; other++) {
      keys = join(keys, group_keys[other]);
    }
    clusters[cluster].group_low = low_of(keys);
    clusters[cluster].group_high = high_of(keys);
  }
}
