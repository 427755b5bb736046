// Stage `caps`: lists the faces whose caps are drawn, for each light of a batch (up to 32 lights), in a view. A light cap
// is a face, a dark cap is the same face at the far end of the volume. A near cap is the part of a face between light and
// near plane, projected from the light onto that plane. The near rectangle is what the camera sees of the near plane.
// Dispatched after `counting_methods` and `zp_plus_2005_cases` for each group of casters, light batch and view; eight
// invocations share a chunk of 64 face slots. Reads: choices, positions, facing masks, excluded masks. Excluded faces have
// no caps. Writes: dirty lists, which `relist` emptied, in arbitrary order, for `shadow_arguments` and `cap_faces`;
// CHOICE_LISTED_NEAR_CAP of casters with near caps, for which later stages clip sides. Culling may list a face without a
// near cap, and never drops one with a near cap.
// docs/numerics/shadow-volumes.md, "Closed volumes" and "Slack of culling".

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/culling
#import shadow/draw_lists
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> view_lights: array<ViewLight>; // For each view all lights.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var<storage, read> faces: array<u32>;
@group(0) @binding(6) var<storage, read> facing_masks: array<u32>;
@group(0) @binding(7) var<storage, read> excluded_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> choices: array<atomic<u32>>;
// Four counts for each of 32 lights, then the lists (draw_lists.wgsl).
@group(0) @binding(9) var<storage, read_write> caps_listed: array<atomic<u32>>;

// Whether all three corners are certainly outside one plane of the pyramid of light and near rectangle.
fn is_outside_pyramid(view: ShadowView, light: ShadowLight, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> bool {
  let p = pyramid_planes(view, light, a);
  let q = pyramid_planes(view, light, b);
  let r = pyramid_planes(view, light, c);
  let outside = are_negative(p.side_heights, p.side_terms) & are_negative(q.side_heights, q.side_terms) &
    are_negative(r.side_heights, r.side_terms);
  let outside_near = is_negative(p.depth, p.depth_terms) && is_negative(q.depth, q.depth_terms) &&
    is_negative(r.depth, r.depth_terms);
  return any(outside) || outside_near;
}

// The choices for a caster.
struct CapChoices {
  words: vec4<u32>, // CHOICE_CASTS, CHOICE_EVERY_FACE and CHOICE_NEAR_CAP. The fourth word is 0.
  excludes: u32, // CHOICE_EXCLUDES.
  lights: u32, // The lights for which faces of the caster may have caps that are to be listed.
  flags: u32, // The flags of the caster.
}

// The lights whose lists must be made again.
fn load_dirty_lights() -> u32 {
  return atomicLoad(
    &choices[CHOICE_WORDS * choice_index(shape.first_caster, draw.first_light / 32u, draw.view) + CHOICE_DIRTY]);
}

fn load_choices(caster: u32) -> CapChoices {
  let offset = CHOICE_WORDS * choice_index(caster, draw.first_light / 32u, draw.view);
  var result: CapChoices;
  for (var word = 0u; word < 3u; word++) {
    result.words[word] = atomicLoad(&choices[offset + word]);
  }
  result.excludes = atomicLoad(&choices[offset + CHOICE_EXCLUDES]);
  result.flags = caster_flags(caster);
  // Whether light and dark caps are possible. If not, only lights with CHOICE_NEAR_CAP can have caps. `has_far_caps` decides
  // for each light.
  let can_have_far_caps = shape.counting == COUNT_Z_FAIL || shape.counting == COUNT_ZP_PLUS_2005 ||
    shape.end_at_range != 0u || (result.flags & PROXY) != 0u;
  result.lights = result.words[CHOICE_CASTS] & select(result.words[CHOICE_NEAR_CAP], 0xffffffffu, can_have_far_caps) &
    load_dirty_lights();
  return result;
}

// The end of the caster's volume: `ShadowLight::end`. 0: at infinity.
fn load_volume_end(caster: u32, light_index: u32) -> f32 {
  if (!has_measures()) {
    return 0.0;
  }
  let measures_offset = CHOICE_WORDS * shape.views * shape.batches * shape.casters;
  return bitcast<f32>(atomicLoad(&choices[measures_offset + 2u * measure_index(caster, light_index, draw.view)]));
}

// Appends a face to a list of a light. Two lists share a range, from both ends. If it overflows, only the counts are right,
// and the vertex shaders test all faces.
fn list_cap(bit: u32, kind: u32, slot: u32) {
  let entry = atomicAdd(&caps_listed[4u * bit + kind], 1u);
  if (entry < cap_capacity(kind)) {
    atomicStore(&caps_listed[cap_entry_offset(bit, kind, entry)], slot);
  }
}

// Lists the caps of a face for all lights of `caster_choices` for which it casts.
fn list_face(caster: u32, slot: u32, caster_choices: CapChoices) {
  let first_corner = 3u * (face_range(caster).z + slot - face_range(caster).x);
  let corners = vec3<u32>(faces[first_corner], faces[first_corner + 1u], faces[first_corner + 2u]);
  let a = vertex_position(caster, corners.x);
  let b = vertex_position(caster, corners.y);
  let c = vertex_position(caster, corners.z);
  let is_degenerate = corners.x == corners.y || corners.y == corners.z || corners.z == corners.x;
  if (is_degenerate || !is_finite(a) || !is_finite(b) || !is_finite(c)) {
    return;
  }
  let facing_mask = facing_masks[slot];
  let excluded_mask = excluded_masks[slot] & caster_choices.excludes;
  let is_mirrored = (caster_choices.flags & MIRRORED) != 0u;
  // Turns: 32.
  for (var remaining = caster_choices.lights & ~excluded_mask; remaining != 0u; remaining &= remaining - 1u) {
    let bit = firstTrailingBit(remaining);
    let light_index = draw.first_light + bit;
    let caster_light = light_for_caster(caster, view_lights[draw.view * shape.lights + light_index].light, light_index);
    var light = with_choices(
      caster_light, bit, caster_choices.words, caster_choices.excludes, caster_choices.words[CHOICE_NEAR_CAP]);
    light.end = load_volume_end(caster, light_index);
    let is_front_facing = ((facing_mask >> bit) & 1u) != 0u;
    if (!is_casting_face(light, is_front_facing)) {
      continue;
    }
    if (has_far_caps(light, caster_choices.flags)) {
      list_cap(bit, far_cap_kind(is_front_facing, is_mirrored), slot);
    }
    var can_have_near_cap = has_near_cap(light);
    if (light.counting == COUNT_ZP_PLUS) {
      let view = view_for_caster(caster, view_lights[draw.view * shape.lights + light_index].view);
      can_have_near_cap = !is_outside_pyramid(view, light, a, b, c);
    }
    if (can_have_near_cap) {
      list_cap(bit, near_cap_kind(light, is_front_facing, is_mirrored), slot);
      let offset = CHOICE_WORDS * choice_index(caster, draw.first_light / 32u, draw.view);
      atomicOr(&choices[offset + CHOICE_LISTED_NEAR_CAP], 1u << bit);
    }
  }
}

@compute @workgroup_size(256)
fn caps(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  if (load_dirty_lights() == 0u) {
    return;
  }
  // An item is a share of a chunk: each LANES-th slot.
  // Turns: ITEMS.
  for (var item = id.x; item < shape.faces / CHUNK * LANES; item += 256u * groups.x) {
    let first = item / LANES * CHUNK;
    let caster = caster_of_slot(shape.face_chunks_offset, first);
    let caster_choices = load_choices(caster);
    if (caster_choices.lights != 0u) {
      let end = min(first + CHUNK, face_range(caster).x + face_range(caster).y);
      // Turns: CHUNK / LANES.
      for (var slot = first + item % LANES; slot < end; slot += LANES) {
        list_face(caster, slot, caster_choices);
      }
    }
  }
}
