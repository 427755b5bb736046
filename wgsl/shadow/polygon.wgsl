// Draws polygons that clipping made as triangle strips of five vertices.

const NOTHING = vec4<f32>(0.0, 0.0, 0.0, 1.0);

// Picks one vertex of a polygon. The vertices are offered one after another. A place past the last vertex repeats it.
struct Picked {
  clip: vec4<f32>,
  wanted: u32,
  offered: u32,
}

// Picks the vertex of the strip at `place`.
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
