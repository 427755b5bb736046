// Shadow depth: how many faces lie strictly between each point and each light, one invocation a pair of these. A face in
// doubt is noted for exact_shadow_depth.wgsl; where there are more than can be noted, that stage counts the range anew.

fn doubtful_face(segment: Segment, face: Face, index: u32) -> u32 {
  if (doubt.x < MOST_DOUBTS) {
    doubt[doubt.x + 1u] = index;
  }
  doubt.x++;
  return 0u;
}

@compute @workgroup_size(64)
fn shadow_depth(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  for (var index = id.x; index < chunk.count * word.count; index += 64u * groups.x) {
    let query = query_of(index);
    doubt = vec4<u32>(0u);
    if (!is_finite(query.p_bits)) {
      depths[query.at] = -1;
    } else {
      let count = count_range(segment_of(query));
      let counted = select(i32(count), 0, doubt.x > MOST_DOUBTS);
      if (range.is_first != 0u) {
        depths[query.at] = counted;
      } else {
        depths[query.at] += counted;
      }
    }
    doubts[index] = doubt;
  }
}
