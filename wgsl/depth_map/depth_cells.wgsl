// Depth cells: lists the cells of a depth map that have a triangle to draw, in their order. It has three passes: count those
// of each block, turn the counts into places, list them.

// For each block its listed cells, then those of all blocks before it.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;
// The number of cells, then their entries.
@group(0) @binding(3) var<storage, read_write> cells: array<u32>;
// The indirect draw.
@group(0) @binding(5) var<storage, read_write> draws: array<u32>;

const BLOCK: u32 = 256u;
const BLOCK_WORDS: u32 = 8u;
// The listed cells of the block, as a bit set.
var<workgroup> members: array<atomic<u32>, BLOCK_WORDS>;

// The entry of the invocation's cell, 0 if it is not listed. Before it, all invocations have read what they want of the
// block before.
fn gathered(cell: u32, local: u32) -> u32 {
  if (local < BLOCK_WORDS) {
    atomicStore(&members[local], 0u);
  }
  workgroupBarrier();
  var entry = 0u;
  if (cell < depth_map.cells) {
    entry = entry_of_cell(cell);
  }
  let is_listed = (entry & (FIRST_TRIANGLE | SECOND_TRIANGLE)) != 0u;
  if (is_listed) {
    atomicOr(&members[local / 32u], 1u << (local % 32u));
  }
  workgroupBarrier();
  return select(0u, entry, is_listed);
}

// Workgroups take blocks in turn, where a dispatch may not have as many.
@compute @workgroup_size(BLOCK)
fn depth_cells_count(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    gathered(block * BLOCK + local, local);
    if (local == 0u) {
      var total = 0u;
      for (var at = 0u; at < BLOCK_WORDS; at++) {
        total += countOneBits(atomicLoad(&members[at]));
      }
      places[block] = total;
    }
    workgroupBarrier();
  }
}

var<workgroup> sums: array<u32, BLOCK>;

// One workgroup. Each invocation takes a run of blocks. The sums of the runs are scanned, and then the runs are filled in.
@compute @workgroup_size(BLOCK)
fn depth_cells_places(@builtin(local_invocation_index) local: u32) {
  let run = (depth_map.blocks + BLOCK - 1u) / BLOCK;
  let begin = min(local * run, depth_map.blocks);
  let end = min(begin + run, depth_map.blocks);
  var total = 0u;
  for (var block = begin; block < end; block++) {
    total += places[block];
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
  for (var block = begin; block < end; block++) {
    let count = places[block];
    places[block] = place;
    place += count;
  }
  if (local == BLOCK - 1u) {
    cells[0] = place;
    // A list that overflowed is not read: every cell is drawn, and the vertex shader decides.
    draws[0] = 6u * select(place, depth_map.cells, place > depth_map.capacity);
    draws[1] = 1u;
    draws[2] = 0u;
    draws[3] = 0u;
  }
}

fn place_in_block(local: u32) -> u32 {
  var place = 0u;
  for (var at = 0u; at < local / 32u; at++) {
    place += countOneBits(atomicLoad(&members[at]));
  }
  return place + countOneBits(atomicLoad(&members[local / 32u]) & ((1u << (local % 32u)) - 1u));
}

@compute @workgroup_size(BLOCK)
fn depth_cells_list(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let entry = gathered(block * BLOCK + local, local);
    let place = places[block] + place_in_block(local);
    if (entry != 0u && place < depth_map.capacity) {
      cells[1u + place] = entry;
    }
    workgroupBarrier();
  }
}
