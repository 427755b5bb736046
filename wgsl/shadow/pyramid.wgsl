// The pyramid between a light and the near rectangle, as planes. Faces in it cast onto the near rectangle.

// The relative slack of all tests. It is far above the rounding error of the tests.
const SLACK: f32 = 4e-6;

// Whether a point is outside a plane, from its `value` there. `size` bounds the terms whose sum is the value.
fn is_out(value: f32, size: f32) -> bool {
  return value < -SLACK * size;
}

struct PyramidPlanes {
  // Left, right, bottom, top; negative outside. Then bounds on the terms whose sums they are.
  value: vec4<f32>,
  size: vec4<f32>,
  // Negative on the far side of the near plane as seen from the light.
  depth: f32,
  depth_size: f32,
}

// Bounds on the terms whose sums are a position's clip coordinates.
fn clip_size(view: ShadowView, q: vec3<f32>) -> vec4<f32> {
  return abs(view.view_projection[0]) * q.x + abs(view.view_projection[1]) * q.y + abs(view.view_projection[2]) * q.z +
    abs(view.view_projection[3]);
}

fn height_size(view: ShadowView, q: vec3<f32>) -> f32 {
  return dot_3(abs(view.near_plane.xyz), q) + abs(view.near_plane.w);
}

fn pyramid_planes(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> PyramidPlanes {
  let s = light_side(light);
  let v = corner(view, light, position);
  let q = abs(placed(view, position));
  let size = clip_size(view, q);
  let height = height_size(view, q);
  let xy = s * (v.near.xy * light.height - light.clip.xy * v.height);
  let w = s * view.near_w * (light.height - light.light.w * v.height);
  let xy_size = size.xy * abs(light.height) + abs(light.clip.xy) * height;
  let w_size = view.near_w * (abs(light.height) + light.light.w * height);
  return PyramidPlanes(
    vec4<f32>(w + xy.x, w - xy.x, w + xy.y, w - xy.y),
    w_size + vec4<f32>(xy_size.xx, xy_size.yy),
    s * v.height,
    height,
  );
}
