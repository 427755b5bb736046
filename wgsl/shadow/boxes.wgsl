// Boxes of casters. `bounds` computes those of casters in world space. A rigid caster has its box in the table, in mesh
// space.

struct CasterBox {
  low: vec3<f32>,
  high: vec3<f32>,
  // There is no finite face.
  is_empty: bool,
  // Some face is not finite.
  has_holes: bool,
}

fn unordered(bits: vec3<u32>) -> vec3<f32> {
  return bitcast<vec3<f32>>(select(~bits, bits & vec3<u32>(0x7fffffffu), bits >= vec3<u32>(0x80000000u)));
}

fn is_in_mesh_space(caster: u32) -> bool {
  return MANY && (caster_flags(caster) & RIGID) != 0u;
}

// The box of a caster, in the space of its positions.
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
