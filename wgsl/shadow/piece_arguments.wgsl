// Piece arguments: a compute stage that makes the indirect draws of the pieces of L-twisted polygons, whose outlines cross
// themselves as seen from light L, so that they have lit and dark parts. A piece is a part of the border between these;
// `cut_edges` and `cut_quads` listed them (shadow/lists.wgsl). Dispatched after `shadow_arguments` for a mesh of polygons, one
// workgroup for each batch (up to 32 lights) and view, an invocation a light. It reads the choices for the only caster, and
// writes `piece_draws`, for the vertex shaders `pieces` in the caller's render pass, and the number of pieces that had no room,
// to the statistics.

#import common/extraction
#import shadow/choices
#import shadow/lists
#import shadow/shadow

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

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: array<SeenLight>;
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> pieces: array<u32>;
@group(0) @binding(5) var<storage, read_write> piece_draws: array<PieceDraws>;
@group(0) @binding(6) var<storage, read_write> shadow_statistics: ShadowStatistics;

fn arguments(vertices: u32, instances: u32, is_drawn: bool) -> DrawArguments {
  if (!is_drawn || instances == 0u) {
    return DrawArguments(0u, 0u, 0u, 0u);
  }
  return DrawArguments(vertices, instances, 0u, 0u);
}

fn write_arguments(bit: u32) {
  let number = draw.first_light + bit;
  let place = draw.view * shape.lights + number;
  let light = chosen_light(0u, seen[place].light, number, draw.view);
  var draws = PieceDraws();
  if (seen[place].view.near_w != 0.0 && light.casting != CAST_NOTHING) {
    let count = min(pieces[bit], piece_capacity());
    if (pieces[bit] > count) {
      atomicAdd(&shadow_statistics.lost_pieces, pieces[bit] - count);
    }
    let is_clipped = light.counting == COUNT_ZP_PLUS;
    let is_fail = light.counting == COUNT_Z_FAIL;
    // The faces that pieces make face the light.
    let kind = near_kind(light, true, false);
    let ends = light.end > 0.0 && shape.end_at_range != 0u;
    draws.plain = arguments(4u, count, !is_clipped);
    draws.clipped = arguments(5u, count, is_clipped);
    draws.near_front = arguments(5u, count, is_clipped && kind == 0u);
    draws.near_back = arguments(5u, count, is_clipped && kind == 1u);
    // The faces that pieces make are not in the depth buffer, so the eye sees through them.
    draws.light_cap = arguments(4u, count, true);
    draws.dark_cap = arguments(3u, count, is_fail || ends);
  }
  piece_draws[place] = draws;
}

@compute @workgroup_size(32)
fn piece_arguments(@builtin(local_invocation_index) bit: u32) {
  if (draw.first_light + bit < shape.lights) {
    write_arguments(bit);
  }
}
