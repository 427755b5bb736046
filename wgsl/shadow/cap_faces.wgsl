// Vertex shaders of caps, the faces that close shadow volumes, in the caller's render pass. The indirect draws of
// `shadow_arguments` have an instance for each entry of a list of `caps`. If the two lists of a range overflowed, the draw of
// each that is not empty has an instance for each face slot of the group, and the shader decides whether it is drawn. Casters
// of other count batches are never drawn. The first three read the lists of light and dark caps, the others those of near
// caps. `seen_light_cap` is a strip of four vertices, `near_cap` one of five; the others are lists of triangles.
// * `light_cap`, `dark_cap`: a face, and the same face at the far end of the volume. z-fail draws both. If volumes may end
//   at the range, z-pass draws dark caps of those that end. Volumes that ZP+ counts do not end.
// * `seen_light_cap`: the light cap of a caster that is not in the depth buffer, for z-pass and ZP+.
// * `near_cap`: the part of a face between light and near plane, projected from the light onto that plane. ZP+ draws it.
// * `zp_plus_2005_cap`: the near cap of ZP+ as published in 2005.
// Corners keep the order of the face, so that `light_cap` has the depths of the surface. docs/numerics/shadow-volumes.md.

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/draw_lists
#import shadow/shadow
#import shadow/vertices

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> view_light: ViewLight; // The light and view of the draw.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read> positions: array<u32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;
@group(1) @binding(2) var<storage, read> facing_masks: array<u32>;
@group(1) @binding(3) var<storage, read> excluded_masks: array<u32>;
@group(1) @binding(4) var<storage, read> caps_listed: array<u32>;
override CAP_KIND: u32 = 0u; // The kind of the list that is drawn (shadow/draw_lists.wgsl).

// The face of an instance, and view and light for its caster.
struct CapInstance {
  is_drawn: bool,
  corners: vec3<u32>, // Vertex indices.
  caster: u32,
  view: ShadowView,
  light: ShadowLight, // It has the choices for the caster only if `load_cap` needs them.
}

// The cap of an instance in the draw of list CAP_KIND. If the lists overflowed, it repeats the tests of `caps` but one:
// if a caster has near caps, those of its faces outside the pyramid of light and near rectangle are drawn, too. They lie
// outside the picture or have no area.
fn load_cap(instance: u32) -> CapInstance {
  let bit = draw.light - draw.first_light;
  let first_kind = CAP_KIND & FAR_CAPS;
  let is_overflowed = caps_listed[4u * bit + first_kind] + caps_listed[4u * bit + first_kind + 1u] > cap_capacity(CAP_KIND);
  var slot = instance;
  if (!is_overflowed) {
    slot = caps_listed[cap_entry_offset(bit, CAP_KIND, instance)];
  }
  var result: CapInstance;
  result.caster = caster_of_slot(shape.face_chunks_offset, slot);
  result.view = view_for_caster(result.caster, view_light.view);
  result.light = light_for_caster(result.caster, view_light.light, draw.light);
  result.is_drawn = is_in_count_batch(result.caster, draw.count_batch);
  let range = face_range(result.caster);
  let face = range.z + slot - range.x;
  result.corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
  // If none holds, the volume has no end, and the draws of listed caps do not read the other choices.
  if (is_overflowed || has_measures() || shape.proxies != 0u) {
    result.light = with_stored_choices(result.caster, result.light, draw.light, draw.view);
  }
  if (is_overflowed) {
    let corners = result.corners;
    let is_front_facing = ((facing_masks[slot] >> bit) & 1u) != 0u;
    let flags = caster_flags(result.caster);
    let is_mirrored = (flags & MIRRORED) != 0u;
    let is_excluded = result.light.excludes != 0u && ((excluded_masks[slot] >> bit) & 1u) != 0u;
    var is_of_kind = has_near_cap(result.light) && near_cap_kind(result.light, is_front_facing, is_mirrored) == CAP_KIND;
    if (CAP_KIND >= FAR_CAPS) {
      is_of_kind = has_far_caps(result.light, flags) && far_cap_kind(is_front_facing, is_mirrored) == CAP_KIND;
    }
    result.is_drawn = result.is_drawn && slot - range.x < range.y && is_casting_face(result.light, is_front_facing) &&
      !is_excluded && is_of_kind &&
      corners.x != corners.y && corners.y != corners.z && corners.z != corners.x &&
      is_finite(vertex_position(result.caster, corners.x)) && is_finite(vertex_position(result.caster, corners.y)) &&
      is_finite(vertex_position(result.caster, corners.z));
  }
  return result;
}

// For z-fail. TRIM does not cut it at the frustum, because it must have the depths of the surface, bit for bit.
@vertex fn light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let cap = load_cap(instance);
  if (!cap.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return VolumeVertex(to_clip(cap.view, vertex_position(cap.caster, cap.corners[vertex])));
}

fn face_of_cap(cap: CapInstance) -> CapFace {
  return CapFace(
    vertex_position(cap.caster, cap.corners.x),
    vertex_position(cap.caster, cap.corners.y),
    vertex_position(cap.caster, cap.corners.z),
    cap.corners,
  );
}

// For z-pass and ZP+. Light caps of casters in the depth buffer are not drawn.
@vertex fn seen_light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let cap = load_cap(instance);
  if (!cap.is_drawn || (caster_flags(cap.caster) & PROXY) == 0u) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_light_cap(cap.view, cap.light, face_of_cap(cap), has_near_cap(cap.light), vertex);
}

@vertex fn dark_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let cap = load_cap(instance);
  // The lists also have faces of casters that are not in the depth buffer, whose volumes may go to infinity.
  let is_endless = shape.proxies != 0u && cap.light.counting != COUNT_Z_FAIL && cap.light.end == 0.0;
  if (!cap.is_drawn || is_endless) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_dark_cap(cap.view, cap.light, face_of_cap(cap), vertex);
}

@vertex fn near_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let cap = load_cap(instance);
  if (!cap.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_near_cap(cap.view, cap.light, face_of_cap(cap), vertex);
}

// The face transformed by the matrix of the light's frustum. The hardware clips it.
@vertex fn zp_plus_2005_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let cap = load_cap(instance);
  if (!cap.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return VolumeVertex(frustum_to_clip(cap.view, cap.light, vertex_position(cap.caster, cap.corners[vertex])));
}

// Writes nothing, for passes with colour attachments.
@fragment fn nothing() {}
