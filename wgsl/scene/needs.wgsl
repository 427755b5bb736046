// Needs: a compute stage that finds which figures of a scene a frame needs, before they are deformed, from boxes that the
// caller states. A figure is a caster (a mesh that throws shadows) whose positions `deform`, or the caller, may compute anew.
// Dispatched if the caller asks for it, before `deform`, an invocation a figure. A frame needs a figure if a camera may see
// it, or its shadow from a light that may reach it; tests have slack, so none that is seen is left out. It writes a word for
// each figure: 0 if it is needed. The words are copied for `deform`, which makes the others a point, and for `reach`, which
// leaves these out. docs/numerics/scene.md, "Deforming casters that a frame needs".

#import common/casters
#import shadow/shadow
#import shadow/visibility

struct NeedsDispatch {
  figures: u32,
  views: u32,
  lights: u32, // Lights of each view, at least 1.
  parts: u32, // Vec4s of each figure.
  all: u32, // 1: every figure is needed.
  // 1: casters that a light's range does not reach, and shadows that a camera cannot see, are skipped.
  skip_unreached: u32,
  skip_unseen: u32,
  reserved: u32,
}

@group(0) @binding(0) var<uniform> frame: NeedsDispatch;
@group(0) @binding(1) var<storage, read> seen: array<SeenLight>;
// For each figure the lowest corner of its box and whether it has one, the highest corner, and the bits of its lights.
@group(0) @binding(2) var<storage, read> figures: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> unneeded: array<u32>; // For each figure 1 if it is not needed, else 2. 0: this stage never ran.

// Whether a camera may see the shadow that its light `number` makes of a box, and the light may reach that. Never false if it
// does.
fn may_shade(view: u32, number: u32, low: vec3<f32>, high: vec3<f32>) -> bool {
  let light = seen[view * frame.lights + number].light;
  let cone = seen[view * frame.lights + number].cone;
  if (frame.skip_unreached != 0u && (is_out_of_range(light, 1.0, low, high) || !may_be_in_cone(cone, low, high, 0.0))) {
    return false;
  }
  return frame.skip_unseen == 0u || !is_volume_outside_view(seen[view * frame.lights + number].view, light, low, high);
}

fn is_needed(figure: u32) -> bool {
  let at = frame.parts * figure;
  let low = bitcast<vec3<f32>>(figures[at].xyz);
  let high = bitcast<vec3<f32>>(figures[at + 1u].xyz);
  if (frame.all != 0u || figures[at].w == 0u) {
    return true;
  }
  // Turns: NEEDS_BOXES / 2.
  for (var view = 0u; view < frame.views; view++) {
    if (!is_box_outside_view(seen[view * frame.lights].view, low, high)) {
      return true;
    }
    // Turns: NEEDS_BOXES in all.
    for (var number = 0u; number < frame.lights; number++) {
      let word = number / 32u;
      let has_light = ((figures[at + 2u + word / 4u][word % 4u] >> (number % 32u)) & 1u) != 0u;
      if (has_light && may_shade(view, number, low, high)) {
        return true;
      }
    }
  }
  return false;
}

@compute @workgroup_size(64)
fn needs(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x < frame.figures) {
    unneeded[id.x] = select(1u, 2u, is_needed(id.x));
  }
}
