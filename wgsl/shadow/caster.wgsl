// The positions of the caster, as the stage binds them: `positions`, with the layout in `shape`.

fn caster_bits(vertex: u32) -> vec3<u32> {
  let word = shape.position_offset + vertex * shape.position_stride;
  return vec3<u32>(positions[word], positions[word + 1u], positions[word + 2u]);
}

fn caster_position(vertex: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(caster_bits(vertex));
}
