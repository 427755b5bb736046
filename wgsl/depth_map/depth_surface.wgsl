// Depth surface: the vertices of the boundary between light and shadow, and where the near rectangle is in shadow.

#import depth_map/edge_code
#import depth_map/samples
#import depth_map/surface

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

// Whether a place on the near rectangle is behind the surface: it is looked up in the triangle that the draw has there.
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
