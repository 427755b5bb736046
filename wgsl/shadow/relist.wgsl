// Stage `relist`: finds the lights whose lists of sides and caps are dirty, for a group of casters and a view, and
// empties these lists. A list is dirty if the silhouettes, the camera or its receivers changed. All other lists are
// cached and drawn again. The lists of lights that the view leaves out are empty and never dirty.
// Dispatched before `bounds`, one workgroup for each group, light batch (up to 32 lights) and view; an invocation is a
// light.
// Reads: the encodes that made the silhouettes (`cache`), and the camera's version, which also changes with the receivers.
// Writes: `list_versions`, the versions from which lists are made; CHOICE_DIRTY, for `bounds`, `counting_methods`, `caps` and
// `list_sides`. It clears CHOICE_MAY_EXCLUDE and CHOICE_DOES_EXCLUDE of dirty lights, no choice of a caster.
// Versions are on the GPU beside the lists, so an encoder that is dropped changes neither. docs/numerics/scene.md,
// "Cached results".

#import shadow/choices
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> view_lights: array<ViewLight>; // For each view all lights.
// Versions of the scene. A version is the number of an encode, a call of `Scene::encode`. From `shape.lists_offset` on it
// has the encode that made the silhouette list of each light of the batch.
@group(0) @binding(3) var<storage, read> cache: array<u32>;
// For each group, batch, view and light what its lists were made from. x: the encode of its silhouettes. y: the camera's
// version.
@group(0) @binding(4) var<storage, read_write> list_versions: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> choices: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> sides: array<u32>;
@group(0) @binding(7) var<storage, read_write> caps_listed: array<u32>;
@group(0) @binding(8) var<storage, read_write> shadow_statistics: ShadowStatistics;
var<workgroup> dirty_lights: atomic<u32>;

@compute @workgroup_size(32)
fn relist(@builtin(local_invocation_index) bit: u32) {
  if (bit == 0u) {
    atomicStore(&dirty_lights, 0u);
  }
  workgroupBarrier();
  let entry = draw.view * shape.lights + draw.first_light + bit;
  let versions = vec2<u32>(cache[shape.lists_offset + bit], view_lights[entry].version.x);
  let index = 32u * (shape.group_and_batch * shape.views + draw.view) + bit;
  if (shape.uses_cache == 0u || any(list_versions[index] != versions)) {
    // Entries of lights that the view leaves out are zeros.
    atomicOr(&dirty_lights, select(0u, 1u << bit, view_lights[entry].view.near_w != 0.0));
    list_versions[index] = versions;
    sides[2u * bit] = 0u;
    sides[2u * bit + 1u] = 0u;
    // Turns: 4.
    for (var kind = 0u; kind < 4u; kind++) {
      caps_listed[4u * bit + kind] = 0u;
    }
  } else if (any(view_lights[entry].light.light != vec4<f32>(0.0))) {
    atomicAdd(&shadow_statistics.cached_lists, 1u);
  }
  workgroupBarrier();
  if (bit == 0u) {
    let group_offset = CHOICE_WORDS * choice_index(shape.first_caster, draw.first_light / 32u, draw.view);
    let mask = atomicLoad(&dirty_lights);
    atomicStore(&choices[group_offset + CHOICE_DIRTY], mask);
    atomicAnd(&choices[group_offset + CHOICE_MAY_EXCLUDE], ~mask);
    atomicAnd(&choices[group_offset + CHOICE_DOES_EXCLUDE], ~mask);
  }
}
