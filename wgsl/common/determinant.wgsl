// det[b - a, c - a, l - w a] in f32. Its sign tells the light's side of the face. The local form takes differences
// only; the plane form takes the face's plane. NUMERICS.md, "Facing" and "Per edge".

// Whether to use the plane form, as published in 2003, instead of the local form.
override PLANE: bool = false;

// u x v. For b - a and c - a it is the normal on the counter-clockwise side.
fn cross_product(u: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
  return vec3<f32>(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
}

fn sum_of_sizes(v: vec3<f32>) -> f32 {
  return abs(v.x) + abs(v.y) + abs(v.z);
}

fn largest_of(v: vec3<f32>) -> f32 {
  return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

// n . (l - w a)
fn local_form(n: vec3<f32>, a: vec3<f32>, light: vec4<f32>) -> f32 {
  let to_light = light.xyz - light.w * a;
  return n.x * to_light.x + n.y * to_light.y + n.z * to_light.z;
}

// The plane through a with normal n.
fn plane_through(n: vec3<f32>, a: vec3<f32>) -> vec4<f32> {
  return vec4<f32>(n, -(n.x * a.x + n.y * a.y + n.z * a.z));
}

// n . l + w e, for the light as given.
fn plane_form(plane: vec4<f32>, light: vec4<f32>) -> f32 {
  return plane.x * light.x + plane.y * light.y + plane.z * light.z + plane.w * light.w;
}
