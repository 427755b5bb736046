// Casters, the meshes that throw shadows, as the stages of shadow volumes find them: in the scene's table, which begins with eight
// vec4s for each (`SceneCaster`). A slot is the index of a face or edge in the masks of a group, the casters drawn together. A
// chunk is 64 slots, all of one caster. These functions give a caster's slots, its positions and box, and what camera and light
// are to it: positions of a rigid caster are in the space of its mesh, and those of all others in world space. All that is
// computed for a caster must take camera, light and positions from here, in one space.
//
// Expects: `shape`, and as far as functions are used `table`, the table of casters; `boxes`, those of shadow/bounds.wgsl;
// `positions`.

#import common/casters
#import shadow/shadow

fn caster_part(caster: u32, part: u32) -> vec4<u32> { return table[8u * caster + part]; }
fn caster_flags(caster: u32) -> u32 { return caster_part(caster, 4u).w; }

// Faces: the first slot, their number, the first in the page, and the word of vertex 0 in the bound positions.
fn face_run(caster: u32) -> vec4<u32> { return caster_part(caster, 5u); }

// Edge records: the first slot, their number, the first in the page, and the words from one vertex to the next.
fn edge_run(caster: u32) -> vec4<u32> { return caster_part(caster, 6u); }

// The caster of a slot. `chunks_at` is where the casters of the chunks begin in the table.
fn caster_of(chunks_at: u32, slot: u32) -> u32 {
  let chunk = slot / CHUNK;
  return table[chunks_at + chunk / 4u][chunk % 4u];
}

fn first_of_group(caster: u32) -> u32 { return caster_part(caster, 7u).z; }

// The camera as a caster sees it: the placement is that of its positions.
fn view_of(caster: u32, view: ShadowView) -> ShadowView {
  let x = bitcast<vec4<f32>>(caster_part(caster, 0u));
  let y = bitcast<vec4<f32>>(caster_part(caster, 1u));
  let z = bitcast<vec4<f32>>(caster_part(caster, 2u));
  var own = view;
  own.placement = array<vec4<f32>, 3>(
    vec4<f32>(x.xyz, x.w + view.placement[0].w),
    vec4<f32>(y.xyz, y.w + view.placement[1].w),
    vec4<f32>(z.xyz, z.w + view.placement[2].w));
  return own;
}

// The light as a caster sees it: in the space of its positions.
fn light_of(caster: u32, light: ShadowLight, number: u32) -> ShadowLight {
  if (!is_in_mesh_space(caster)) {
    return light;
  }
  // The bits of the caster's lights in the batch, and where they begin.
  let lights = table[shape.lights_at + number / 32u * shape.casters + caster];
  let place = countOneBits(lights.x & ((1u << (number % 32u)) - 1u));
  let given = bitcast<vec4<f32>>(table[lights.y + 2u * place]);
  var own = light;
  own.light = vec4<f32>(given.xyz * light.scale, light.light.w);
  return own;
}

struct CasterBox {
  low: vec3<f32>,
  high: vec3<f32>,
  is_empty: bool, // There is no finite face.
  has_holes: bool, // Some face is not finite.
}

fn is_in_mesh_space(caster: u32) -> bool { return (caster_flags(caster) & RIGID) != 0u; }

// The box of a caster, in the space of its positions: that of the table if it is rigid, else that of `bounds`.
fn box_of(caster: u32) -> CasterBox {
  if (is_in_mesh_space(caster)) {
    let low = bitcast<vec3<f32>>(caster_part(caster, 3u).xyz);
    let high = bitcast<vec3<f32>>(caster_part(caster, 4u).xyz);
    return CasterBox(low, high, low.x > high.x, (caster_flags(caster) & HOLED) != 0u);
  }
  let at = 7u * caster;
  let low = unordered(~vec3<u32>(boxes[at], boxes[at + 1u], boxes[at + 2u]));
  let high = unordered(vec3<u32>(boxes[at + 3u], boxes[at + 4u], boxes[at + 5u]));
  return CasterBox(low, high, boxes[at + 3u] == 0u, boxes[at + 6u] != 0u);
}

fn vertex_bits(caster: u32, vertex: u32) -> vec3<u32> {
  let word = face_run(caster).w + vertex * edge_run(caster).w;
  return vec3<u32>(positions[word], positions[word + 1u], positions[word + 2u]);
}

fn vertex_position(caster: u32, vertex: u32) -> vec3<f32> { return bitcast<vec3<f32>>(vertex_bits(caster, vertex)); }

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

// A caster's box in world space. Of a rigid caster it is the box of its turned box.
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
