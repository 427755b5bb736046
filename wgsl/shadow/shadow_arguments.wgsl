// Stages `shadow_arguments` and `piece_arguments`: write the arguments of the indirect draws of the caller's render pass,
// and count in the statistics lists that overflowed, lists with near caps, and pieces.
// Dispatched after `list_sides` for each group of casters, light batch and view, one workgroup; an invocation is one of the
// batch's 32 lights, used or not. `piece_arguments` is only for groups whose caster is a mesh of polygons.
// Reads: the counts of lists (shadow/draw_lists.wgsl), and for pieces choices. Writes: `shadow_draws` for sides and caps,
// `piece_draws` for pieces, which a group has for all views and lights.
// The vertex shaders of sides.wgsl, cap_faces.wgsl and piece_volumes.wgsl derive list entries from instance indices as
// they are counted here: change both together.

#import common/extraction
#import shadow/choices
#import shadow/draw_lists
#import shadow/shadow

// Stage `shadow_arguments`: from the counts of `list_sides` and `caps`. If the two lists of a range overflowed, the draws
// of those that are not empty have two instances for each edge slot of the group, or one for each face slot. The vertex
// shader rejects those that would not be in its list, but for near caps that cover nothing. So shadows stay right.

// The draws of the shadow volumes of one light, view and group. Fronts and backs of caps: their kinds, 0 or 2 and 1 or 3
// (shadow/draw_lists.wgsl).
struct ShadowDraws {
  plain: DrawArguments, // Sides that the hardware clips.
  clipped: DrawArguments, // Sides clipped at the near plane, or sides of ZP+ as published.
  near_front: DrawArguments,
  near_back: DrawArguments,
  // With z-fail light caps and dark caps, in a draw each. With z-pass dark caps, of volumes that end.
  far_front: DrawArguments,
  far_back: DrawArguments,
  // With z-pass and ZP+ light caps of casters that are not in the depth buffer. They share lists with dark caps, and the
  // vertex shader of each rejects faces that have no such cap.
  light_front: DrawArguments,
  light_back: DrawArguments,
}

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> sides: array<u32>;
@group(0) @binding(3) var<storage, read> caps_listed: array<u32>;
@group(0) @binding(4) var<storage, read_write> shadow_draws: array<ShadowDraws>;
@group(0) @binding(5) var<storage, read_write> shadow_statistics: ShadowStatistics;

fn draw_arguments(vertices: u32, instances: u32) -> DrawArguments {
  return DrawArguments(select(vertices, 0u, instances == 0u), instances, 0u, 0u);
}

// The instances of two lists that share a range, from their counts. `all`: the instances of a list if the range
// overflowed. An empty list has none even then.
fn instances_of_lists(counts: vec2<u32>, capacity: u32, all: u32) -> vec2<u32> {
  if (counts.x + counts.y > capacity) {
    return select(counts, vec2<u32>(all), counts != vec2<u32>(0u));
  }
  return counts;
}

@compute @workgroup_size(32)
fn shadow_arguments(@builtin(local_invocation_index) bit: u32) {
  let plain = sides[2u * bit];
  let clipped = sides[2u * bit + 1u];
  // The counts of cap faces by kind (shadow/draw_lists.wgsl).
  let cap_counts = vec4<u32>(
    caps_listed[4u * bit], caps_listed[4u * bit + 1u], caps_listed[4u * bit + 2u], caps_listed[4u * bit + 3u]);
  if (plain + clipped > shape.side_capacity) {
    atomicAdd(&shadow_statistics.overflowed_sides, 1u);
  }
  if (cap_counts.x + cap_counts.y > shape.near_capacity || cap_counts.z + cap_counts.w > shape.far_capacity) {
    atomicAdd(&shadow_statistics.overflowed_caps, 1u);
  }
  if (cap_counts.x + cap_counts.y > 0u) {
    atomicAdd(&shadow_statistics.near_capped, 1u);
  }
  // Two instances an edge slot, since a side may have the weight 2.
  let side_instances = instances_of_lists(vec2<u32>(plain, clipped), shape.side_capacity, 2u * shape.edges);
  let near = instances_of_lists(cap_counts.xy, shape.near_capacity, shape.faces);
  let far = instances_of_lists(cap_counts.zw, shape.far_capacity, shape.faces);
  let is_published = shape.counting == COUNT_ZP_PLUS_2005;
  var draws = ShadowDraws();
  draws.plain = draw_arguments(4u, side_instances.x);
  // ZP+ as published draws three quads a side.
  draws.clipped = draw_arguments(select(5u, 4u, is_published), side_instances.y * select(1u, 3u, is_published));
  draws.near_front = draw_arguments(select(5u, 3u, is_published), near.x);
  draws.near_back = draw_arguments(select(5u, 3u, is_published), near.y);
  draws.far_front = draw_arguments(3u, far.x);
  draws.far_back = draw_arguments(3u, far.y);
  if (shape.proxies != 0u) {
    draws.light_front = draw_arguments(4u, far.x);
    draws.light_back = draw_arguments(4u, far.y);
  }
  shadow_draws[draw.view * shape.lights + draw.first_light + bit] = draws;
}

// Stage `piece_arguments`: from the counts of `cut_edges` and `cut_quads`, which list pieces of twisted polygons
// (shadow/draw_lists.wgsl), and from the choices for the only caster of the group.

// The draws of the pieces of one light, view and group.
struct PieceDraws {
  plain: DrawArguments, // Sides that the hardware clips.
  clipped: DrawArguments, // Sides clipped at the near plane.
  near_front: DrawArguments, // Near caps that count up on their front.
  near_back: DrawArguments, // Near caps that count up on their back.
  light_cap: DrawArguments,
  dark_cap: DrawArguments,
}

@group(0) @binding(6) var<storage, read> view_lights: array<ViewLight>; // For each view all lights.
@group(0) @binding(7) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(8) var<storage, read> pieces: array<u32>;
@group(0) @binding(9) var<storage, read_write> piece_draws: array<PieceDraws>;

fn draw_arguments_if(is_drawn: bool, vertices: u32, instances: u32) -> DrawArguments {
  return draw_arguments(vertices, select(0u, instances, is_drawn));
}

@compute @workgroup_size(32)
fn piece_arguments(@builtin(local_invocation_index) bit: u32) {
  let light_index = draw.first_light + bit;
  let entry = draw.view * shape.lights + light_index;
  let light = with_stored_choices(shape.first_caster, view_lights[entry].light, light_index, draw.view);
  var draws = PieceDraws();
  // Entries of unused views are zeros, and so are those of lights that the view leaves out.
  if (view_lights[entry].view.near_w != 0.0 && light.casting != CAST_NOTHING) {
    let count = min(pieces[bit], shape.piece_capacity);
    if (pieces[bit] > count) {
      atomicAdd(&shadow_statistics.lost_pieces, pieces[bit] - count);
    }
    atomicMax(&shadow_statistics.most_pieces, pieces[bit]);
    let is_clipped = light.counting == COUNT_ZP_PLUS;
    let is_z_fail = light.counting == COUNT_Z_FAIL;
    // A piece and the middle of its polygon make a front-facing triangle. If the caster's matrix mirrors, the vertex shader
    // exchanges the ends of the piece.
    let kind = near_cap_kind(light, true, false);
    let ends_at_range = light.end > 0.0 && shape.end_at_range != 0u;
    draws.plain = draw_arguments_if(!is_clipped, 4u, count);
    draws.clipped = draw_arguments_if(is_clipped, 5u, count);
    draws.near_front = draw_arguments_if(is_clipped && kind == 0u, 5u, count);
    draws.near_back = draw_arguments_if(is_clipped && kind == 1u, 5u, count);
    // The triangles of pieces are not in the depth buffer, so the eye sees through them.
    draws.light_cap = draw_arguments(4u, count);
    draws.dark_cap = draw_arguments_if(is_z_fail || ends_at_range, 3u, count);
  }
  piece_draws[entry] = draws;
}
