// Reach: finds the lights that matter to each caster, for each batch: those that are allowed, and have the box of a
// rigid caster within their range.

// For each batch and caster the bits of these lights.
@group(0) @binding(3) var<storage, read_write> lit: array<u32>;

// Above this size squares may overflow, and nothing is said.
const TOO_LARGE: f32 = 0x1p60;
// 32 units in the last place. Rounding, division and root add fewer to a distance, relative to the largest coordinate.
const SLACK: f32 = 0x1p-18;

// Whether the light may reach the box. It is never false for a light that does.
fn may_reach(light: vec4<f32>, range: f32, low: vec3<f32>, high: vec3<f32>, scale: f32) -> bool {
  if (range == 0.0 || abs(light.w) < 0x1p-30 || low.x > high.x) {
    return true;
  }
  let point = light.xyz / light.w;
  let sizes = max(max(abs(low), abs(high)), abs(point));
  let size = max(max(sizes.x, sizes.y), sizes.z);
  if (!(size < TOO_LARGE)) {
    return true;
  }
  let apart = point - clamp(point, low, high);
  let distance = sqrt(apart.x * apart.x + apart.y * apart.y + apart.z * apart.z);
  return !(scale * (distance - SLACK * size) > range * (1.0 + SLACK));
}

fn lights_that_matter(caster: u32, batch: u32) -> u32 {
  let lights = caster_lights(caster, batch);
  let low = caster_part(caster, 3u);
  let high = caster_part(caster, 4u);
  if ((high.w & RIGID) == 0u) {
    return lights.allowed;
  }
  var matter = 0u;
  var at = lights.first;
  for (var rest = lights.allowed; rest != 0u; rest &= rest - 1u) {
    let light = firstTrailingBit(rest);
    let range = bitcast<f32>(table[group.ranges_at + 8u * batch + light / 4u][light % 4u]);
    let scaled = bitcast<vec4<f32>>(table[at + 1u]);
    if (may_reach(scaled, range, bitcast<vec3<f32>>(low.xyz), bitcast<vec3<f32>>(high.xyz), bitcast<f32>(low.w))) {
      matter |= 1u << light;
    }
    at += 2u;
  }
  return matter;
}

@compute @workgroup_size(64)
fn reach(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  for (var pair = id.x; pair < group.casters * group.batches; pair += 64u * groups.x) {
    lit[pair] = lights_that_matter(pair % group.casters, pair / group.casters);
  }
}
