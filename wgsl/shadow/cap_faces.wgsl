// Cap faces: vertex shaders that draw caps, the faces that close shadow volumes, in the caller's render pass, by the indirect
// draws that `shadow_arguments` made of the lists of `caps`; an instance is a face. A light cap is a face at its place. A dark
// cap is the face at the far end of the volume. A near cap is the part of a face between light and near plane, projected from the
// light onto that plane. z-fail draws light and dark caps; ZP+ draws near caps beside the sides of z-pass. z-pass and ZP+ also
// draw light caps of casters that are not in the depth buffer. z-pass also draws dark caps where volumes end; volumes that ZP+
// counts do not end. Light and dark caps have the same lists. If lists overflowed, each face of the group is an instance and is
// tested here. Corners keep their order, since depths of light caps must be those of the surface.

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/lists
#import shadow/shadow
#import shadow/vertices

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: SeenLight; // The light and view of the draw.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read> positions: array<u32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;
@group(1) @binding(2) var<storage, read> facing_masks: array<u32>;
@group(1) @binding(3) var<storage, read> excluded_masks: array<u32>;
@group(1) @binding(4) var<storage, read> caps_listed: array<u32>;
// The list of cap faces that is drawn: near caps counted on their front (0) or back (1), light and dark caps likewise (2, 3).
override CAP_KIND: u32 = 0u;

// A face, and what its caster sees.
struct Cap {
  valid: bool,
  corners: vec3<u32>,
  caster: u32,
  view: ShadowView,
  light: ShadowLight,
}

// An instance is an entry of the list. If the lists overflowed, every face slot is an instance, and those that do not belong to
// the list are not valid, by the tests with which `caps` listed, but one: faces that miss the pyramid of light and near rectangle
// stay among near caps, and their caps are off the picture or without area.
fn cap_of(instance: u32) -> Cap {
  let bit = draw.light - draw.first_light;
  let pair = CAP_KIND & FAR;
  let overflowed = caps_listed[4u * bit + pair] + caps_listed[4u * bit + pair + 1u] > cap_capacity(CAP_KIND);
  var slot = instance;
  if (!overflowed) {
    slot = caps_listed[cap_place(bit, CAP_KIND, instance)];
  }
  var own: Cap;
  own.caster = caster_of(shape.face_chunks_at, slot);
  own.view = view_of(own.caster, seen.view);
  own.light = light_of(own.caster, seen.light, draw.light);
  own.valid = is_counted(own.caster, draw.count_batch);
  let run = face_run(own.caster);
  let face = run.z + slot - run.x;
  own.corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
  if (overflowed || has_measures() || shape.proxies != 0u) {
    own.light = chosen_light(own.caster, own.light, draw.light, draw.view);
  }
  if (overflowed) {
    let corners = own.corners;
    let facing = ((facing_masks[slot] >> bit) & 1u) != 0u;
    let flags = caster_flags(own.caster);
    let mirrored = (flags & MIRRORED) != 0u;
    let is_excluded = own.light.excludes != 0u && ((excluded_masks[slot] >> bit) & 1u) != 0u;
    var is_of_kind = has_near_cap(own.light) && near_kind(own.light, facing, mirrored) == CAP_KIND;
    if (CAP_KIND >= FAR) {
      is_of_kind = has_far_caps(own.light, flags) && far_kind(facing, mirrored) == CAP_KIND;
    }
    own.valid = own.valid && slot - run.x < run.y && casts(own.light, facing) && !is_excluded && is_of_kind &&
      corners.x != corners.y && corners.y != corners.z && corners.z != corners.x &&
      is_finite(vertex_position(own.caster, corners.x)) && is_finite(vertex_position(own.caster, corners.y)) &&
      is_finite(vertex_position(own.caster, corners.z));
  }
  return own;
}

// For z-fail. It is not trimmed: its depths must be those of the surface, bit for bit.
@vertex fn light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = cap_of(instance);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return VolumeVertex(to_clip(own.view, vertex_position(own.caster, own.corners[vertex])));
}

fn face_of(own: Cap) -> CapFace {
  return CapFace(
    vertex_position(own.caster, own.corners.x),
    vertex_position(own.caster, own.corners.y),
    vertex_position(own.caster, own.corners.z),
    own.corners,
  );
}

// For z-pass and ZP+: the light cap of a caster that is not in the depth buffer. Others have none.
@vertex fn seen_light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = cap_of(instance);
  if (!own.valid || (caster_flags(own.caster) & PROXY) == 0u) {
    return VolumeVertex(NOTHING);
  }
  return drawn_light_cap(own.view, own.light, face_of(own), has_near_cap(own.light), vertex);
}

@vertex fn dark_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = cap_of(instance);
  // Lists also have faces of casters that are not in the depth buffer, and their volume need not end.
  let is_endless = shape.proxies != 0u && own.light.counting != COUNT_Z_FAIL && own.light.end == 0.0;
  if (!own.valid || is_endless) {
    return VolumeVertex(NOTHING);
  }
  return drawn_dark_cap(own.view, own.light, face_of(own), vertex);
}

@vertex fn near_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = cap_of(instance);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return drawn_near_cap(own.view, own.light, face_of(own), vertex);
}

// The near cap as published: the face transformed by the matrix of the light's frustum. The hardware clips it.
@vertex fn zp_plus_2005_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = cap_of(instance);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return VolumeVertex(frustum_to_clip(own.view, own.light, vertex_position(own.caster, own.corners[vertex])));
}

// For passes with colour attachments, which are not changed.
@fragment fn nothing() {}
