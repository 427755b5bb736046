// Per edge: the method that Brabec and Seidel published in 2003, for comparison. If the options ask for it, it replaces
// `facing`, `exact_facing` and `edges`. Dispatched for each range of edge records and batch of up to 32 lights, an
// invocation a record. A record is a directed edge with one or two faces. It gathers the positions of their three or four
// vertices, tests the faces against every light, then writes masks and lists as `edges` does, for `compact`, `arguments` and
// callers. It computes the plane form, as published, or the local form (common/determinant.wgsl), in f32; it has no exact
// form, and no test for vertices that are not finite: bits of their faces mean nothing, and statistics do not count them.
// Each edge decides its faces again, so loops may fail to close.
// Gathering and testing at each edge is what is measured: do not share work. Claim: docs/numerics/facing.md, "Per edge".

#import common/determinant
#import common/extraction
#import common/positions
#import extract/edge_lists
#import extract/one_caster

// (a, b, c, d): face 0 is (a, b, c). Face 1 is (b, a, d), or (a, b, d) if bit 31 of a is set. d is NO_FACE if there is none.
@group(0) @binding(6) var<storage, read> edge_corners: array<vec4<u32>>;

fn position(vertex: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(position_bits(vertex, batch.position_offset, batch.position_stride));
}

// A face's values for all lights: its plane, and the corner that the local form subtracts.
struct FacePlane {
  plane: vec4<f32>,
  a: vec3<f32>,
}

fn face_plane(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> FacePlane {
  return FacePlane(plane_through(cross_product(b - a, c - a), a), a);
}

// The plane form takes the light as given, as published; the local form takes the scaled one, as in `facing`.
fn is_facing(face: FacePlane, light: u32) -> bool {
  if (PLANE) {
    return plane_form(face.plane, bitcast<vec4<f32>>(batch.light_bits[light])) > 0.0;
  }
  return local_form(face.plane.xyz, face.a, batch.lights[light]) > 0.0;
}

// A bit for each light that the face faces. Tests four lights at a time. Past the last light the batch repeats it; these
// bits are dropped at the end.
fn facing_mask_of(face: FacePlane) -> u32 {
  var mask = 0u;
  // Turns: 8.
  for (var light = 0u; light < batch.count; light += 4u) {
    mask |= select(0u, 1u, is_facing(face, light)) << light;
    mask |= select(0u, 2u, is_facing(face, light + 1u)) << light;
    mask |= select(0u, 4u, is_facing(face, light + 2u)) << light;
    mask |= select(0u, 8u, is_facing(face, light + 3u)) << light;
  }
  return mask & batch.active_bits;
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
  // The facing mask of face 0 is the winding of the edge's side. An edge without face 1 is a silhouette for every light: the
  // surface that ends there casts a shadow from either side.
  let winding = facing_mask_of(face_plane(a, b, position(corners.z)));
  var silhouette = batch.active_bits;
  if (corners.w != NO_FACE) {
    let d = position(corners.w);
    if ((corners.x & INCONSISTENT) != 0u) {
      // Face 1 traverses the edge the same way, so its front is on the other side of the surface: equal bits are a
      // silhouette.
      silhouette = ~(winding ^ facing_mask_of(face_plane(a, b, d))) & batch.active_bits;
    } else {
      silhouette = winding ^ facing_mask_of(face_plane(b, a, d));
    }
  }
  emit(edge, silhouette, winding);
}
