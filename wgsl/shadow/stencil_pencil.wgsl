// Stencil pencil: a compute stage that finds for each light and view a pencil, half planes that begin at one line through the
// light (shadow/pencil.wgsl), by which stencil counts are bounded. Dispatched after `shadow_arguments` and only if the caller
// asks for a bound, one workgroup for each light of a batch and view, which shares all casters. It reads choices and the boxes
// of casters that cast for the light and view. It writes the pencil, and into its rows, zeros before, how many faces all of
// these casters have, and those of them that the line may meet. `stencil_crossings` and `piece_crossings` go on from it. Tests
// of boxes have slack: a caster that the line may meet must be found. docs/numerics/receivers.md, "Bound on counts".

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/pencil
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: array<SeenLight>;
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> boxes: array<u32>;
@group(0) @binding(5) var<storage, read_write> pencils: array<StencilPencil>;
@group(0) @binding(6) var<storage, read_write> crossings: array<atomic<u32>>; // The rows of the pencils. They are zeros before.
const THREADS: u32 = 256u;
// The box of all casters that cast, as integers of the same order: the lowest corner, inverted, and the highest.
var<workgroup> corners: array<atomic<u32>, 6>;
// For each coordinate axis through the light how many faces the casters have that it may meet.
var<workgroup> met: array<atomic<u32>, 3>;

fn does_cast(caster: u32, light: u32, view: u32) -> bool {
  return ((choice_part(caster, light / 32u, view, 0u)[CASTS] >> (light % 32u)) & 1u) != 0u;
}

// The pencil of a light that is at infinity or outside the box. Its kind is AROUND if the light is neither.
fn fan(light: vec4<f32>, low: vec3<f32>, high: vec3<f32>) -> StencilPencil {
  var by = StencilPencil();
  by.forward = -light.xyz;
  by.kind = PARALLEL;
  if (light.w > 0.0) {
    by.place = light.xyz / light.w;
    by.forward = clamp(by.place, low, high) - by.place;
    by.kind = FAN;
  }
  let size = max(max(abs(by.forward.x), abs(by.forward.y)), abs(by.forward.z));
  if (by.kind == FAN && size <= box_slack(by.place, low, high)) {
    by.kind = AROUND;
    return by;
  }
  by.forward = by.forward / size;
  // The axis is the coordinate axis that is farthest from `forward`, turned to a right angle with it.
  let a = abs(by.forward);
  by.aside = vec3<f32>(0.0, by.forward.z, -by.forward.y);
  if (a.y <= a.x && a.y <= a.z) {
    by.aside = vec3<f32>(-by.forward.z, 0.0, by.forward.x);
  } else if (a.z <= a.x) {
    by.aside = vec3<f32>(by.forward.y, -by.forward.x, 0.0);
  }
  by.first = half_plane(by, low);
  var last = by.first;
  for (var number = 1u; number < 8u; number++) {
    let at = half_plane(by, box_corner(low, high, number));
    by.first = min(by.first, at);
    last = max(last, at);
  }
  by.scale = f32(BINS) / max(last - by.first, 1e-30);
  return by;
}

// The pencil around the coordinate axis that may meet the fewest faces.
fn around(place: vec3<f32>) -> StencilPencil {
  let faces = vec3<u32>(atomicLoad(&met[0]), atomicLoad(&met[1]), atomicLoad(&met[2]));
  var by = StencilPencil();
  by.place = place;
  by.kind = AROUND;
  by.scale = f32(BINS) / 4.0;
  if (faces.y <= faces.x && faces.y <= faces.z) {
    by.forward.z = 1.0;
    by.aside.x = 1.0;
  } else if (faces.z <= faces.x) {
    by.forward.x = 1.0;
    by.aside.y = 1.0;
  } else {
    by.forward.y = 1.0;
    by.aside.z = 1.0;
  }
  return by;
}

@compute @workgroup_size(THREADS)
fn stencil_pencil(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
  let light = draw.first_light + group.x;
  let view = draw.view;
  // Turns: PENCIL_CASTERS.
  for (var caster = thread; caster < shape.casters; caster += THREADS) {
    if (does_cast(caster, light, view)) {
      let own = world_box(caster);
      let lowest = ~ordered(bitcast<vec3<u32>>(own.low));
      let highest = ordered(bitcast<vec3<u32>>(own.high));
      atomicMax(&corners[0], lowest.x);
      atomicMax(&corners[1], lowest.y);
      atomicMax(&corners[2], lowest.z);
      atomicMax(&corners[3], highest.x);
      atomicMax(&corners[4], highest.y);
      atomicMax(&corners[5], highest.z);
      atomicAdd(&crossings[row_of(view, light, caster % shape.count_batches) + ALL_FACES], face_run(caster).y);
    }
  }
  workgroupBarrier();
  let low = unordered(~vec3<u32>(atomicLoad(&corners[0]), atomicLoad(&corners[1]), atomicLoad(&corners[2])));
  let high = unordered(vec3<u32>(atomicLoad(&corners[3]), atomicLoad(&corners[4]), atomicLoad(&corners[5])));
  // Where nothing casts, the box has no meaning, and nothing is counted.
  var by = fan(seen[view * shape.lights + light].light.light, low, high);
  // Turns: PENCIL_CASTERS.
  for (var caster = thread; by.kind == AROUND && caster < shape.casters; caster += THREADS) {
    if (does_cast(caster, light, view)) {
      let own = world_box(caster);
      let faces = face_run(caster).y;
      atomicAdd(&met[0], select(0u, faces, axis_meets(by.place, 0u, own.low, own.high)));
      atomicAdd(&met[1], select(0u, faces, axis_meets(by.place, 1u, own.low, own.high)));
      atomicAdd(&met[2], select(0u, faces, axis_meets(by.place, 2u, own.low, own.high)));
    }
  }
  workgroupBarrier();
  if (by.kind == AROUND) {
    by = around(by.place);
  }
  let axis = axis_of(by);
  // Turns: PENCIL_CASTERS.
  for (var caster = thread; by.kind == AROUND && caster < shape.casters; caster += THREADS) {
    if (does_cast(caster, light, view)) {
      let own = world_box(caster);
      if (axis_meets(by.place, axis, own.low, own.high)) {
        atomicAdd(&crossings[row_of(view, light, caster % shape.count_batches) + MET_FACES], face_run(caster).y);
      }
    }
  }
  if (thread == 0u) {
    pencils[view * shape.lights + light] = by;
  }
}
