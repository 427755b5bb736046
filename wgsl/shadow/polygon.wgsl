// Draws polygons that clipping made as triangle strips of five vertices.

const NOTHING = vec4<f32>(0.0, 0.0, 0.0, 1.0);

// One vertex of a polygon whose vertices are offered one after another; those beyond the last repeat it.
struct Picked {
  clip: vec4<f32>,
  wanted: u32,
  offered: u32,
}

// To pick the vertex that the strip has at `place`.
fn pick(place: u32) -> Picked {
  let order = vec4<u32>(0u, 1u, 4u, 2u);
  return Picked(NOTHING, select(order[min(place, 3u)], 3u, place == 4u), 0u);
}

fn offer(picked: Picked, clip: vec4<f32>, is_there: bool) -> Picked {
  var next = picked;
  if (is_there) {
    if (picked.offered <= picked.wanted) {
      next.clip = clip;
    }
    next.offered++;
  }
  return next;
}
