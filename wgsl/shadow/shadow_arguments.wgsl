// Arguments of shadow volumes: two compute stages that make indirect draws for the caller's render pass, and count in the
// statistics what had no room. `shadow_arguments` for sides and caps; `piece_arguments`, after it, for the pieces of a mesh of
// polygons. Each has a workgroup for each batch (up to 32 lights) and view, an invocation a light. Vertex shaders read
// instances as they are made here: change both together.

#import common/extraction
#import shadow/choices
#import shadow/lists
#import shadow/shadow

// Stage `shadow_arguments`: from the counts of `list_sides` and `caps`, dispatched after `list_sides`, for each group of
// casters. It writes `shadow_draws`, for the vertex shaders of sides.wgsl and cap_faces.wgsl. Where lists overflowed, draws go
// over all edges or faces, and these shaders reject what does not belong: slower, never wrong.

// The draws of one light's shadow volume.
struct ShadowDraws {
  // Sides that are not clipped, and sides clipped at the near plane, or sides of ZP+ as published.
  plain: DrawArguments,
  clipped: DrawArguments,
  // Near caps that count up on their front, and on their back.
  near_front: DrawArguments,
  near_back: DrawArguments,
  // Light and dark caps of z-fail, likewise. With z-pass, the dark caps of volumes that end.
  far_front: DrawArguments,
  far_back: DrawArguments,
  // With z-pass and ZP+, the light caps of casters that are not in the depth buffer.
  light_front: DrawArguments,
  light_back: DrawArguments,
}

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> sides: array<u32>;
@group(0) @binding(3) var<storage, read> caps_listed: array<u32>;
@group(0) @binding(4) var<storage, read_write> shadow_draws: array<ShadowDraws>;
@group(0) @binding(5) var<storage, read_write> shadow_statistics: ShadowStatistics;

fn arguments(vertices: u32, instances: u32) -> DrawArguments {
  return DrawArguments(select(vertices, 0u, instances == 0u), instances, 0u, 0u);
}

// Instances of two lists that share a run. `all` are those of a run that overflowed, for lists that are not empty.
fn instances_of(first: u32, second: u32, capacity: u32, all: u32) -> vec2<u32> {
  let listed = vec2<u32>(first, second);
  if (first + second > capacity) {
    return select(listed, vec2<u32>(all), listed != vec2<u32>(0u));
  }
  return listed;
}

fn write_arguments(bit: u32) {
  let plain = sides[2u * bit];
  let clipped = sides[2u * bit + 1u];
  let counts = vec4<u32>(
    caps_listed[4u * bit], caps_listed[4u * bit + 1u], caps_listed[4u * bit + 2u], caps_listed[4u * bit + 3u]);
  if (plain + clipped > shape.side_capacity) {
    atomicAdd(&shadow_statistics.overflowed_sides, 1u);
  }
  if (counts.x + counts.y > shape.near_capacity || counts.z + counts.w > shape.far_capacity) {
    atomicAdd(&shadow_statistics.overflowed_caps, 1u);
  }
  if (counts.x + counts.y > 0u) {
    atomicAdd(&shadow_statistics.capped, 1u);
  }
  // A side may have weight 2.
  let side_instances = instances_of(plain, clipped, shape.side_capacity, 2u * shape.edges);
  let near = instances_of(counts.x, counts.y, shape.near_capacity, shape.faces);
  let far = instances_of(counts.z, counts.w, shape.far_capacity, shape.faces);
  let is_published = shape.counting == COUNT_ZP_PLUS_2005;
  var draws = ShadowDraws();
  draws.plain = arguments(4u, side_instances.x);
  // ZP+ as published takes three quads a side.
  draws.clipped = arguments(select(5u, 4u, is_published), side_instances.y * select(1u, 3u, is_published));
  draws.near_front = arguments(select(5u, 3u, is_published), near.x);
  draws.near_back = arguments(select(5u, 3u, is_published), near.y);
  draws.far_front = arguments(3u, far.x);
  draws.far_back = arguments(3u, far.y);
  if (shape.proxies != 0u) {
    draws.light_front = arguments(4u, far.x);
    draws.light_back = arguments(4u, far.y);
  }
  shadow_draws[draw.view * shape.lights + draw.first_light + bit] = draws;
}

@compute @workgroup_size(32)
fn shadow_arguments(@builtin(local_invocation_index) bit: u32) {
  if (draw.first_light + bit < shape.lights) {
    write_arguments(bit);
  }
}

// Stage `piece_arguments`: makes the draws of the pieces of L-twisted polygons, whose outlines cross themselves as seen from
// light L, so that they have lit and dark parts. A piece is a part of the border between these; `cut_edges` and `cut_quads`
// listed them (shadow/lists.wgsl). It reads the choices for the only caster of the group, and writes `piece_draws`, for the vertex shaders
// `piece_…`, and the number of pieces that had no room.

// The draws of the pieces of a light's L-twisted polygons.
struct PieceDraws {
  // Sides that are not clipped, and sides clipped at the near plane.
  plain: DrawArguments,
  clipped: DrawArguments,
  // Near caps that count up on their front, or on their back.
  near_front: DrawArguments,
  near_back: DrawArguments,
  // Caps at the polygon, and at the far end.
  light_cap: DrawArguments,
  dark_cap: DrawArguments,
}

@group(0) @binding(6) var<storage, read> seen: array<SeenLight>;
@group(0) @binding(7) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(8) var<storage, read> pieces: array<u32>;
@group(0) @binding(9) var<storage, read_write> piece_draws: array<PieceDraws>;

fn arguments_if(is_drawn: bool, vertices: u32, instances: u32) -> DrawArguments {
  return arguments(vertices, select(0u, instances, is_drawn));
}

fn write_piece_arguments(bit: u32) {
  let number = draw.first_light + bit;
  let place = draw.view * shape.lights + number;
  let light = chosen_light(shape.first_caster, seen[place].light, number, draw.view);
  var draws = PieceDraws();
  if (seen[place].view.near_w != 0.0 && light.casting != CAST_NOTHING) {
    let count = min(pieces[bit], shape.piece_capacity);
    if (pieces[bit] > count) {
      atomicAdd(&shadow_statistics.lost_pieces, pieces[bit] - count);
    }
    let is_clipped = light.counting == COUNT_ZP_PLUS;
    let is_fail = light.counting == COUNT_Z_FAIL;
    // The faces that pieces make face the light.
    let kind = near_kind(light, true, false);
    let ends = light.end > 0.0 && shape.end_at_range != 0u;
    draws.plain = arguments_if(!is_clipped, 4u, count);
    draws.clipped = arguments_if(is_clipped, 5u, count);
    draws.near_front = arguments_if(is_clipped && kind == 0u, 5u, count);
    draws.near_back = arguments_if(is_clipped && kind == 1u, 5u, count);
    // The faces that pieces make are not in the depth buffer, so the eye sees through them.
    draws.light_cap = arguments(4u, count);
    draws.dark_cap = arguments_if(is_fail || ends, 3u, count);
  }
  piece_draws[place] = draws;
}

@compute @workgroup_size(32)
fn piece_arguments(@builtin(local_invocation_index) bit: u32) {
  if (draw.first_light + bit < shape.lights) {
    write_piece_arguments(bit);
  }
}
