// Pencils of half planes, which bound stencil counts, if the caller asks for a bound. The half planes of a pencil begin at a line
// through the light, its axis, and are sorted into bins by one number each. A pixel's count is at most half of what crosses its
// half plane and the faces that the axis may meet, so sides are added to all bins that they may cross. `stencil_pencil` finds a
// pencil for each light and view; `stencil_crossings` and `piece_crossings` add sides; `stencil_bound` reads the bins. A side may
// be added to too many bins, never to too few. docs/numerics/receivers.md, "Bound on counts".
//
// Expects: `shape`, and where sides are added `crossings`, the rows of all pencils.

#import common/casters

struct StencilPencil {
  place: vec3<f32>, // The position of the light. 0 if it is at infinity.
  kind: u32, // One of the constants below.
  forward: vec3<f32>, // Two directions at right angles to the axis.
  // The number of the half plane where the first bin begins, and bins for each unit.
  first: f32,
  aside: vec3<f32>,
  scale: f32,
}

const PARALLEL: u32 = 0u; // The light is at infinity: the half planes are parallel.
const FAN: u32 = 1u; // The light is outside the box of all casters, which lie in front of it: in direction `forward`.
const AROUND: u32 = 2u; // The light is in the box. The half planes go all around a coordinate axis.
// Bins of a pencil. Each pencil has a row of words: for each bin the weights that begin there less those that ended in the
// bin before, then one more end, then the faces of casters that the axis meets, and the faces of all casters.
const BINS: u32 = 1024u;
const MET_FACES: u32 = 1025u;
const ALL_FACES: u32 = 1026u;
const ROW: u32 = 1028u;

// The row of a light in a view, for a batch of casters.
fn row_of(view: u32, light: u32, count_batch: u32) -> u32 {
  return ROW * ((view * shape.lights + light) * shape.count_batches + count_batch);
}

// The angle of (u, v) as a number that grows with it: from 0 to 4, once around.
fn turn(u: f32, v: f32) -> f32 {
  let along = u / max(abs(u) + abs(v), 1e-30);
  return select(3.0 + along, 1.0 - along, v >= 0.0);
}

// The number of the half plane of a pencil that a position lies in.
fn half_plane(by: StencilPencil, position: vec3<f32>) -> f32 {
  let d = position - by.place;
  let v = dot_3(by.aside, d);
  if (by.kind == PARALLEL) {
    return v;
  }
  let u = dot_3(by.forward, d);
  if (by.kind == FAN) {
    return v / u;
  }
  return turn(u, v);
}

// How near the light may be to a box before nothing is said about the side that it is on.
fn box_slack(place: vec3<f32>, low: vec3<f32>, high: vec3<f32>) -> f32 {
  let slack = 4e-6 * max(max(abs(low), abs(high)), abs(place));
  return 4.0 * max(max(slack.x, slack.y), slack.z);
}

// Whether the axis through `place` along coordinate axis `axis` may meet a box.
fn axis_meets(place: vec3<f32>, axis: u32, low: vec3<f32>, high: vec3<f32>) -> bool {
  let slack = box_slack(place, low, high);
  var within = (low - slack <= place) & (place <= high + slack);
  within[axis] = true;
  return all(within);
}

// The coordinate axis of a pencil that goes around it.
fn axis_of(by: StencilPencil) -> u32 {
  let used = abs(by.forward) + abs(by.aside);
  return select(select(2u, 1u, used.y == 0.0), 0u, used.x == 0.0);
}

// Adds the weight to the bins from `first` to `last`: where it begins, and off again behind it.
fn cross_bins(row: u32, first: u32, last: u32, weight: u32) {
  atomicAdd(&crossings[row + first], weight);
  atomicSub(&crossings[row + last + 1u], weight);
}

fn bin_of(by: StencilPencil, at: f32) -> u32 { return u32(clamp((at - by.first) * by.scale, 0.0, f32(BINS - 1u))); }

// Adds the weight of an edge to all bins that it may cross.
fn cross_edge(by: StencilPencil, row: u32, a: vec3<f32>, b: vec3<f32>, weight: u32) {
  let p = half_plane(by, a);
  let q = half_plane(by, b);
  let first = bin_of(by, min(p, q));
  let last = bin_of(by, max(p, q));
  // An edge that does not meet the axis goes the shorter way around it.
  if (by.kind == AROUND && abs(p - q) > 2.0) {
    cross_bins(row, 0u, first, weight);
    cross_bins(row, last, BINS - 1u, weight);
  } else {
    cross_bins(row, first, last, weight);
  }
}
