// Casters in world space.

// A position of a caster in world space.
fn in_world(caster: u32, position: vec3<f32>) -> vec3<f32> {
  if (!is_in_mesh_space(caster)) {
    return position;
  }
  var world: vec3<f32>;
  for (var axis = 0u; axis < 3u; axis++) {
    let row = bitcast<vec4<f32>>(caster_part(caster, axis));
    world[axis] = dot_3(row.xyz, position) + row.w;
  }
  return world;
}

// A caster's box in world space.
fn world_box(caster: u32) -> CasterBox {
  var own = box_of(caster);
  if (!is_in_mesh_space(caster)) {
    return own;
  }
  let low = own.low;
  let high = own.high;
  for (var axis = 0u; axis < 3u; axis++) {
    let row = bitcast<vec4<f32>>(caster_part(caster, axis));
    own.low[axis] = dot_3(min(row.xyz * low, row.xyz * high), vec3<f32>(1.0)) + row.w;
    own.high[axis] = dot_3(max(row.xyz * low, row.xyz * high), vec3<f32>(1.0)) + row.w;
  }
  return own;
}
