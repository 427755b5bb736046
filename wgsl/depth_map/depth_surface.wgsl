// Depth surface: the vertices of the boundary between light and shadow, and where the near rectangle is in shadow.

struct DepthMapView {
  // Columns of the matrix to the eye's clip space, of twice the place on the lattice from its middle, and of the depth.
  across: vec4<f32>,
  down: vec4<f32>,
  depth: vec4<f32>,
  middle: vec4<f32>,
  // The same for places at infinity, away from the light.
  far_across: vec4<f32>,
  far_down: vec4<f32>,
  far_middle: vec4<f32>,
  // Columns from x and y on the near rectangle, from -1 to 1, to the lattice and the depth: homogeneous.
  near_across: vec4<f32>,
  near_up: vec4<f32>,
  near_middle: vec4<f32>,
  // The depth at infinity, of the same terms as `far_across`. 1 in w: there is none, the light is parallel.
  infinity: vec4<f32>,
  // How far the surface moves: a share of its slope, of its depth, and a constant.
  bias: vec4<f32>,
}

@group(0) @binding(2) var<storage, read> cells: array<u32>;
// One element. It is an array so that its binding has no dynamic offset.
@group(0) @binding(3) var<storage, read> views: array<DepthMapView>;

fn depth_of(key: u32) -> f32 {
  return bitcast<f32>(depth_bits(key));
}

// The depth difference to each side that is smaller, 0 where they have different signs or a side is far.
fn slope(key: u32, before: u32, after: u32) -> f32 {
  if (before == FAR_KEY || after == FAR_KEY) {
    return 0.0;
  }
  let a = depth_of(key) - depth_of(before);
  let b = depth_of(after) - depth_of(key);
  return select(0.0, min(abs(a), abs(b)), (a > 0.0) == (b > 0.0));
}

// The depth of a sample that is not far, moved away from the light. It stays before the far plane.
fn moved_depth(at: vec2<u32>, key: u32) -> f32 {
  let across = slope(key, key_at(at - vec2<u32>(1u, 0u)), key_at(at + vec2<u32>(1u, 0u)));
  let down = slope(key, key_at(at - vec2<u32>(0u, 1u)), key_at(at + vec2<u32>(0u, 1u)));
  let depth = depth_of(key);
  let is_reversed = depth_map.is_reversed != 0u;
  let to_far = select(1.0 - depth, depth, is_reversed);
  let bias = views[0].bias;
  let offset = min(bias.x * (across + down) + bias.y * depth + bias.z, 0.5 * to_far);
  return depth + select(offset, -offset, is_reversed);
}

// Twice the place of a sample from the middle of the lattice.
fn from_middle(at: vec2<u32>) -> vec2<f32> {
  return vec2<f32>(2 * vec2<i32>(at) - 1 - vec2<i32>(depth_map.size));
}

// All triangles at a sample take its vertex from here.
fn surface_vertex(at: vec2<u32>) -> vec4<f32> {
  let key = key_at(at);
  let place = from_middle(at);
  if (key == FAR_KEY) {
    return views[0].far_across * place.x + views[0].far_down * place.y + views[0].far_middle;
  }
  let depth = moved_depth(at, key);
  return views[0].across * place.x + views[0].down * place.y + views[0].depth * depth + views[0].middle;
}

// The sample of a triangle's corner, from sample (0, 0) of the cell.
fn triangle_corner(entry: u32, second: u32, corner: u32) -> vec2<u32> {
  // Numbers of samples, two bits each: 0 is (0, 0), 1 is (1, 0), 2 is (0, 1), 3 is (1, 1).
  let plain = select(0x34u, 0x2cu, second != 0u);
  let split = select(0x24u, 0x2du, second != 0u);
  let number = (select(plain, split, (entry & SPLIT) != 0u) >> (2u * corner)) & 3u;
  return vec2<u32>(number & 1u, number >> 1u);
}

struct SurfaceVertex {
  @builtin(position) @invariant position: vec4<f32>,
}

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

// The depth of a sample in the plane of a triangle. A parallel light has none for far samples.
fn plane_depth(at: vec2<u32>) -> f32 {
  let key = key_at(at);
  if (key == FAR_KEY) {
    let place = from_middle(at);
    return dot(views[0].infinity.xyz, vec3<f32>(place, 1.0));
  }
  return moved_depth(at, key);
}

// Whether a place on the near rectangle is behind the surface: it is looked up in the triangle that the draw has there.
fn is_behind(place: vec2<f32>) -> bool {
  let point = views[0].near_across * place.x + views[0].near_up * place.y + views[0].near_middle;
  if (point.w <= 0.0) {
    return false;
  }
  let lattice = point.xy / point.w;
  if (!(all(lattice >= vec2<f32>(0.0)) && all(lattice < vec2<f32>(depth_map.size + 1u)))) {
    return false;
  }
  let cell = floor(lattice);
  let at = vec2<u32>(cell);
  let part = lattice - cell;
  let entry = templates(keys_of_cell(at));
  let is_split = (entry & SPLIT) != 0u;
  let second = select((part.x < part.y), (part.x + part.y > 1.0), is_split);
  // The shares of the samples (0, 0), (1, 0), (0, 1), (1, 1).
  var shares = vec4<f32>(1.0 - part.x, part.x - part.y, 0.0, part.y);
  if (is_split) {
    shares = vec4<f32>(1.0 - part.x - part.y, part.x, part.y, 0.0);
    if (second) {
      shares = vec4<f32>(0.0, 1.0 - part.y, 1.0 - part.x, part.x + part.y - 1.0);
    }
  } else if (second) {
    shares = vec4<f32>(1.0 - part.y, 0.0, part.y - part.x, part.x);
  }
  var depth = 0.0;
  for (var number = 0u; number < 4u; number++) {
    if (shares[number] > 0.0) {
      let sample = at + vec2<u32>(number & 1u, number >> 1u);
      if (views[0].infinity.w != 0.0 && key_at(sample) == FAR_KEY) {
        return false;
      }
      depth += shares[number] * plane_depth(sample);
    }
  }
  let ahead = point.z / point.w - depth;
  return select(ahead > 0.0, ahead < 0.0, depth_map.is_reversed != 0u);
}

@fragment
fn depth_near_cap_fragment(@location(0) @interpolate(linear, sample) place: vec2<f32>) {
  if (!is_behind(place)) {
    discard;
  }
}

@fragment
fn nothing() {}
