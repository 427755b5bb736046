// Shadow arguments: a compute stage that makes the indirect draws of shadow volumes from the counts of `list_sides` and `caps`,
// and counts lists that overflowed in the statistics. Dispatched after `list_sides`, one workgroup for each group of casters,
// batch (up to 32 lights) and view, an invocation a light. The caller's render pass draws with `shadow_draws`, by the vertex
// shaders `sides` and `cap_faces`. Where lists overflowed, draws go over all edges or faces, and these shaders reject what does
// not belong: slower, never wrong. So the instances here and how the shaders read them must stay the same.

#import common/extraction
#import shadow/shadow

// The draws of one light's shadow volume.
struct ShadowDraws {
  // Sides that are not clipped, and sides clipped at the near plane, or sides of ZP+ as published.
  plain: DrawArguments,
  clipped: DrawArguments,
  // Near caps that count up on their front, and on their back.
  near_front: DrawArguments,
  near_back: DrawArguments,
  // Light and dark caps of z-fail, likewise. With z-pass, the dark caps of volumes that end.
  far_front: DrawArguments,
  far_back: DrawArguments,
  // With z-pass and ZP+, the light caps of casters that are not in the depth buffer.
  light_front: DrawArguments,
  light_back: DrawArguments,
}

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> sides: array<u32>;
@group(0) @binding(3) var<storage, read> caps_listed: array<u32>;
@group(0) @binding(4) var<storage, read_write> shadow_draws: array<ShadowDraws>;
@group(0) @binding(5) var<storage, read_write> shadow_statistics: ShadowStatistics;

fn arguments(vertices: u32, instances: u32) -> DrawArguments {
  return DrawArguments(select(vertices, 0u, instances == 0u), instances, 0u, 0u);
}

// Instances of two lists that share a run. `all` are those of a run that overflowed, for lists that are not empty.
fn instances_of(first: u32, second: u32, capacity: u32, all: u32) -> vec2<u32> {
  let listed = vec2<u32>(first, second);
  if (first + second > capacity) {
    return select(listed, vec2<u32>(all), listed != vec2<u32>(0u));
  }
  return listed;
}

fn write_arguments(bit: u32) {
  let plain = sides[2u * bit];
  let clipped = sides[2u * bit + 1u];
  let counts = vec4<u32>(
    caps_listed[4u * bit], caps_listed[4u * bit + 1u], caps_listed[4u * bit + 2u], caps_listed[4u * bit + 3u]);
  if (plain + clipped > shape.side_capacity) {
    atomicAdd(&shadow_statistics.overflowed_sides, 1u);
  }
  if (counts.x + counts.y > shape.near_capacity || counts.z + counts.w > shape.far_capacity) {
    atomicAdd(&shadow_statistics.overflowed_caps, 1u);
  }
  if (counts.x + counts.y > 0u) {
    atomicAdd(&shadow_statistics.capped, 1u);
  }
  // A side may have weight 2.
  let side_instances = instances_of(plain, clipped, shape.side_capacity, 2u * shape.edges);
  let near = instances_of(counts.x, counts.y, shape.near_capacity, shape.faces);
  let far = instances_of(counts.z, counts.w, shape.far_capacity, shape.faces);
  let is_published = shape.counting == COUNT_ZP_PLUS_2005;
  var draws = ShadowDraws();
  draws.plain = arguments(4u, side_instances.x);
  // ZP+ as published takes three quads a side.
  draws.clipped = arguments(select(5u, 4u, is_published), side_instances.y * select(1u, 3u, is_published));
  draws.near_front = arguments(select(5u, 3u, is_published), near.x);
  draws.near_back = arguments(select(5u, 3u, is_published), near.y);
  draws.far_front = arguments(3u, far.x);
  draws.far_back = arguments(3u, far.y);
  if (shape.proxies != 0u) {
    draws.light_front = arguments(4u, far.x);
    draws.light_back = arguments(4u, far.y);
  }
  shadow_draws[draw.view * shape.lights + draw.first_light + bit] = draws;
}

@compute @workgroup_size(32)
fn shadow_arguments(@builtin(local_invocation_index) bit: u32) {
  if (draw.first_light + bit < shape.lights) {
    write_arguments(bit);
  }
}
