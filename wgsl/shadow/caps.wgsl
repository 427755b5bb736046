// Caps: a compute stage that lists the faces whose caps are drawn, for each light of a batch (up to 32 lights, a bit each) in a
// view. Dispatched after `choose` for each group of casters, batch and view; eight invocations share a chunk of 64 face slots.
// `shadow_arguments` makes draws of the lists, and `cap_faces` reads them. Near
// caps, which ZP+ needs, come from faces between light and near rectangle (what the camera sees of the near plane). With z-fail,
// where volumes end at the range, and for casters that are not in the depth buffer, light and dark caps come from every face that
// casts. Excluded faces, those whose plane has the light and those that are not finite, have no caps. It sets CAPPED in the
// choices of casters that have near caps: only their sides are clipped, so a face that may have a near cap must never be left
// out. Lists are in no particular order.

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/lists
#import shadow/shadow
#import shadow/visibility

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: array<SeenLight>;
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var<storage, read> faces: array<u32>;
@group(0) @binding(6) var<storage, read> facing_masks: array<u32>;
@group(0) @binding(7) var<storage, read> excluded_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> choices: array<atomic<u32>>;
// For each light of the batch the numbers of its cap faces of each kind; then the lists.
@group(0) @binding(9) var<storage, read_write> caps_listed: array<atomic<u32>>;

// Whether all three corners are outside one of the pyramid's planes.
fn misses_pyramid(view: ShadowView, light: ShadowLight, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> bool {
  let p = pyramid_planes(view, light, a);
  let q = pyramid_planes(view, light, b);
  let r = pyramid_planes(view, light, c);
  let out = (p.value < -SLACK * p.size) & (q.value < -SLACK * q.size) & (r.value < -SLACK * r.size);
  let beyond = p.depth < -SLACK * p.depth_size && q.depth < -SLACK * q.depth_size && r.depth < -SLACK * r.depth_size;
  return any(out) || beyond;
}

// The choices for a caster: words as in choices.wgsl, bits of the lights that may need caps of its faces, and its flags.
struct Needs {
  first: vec4<u32>, // CASTS, EVERY, NEAR; CAPPED, which this stage writes, is 0.
  excludes: u32,
  lights: u32,
  flags: u32,
}

// The lights whose lists are made anew.
fn fresh_lights() -> u32 {
  return atomicLoad(&choices[CHOICE_WORDS * choices_of(shape.first_caster, draw.first_light / 32u, draw.view) + FRESH]);
}

fn needs_of(caster: u32) -> Needs {
  let at = CHOICE_WORDS * choices_of(caster, draw.first_light / 32u, draw.view);
  var needs: Needs;
  for (var word = 0u; word < 3u; word++) {
    needs.first[word] = atomicLoad(&choices[at + word]);
  }
  needs.excludes = atomicLoad(&choices[at + EXCLUDES]);
  needs.flags = caster_flags(caster);
  // Where a volume ends, it has dark caps. With z-pass each light tells.
  let far = shape.counting == COUNT_Z_FAIL || shape.counting == COUNT_ZP_PLUS_2005 || shape.end_at_range != 0u ||
    (needs.flags & PROXY) != 0u;
  needs.lights = needs.first[CASTS] & select(needs.first[NEAR], 0xffffffffu, far) & fresh_lights();
  return needs;
}

// The end of the caster's volume for light `number`: `ShadowLight::end`.
fn end_of(caster: u32, number: u32) -> f32 {
  if (!has_measures()) {
    return 0.0;
  }
  let before = CHOICE_WORDS * shape.views * shape.batches * shape.casters;
  return bitcast<f32>(atomicLoad(&choices[before + 2u * measures_of(caster, number, draw.view)]));
}

// Appends a face to a list of a light. A list without room counts on.
fn list_cap(bit: u32, kind: u32, slot: u32) {
  let place = atomicAdd(&caps_listed[4u * bit + kind], 1u);
  if (place < cap_capacity(kind)) {
    atomicStore(&caps_listed[cap_place(bit, kind, place)], slot);
  }
}

// Lists the caps of a face, for all lights that need caps of its caster.
fn list_face(caster: u32, slot: u32, needs: Needs) {
  let corners_at = 3u * (face_run(caster).z + slot - face_run(caster).x);
  let corners = vec3<u32>(faces[corners_at], faces[corners_at + 1u], faces[corners_at + 2u]);
  let a = vertex_position(caster, corners.x);
  let b = vertex_position(caster, corners.y);
  let c = vertex_position(caster, corners.z);
  let is_degenerate = corners.x == corners.y || corners.y == corners.z || corners.z == corners.x;
  if (is_degenerate || !is_finite(a) || !is_finite(b) || !is_finite(c)) {
    return;
  }
  let facing_mask = facing_masks[slot];
  let excluded_mask = excluded_masks[slot] & needs.excludes;
  let mirrored = (needs.flags & MIRRORED) != 0u;
  // Turns: 32.
  for (var rest = needs.lights & ~excluded_mask; rest != 0u; rest &= rest - 1u) {
    let bit = firstTrailingBit(rest);
    let number = draw.first_light + bit;
    let own = light_of(caster, seen[draw.view * shape.lights + number].light, number);
    var light = with_choices(own, bit, needs.first, needs.excludes, needs.first[NEAR]);
    light.end = end_of(caster, number);
    let facing = ((facing_mask >> bit) & 1u) != 0u;
    if (!casts(light, facing)) {
      continue;
    }
    if (has_far_caps(light, needs.flags)) {
      list_cap(bit, far_kind(facing, mirrored), slot);
    }
    var is_near = has_near_cap(light);
    if (light.counting == COUNT_ZP_PLUS) {
      let view = view_of(caster, seen[draw.view * shape.lights + number].view);
      is_near = !misses_pyramid(view, light, a, b, c);
    }
    if (is_near) {
      list_cap(bit, near_kind(light, facing, mirrored), slot);
      atomicOr(&choices[CHOICE_WORDS * choices_of(caster, draw.first_light / 32u, draw.view) + CAPPED], 1u << bit);
    }
  }
}

@compute @workgroup_size(256)
fn caps(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  if (fresh_lights() == 0u) {
    return;
  }
  // Invocations share a chunk, and take its slots in turn.
  // Turns: ITEMS.
  for (var item = id.x; item < shape.faces / CHUNK * LANES; item += 256u * groups.x) {
    let first = item / LANES * CHUNK;
    let caster = caster_of(shape.face_chunks_at, first);
    let needs = needs_of(caster);
    if (needs.lights != 0u) {
      let end = min(first + CHUNK, face_run(caster).x + face_run(caster).y);
      // Turns: CHUNK / LANES.
      for (var slot = first + item % LANES; slot < end; slot += LANES) {
        list_face(caster, slot, needs);
      }
    }
  }
}
