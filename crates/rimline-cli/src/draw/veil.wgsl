// Veils: for each square of the survey (model.wgsl), and for larger ones, the depth behind which everything in the square is
// certainly hidden. lines.wgsl tests them first: they hide most lines in scenes of many bodies.

@group(1) @binding(0) var seen: texture_2d<u32>;
@group(1) @binding(1) var<storage, read> positions: array<f32>;
@group(1) @binding(2) var<storage, read> faces: array<u32>;

// The side of a square of the finest level, in texels of the survey; SQUARE_BITS in lines.wgsl, SQUARE in
// outline_picture.rs.
const SQUARE = 8;
// Bound on rounding errors, as a share of a distance.
const SLACK = 1e-5;
// Bits of infinity: nothing is hidden where the survey sees nothing.
const OPEN = 0x7f800000u;

fn from_eye(face: u32, corner: u32) -> vec3<f32> {
  let first = 3u * faces[3u * face + corner];
  return vec3<f32>(positions[first], positions[first + 1u], positions[first + 2u]) - frame.eye;
}

// Not shorter than the vector, and nothing is squared.
fn size_of(v: vec3<f32>) -> f32 {
  return abs(v.x) + abs(v.y) + abs(v.z);
}

// A point farther ahead of the eye than this is far behind the face, as `verdict_of` in lines.wgsl tests it.
fn veil_of(face: u32) -> f32 {
  let a = from_eye(face, 0u);
  let b = from_eye(face, 1u);
  let c = from_eye(face, 2u);
  let farthest = max(max(dot(a, frame.forward), dot(b, frame.forward)), dot(c, frame.forward));
  let longest = max(size_of(b - a), max(size_of(c - a), size_of(c - b)));
  return farthest + 2.0 * longest + SLACK * max(size_of(a), max(size_of(b), size_of(c)));
}

// Bits of the largest veil in a square. Positive floats have the order of their bits. 0 beyond the survey, where nobody looks.
@fragment fn veil_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<u32> {
  let first = SQUARE * vec2<i32>(at.xy);
  let end = min(first + SQUARE, frame.survey_scale * vec2<i32>(frame.size));
  var known = 0u;
  var largest = 0.0;
  // Turns: SQUARE.
  for (var y = first.y; y < end.y; y++) {
    // Turns: SQUARE.
    for (var x = first.x; x < end.x; x++) {
      let halves = textureLoad(seen, vec2<i32>(x, y), 0).rg;
      let face = halves.x | (halves.y << 16u);
      if (face == 0u) {
        return vec4<u32>(OPEN);
      }
      if (face != known) {
        known = face;
        let veil = veil_of(face - 1u);
        // Written so that what is no number ends here.
        if (!(veil < 1e37)) {
          return vec4<u32>(OPEN);
        }
        largest = max(largest, veil);
      }
    }
  }
  return vec4<u32>(bitcast<u32>(largest));
}

// A level of veils from the next finer one, which is bound instead of the survey.
@fragment fn veil_level_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<u32> {
  let first = 2 * vec2<i32>(at.xy);
  var largest = 0u;
  for (var corner = 0; corner < 4; corner++) {
    // A side of one square has no second one: nothing is there, and 0 is read or the same square again.
    let texel = first + vec2<i32>(corner & 1, corner >> 1u);
    largest = max(largest, textureLoad(seen, texel, 0).r);
  }
  return vec4<u32>(largest);
}
