// Positions of casters, as the stage binds them: `positions`, with the layout in the table.

fn vertex_bits(caster: u32, vertex: u32) -> vec3<u32> {
  let word = face_run(caster).w + vertex * edge_run(caster).w;
  return vec3<u32>(positions[word], positions[word + 1u], positions[word + 2u]);
}

fn vertex_position(caster: u32, vertex: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(vertex_bits(caster, vertex));
}
