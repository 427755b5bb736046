// Shadow arguments: computes the indirect draws of each light's volume. If the caps stage found no face for a light,
// plain z-pass counts it. The draws of lists that overflowed go over all edges or faces. The vertex shader then rejects
// those that do not belong.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<storage, read> silhouette_counts: array<u32>;
@group(0) @binding(2) var<storage, read> cap_counts: array<u32>;
@group(0) @binding(3) var<storage, read> shadow_lights: array<ShadowLight>;
@group(0) @binding(4) var<storage, read_write> shadow_draws: array<ShadowDraws>;
@group(0) @binding(5) var<storage, read_write> shadow_statistics: ShadowStatistics;

fn arguments(vertices: u32, instances: u32) -> DrawArguments {
  return DrawArguments(select(vertices, 0u, instances == 0u), instances, 0u, 0u);
}

fn cap_instances(count: u32) -> u32 {
  return select(count, shape.faces, count > shape.cap_capacity);
}

fn write_arguments(index: u32) {
  let light = shadow_lights[index];
  var sides = select(silhouette_counts[index], shape.edges, silhouette_counts[index] > shape.capacity);
  // A side of weight 2 is drawn twice.
  sides *= select(1u, 2u, light.casting == CAST_EVERY);
  // Sides of holes and of excluded faces count where every face casts, as it does then. Three edges a face.
  let excluded = cap_counts[LISTS * index + EXCLUDED];
  let excluded_overflowed = excluded > list_capacity(EXCLUDED, shape.cap_capacity);
  let hole_faces = select(excluded, shape.faces, light.holed != 0u || excluded_overflowed);
  let holes = select(0u, 3u * hole_faces, light.casting == CAST_EVERY);
  var front = cap_counts[LISTS * index];
  var back = cap_counts[LISTS * index + 1u];
  if (light.casting == CAST_NOTHING) {
    sides = 0u;
    front = 0u;
    back = 0u;
    atomicAdd(&shadow_statistics.skipped, 1u);
  } else if (light.casting == CAST_EVERY) {
    atomicAdd(&shadow_statistics.every_face, 1u);
  }
  if (light.casting != CAST_NOTHING && light.end > 0.0) {
    atomicAdd(&shadow_statistics.ended, 1u);
  }
  if (light.casting != CAST_NOTHING && (max(front, back) > shape.cap_capacity || excluded_overflowed)) {
    atomicAdd(&shadow_statistics.overflowed_caps, 1u);
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
      draws.clipped = arguments(4u, 3u * sides);
      draws.front = arguments(3u, front);
      draws.back = arguments(3u, back);
    } else {
      draws.switched = arguments(4u, sides);
      draws.far_front = arguments(3u, front);
      draws.far_back = arguments(3u, back);
    }
  } else {
    let cap_vertices = select(3u, 5u, light.counting == COUNT_ZP_PLUS);
    draws.plain = arguments(4u, select(sides, 0u, is_clipped));
    draws.clipped = arguments(5u, select(0u, sides, is_clipped));
    if (light.counting == COUNT_Z_PASS) {
      draws.far_front = arguments(3u, front);
      draws.far_back = arguments(3u, back);
    } else {
      draws.front = arguments(cap_vertices, front);
      draws.back = arguments(cap_vertices, back);
    }
  }
  draws.holes = arguments(5u, select(holes, 0u, is_clipped));
  draws.clipped_holes = arguments(6u, select(0u, holes, is_clipped));
  shadow_draws[index] = draws;
}

@compute @workgroup_size(64)
fn shadow_arguments(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  for (var light = id.x; light < shape.lights; light += 64u * groups.x) {
    write_arguments(light);
  }
}
