// Caps: lists of the faces that caps are drawn from. With ZP+ those between light and near rectangle; with z-fail, the
// published ZP+, and where volumes end at the range, every face that casts. Each light has two lists: of faces whose cap
// counts up on its front, and of faces whose cap counts up on its back. Excluded faces have no caps.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> view: ShadowView;
// The first light of this batch.
@group(0) @binding(2) var<uniform> draw: ShadowDraw;
@group(0) @binding(3) var<storage, read> positions: array<u32>;
@group(0) @binding(4) var<storage, read> faces: array<u32>;
@group(0) @binding(5) var<storage, read> facing_masks: array<u32>;
@group(0) @binding(6) var<storage, read> shadow_lights: array<ShadowLight>;
@group(0) @binding(7) var<storage, read_write> cap_counts: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> cap_list: array<u32>;
@group(0) @binding(9) var<storage, read> excluded_masks: array<u32>;

// Whether all three corners are outside one of the pyramid's planes.
fn misses_pyramid(light: ShadowLight, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> bool {
  let p = pyramid_planes(view, light, a);
  let q = pyramid_planes(view, light, b);
  let r = pyramid_planes(view, light, c);
  let out = (p.value < -SLACK * p.size) & (q.value < -SLACK * q.size) & (r.value < -SLACK * r.size);
  let beyond = p.depth < -SLACK * p.depth_size && q.depth < -SLACK * q.depth_size && r.depth < -SLACK * r.depth_size;
  return any(out) || beyond;
}

fn append(index: u32, kind: u32, face: u32) {
  let place = atomicAdd(&cap_counts[LISTS * (draw.first_light + index) + kind], 1u);
  if (place < shape.cap_capacity) {
    cap_list[list_begin(index, kind, shape.cap_capacity) + place] = face;
  }
}

fn list_for(index: u32, face: u32, facing: bool, excluded: bool, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) {
  let light = shadow_lights[draw.first_light + index];
  if (!casts(light, facing) || (light.excludes != 0u && excluded)) {
    return;
  }
  if ((light.counting == COUNT_Z_PASS && light.end == 0.0) || (light.counting == COUNT_ZP_PLUS && misses_pyramid(light, a, b, c))) {
    return;
  }
  append(index, cap_class(light, facing), face);
}

@compute @workgroup_size(256)
fn caps(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  for (var face = id.x; face < shape.faces; face += 256u * groups.x) {
    let corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
    let a = caster_position(corners.x);
    let b = caster_position(corners.y);
    let c = caster_position(corners.z);
    let is_degenerate = corners.x == corners.y || corners.y == corners.z || corners.z == corners.x;
    if (!is_degenerate && is_finite(a) && is_finite(b) && is_finite(c)) {
      let mask = facing_masks[face];
      let excluded = excluded_masks[face];
      let lights = min(shape.lights - draw.first_light, 32u);
      for (var light = 0u; light < lights; light++) {
        list_for(light, face, ((mask >> light) & 1u) != 0u, ((excluded >> light) & 1u) != 0u, a, b, c);
      }
    }
  }
}
