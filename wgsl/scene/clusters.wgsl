// Clusters: a compute stage of a scene that decides whether all faces of a cluster (128 faces of a mesh, with a bound on their
// planes) face a light, or none does, for a batch of up to 32 lights. Dispatched after `reach` for each group of casters and
// batch; invocations share the chunks, 64 face slots of one caster each. It takes the lights in `taken`, which `reach` chose, and
// lists in `work` the chunks with a bit that is to be tested or changed, in no particular order, for `facing`, with what is
// decided already; and it notes in `kept` what the masks will hold, for `chunks` and the next encode. It decides only what exact
// facing would decide the same way, so bounds must not shrink. docs/numerics/clusters.md.

#import common/casters
#import scene/many_casters
#import scene/table

@group(0) @binding(4) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> kept: array<u32>;
@group(0) @binding(7) var<storage, read_write> statistics: SceneStatistics;
// Kinds of bounds, the fourth word of one. Kind 1 decides that all faces face a light, or that none does.
const MIXED: u32 = 0u; // It decides nothing.
const AT_MOST_AVERTED: u32 = 2u; // It decides only that none does: some faces name a vertex twice.
const AVERTED: u32 = 3u; // No face ever faces a light.
// 2.5 units in the last place: the most that the rounding of w centre adds, relative to its size.
const PRODUCT: f32 = 2.5 * 0x1p-23;
const LEAST: f32 = 0x1p-118; // The most that underflow adds.

// Lights that are decided for a whole cluster, and those of them that its faces face.
struct Decision {
  decided: u32,
  facing: u32,
}

fn four_words(at: u32) -> vec4<u32> {
  return vec4<u32>(cluster_words[at], cluster_words[at + 1u], cluster_words[at + 2u], cluster_words[at + 3u]);
}

// Decides the lights that are taken for the caster at hand by the bound at word `at` of `cluster_words`: the centre and the kind;
// the middle of all planes through the centre, normal and offset; half their spread.
fn decide(at: u32) -> Decision {
  let first = four_words(at);
  let kind = first.w;
  if (kind == MIXED) {
    return Decision(0u, 0u);
  }
  if (kind == AVERTED) {
    return Decision(matter, 0u);
  }
  let centre = bitcast<vec3<f32>>(first.xyz);
  let middle = bitcast<vec4<f32>>(four_words(at + 4u));
  let half = bitcast<vec4<f32>>(four_words(at + 8u));
  let size = abs(centre.x) + abs(centre.y) + abs(centre.z);
  var decision = Decision(0u, 0u);
  var place = 0u;
  for (var rest = lights.allowed; rest != 0u; rest &= rest - 1u) {
    let bit = (rest & (~rest + 1u)) & matter;
    if (bit != 0u) {
      let light = scaled_light(place);
      let inexact = inexact_w(place);
      let t = light.xyz - light.w * centre;
      let height = middle.x * t.x + middle.y * t.y + middle.z * t.z + middle.w * light.w;
      let sizes = abs(t);
      let spread = half.x * sizes.x + half.y * sizes.y + half.z * sizes.z + half.w * max(abs(light.w), inexact) +
        PRODUCT * inexact * size + LEAST;
      let is_facing = height > spread && kind != AT_MOST_AVERTED;
      decision.decided |= select(0u, bit, is_facing || height < -spread);
      decision.facing |= select(0u, bit, is_facing);
    }
    place++;
  }
  return decision;
}

// Lists a chunk of the caster at hand for `facing`, with what is decided for all its faces.
fn list_faces(chunk: u32, decision: Decision) {
  let at = group.face_work + FACE_ENTRY * atomicAdd(&work[group.work_count], 1u);
  atomicStore(&work[at], chunk);
  atomicStore(&work[at + 1u], decision.decided);
  atomicStore(&work[at + 2u], decision.facing);
  atomicStore(&work[at + 3u], select(places_of(matter & ~decision.decided), 0xffffffffu, decision.decided == 0u));
  if ((matter & ~decision.decided) != 0u) {
    atomicAdd(&statistics.faces, faces_in(chunk));
  } else {
    atomicAdd(&statistics.spared_faces, faces_in(chunk));
  }
}

fn faces_in(chunk: u32) -> u32 { return min(CHUNK, of_faces.x + of_faces.y - CHUNK * chunk); }

// Takes the chunks of the cluster that begins with `chunk`. `number` is the cluster's among those of the caster.
fn take_cluster(chunk: u32, number: u32) {
  let decision = decide(caster_part(caster, 7u).w + BOUND_WORDS * number);
  let at = kept_cluster_at(chunk);
  var before = Decision(0u, 0u);
  if (kept[0] == group.structure) {
    before = Decision(kept[at], kept[at + 1u]);
  }
  kept[at] = (before.decided & ~matter) | decision.decided;
  kept[at + 1u] = (before.facing & ~matter) | decision.facing;
  // Where the masks have these bits already, nothing is to be done.
  let is_known = (matter & ~(decision.decided & before.decided)) == 0u &&
    ((decision.facing ^ before.facing) & matter) == 0u;
  let end = min(chunk + CLUSTER_CHUNKS, (of_faces.x + of_faces.y + CHUNK - 1u) / CHUNK);
  // Turns: CLUSTER_CHUNKS.
  for (var each = chunk; each < end; each++) {
    if (is_known) {
      atomicAdd(&statistics.spared_faces, select(0u, faces_in(each), matter != 0u));
    } else {
      list_faces(each, decision);
    }
  }
}

// Takes the cluster that begins with a chunk, or the chunk itself where a caster has no clusters.
fn take_chunk(chunk: u32) {
  take_caster(caster_of(group.face_chunks_at, chunk));
  if (!has_clusters(caster)) {
    if (matter != 0u) {
      list_faces(chunk, Decision(0u, 0u));
    }
    return;
  }
  let number = chunk - of_faces.x / CHUNK;
  if (number % CLUSTER_CHUNKS == 0u) {
    take_cluster(chunk, number / CLUSTER_CHUNKS);
  }
}

@compute @workgroup_size(256)
fn clusters(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // Where no list is made anew, no bit is.
  let is_still = atomicLoad(&work[group.work_count + 2u]) == 0u;
  // Turns: SCENE_ITEMS.
  for (var chunk = id.x; chunk < select(group.face_chunks, 0u, is_still); chunk += 256u * groups.x) {
    take_chunk(chunk);
  }
}
