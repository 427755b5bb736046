// Trim: cuts polygons of volumes at the frustum, for drivers that clip slivers wrongly. It goes from one plane to the next, and
// cuts an edge from its inner to its outer end. So an edge that two polygons share is cut to the same bits. NUMERICS.md,
// "Triangles that leave the picture".

// Whether polygons are trimmed. A draw has as many vertices as without, so each polygon is drawn in parts, by draws of their own:
// two triangles of its fan as a strip, or one in a list.
override TRIM: bool = false;
override PART: u32 = 0u;
// Whether near and far plane do not clip.
override UNCLIPPED: bool = false;

// Five corners, and one more for each plane.
const MOST_CORNERS: u32 = 11u;

struct Outline {
  corners: array<vec4<f32>, MOST_CORNERS>,
  count: u32,
}

fn with_corner(outline: Outline, clip: vec4<f32>) -> Outline {
  var next = outline;
  if (next.count < MOST_CORNERS) {
    next.corners[next.count] = clip;
    next.count++;
  }
  return next;
}

// The place of a corner in a strip of up to five vertices, as `pick` has them.
fn strip_place(corner: u32) -> u32 {
  let order = vec4<u32>(0u, 1u, 3u, 4u);
  return select(order[min(corner, 3u)], 2u, corner == 4u);
}

// Positive on the inner side of a plane of the frustum.
fn inner_height(plane: u32, clip: vec4<f32>) -> f32 {
  let along = clip[plane / 2u];
  if (plane == 4u) {
    return along;
  }
  return clip.w + select(along, -along, (plane & 1u) != 0u);
}

// Where an edge meets a plane: exactly on it, so that nothing is left for the driver to clip.
fn meet_plane(plane: u32, inner: vec4<f32>, outer: vec4<f32>) -> vec4<f32> {
  let height = inner_height(plane, inner);
  let depth = -inner_height(plane, outer);
  // Ends may differ by many orders of magnitude, since they are homogeneous. No difference of them is taken, so neither is lost.
  var meeting = inner * (depth / (height + depth)) + outer * (height / (height + depth));
  meeting[plane / 2u] = select(select(-meeting.w, 0.0, plane == 4u), meeting.w, (plane & 1u) != 0u);
  return meeting;
}

// At most 66 turns: six planes, eleven corners.
fn trimmed(outline: Outline) -> Outline {
  var polygon = outline;
  let planes = select(6u, 4u, UNCLIPPED);
  // Turns: 6.
  for (var plane = 0u; plane < planes; plane++) {
    var next: Outline;
    // Turns: 11.
    for (var corner = 0u; corner < polygon.count; corner++) {
      let here = polygon.corners[corner];
      let there = polygon.corners[select(corner + 1u, 0u, corner + 1u == polygon.count)];
      let is_in = inner_height(plane, here) >= 0.0;
      if (is_in) {
        next = with_corner(next, here);
      }
      if (is_in != (inner_height(plane, there) >= 0.0)) {
        if (is_in) {
          next = with_corner(next, meet_plane(plane, here, there));
        } else {
          next = with_corner(next, meet_plane(plane, there, here));
        }
      }
    }
    polygon = next;
  }
  return polygon;
}

// A vertex of the part that is drawn.
fn vertex_of_part(polygon: Outline, is_list: bool, vertex: u32) -> vec4<f32> {
  let first = select(2u, 1u, is_list) * PART;
  if (first + 2u >= polygon.count) {
    return NOTHING;
  }
  if (vertex == 0u) {
    return polygon.corners[0];
  }
  // Corners 0, 1, 3, 2 of a quad are a strip. What a strip has beyond them repeats the last.
  let corner = select(select(vertex, 3u, vertex == 2u), 2u, vertex > 2u);
  return polygon.corners[min(first + select(corner, vertex, is_list), polygon.count - 1u)];
}
