// Shadow arguments: computes the indirect draws of each light's volume. If the caps stage found no face for a light,
// plain z-pass counts it. The draws of lists that overflowed go over all edges or faces. The vertex shader then rejects
// those that do not belong.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
// The first light of this batch.
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
// Of each light of the batch, two numbers of sides. The lists follow.
@group(0) @binding(2) var<storage, read> sides: array<u32>;
@group(0) @binding(3) var<storage, read> cap_counts: array<u32>;
@group(0) @binding(4) var<storage, read> shadow_lights: array<ShadowLight>;
@group(0) @binding(5) var<storage, read_write> shadow_draws: array<ShadowDraws>;
@group(0) @binding(6) var<storage, read_write> shadow_statistics: ShadowStatistics;

fn arguments(vertices: u32, instances: u32) -> DrawArguments {
  return DrawArguments(select(vertices, 0u, instances == 0u), instances, 0u, 0u);
}

fn cap_instances(count: u32) -> u32 {
  return select(count, shape.faces, count > shape.cap_capacity);
}

// A side of weight 2 is drawn twice.
fn side_instances(bit: u32) -> u32 {
  let singles = sides[2u * bit];
  let doubles = sides[2u * bit + 1u];
  if (singles + doubles > shape.side_capacity) {
    atomicAdd(&shadow_statistics.overflowed_sides, 1u);
    return 2u * shape.edges;
  }
  return singles + 2u * doubles;
}

fn write_arguments(bit: u32) {
  let index = draw.first_light + bit;
  let light = shadow_lights[index];
  var instances = 0u;
  var front = 0u;
  var back = 0u;
  if (light.casting == CAST_NOTHING) {
    atomicAdd(&shadow_statistics.skipped, 1u);
  } else {
    instances = side_instances(bit);
    front = cap_counts[LISTS * index];
    back = cap_counts[LISTS * index + 1u];
    atomicAdd(&shadow_statistics.every_face, select(0u, 1u, light.casting == CAST_EVERY));
    atomicAdd(&shadow_statistics.ended, select(0u, 1u, light.end > 0.0));
    atomicAdd(&shadow_statistics.overflowed_caps, select(0u, 1u, max(front, back) > shape.cap_capacity));
  }
  let has_caps = front + back > 0u;
  let is_clipped = light.counting == COUNT_ZP_PLUS && has_caps;
  if (is_clipped || (light.counting == COUNT_ZP_PLUS_2005 && has_caps)) {
    atomicAdd(&shadow_statistics.capped, 1u);
  }
  front = cap_instances(front);
  back = cap_instances(back);
  var draws = ShadowDraws();
  if (shape.counting == COUNT_ZP_PLUS_2005) {
    if (light.counting == COUNT_ZP_PLUS_2005) {
      draws.clipped = arguments(4u, 3u * instances);
      draws.front = arguments(3u, front);
      draws.back = arguments(3u, back);
    } else {
      draws.switched = arguments(4u, instances);
      draws.far_front = arguments(3u, front);
      draws.far_back = arguments(3u, back);
    }
  } else {
    let cap_vertices = select(3u, 5u, light.counting == COUNT_ZP_PLUS);
    draws.plain = arguments(4u, select(instances, 0u, is_clipped));
    draws.clipped = arguments(5u, select(0u, instances, is_clipped));
    if (light.counting == COUNT_Z_PASS) {
      draws.far_front = arguments(3u, front);
      draws.far_back = arguments(3u, back);
    } else {
      draws.front = arguments(cap_vertices, front);
      draws.back = arguments(cap_vertices, back);
    }
  }
  shadow_draws[index] = draws;
}

@compute @workgroup_size(32)
fn shadow_arguments(@builtin(local_invocation_index) bit: u32) {
  if (draw.first_light + bit < shape.lights) {
    write_arguments(bit);
  }
}
