// Relist: a compute stage, for scenes, that finds the lights of a group of casters whose lists of sides and caps for a view
// must be made anew, because the silhouettes, the camera or its receivers changed since, and empties these lists; the others
// are drawn as they are. Dispatched before `bounds`, one workgroup for each group, batch of up to 32 lights and view, an
// invocation a light. It compares the encodes that made the silhouettes (`kept`) and the camera's version, which is new for
// other receivers, too, with `listed`, what the lists were made from, which it then updates; both lie on the GPU, so an
// encoder that was dropped spoils nothing. It writes the bits FRESH of the choices, for `bounds`, `choose`, `caps` and
// `list_sides`, and takes back what the choices said of exclusion. docs/numerics/scene.md, "Cached results".

#import shadow/choices
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: array<SeenLight>;
// The versions of what was extracted, with the encodes that made the silhouettes: `shape.lists_at`.
@group(0) @binding(3) var<storage, read> kept: array<u32>;
// For each group, batch and view the encode that made the silhouettes of each light, and the version of the camera.
@group(0) @binding(4) var<storage, read_write> listed: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> choices: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> sides: array<u32>;
@group(0) @binding(7) var<storage, read_write> caps_listed: array<u32>;
@group(0) @binding(8) var<storage, read_write> shadow_statistics: ShadowStatistics;
var<workgroup> fresh: atomic<u32>;

@compute @workgroup_size(32)
fn relist(@builtin(local_invocation_index) bit: u32) {
  if (bit == 0u) {
    atomicStore(&fresh, 0u);
  }
  workgroupBarrier();
  let entry = draw.view * shape.lights + draw.first_light + bit;
  let made_from = vec2<u32>(kept[shape.lists_at + bit], seen[entry].version.x);
  let at = 32u * (shape.part * shape.views + draw.view) + bit;
  if (shape.keeps == 0u || any(listed[at] != made_from)) {
    atomicOr(&fresh, 1u << bit);
    listed[at] = made_from;
    sides[2u * bit] = 0u;
    sides[2u * bit + 1u] = 0u;
    // Turns: 4.
    for (var kind = 0u; kind < 4u; kind++) {
      caps_listed[4u * bit + kind] = 0u;
    }
  } else if (any(seen[entry].light.light != vec4<f32>(0.0))) {
    atomicAdd(&shadow_statistics.kept_lists, 1u);
  }
  workgroupBarrier();
  if (bit == 0u) {
    let first = CHOICE_WORDS * choices_of(shape.first_caster, draw.first_light / 32u, draw.view);
    let mask = atomicLoad(&fresh);
    atomicStore(&choices[first + FRESH], mask);
    atomicAnd(&choices[first + MAY_EXCLUDE], ~mask);
    atomicAnd(&choices[first + DOES_EXCLUDE], ~mask);
  }
}
