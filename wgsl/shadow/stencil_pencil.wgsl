// Stage `stencil_pencil`: chooses a pencil of half planes for each light and view, from which `stencil_bound` bounds
// stencil counts (shadow/half_plane_bins.wgsl).
// Dispatched after `shadow_arguments`, if the caller asks for a bound: a workgroup for each light and view, whose
// invocations share all casters.
// Reads: choices, and boxes of the casters that cast for the light and view.
// Writes: the pencil; ALL_FACES and AXIS_FACES of its rows, which must be zeros before. `stencil_crossings` and
// `piece_crossings` add to the same rows.
// Tests of boxes have slack, so no caster that the axis meets is missed. docs/numerics/receivers.md, "Bound on counts".

#import common/order_keys
#import shadow/caster
#import shadow/choices
#import shadow/half_plane_bins
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape; // The first group's: read only what all share.
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> view_lights: array<ViewLight>; // For each view all lights.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> boxes: array<u32>;
@group(0) @binding(5) var<storage, read_write> pencils: array<StencilPencil>;
@group(0) @binding(6) var<storage, read_write> bin_rows: array<atomic<u32>>; // The rows of all pencils.
const THREADS: u32 = 256u;
// The world-space box around all casters that cast: keys of the lowest corner, inverted, then of the highest. Keys are
// integers with the order of floats.
var<workgroup> box_keys: array<atomic<u32>, 6>;
// For each coordinate axis: the faces of all casters that the line through the light, parallel to this axis, may meet.
var<workgroup> axis_faces: array<atomic<u32>, 3>;

fn is_casting(caster: u32, light_index: u32, view: u32) -> bool {
  return ((choice_part(caster, light_index / 32u, view, 0u)[CHOICE_CASTS] >> (light_index % 32u)) & 1u) != 0u;
}

// The pencil of a light at infinity, or of one outside the box around all casters that cast. If the light may be in the box,
// only the kind, PENCIL_AROUND, and the position have a meaning.
fn pencil_of_outer_light(light: vec4<f32>, low: vec3<f32>, high: vec3<f32>) -> StencilPencil {
  var pencil = StencilPencil();
  pencil.forward = -light.xyz;
  pencil.kind = PENCIL_PARALLEL;
  if (light.w > 0.0) {
    pencil.light_position = light.xyz / light.w;
    pencil.forward = clamp(pencil.light_position, low, high) - pencil.light_position;
    pencil.kind = PENCIL_FAN;
  }
  let size = max(max(abs(pencil.forward.x), abs(pencil.forward.y)), abs(pencil.forward.z));
  if (pencil.kind == PENCIL_FAN && size <= box_slack(pencil.light_position, low, high)) {
    pencil.kind = PENCIL_AROUND;
    return pencil;
  }
  pencil.forward = pencil.forward / size;
  // `aside` is at right angles to `forward` and to the coordinate axis along which `forward` is smallest. The axis of the
  // pencil is at right angles to both.
  let a = abs(pencil.forward);
  pencil.aside = vec3<f32>(0.0, pencil.forward.z, -pencil.forward.y);
  if (a.y <= a.x && a.y <= a.z) {
    pencil.aside = vec3<f32>(-pencil.forward.z, 0.0, pencil.forward.x);
  } else if (a.z <= a.x) {
    pencil.aside = vec3<f32>(pencil.forward.y, -pencil.forward.x, 0.0);
  }
  pencil.first_key = half_plane_key(pencil, low);
  var last = pencil.first_key;
  for (var index = 1u; index < 8u; index++) {
    let key = half_plane_key(pencil, box_corner(low, high, index));
    pencil.first_key = min(pencil.first_key, key);
    last = max(last, key);
  }
  pencil.bins_per_key = f32(BINS) / max(last - pencil.first_key, 1e-30);
  return pencil;
}

// The pencil around the parallel to a coordinate axis that may meet the fewest faces.
fn pencil_around_axis(light_position: vec3<f32>) -> StencilPencil {
  let faces = vec3<u32>(atomicLoad(&axis_faces[0]), atomicLoad(&axis_faces[1]), atomicLoad(&axis_faces[2]));
  var pencil = StencilPencil();
  pencil.light_position = light_position;
  pencil.kind = PENCIL_AROUND;
  pencil.bins_per_key = f32(BINS) / 4.0;
  if (faces.y <= faces.x && faces.y <= faces.z) {
    pencil.forward.z = 1.0;
    pencil.aside.x = 1.0;
  } else if (faces.z <= faces.x) {
    pencil.forward.x = 1.0;
    pencil.aside.y = 1.0;
  } else {
    pencil.forward.y = 1.0;
    pencil.aside.z = 1.0;
  }
  return pencil;
}

@compute @workgroup_size(THREADS)
fn stencil_pencil(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
  let light_index = draw.first_light + group.x;
  let view = draw.view;
  // Turns: PENCIL_CASTERS.
  for (var caster = thread; caster < shape.casters; caster += THREADS) {
    if (is_casting(caster, light_index, view)) {
      let world_box = caster_world_box(caster);
      let lowest = ~order_keys(bitcast<vec3<u32>>(world_box.low));
      let highest = order_keys(bitcast<vec3<u32>>(world_box.high));
      atomicMax(&box_keys[0], lowest.x);
      atomicMax(&box_keys[1], lowest.y);
      atomicMax(&box_keys[2], lowest.z);
      atomicMax(&box_keys[3], highest.x);
      atomicMax(&box_keys[4], highest.y);
      atomicMax(&box_keys[5], highest.z);
      let row = row_offset(view, light_index, caster % shape.count_batches);
      atomicAdd(&bin_rows[row + ALL_FACES], face_range(caster).y);
    }
  }
  workgroupBarrier();
  let low = floats_of_keys(~vec3<u32>(atomicLoad(&box_keys[0]), atomicLoad(&box_keys[1]), atomicLoad(&box_keys[2])));
  let high = floats_of_keys(vec3<u32>(atomicLoad(&box_keys[3]), atomicLoad(&box_keys[4]), atomicLoad(&box_keys[5])));
  // If no caster casts, the box has no meaning, and no bin gets a weight.
  var pencil = pencil_of_outer_light(view_lights[view * shape.lights + light_index].light.light, low, high);
  // Turns: PENCIL_CASTERS.
  for (var caster = thread; pencil.kind == PENCIL_AROUND && caster < shape.casters; caster += THREADS) {
    if (is_casting(caster, light_index, view)) {
      let world_box = caster_world_box(caster);
      let faces = face_range(caster).y;
      atomicAdd(&axis_faces[0], select(0u, faces, can_axis_meet_box(pencil.light_position, 0u, world_box.low, world_box.high)));
      atomicAdd(&axis_faces[1], select(0u, faces, can_axis_meet_box(pencil.light_position, 1u, world_box.low, world_box.high)));
      atomicAdd(&axis_faces[2], select(0u, faces, can_axis_meet_box(pencil.light_position, 2u, world_box.low, world_box.high)));
    }
  }
  workgroupBarrier();
  if (pencil.kind == PENCIL_AROUND) {
    pencil = pencil_around_axis(pencil.light_position);
  }
  let axis = axis_of_pencil(pencil);
  // Turns: PENCIL_CASTERS.
  for (var caster = thread; pencil.kind == PENCIL_AROUND && caster < shape.casters; caster += THREADS) {
    if (is_casting(caster, light_index, view)) {
      let world_box = caster_world_box(caster);
      if (can_axis_meet_box(pencil.light_position, axis, world_box.low, world_box.high)) {
        let row = row_offset(view, light_index, caster % shape.count_batches);
        atomicAdd(&bin_rows[row + AXIS_FACES], face_range(caster).y);
      }
    }
  }
  if (thread == 0u) {
    pencils[view * shape.lights + light_index] = pencil;
  }
}
