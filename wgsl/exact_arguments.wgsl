// Exact arguments: the indirect dispatch of exact_facing.wgsl, from how many faces are undecided.

@group(0) @binding(0) var<uniform> chunk: Chunk;
@group(0) @binding(1) var<storage, read> undecided: array<u32>;
@group(0) @binding(2) var<storage, read_write> dispatch: array<u32, 3>;

// Workgroups that a dispatch may have along x, y or z.
override MOST_WORKGROUPS: u32 = 65535u;

@compute @workgroup_size(1)
fn exact_arguments() {
  var items = undecided[0];
  if (items >= arrayLength(&undecided)) {
    items = chunk.count;
  }
  let groups = (items + 63u) / 64u;
  let rows = (groups + MOST_WORKGROUPS - 1u) / MOST_WORKGROUPS;
  // A chunk has at most four groups for each of MOST_WORKGROUPS, so layers are few.
  let layers = (rows + MOST_WORKGROUPS - 1u) / MOST_WORKGROUPS;
  dispatch[0] = min(groups, MOST_WORKGROUPS);
  dispatch[1] = min(rows, MOST_WORKGROUPS);
  dispatch[2] = layers;
}
