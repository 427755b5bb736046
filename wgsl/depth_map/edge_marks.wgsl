// Marks of edges, many at once: a word has 16 samples that follow each other in a row of the lattice. It has a bit for the edge
// from each sample to the next one on the right, and 16 bits higher one for the edge to the sample below.

// What an earlier pass marked.
@group(0) @binding(7) var<storage, read> edges_before: array<u32>;

// For as many samples, whether each casts, and 16 bits higher whether the cell below it and on its right is split.
@group(0) @binding(10) var<storage, read_write> sample_bits: array<u32>;

// A triangle is drawn if one of its samples is so many edges, less one, from the end of a marked edge.
override RINGS: u32 = 2u;

// Where a word is, and whether there is one.
struct WordPlace {
  index: u32,
  exists: bool,
}

fn word_at(word: i32, row: i32) -> WordPlace {
  let exists = all(vec2<i32>(word, row) >= vec2<i32>(0)) && all(vec2<i32>(word, row) < vec2<i32>(edge_rule.words));
  return WordPlace(select(0u, u32(row) * edge_rule.words.x + u32(word), exists), exists);
}

// The lower and the higher halves of two words, from a place on: 17 samples or more.
fn halves_from(first: u32, second: u32, place: i32) -> vec2<u32> {
  let both = vec2<u32>((first & 0xffffu) | (second << 16u), (first >> 16u) | (second & 0xffff0000u));
  return both >> vec2<u32>(u32(place & 15));
}

// Marks of 17 samples or more from a place on: edges across, and down. Samples that do not exist have none.
fn marks_from(at: vec2<i32>) -> vec2<u32> {
  let first = word_at(at.x >> 4u, at.y);
  let second = word_at((at.x >> 4u) + 1, at.y);
  return halves_from(
    select(0u, edges_before[first.index], first.exists), select(0u, edges_before[second.index], second.exists), at.x);
}

// Of 17 samples or more from a place on: which of them cast, and which cells are split.
fn samples_from(at: vec2<i32>) -> vec2<u32> {
  let first = word_at(at.x >> 4u, at.y);
  let second = word_at((at.x >> 4u) + 1, at.y);
  return halves_from(
    select(0u, sample_bits[first.index], first.exists), select(0u, sample_bits[second.index], second.exists), at.x);
}

// For 17 cells from a place on, whether exactly one of their edges is marked.
fn dangling_from(at: vec2<i32>) -> u32 {
  let own = marks_from(at);
  let bottom = marks_from(at + vec2<i32>(0, 1)).x;
  let right = marks_from(at + vec2<i32>(1, 0)).y;
  let two = (own.x & bottom) | (own.y & right) | ((own.x | bottom) & (own.y | right));
  var single = (own.x | bottom | own.y | right) & ~two;
  if (depth_map.faces > 1u) {
    // There are none between two maps.
    let side = i32(depth_map.size.x);
    for (var cell = 0; cell < 17; cell++) {
      let is_between = any((at + vec2<i32>(cell, 0) + side) % side == vec2<i32>(side - 1));
      single &= ~select(0u, 1u << u32(cell), is_between);
    }
  }
  return single;
}

// Samples on the borders of a map of a cube: other maps may have marked edges at them. `in_map`: a place in the map.
struct Borders {
  in_map: vec2<i32>,
  // Of 13 samples from there on, those in its first or last column.
  columns: u32,
}

fn borders_from(in_map: vec2<i32>) -> Borders {
  let last = i32(depth_map.size.x) - 1 - in_map.x;
  let first_columns = select(0u, (2u << u32(-in_map.x)) - 1u, in_map.x <= 0);
  let last_columns = select(0u, 0xffffffffu << u32(last), last < 32);
  return Borders(in_map, select(0u, first_columns | last_columns, depth_map.faces > 1u));
}

// Samples of a row that are at the end of a marked edge, or on a border, but for the first. `marks` are those of the row,
// `down_before` those of the edges down from the row before. `row`: from the place of the borders on.
fn ends_of(marks: vec2<u32>, down_before: u32, borders: Borders, row: i32) -> u32 {
  let in_map = borders.in_map.y + row;
  let is_border = depth_map.faces > 1u && (in_map <= 0 || in_map >= i32(depth_map.size.y) - 1);
  return marks.x | (marks.x << 1u) | marks.y | down_before | select(borders.columns, 0xffffffffu, is_border);
}
