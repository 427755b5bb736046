// Bins of half planes, from which `stencil_bound` bounds stencil counts if the caller asks for a bound. A pencil is all half
// planes that begin at one line through the light, its axis. Each half plane has a key, and bins are ranges of keys. A
// stencil count belongs to the ray from the light to a position, which lies in one half plane. The count is at most half of
// the weights of the sides (quads of shadow volumes) that cross the half plane, plus the faces of casters that the axis may
// meet. The weight of a side is how much the count changes across it. `stencil_pencil` chooses a pencil for each light and
// view and counts faces, `stencil_crossings` and `piece_crossings` add sides to bins, `stencil_bound` reads the bins. A side
// is added to all bins that it crosses, but for the rounding of keys. docs/numerics/receivers.md, "Bound on counts".
//
// Expects: `shape`, and, where sides are added, `bin_rows`, the rows of bins of all pencils.

#import common/casters

struct StencilPencil {
  light_position: vec3<f32>, // The position of the light. 0 if it is at infinity.
  kind: u32, // One of the constants PENCIL_….
  // Two directions at right angles to the axis and to each other, in general not of length 1. They are the coordinates from
  // which keys are computed.
  forward: vec3<f32>,
  first_key: f32, // The key at which the first bin begins.
  aside: vec3<f32>,
  bins_per_key: f32, // Bins for each unit of the key.
}

const PENCIL_PARALLEL: u32 = 0u; // The light is at infinity. The half planes are parallel.
// The light is outside the box of all casters that cast. Their positions, relative to it, have a positive dot product with
// `forward`.
const PENCIL_FAN: u32 = 1u;
// The light is in this box, or as near as `box_slack`. The axis is parallel to a coordinate axis.
const PENCIL_AROUND: u32 = 2u;
const BINS: u32 = 1024u;
// A row of words for each pencil and count batch. Word n is the weight that begins in bin n less the weight that ends in bin
// n - 1. A word for the last end follows, then these:
const AXIS_FACES: u32 = 1025u; // Faces of those casters of ALL_FACES that the axis may meet. 0 unless PENCIL_AROUND.
const ALL_FACES: u32 = 1026u; // Faces of all casters of the count batch that cast for the light. Another word is not used.
const ROW_WORDS: u32 = 1028u;

// The offset of the row of a light in a view, for a count batch.
fn row_offset(view: u32, light_index: u32, count_batch: u32) -> u32 {
  return ROW_WORDS * ((view * shape.lights + light_index) * shape.count_batches + count_batch);
}

// A number that grows with the angle of (u, v), from 0 to 4 for a full circle.
fn pseudo_angle(u: f32, v: f32) -> f32 {
  let along = u / max(abs(u) + abs(v), 1e-30);
  return select(3.0 + along, 1.0 - along, v >= 0.0);
}

// The key of the half plane that contains a position.
fn half_plane_key(pencil: StencilPencil, position: vec3<f32>) -> f32 {
  let d = position - pencil.light_position;
  let v = dot_3(pencil.aside, d);
  if (pencil.kind == PENCIL_PARALLEL) {
    return v;
  }
  let u = dot_3(pencil.forward, d);
  if (pencil.kind == PENCIL_FAN) {
    return v / u;
  }
  return pseudo_angle(u, v);
}

// Within this distance of a box, rounding errors leave open whether a position is inside.
fn box_slack(position: vec3<f32>, low: vec3<f32>, high: vec3<f32>) -> f32 {
  let slack = 4e-6 * max(max(abs(low), abs(high)), abs(position));
  return 4.0 * max(max(slack.x, slack.y), slack.z);
}

// Whether the line through `position` in the direction of a coordinate axis may meet a box. Never false for a box that it
// meets.
fn can_axis_meet_box(position: vec3<f32>, axis: u32, low: vec3<f32>, high: vec3<f32>) -> bool {
  let slack = box_slack(position, low, high);
  var is_within = (low - slack <= position) & (position <= high + slack);
  is_within[axis] = true;
  return all(is_within);
}

// The coordinate axis to which the axis of a pencil of kind PENCIL_AROUND is parallel.
fn axis_of_pencil(pencil: StencilPencil) -> u32 {
  let used = abs(pencil.forward) + abs(pencil.aside);
  return select(select(2u, 1u, used.y == 0.0), 0u, used.x == 0.0);
}

// Bins from `first` to `last`.
struct BinRange {
  first: u32,
  last: u32,
}

// Adds a weight to bins of a row.
fn add_to_bins(row: u32, range: BinRange, weight: u32) {
  atomicAdd(&bin_rows[row + range.first], weight);
  atomicSub(&bin_rows[row + range.last + 1u], weight);
}

fn bin_of_key(pencil: StencilPencil, key: f32) -> u32 {
  return u32(clamp((key - pencil.first_key) * pencil.bins_per_key, 0.0, f32(BINS - 1u)));
}

// Adds the weight of the side of an edge to all bins whose half planes may cross the edge.
fn add_edge(pencil: StencilPencil, row: u32, a: vec3<f32>, b: vec3<f32>, weight: u32) {
  let p = half_plane_key(pencil, a);
  let q = half_plane_key(pencil, b);
  let first = bin_of_key(pencil, min(p, q));
  let last = bin_of_key(pencil, max(p, q));
  // Callers leave out casters whose box the axis may meet, so the edge spans less than half a turn: it goes the shorter way.
  if (pencil.kind == PENCIL_AROUND && abs(p - q) > 2.0) {
    add_to_bins(row, BinRange(0u, first), weight);
    add_to_bins(row, BinRange(last, BINS - 1u), weight);
  } else {
    add_to_bins(row, BinRange(first, last), weight);
  }
}
