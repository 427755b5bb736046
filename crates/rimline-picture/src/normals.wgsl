// The normal of each group of corners: the sum over its faces by area, at the positions of now. A large group is cut into
// pieces, since llvmpipe ends all loops of an invocation after 65,535 turns together (docs/numerics/loops.md):
// `sums_of_pieces`, then `normals_of_pieces`, an invocation a piece. `normals_of_groups` takes the other groups.

@group(0) @binding(0) var<storage, read> positions: array<f32>;
@group(0) @binding(1) var<storage, read> faces: array<u32>;
// Where the faces and the corners of each group begin, and at last where they end.
@group(0) @binding(2) var<storage, read> starts: array<vec2<u32>>;
// `members`: the faces of one group after the other; a face may be in several. `corners`: their corners, each in one group.
@group(0) @binding(3) var<storage, read> members: array<u32>;
@group(0) @binding(4) var<storage, read> corners: array<u32>;
// One a corner, folded onto an octahedron.
@group(0) @binding(5) var<storage, read_write> normals: array<u32>;

// Begin and end of the faces of a piece in `members`, of its corners in `corners`, and of the pieces of its group.
struct Piece {
  faces: vec2<u32>,
  corners: vec2<u32>,
  of_group: vec2<u32>,
  sum: vec3<f32>,
}

@group(0) @binding(6) var<storage, read_write> pieces: array<Piece>;

// The most faces, and corners, of a piece or of a group that is not cut. crates/rimline-picture/src/smoothing.rs has it, too.
const PIECE: u32 = 4096u;
// 16 million faces at a vertex are more than a binding of llvmpipe holds.
const MOST_PIECES: u32 = 4096u;

fn position(vertex: u32) -> vec3<f32> {
  return vec3<f32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

// The inverse of `unfold` but for the length, which may be any.
fn fold(n: vec3<f32>) -> u32 {
  let flat = n / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-37);
  let over = (1.0 - abs(flat.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), flat.xy >= vec2<f32>(0.0));
  return pack2x16snorm(select(flat.xy, over, flat.z < 0.0));
}

// The sum over faces: their indices are `members` from `first` to before `end`.
fn sum_of_faces(first: u32, end: u32) -> vec3<f32> {
  var sum = vec3<f32>(0.0);
  // Turns: PIECE.
  for (var i = first; i < end; i++) {
    let face = 3u * members[i];
    let a = position(faces[face]);
    sum += cross(position(faces[face + 1u]) - a, position(faces[face + 2u]) - a);
  }
  return sum;
}

fn write_normal(sum: vec3<f32>, first: u32, end: u32) {
  let normal = fold(sum);
  // Turns: PIECE.
  for (var i = first; i < end; i++) {
    normals[corners[i]] = normal;
  }
}

@compute @workgroup_size(64) fn normals_of_groups(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(num_workgroups) workgroups: vec3<u32>,
) {
  let group = id.x + id.y * 64u * workgroups.x;
  if (group + 1u >= arrayLength(&starts)) {
    return;
  }
  let first = starts[group];
  let end = starts[group + 1u];
  if (all(end - first <= vec2<u32>(PIECE))) {
    write_normal(sum_of_faces(first.x, end.x), first.y, end.y);
  }
}

@compute @workgroup_size(64) fn sums_of_pieces(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(num_workgroups) workgroups: vec3<u32>,
) {
  let piece = id.x + id.y * 64u * workgroups.x;
  if (piece < arrayLength(&pieces)) {
    pieces[piece].sum = sum_of_faces(pieces[piece].faces.x, pieces[piece].faces.y);
  }
}

@compute @workgroup_size(64) fn normals_of_pieces(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(num_workgroups) workgroups: vec3<u32>,
) {
  let piece = id.x + id.y * 64u * workgroups.x;
  if (piece >= arrayLength(&pieces)) {
    return;
  }
  var sum = vec3<f32>(0.0);
  let end = pieces[piece].of_group.y;
  // Turns: MOST_PIECES.
  for (var part = pieces[piece].of_group.x; part < end; part++) {
    sum += pieces[part].sum;
  }
  write_normal(sum, pieces[piece].corners.x, pieces[piece].corners.y);
}
