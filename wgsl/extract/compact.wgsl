// Compact: a compute stage of three passes that makes lists of silhouette edges for each light of a batch (up to 32), in edge
// order, from the masks of `edges`, for callers that ask for ordered lists. Dispatched for each batch, after `edges` (or
// `per_edge`), which then appends nothing. `compact_count`: an invocation an edge; counts the bits of each block of 256 edges.
// `compact_scan`: a workgroup a light; turns the counts into offsets, and writes the light's count. `compact_scatter`: an
// invocation an edge; writes the lists, for `arguments`, callers and shadow volumes. Lists are the same on every device. Bit
// 31 of an entry is the winding: face 0 of the edge faces the light. Counts go on where a list has no room.

#import common/extraction

@group(0) @binding(0) var<uniform> chunk: Chunk;
@group(0) @binding(1) var<storage, read> masks: array<EdgeMasks>;
// For each light one number a block: first its silhouettes in the block, then those in all earlier blocks.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> list: array<u32>;
const BLOCK_WORDS: u32 = BLOCK / 32u;
// For each light the silhouette edges of the block, as a bit set.
var<workgroup> members: array<atomic<u32>, 32u * BLOCK_WORDS>;

// No silhouette past the last edge, so that invocations of a workgroup stay together at barriers.
fn silhouette_of(edge: u32) -> EdgeMasks {
  if (edge < chunk.count) {
    return masks[edge];
  }
  return EdgeMasks(0u, 0u);
}

// Fills `members`, which is zero before, from the masks of all invocations.
fn gather_members(silhouette: u32, local: u32) {
  for (var rest = silhouette; rest != 0u; rest &= rest - 1u) {
    atomicOr(&members[firstTrailingBit(rest) * BLOCK_WORDS + local / 32u], 1u << (local % 32u));
  }
  workgroupBarrier();
}

@compute @workgroup_size(BLOCK)
fn compact_count(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  gather_members(silhouette_of(id.x).silhouette, local);
  if (local < 32u) {
    var total = 0u;
    // Turns: BLOCK / 32.
    for (var at = 0u; at < BLOCK_WORDS; at++) {
      total += countOneBits(atomicLoad(&members[local * BLOCK_WORDS + at]));
    }
    places[local * chunk.blocks + chunk.first / BLOCK + group.x] = total;
  }
}

var<workgroup> sums: array<u32, BLOCK>;

// Each invocation takes a run of blocks. The sums of the runs are scanned, and then the runs are filled in.
fn scan_light(light: u32, local: u32) {
  let run = (chunk.blocks + BLOCK - 1u) / BLOCK;
  let begin = min(local * run, chunk.blocks);
  let end = min(begin + run, chunk.blocks);
  var total = 0u;
  // Turns: SCAN_BLOCKS.
  for (var block = begin; block < end; block++) {
    total += places[light * chunk.blocks + block];
  }
  sums[local] = total;
  for (var reach = 1u; reach < BLOCK; reach *= 2u) {
    workgroupBarrier();
    var before = 0u;
    if (local >= reach) {
      before = sums[local - reach];
    }
    workgroupBarrier();
    sums[local] += before;
  }
  var place = sums[local] - total;
  // Turns: SCAN_BLOCKS.
  for (var block = begin; block < end; block++) {
    let count = places[light * chunk.blocks + block];
    places[light * chunk.blocks + block] = place;
    place += count;
  }
  if (local == BLOCK - 1u) {
    counts[chunk.first_light + light] = place;
  }
}

// One workgroup takes one light. If a device allows fewer workgroups than 32, each takes several lights in turn.
@compute @workgroup_size(BLOCK)
fn compact_scan(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let lights = min(arrayLength(&counts) - chunk.first_light, 32u);
  // Turns: 1.
  for (var light = group.x; light < lights; light += groups.x) {
    scan_light(light, local);
  }
}

@compute @workgroup_size(BLOCK)
fn compact_scatter(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let found = silhouette_of(id.x);
  gather_members(found.silhouette, local);
  for (var rest = found.silhouette; rest != 0u; rest &= rest - 1u) {
    let light = firstTrailingBit(rest);
    let own = light * BLOCK_WORDS + local / 32u;
    var place = places[light * chunk.blocks + chunk.first / BLOCK + group.x];
    // Turns: BLOCK / 32.
    for (var at = light * BLOCK_WORDS; at < own; at++) {
      place += countOneBits(atomicLoad(&members[at]));
    }
    place += countOneBits(atomicLoad(&members[own]) & ((1u << (local % 32u)) - 1u));
    if (place < chunk.capacity) {
      list[light * chunk.capacity + place] = (chunk.first + id.x) | (((found.winding >> light) & 1u) << 31u);
    }
  }
}

// Stage `arguments`: makes the indirect draw of each light's list of silhouette edges, for callers that draw them, and counts
// lists that overflowed in the statistics. Dispatched once at the end of an extraction, also where nothing was compacted, an
// invocation a light; in a scene for each group of casters and batch of up to 32 lights. The draw of a list that overflowed
// goes over all edges, and the caller's vertex shader rejects those that are no silhouettes (extract/results.wgsl): slower,
// never wrong.

@group(0) @binding(0) var<uniform> shape: DrawShape;
@group(0) @binding(2) var<storage, read_write> draw_arguments: array<DrawArguments>;
@group(0) @binding(4) var<storage, read_write> statistics: ExtractionStatistics;

fn write_arguments(light: u32) {
  var instances = counts[light];
  if (instances > shape.capacity) {
    atomicAdd(&statistics.overflowed_lists, 1u);
    instances = shape.edges;
  }
  draw_arguments[light] = DrawArguments(shape.vertices_per_edge, instances, 0u, 0u);
}

@compute @workgroup_size(64)
fn arguments(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // Turns: 16.
  for (var light = id.x; light < shape.lights; light += 64u * groups.x) {
    write_arguments(light);
  }
}
