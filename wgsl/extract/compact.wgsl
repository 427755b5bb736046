// Stage `compact` (`arguments` is below): makes lists of silhouette edges for each light of a batch (up to 32), in edge
// order, for callers that ask for ordered lists. Scenes do not. It reads the masks of `edges` or `per_edge`, which then
// append nothing. Three passes for each batch. `compact_count`: an invocation an edge; counts the silhouettes of each light
// in each block of 256 edges. `compact_scan`: a workgroup a light, for all chunks at once; turns the counts into offsets and
// writes the light's count. `compact_scatter`: an invocation an edge; writes the lists. Chunks begin at multiples of BLOCK,
// and their workgroups are one row. Lists are the same on every device. Bit 31 of an entry is the winding (`EdgeMasks`).
// The count of a light includes entries that its list has no room for.

#import common/extraction

@group(0) @binding(0) var<uniform> chunk: Chunk;
@group(0) @binding(1) var<storage, read> masks: array<EdgeMasks>;
// For each light and block: after `compact_count` the silhouettes in the block, after `compact_scan` those in all earlier
// blocks.
@group(0) @binding(2) var<storage, read_write> block_offsets: array<u32>;
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> list: array<u32>;
const BLOCK_WORDS: u32 = BLOCK / 32u;
// For each light the silhouette edges of the block, a bit each.
var<workgroup> members: array<atomic<u32>, 32u * BLOCK_WORDS>;

// The masks of an edge. Past the last edge there is no silhouette, so that all invocations of a workgroup meet at barriers.
fn edge_masks(edge: u32) -> EdgeMasks {
  if (edge < chunk.count) {
    return masks[edge];
  }
  return EdgeMasks(0u, 0u);
}

// Sets the bits of `members`, which are zero before, from the masks of all invocations.
fn gather_members(silhouette: u32, lane: u32) {
  for (var remaining = silhouette; remaining != 0u; remaining &= remaining - 1u) {
    atomicOr(&members[firstTrailingBit(remaining) * BLOCK_WORDS + lane / 32u], 1u << (lane % 32u));
  }
  workgroupBarrier();
}

@compute @workgroup_size(BLOCK)
fn compact_count(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  gather_members(edge_masks(id.x).silhouette, lane);
  if (lane < 32u) {
    var total = 0u;
    // Turns: BLOCK / 32.
    for (var word = 0u; word < BLOCK_WORDS; word++) {
      total += countOneBits(atomicLoad(&members[lane * BLOCK_WORDS + word]));
    }
    block_offsets[lane * chunk.blocks + chunk.first / BLOCK + group.x] = total;
  }
}

var<workgroup> sums: array<u32, BLOCK>;

// Each invocation takes a range of blocks: sums its counts, scans the sums with the other invocations, then writes offsets.
fn scan_light(light: u32, lane: u32) {
  let range_length = (chunk.blocks + BLOCK - 1u) / BLOCK;
  let begin = min(lane * range_length, chunk.blocks);
  let end = min(begin + range_length, chunk.blocks);
  var total = 0u;
  // Turns: SCAN_BLOCKS.
  for (var block = begin; block < end; block++) {
    total += block_offsets[light * chunk.blocks + block];
  }
  sums[lane] = total;
  for (var distance = 1u; distance < BLOCK; distance *= 2u) {
    workgroupBarrier();
    var addend = 0u;
    if (lane >= distance) {
      addend = sums[lane - distance];
    }
    workgroupBarrier();
    sums[lane] += addend;
  }
  var offset = sums[lane] - total;
  // Turns: SCAN_BLOCKS.
  for (var block = begin; block < end; block++) {
    let count = block_offsets[light * chunk.blocks + block];
    block_offsets[light * chunk.blocks + block] = offset;
    offset += count;
  }
  if (lane == BLOCK - 1u) {
    counts[chunk.first_light + light] = offset;
  }
}

// A workgroup takes a light, or several if the device allows fewer than 32 workgroups.
@compute @workgroup_size(BLOCK)
fn compact_scan(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let lights = min(arrayLength(&counts) - chunk.first_light, 32u);
  // Turns: 1.
  for (var light = group.x; light < lights; light += groups.x) {
    scan_light(light, lane);
  }
}

@compute @workgroup_size(BLOCK)
fn compact_scatter(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let masks_of_edge = edge_masks(id.x);
  gather_members(masks_of_edge.silhouette, lane);
  for (var remaining = masks_of_edge.silhouette; remaining != 0u; remaining &= remaining - 1u) {
    let light = firstTrailingBit(remaining);
    let last_word = light * BLOCK_WORDS + lane / 32u;
    var index = block_offsets[light * chunk.blocks + chunk.first / BLOCK + group.x];
    // Turns: BLOCK / 32.
    for (var word = light * BLOCK_WORDS; word < last_word; word++) {
      index += countOneBits(atomicLoad(&members[word]));
    }
    index += countOneBits(atomicLoad(&members[last_word]) & ((1u << (lane % 32u)) - 1u));
    if (index < chunk.capacity) {
      list[light * chunk.capacity + index] = (chunk.first + id.x) | (((masks_of_edge.winding >> light) & 1u) << 31u);
    }
  }
}

// Stage `arguments`: makes the indirect draw of each light's list of silhouette edges, and counts lists that overflowed in
// the statistics. Dispatched once at the end of an extraction with lists, also if nothing was compacted, for all lights that
// there is room for; in a scene for each group of casters and batch of up to 32 lights. The draw of a list that overflowed
// has an instance for every edge record, in a scene every edge slot. Vertex shaders reject by the facing masks those that
// are no silhouettes (extract/results.wgsl, outline/scene_edges.wgsl): slower, never wrong. `per_edge` makes no facing masks.

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
