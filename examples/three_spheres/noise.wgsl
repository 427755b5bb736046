// Moves a vertex of one of three spheres along its ray by noise that drifts with time.

fn hash(cell: vec3<i32>) -> f32 {
  let bits = bitcast<vec3<u32>>(cell) * vec3<u32>(0x9e3779b9u, 0x85ebca6bu, 0xc2b2ae35u);
  var h = bits.x ^ bits.y ^ bits.z;
  h ^= h >> 15u;
  h *= 0x2c1b3c6du;
  h ^= h >> 12u;
  return f32(h >> 8u) / 8388608.0 - 1.0;
}

// Random values at integer points, blended smoothly between them.
fn noise(p: vec3<f32>) -> f32 {
  let cell = vec3<i32>(floor(p));
  let f = p - floor(p);
  let t = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
  var sum = 0.0;
  for (var corner = 0; corner < 8; corner++) {
    let offset = vec3<i32>(corner & 1, (corner >> 1u) & 1, corner >> 2u);
    let weight = select(vec3<f32>(1.0) - t, t, offset == vec3<i32>(1));
    sum += weight.x * weight.y * weight.z * hash(cell + offset);
  }
  return sum;
}

fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  // The centre of the sphere at hand, as main.rs places them: one behind, one to each side.
  var centre = vec3<f32>(0.0, 1.25, -1.7);
  if (position.z > -0.55) {
    centre = vec3<f32>(2.0 * sign(position.x), 1.25, 0.6);
  }
  let ray = position - centre;
  let drift = vec3<f32>(0.0, 0.0, time) + 7.0 * centre;
  return centre + ray * (1.0 + 0.34 * noise(2.2 * ray + drift) + 0.12 * noise(5.1 * ray + drift));
}
