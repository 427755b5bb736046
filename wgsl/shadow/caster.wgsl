// Lookups of casters for the stages of shadow volumes and outlines, in the scene table, where a caster has eight vec4s
// (`SceneCaster`). Groups, slots, chunks and pages are defined in common/casters.wgsl.
// Positions of rigid casters are in mesh space, those of all other casters in world space. `caster_box`, `view_for_caster`
// and `light_for_caster` are for the space of the caster's positions, so a stage must take all three from here.
//
// Expects: `shape`, `table`, the scene table, `boxes`, written by shadow/bounds.wgsl, and `positions`: each only where a
// function that is used needs it.

#import common/casters
#import common/order_keys
#import shadow/shadow

fn caster_part(caster: u32, part: u32) -> vec4<u32> { return table[8u * caster + part]; }
fn caster_flags(caster: u32) -> u32 { return caster_part(caster, 4u).w; }

// The faces of a caster. x: first slot. y: count. z: first face in the page. w: word of vertex 0 in `positions`.
fn face_range(caster: u32) -> vec4<u32> { return caster_part(caster, 5u); }

// The edge records of a caster. x: first slot. y: count. z: first record in the page. w: words from vertex to vertex.
fn edge_range(caster: u32) -> vec4<u32> { return caster_part(caster, 6u); }

// The caster that owns a slot. `chunks_offset` is the offset in the table, in vec4s, of the casters of all chunks.
fn caster_of_slot(chunks_offset: u32, slot: u32) -> u32 {
  let chunk = slot / CHUNK;
  return table[chunks_offset + chunk / 4u][chunk % 4u];
}

fn first_caster_of_group(caster: u32) -> u32 { return caster_part(caster, 7u).z; }

// The view for the positions of a caster. Its placement is the caster's matrix plus the translation of `view.placement`.
fn view_for_caster(caster: u32, view: ShadowView) -> ShadowView {
  let x = bitcast<vec4<f32>>(caster_part(caster, 0u));
  let y = bitcast<vec4<f32>>(caster_part(caster, 1u));
  let z = bitcast<vec4<f32>>(caster_part(caster, 2u));
  var result = view;
  result.placement = array<vec4<f32>, 3>(
    vec4<f32>(x.xyz, x.w + view.placement[0].w),
    vec4<f32>(y.xyz, y.w + view.placement[1].w),
    vec4<f32>(z.xyz, z.w + view.placement[2].w));
  return result;
}

// The light in the space of a caster's positions. `light_index` is the light's index among all lights of the frame. The
// caster must be allowed the light, or a rigid one gets another light's position.
fn light_for_caster(caster: u32, light: ShadowLight, light_index: u32) -> ShadowLight {
  if (!is_in_mesh_space(caster)) {
    return light;
  }
  // x: the caster's lights in the batch, a bit each. y: offset of these lights in the table, two vec4s a light.
  let lights = table[shape.lights_offset + light_index / 32u * shape.casters + caster];
  let rank = countOneBits(lights.x & ((1u << (light_index % 32u)) - 1u));
  let in_table = bitcast<vec4<f32>>(table[lights.y + 2u * rank]);
  var result = light;
  result.light = vec4<f32>(in_table.xyz * light.scale, light.light.w);
  return result;
}

// The box around the finite faces of a caster.
struct CasterBox {
  low: vec3<f32>,
  high: vec3<f32>,
  is_empty: bool, // No face is finite.
  has_holes: bool, // Some face with three different vertices is not finite.
}

fn is_in_mesh_space(caster: u32) -> bool { return (caster_flags(caster) & RIGID) != 0u; }

// The box of a caster, in the space of its positions. The table has it for rigid casters, `bounds` computes all others. A
// box that `bounds` skipped is empty.
fn caster_box(caster: u32) -> CasterBox {
  if (is_in_mesh_space(caster)) {
    let low = bitcast<vec3<f32>>(caster_part(caster, 3u).xyz);
    let high = bitcast<vec3<f32>>(caster_part(caster, 4u).xyz);
    return CasterBox(low, high, low.x > high.x, (caster_flags(caster) & NON_FINITE) != 0u);
  }
  let offset = 7u * caster;
  let low = floats_of_keys(~vec3<u32>(boxes[offset], boxes[offset + 1u], boxes[offset + 2u]));
  let high = floats_of_keys(vec3<u32>(boxes[offset + 3u], boxes[offset + 4u], boxes[offset + 5u]));
  return CasterBox(low, high, boxes[offset + 3u] == 0u, boxes[offset + 6u] != 0u);
}

fn vertex_bits(caster: u32, vertex: u32) -> vec3<u32> {
  let offset = face_range(caster).w + vertex * edge_range(caster).w;
  return vec3<u32>(positions[offset], positions[offset + 1u], positions[offset + 2u]);
}

fn vertex_position(caster: u32, vertex: u32) -> vec3<f32> { return bitcast<vec3<f32>>(vertex_bits(caster, vertex)); }

// The position in world space of a position in the caster's space.
fn to_world(caster: u32, position: vec3<f32>) -> vec3<f32> {
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

// The box of a caster in world space. For a rigid caster it is the box around its transformed box, with rounding errors.
fn caster_world_box(caster: u32) -> CasterBox {
  var result = caster_box(caster);
  if (!is_in_mesh_space(caster)) {
    return result;
  }
  let low = result.low;
  let high = result.high;
  for (var axis = 0u; axis < 3u; axis++) {
    let row = bitcast<vec4<f32>>(caster_part(caster, axis));
    result.low[axis] = dot_3(min(row.xyz * low, row.xyz * high), vec3<f32>(1.0)) + row.w;
    result.high[axis] = dot_3(max(row.xyz * low, row.xyz * high), vec3<f32>(1.0)) + row.w;
  }
  return result;
}
