// Per edge: a compute stage with the method that Brabec and Seidel published in 2003, for comparison. If the extractor's options
// ask for it, it stands for `facing` and `edges`; dispatched first, for each range of edge records and batch of up to 32 lights.
// One invocation takes one record (a directed edge with one or two faces), gathers four positions and tests both faces against
// every light. It writes masks and lists as `edges` does, for `compact`, `arguments` and callers. It uses the plane equations, as
// published, or the local form (common/determinant.wgsl). A face's side is decided again at each of its edges, in f32, so loops
// may fail to close. This is what is compared: each edge must gather and test anew. docs/numerics/facing.md, "Per edge".

#import common/determinant
#import common/extraction
#import common/positions
#import extract/edge_lists
#import extract/one_caster

// (a, b, c, d): face 0 is (a, b, c); face 1 is (b, a, d), or (a, b, d) where bit 31 of a is set; no face 1: d is NO_FACE.
@group(0) @binding(6) var<storage, read> edge_corners: array<vec4<u32>>;

fn position(vertex: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(position_bits(vertex, batch.position_offset, batch.position_stride));
}

// The values of a face that all lights share: its plane, and the corner from which the local form takes differences.
struct Side {
  plane: vec4<f32>,
  a: vec3<f32>,
}

fn side_of(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> Side {
  return Side(plane_through(cross_product(b - a, c - a), a), a);
}

// The plane form takes the light as given, as published; the local form takes the scaled one, as in `facing`.
fn is_in_front(side: Side, light: u32) -> bool {
  if (PLANE) {
    return plane_form(side.plane, bitcast<vec4<f32>>(batch.light_bits[light])) > 0.0;
  }
  return local_form(side.plane.xyz, side.a, batch.lights[light]) > 0.0;
}

// A bit for each light that the face faces. Takes four lights at a time: the batch repeats its last light up to entry 31, and the
// bits of these entries are dropped at the end.
fn mask_of(side: Side) -> u32 {
  var mask = 0u;
  // Turns: 8.
  for (var light = 0u; light < batch.count; light += 4u) {
    mask |= select(0u, 1u, is_in_front(side, light)) << light;
    mask |= select(0u, 2u, is_in_front(side, light + 1u)) << light;
    mask |= select(0u, 4u, is_in_front(side, light + 2u)) << light;
    mask |= select(0u, 8u, is_in_front(side, light + 3u)) << light;
  }
  return mask & batch.live;
}

@compute @workgroup_size(256)
fn per_edge(@builtin(global_invocation_id) id: vec3<u32>) {
  let edge = id.x;
  if (edge >= chunk.count) {
    return;
  }
  let corners = edge_corners[edge];
  let a = position(corners.x & ~INCONSISTENT);
  let b = position(corners.y);
  // The facing mask of face 0: the winding of the edge's side. An edge without face 1 is a silhouette for every light, also where
  // face 0 is averted, since a surface that ends there casts from either side.
  let winding = mask_of(side_of(a, b, position(corners.z)));
  var silhouette = batch.live;
  if (corners.w != NO_FACE) {
    let d = position(corners.w);
    if ((corners.x & INCONSISTENT) != 0u) {
      // Face 1 runs the same way, so its front is on the other side of the surface: it differs where the bits are equal.
      silhouette = ~(winding ^ mask_of(side_of(a, b, d))) & batch.live;
    } else {
      silhouette = winding ^ mask_of(side_of(b, a, d));
    }
  }
  emit(edge, silhouette, winding);
}
