// `mark_strip` marks the edges to the right of 16 × 4 samples and below them. It goes along the four rows at once, so that
// few samples are loaded twice. An invocation of `depth_edges_mark` calls it. Only depth_edges.wgsl imports this file.
//
// Expects: `edges`, `faint_edges`, `sample_bits`.

#import depth_map/cell_words
#import depth_map/edge_code
#import depth_map/edge_rule
#import depth_map/samples

// Whether edges are continued.
override CONTINUES: bool = true;

const WORD_SAMPLES: u32 = 16u;

// Samples of the lattice, or of a cube's texture: columns and rows.
fn lattice_size() -> vec2<u32> {
  return select(depth_map.size + 2u, vec2<u32>(3u, 2u) * depth_map.size, depth_map.faces > 1u);
}

// The step along an axis: 0 to the right, 1 down.
fn step_along(axis: u32) -> vec2<u32> {
  return select(vec2<u32>(1u, 0u), vec2<u32>(0u, 1u), axis == 1u);
}

// The column and row of the first word of a strip of marks: four words below each other. (cell_words.wgsl has strips of
// cells.)
fn first_word_of_strip(strip: u32) -> vec2<u32> {
  return vec2<u32>(strip % edge_rule.words.x, strip / edge_rule.words.x * STRIP);
}

// Keys of a column of samples: those in the four rows of a strip; and one above (x) and two below it (y, z).
struct Column {
  keys: vec4<u32>,
  beyond: vec3<u32>,
}

fn load_column(sample: vec2<u32>) -> Column {
  let down = vec2<u32>(0u, 1u);
  return Column(
    vec4<u32>(load_key(sample), load_key(sample + down), load_key(sample + 2u * down), load_key(sample + 3u * down)),
    vec3<u32>(load_key(sample - down), load_key(sample + 4u * down), load_key(sample + 5u * down)));
}

// Keys of four edges in the rows of a strip: of the samples before them, at both ends, and after them.
struct FourEdges {
  before: vec4<u32>,
  first: vec4<u32>,
  second: vec4<u32>,
  after: vec4<u32>,
}

// `edge_state` of each edge.
fn edge_states(four: FourEdges, level: u32) -> vec4<u32> {
  return vec4<u32>(
    edge_state(vec4<u32>(four.before.x, four.first.x, four.second.x, four.after.x), level),
    edge_state(vec4<u32>(four.before.y, four.first.y, four.second.y, four.after.y), level),
    edge_state(vec4<u32>(four.before.z, four.first.z, four.second.z, four.after.z), level),
    edge_state(vec4<u32>(four.before.w, four.first.w, four.second.w, four.after.w), level));
}

// Which edges lie between different objects. An edge with a far sample never does. `sample`: the first sample of the first
// edge.
fn are_object_edges(four: FourEdges, sample: vec2<u32>, step: vec2<u32>) -> vec4<bool> {
  var result = vec4<bool>(false);
  if (OBJECTS && depth_map.has_objects != 0u) {
    // `opaque` keeps the loop from being unrolled into four copies of the loads.
    for (var row = 0u; row < opaque(STRIP); row++) {
      let first = sample + vec2<u32>(0u, row);
      result[row] = max(four.first[row], four.second[row]) != FAR_KEY && is_object_edge(first, first + step);
    }
  }
  return result;
}

// The four words of a strip: edges that are marked, and those that are left to `is_marked_exact`.
struct Marks {
  marked: vec4<u32>,
  undecided: vec4<u32>,
}

// Sets a bit of each word by the `edge_state` of its edge.
fn with_states(marks: Marks, states: vec4<u32>, bit: u32) -> Marks {
  let shift = vec4<u32>(bit);
  return Marks(
    marks.marked | ((states & vec4<u32>(1u)) << shift), marks.undecided | ((states >> vec4<u32>(1u)) << shift));
}

// Four columns of samples beside each other.
struct FourColumns {
  before: vec4<u32>, // Only the keys in the rows of the strip.
  current: Column,
  next: Column,
  after: Column,
}

// The columns one sample further on. `after` is the new last one.
fn shifted(columns: FourColumns, after: Column) -> FourColumns {
  return FourColumns(columns.current.keys, columns.next, columns.after, after);
}

// The position of a column of samples in its map. Maps of a cube lie beside each other, and no edge leads from one to the
// next. For a single map `size` is beyond all samples, because its lattice has a border of far samples instead.
struct MapPosition {
  size: vec2<u32>,
  rows: vec4<u32>,
  column: u32,
}

// The edges from the samples `columns.current` along an axis.
fn edges_along(columns: FourColumns, position: MapPosition, axis: u32) -> FourEdges {
  let far = vec4<u32>(FAR_KEY);
  let current = columns.current;
  if (axis == 1u) {
    return FourEdges(
      select(vec4<u32>(current.beyond.x, current.keys.xyz), far, position.rows == vec4<u32>(0u)),
      current.keys,
      vec4<u32>(current.keys.yzw, current.beyond.y),
      select(vec4<u32>(current.keys.zw, current.beyond.yz), far, position.rows + 2u >= vec4<u32>(position.size.y)));
  }
  return FourEdges(
    select(columns.before, far, position.column == 0u),
    current.keys,
    columns.next.keys,
    select(columns.after.keys, far, position.column + 2u >= position.size.x));
}

// Which edges along an axis lead out of a map of a cube, or begin beyond the last column of the lattice. `x` is the column of
// their first samples in the lattice.
fn leads_out(position: MapPosition, x: u32, axis: u32) -> vec4<bool> {
  if (axis == 1u) {
    return (position.rows + 1u == vec4<u32>(position.size.y)) | vec4<bool>(x >= lattice_size().x);
  }
  return vec4<bool>(position.column + 1u == position.size.x || x >= lattice_size().x);
}

// The bits of `sample_bits` for a column of samples, as for the first samples of words. Bit 0: the sample casts. Bit 16: the
// cell to its right and below it is split.
fn bits_of_column(current: Column, next: Column) -> vec4<u32> {
  let below = vec4<u32>(current.keys.yzw, current.beyond.y);
  let next_below = vec4<u32>(next.keys.yzw, next.beyond.y);
  let split = vec4<bool>(
    is_split(vec4<u32>(current.keys.x, next.keys.x, below.x, next_below.x)),
    is_split(vec4<u32>(current.keys.y, next.keys.y, below.y, next_below.y)),
    is_split(vec4<u32>(current.keys.z, next.keys.z, below.z, next_below.z)),
    is_split(vec4<u32>(current.keys.w, next.keys.w, below.w, next_below.w)));
  let casts = select(vec4<u32>(1u), vec4<u32>(0u), current.keys == vec4<u32>(FAR_KEY));
  return casts | select(vec4<u32>(0u), vec4<u32>(0x10000u), split);
}

// Writes the words of a strip: marks, of both levels if edges are continued, and `sample_bits`.
fn mark_strip(strip: u32) {
  let word = first_word_of_strip(strip);
  let corner = vec2<u32>(word.x * WORD_SAMPLES, word.y);
  let map_size = select(vec2<u32>(0x40000000u), depth_map.size, depth_map.faces > 1u);
  var position = MapPosition(map_size, (corner.y + vec4<u32>(0u, 1u, 2u, 3u)) % map_size.y, corner.x % map_size.x);
  var columns: FourColumns;
  var marks: Marks;
  var faint_marks: Marks;
  var bits = vec4<u32>(0u);
  // The first three iterations only load columns.
  for (var index = 0u; index < WORD_SAMPLES + 3u; index++) {
    columns = shifted(columns, load_column(corner + vec2<u32>(index, 0u) - vec2<u32>(1u, 0u)));
    if (index < 3u) {
      continue;
    }
    let bit = index - 3u;
    let sample = corner + vec2<u32>(bit, 0u);
    for (var axis = 0u; axis < 2u; axis++) {
      let four = edges_along(columns, position, axis);
      let never_marked = leads_out(position, sample.x, axis);
      let always_marked = are_object_edges(four, sample, step_along(axis));
      let states = select(edge_states(four, 0u), vec4<u32>(1u), always_marked);
      marks = with_states(marks, select(states, vec4<u32>(0u), never_marked), bit + 16u * axis);
      if (CONTINUES) {
        let faint_states = select(edge_states(four, 1u), vec4<u32>(1u), always_marked);
        faint_marks = with_states(faint_marks, select(faint_states, vec4<u32>(0u), never_marked), bit + 16u * axis);
      }
    }
    bits |= bits_of_column(columns.current, columns.next) << vec4<u32>(bit);
    position.column = select(position.column + 1u, 0u, position.column + 1u == map_size.x);
  }
  marks.marked |= resolve_undecided(corner, marks.undecided, 0u);
  if (CONTINUES) {
    faint_marks.marked |= resolve_undecided(corner, faint_marks.undecided, 1u);
  }
  // Turns: STRIP.
  for (var row = 0u; row < min(STRIP, edge_rule.words.y - word.y); row++) {
    let index = (word.y + row) * edge_rule.words.x + word.x;
    edges[index] = marks.marked[row];
    sample_bits[index] = bits[row];
    if (CONTINUES) {
      faint_edges[index] = faint_marks.marked[row];
    }
  }
}

// The undecided edges of a strip that are marked. They have a loop of their own, because some devices execute a loop's body
// for all invocations if one needs it.
fn resolve_undecided(corner: vec2<u32>, undecided: vec4<u32>, level: u32) -> vec4<u32> {
  var marked = vec4<u32>(0u);
  var remaining = undecided;
  // Turns: 4 * 2 * WORD_SAMPLES.
  while (any(remaining != vec4<u32>(0u))) {
    let row = select(select(select(3u, 2u, remaining.z != 0u), 1u, remaining.y != 0u), 0u, remaining.x != 0u);
    let bit = firstTrailingBit(remaining[row]);
    let sample = corner + vec2<u32>(bit % WORD_SAMPLES, row);
    marked[row] |= select(0u, 1u << bit, is_marked_exact(keys_along(sample, step_along(bit / WORD_SAMPLES)), level));
    remaining[row] &= remaining[row] - 1u;
  }
  return marked;
}
