// Stage `depth_surface`: draws the boundary between light and shadow into the caller's stencil (`DepthMapFrame::draw`, in the
// caller's render pass after the eye's depths), once for each bit. Depth is tested and not written; a fragment before what is
// seen turns the bit round, or counts.
// `depth_surface` with `nothing`: six vertices for each listed cell, an indirect draw whose arguments `depth_cells` wrote. With
// contours only if the list of walls overflowed. If a list overflowed, it draws every cell and decides about it as the list
// would. `depth_near_cap` with its fragment shader: one triangle over the picture, which turns the bit round where the near
// rectangle (the part of the eye's near plane in the picture) is in shadow; 3 vertices, or 0 if `depth_near` found it in light.
// Both together turn the bit just where what is seen is behind the boundary, unless a detector missed an edge. All vertices come
// from surface.wgsl, invariant.

#import depth_map/edge_code
#import depth_map/samples
#import depth_map/surface

// Vertices 0 to 2 are the first triangle of a cell, 3 to 5 the second. If it is not drawn, they lie in one point.
@vertex
fn depth_surface(@builtin(vertex_index) index: u32) -> SurfaceVertex {
  let number = index / 6u;
  let second = (index / 3u) & 1u;
  var entry = 0u;
  if (cells[0] > depth_map.capacity) {
    entry = entry_of_cell(number);
  } else {
    entry = cells[1u + number];
  }
  if ((entry & (FIRST_TRIANGLE << second)) == 0u) {
    return SurfaceVertex(vec4<f32>(0.0, 0.0, 0.0, 1.0));
  }
  let at = corner_of_cell(entry & CELL_MASK) + triangle_corner(entry, second, index % 3u);
  return SurfaceVertex(surface_vertex(at));
}

struct NearVertex {
  @builtin(position) position: vec4<f32>,
  @location(0) @interpolate(linear, sample) place: vec2<f32>,
}

@vertex
fn depth_near_cap(@builtin(vertex_index) index: u32) -> NearVertex {
  let place = vec2<f32>(select(-1.0, 3.0, index == 1u), select(-1.0, 3.0, index == 2u));
  return NearVertex(vec4<f32>(place, 0.5, 1.0), place);
}

// Whether a place on the near rectangle, from -1 to 1, is behind the boundary.
fn is_behind(place: vec2<f32>) -> bool {
  let found = near_place(place);
  return found.is_in && is_behind_triangle(found);
}

@fragment
fn depth_near_cap_fragment(@location(0) @interpolate(linear, sample) place: vec2<f32>) {
  if (!is_behind(place)) {
    discard;
  }
}

@fragment
fn nothing() {}
