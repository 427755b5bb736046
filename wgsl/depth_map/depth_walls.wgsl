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

// Whether a place of a cell that a contour crosses is behind the surface on its side.
fn is_behind_contour(found: NearPlace, cell: vec2<i32>, code: u32) -> bool {
  let distance = contour_distance(cell, code, found.lattice - floor(found.lattice));
  if (distance != FAR) {
    let depth = select(distance, RANGE - distance, depth_map.is_reversed != 0u);
    return is_behind_depth(found.depth, f32(depth) / f32(RANGE));
  }
  if (views[0].infinity.w != 0.0) {
    return false;
  }
  let twice = 2.0 * found.lattice - vec2<f32>(depth_map.size) - 1.0;
  return is_behind_depth(found.depth, dot(views[0].infinity.xyz, vec3<f32>(twice, 1.0)));
}

// As `is_behind`, for surfaces that end at contours.
fn is_behind_contours(place: vec2<f32>) -> bool {
  let found = near_place(place);
  // A list of walls that overflowed is not drawn.
  if (!found.is_in || cells[0] > depth_map.capacity) {
    return found.is_in && is_behind_triangle(found);
  }
  let corner = floor(found.lattice);
  let cell = vec2<i32>(corner);
  let code = code_of_cell(cell);
  var is_behind = false;
  if (code == 0u) {
    is_behind = is_behind_triangle(found);
  } else {
    is_behind = is_behind_contour(found, cell, code);
  }
  return is_behind != flaps_change(cell, found.lattice - corner, found.depth, is_behind);
}

@fragment
fn depth_walls_near_cap_fragment(@location(0) @interpolate(linear, sample) place: vec2<f32>) {
  if (!is_behind_contours(place)) {
    discard;
  }
}
