// Depth walls: the vertices of walls over contours, and where the near rectangle is behind the surfaces between them. The list of
// walls is bound as `cells`.

@vertex
fn depth_walls(@builtin(vertex_index) index: u32) -> SurfaceVertex {
  let corner = index % 6u;
  // Vertices 0, 1, 2 and 0, 2, 3.
  let number = select(corner, select(0u, corner - 2u, corner > 3u), corner >= 3u);
  let word = 4u + 12u * (index / 6u) + 3u * number;
  let distance = bitcast<i32>(cells[word + 2u]);
  let found = vec2<f32>(vec2<u32>(cells[word], cells[word + 1u])) / f32(TEXEL / 2);
  let place = found - vec2<f32>(depth_map.size) - 1.0;
  let view = views[0];
  if (distance == FAR) {
    return SurfaceVertex(view.far_across * place.x + view.far_down * place.y + view.far_middle);
  }
  let depth = f32(select(distance, RANGE - distance, depth_map.is_reversed != 0u)) / f32(RANGE);
  return SurfaceVertex(view.across * place.x + view.down * place.y + view.depth * depth + view.middle);
}

// As `is_behind`, for surfaces that end at contours.
fn is_behind_contours(place: vec2<f32>) -> bool {
  let found = near_place(place);
  let cell = vec2<i32>(floor(found.lattice));
  // A list of walls that overflowed is not drawn.
  var code = 0u;
  if (found.is_in && cells[0] <= depth_map.capacity) {
    code = code_of_cell(cell);
  }
  if (code == 0u) {
    return found.is_in && is_behind_triangle(found);
  }
  let distance = contour_distance(cell, code, found.lattice - floor(found.lattice));
  let is_reversed = depth_map.is_reversed != 0u;
  var depth = f32(select(distance, RANGE - distance, is_reversed)) / f32(RANGE);
  if (distance == FAR) {
    if (views[0].infinity.w != 0.0) {
      return false;
    }
    let twice = 2.0 * found.lattice - vec2<f32>(depth_map.size) - 1.0;
    depth = dot(views[0].infinity.xyz, vec3<f32>(twice, 1.0));
  }
  return select(found.depth > depth, found.depth < depth, is_reversed);
}

@fragment
fn depth_walls_near_cap_fragment(@location(0) @interpolate(linear, sample) place: vec2<f32>) {
  if (!is_behind_contours(place)) {
    discard;
  }
}
