// Stage `needs`: finds which deforming casters of a scene, the instances of its models, a frame needs, from the boxes of their
// poses. Dispatched before `deform`, an invocation a caster. A frame needs the caster if a view may see it, or may see its
// shadow from one of its lights that affects it. Tests have slack, so that no caster with a visible surface or shadow is
// culled. The words of `needed_states` are copied for `deform`, which sets all positions of culled casters to (0, 0, 0), and
// for `cull_lights`, which gives them no lights. Claim: docs/numerics/scene.md, "Deforming casters that a frame needs".

#import common/casters
#import shadow/culling
#import shadow/shadow

struct NeedsDispatch {
  casters: u32, // Deforming casters.
  views: u32,
  lights: u32, // Entries of each view in `view_lights`, at least 1.
  parts: u32, // Vec4s of each caster in `deforming_casters`.
  // 1: all are needed. Rust sets it if there are no views, if culling is off, or if there are too many views and lights for
  // NEEDS_BOXES (src/turns.rs).
  all: u32,
  cull_by_range: u32, // 1: lights do not affect casters out of their range or cone.
  cull_by_view: u32, // 1: shadows that the camera cannot see do not count.
  reserved: u32,
}

@group(0) @binding(0) var<uniform> frame: NeedsDispatch;
// For each view an entry for each light up to the last, at least one. All have the view, also for lights that it leaves out
// or that were removed. `version.x` is 1 if it has the light, else 0.
@group(0) @binding(1) var<storage, read> view_lights: array<ViewLight>;
// For each caster: xyz the lowest corner of its box in world space, w 1 if it has a box and 0 if not; xyz the highest corner;
// then the bits of its lights. A caster without a box is needed.
@group(0) @binding(2) var<storage, read> deforming_casters: array<vec4<u32>>;
// For each caster 1 if it is culled, 2 if it is needed. `cull_lights` reads 0 if no encoder with this stage was
// submitted.
@group(0) @binding(3) var<storage, read_write> needed_states: array<u32>;

// Whether a view has light `light_index`, which may affect a box, and its camera may see the shadow of the box. Returns false
// only if this is certainly not so.
fn may_shade(view: u32, light_index: u32, low: vec3<f32>, high: vec3<f32>) -> bool {
  let entry = view * frame.lights + light_index;
  if (view_lights[entry].version.x == 0u) {
    return false;
  }
  let light = view_lights[entry].light;
  let cone = view_lights[entry].cone;
  if (frame.cull_by_range != 0u && (is_out_of_range(light, 1.0, low, high) || !may_be_in_cone(cone, low, high, 0.0))) {
    return false;
  }
  return frame.cull_by_view == 0u ||
    !is_volume_outside_view(view_lights[entry].view, light, low, high);
}

fn is_needed(caster: u32) -> bool {
  let offset = frame.parts * caster;
  let low = bitcast<vec3<f32>>(deforming_casters[offset].xyz);
  let high = bitcast<vec3<f32>>(deforming_casters[offset + 1u].xyz);
  if (frame.all != 0u || deforming_casters[offset].w == 0u) {
    return true;
  }
  // Turns: NEEDS_BOXES / 2.
  for (var view = 0u; view < frame.views; view++) {
    if (!is_box_outside_view(view_lights[view * frame.lights].view, low, high)) {
      return true;
    }
    // Turns: NEEDS_BOXES in all.
    for (var light_index = 0u; light_index < frame.lights; light_index++) {
      let word = light_index / 32u;
      let has_light = ((deforming_casters[offset + 2u + word / 4u][word % 4u] >> (light_index % 32u)) & 1u) != 0u;
      if (has_light && may_shade(view, light_index, low, high)) {
        return true;
      }
    }
  }
  return false;
}

// An invocation takes several casters only where the device does not allow one for each.
@compute @workgroup_size(64)
fn needs(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let row = 64u * groups.x;
  // Turns: 1.
  for (var caster = row * id.y + id.x; caster < frame.casters; caster += row * groups.y) {
    needed_states[caster] = select(1u, 2u, is_needed(caster));
  }
}
