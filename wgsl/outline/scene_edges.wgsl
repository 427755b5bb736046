// The functions of interface/outlined.wgsl for a group of a scene's casters, in the variant SCENE of `outline_edges`. A slot
// is the index of a face or edge record in the group's masks. Facing masks decide which edges are silhouettes, by the same
// function as for shadow sides (`side_of_edge`). So a draw by the list and a draw over all slots show the same edges. Only
// casters for which the light is relevant have outlines: masks of other casters have no meaning.
//
// Expects: `outline`, `NO_EDGE`.

#import common/casters
#import common/extraction
#import extract/results
#import shadow/caster
#import shadow/draw_lists
#import shadow/shadow

// A group of casters and a light.
struct OutlinedGroup {
  edge_chunks_offset: u32, // The offset in the table, in vec4s, of the casters of the group's chunks of edges.
  relevant_lights_offset: u32, // The offset in `relevant_lights` of the light's batch, for the first caster of the table.
  capacity: u32, // Entries that the list of each light has room for.
  twisted_offset: u32, // The offset of the twisted masks, which lie behind the facing masks. 0: there are none.
  bit: u32, // The light's bit in its batch.
  reserved_0: u32,
  reserved_1: u32,
  reserved_2: u32,
}

@group(0) @binding(0) var<uniform> outlined: OutlinedGroup;
@group(0) @binding(1) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> relevant_lights: array<u32>; // For each batch and caster, a bit for each light.
@group(0) @binding(3) var<storage, read> positions: array<u32>;
@group(0) @binding(4) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> edge_faces: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> facing_masks: array<u32>;
@group(0) @binding(7) var<storage, read> silhouettes: array<u32>; // The counts of all lights, then the lists.
const LISTS_HEAD: u32 = 64u; // Words before the lists.

// The caster of the slot that `outlined_record` read last.
var<private> outlined_caster: u32;

fn outlined_silhouette(instance: u32) -> RimlineSilhouette {
  // A list that overflowed is drawn over all slots.
  if (silhouettes[outlined.bit] > outlined.capacity) {
    return outlined_record(instance);
  }
  return outlined_record(silhouettes[LISTS_HEAD + outlined.bit * outlined.capacity + instance] & ~WINDING);
}

// The light's bits of the masks of two faces.
fn outlined_bits(first: u32, slots: vec2<u32>) -> vec2<bool> {
  let masks = vec2<u32>(facing_masks[first + slots.x], facing_masks[first + slots.y]);
  return ((masks >> vec2<u32>(outlined.bit)) & vec2<u32>(1u)) != vec2<u32>(0u);
}

fn outlined_record(slot: u32) -> RimlineSilhouette {
  outlined_caster = caster_of_slot(outlined.edge_chunks_offset, slot);
  let range = edge_range(outlined_caster);
  let is_relevant = ((relevant_lights[outlined.relevant_lights_offset + outlined_caster] >> outlined.bit) & 1u) != 0u;
  if (slot - range.x >= range.y || !is_relevant) {
    return RimlineSilhouette(false, 0u, 0u, 0u, false, NO_EDGE);
  }
  let edge = range.z + slot - range.x;
  let faces = edge_faces[edge];
  let is_boundary = faces.y == NO_FACE;
  let slots = vec2<u32>(face_range(outlined_caster).x) + vec2<u32>(faces.x & ~INCONSISTENT, select(faces.y, 0u, is_boundary));
  var twisted = vec2<bool>(false);
  if (outlined.twisted_offset != 0u) {
    twisted = outlined_bits(outlined.twisted_offset, slots);
  }
  let side = side_of_edge(CAST_EVERY, faces, outlined_bits(0u, slots), twisted);
  let vertices = edge_vertices[edge];
  let kind = select(faces.x >> 31u, 2u, is_boundary);
  return RimlineSilhouette(side.weight != 0u, edge, vertices.x, vertices.y, side.winding, kind);
}

fn outlined_faces(edge: u32) -> vec2<u32> { return edge_faces[edge]; }
fn outlined_first_face() -> u32 { return face_range(outlined_caster).z; }

// A row of the matrix from the caster's positions to world space. The matrix is the identity if positions are in a buffer.
fn outlined_row(axis: u32) -> vec4<f32> { return bitcast<vec4<f32>>(caster_part(outlined_caster, axis)); }

fn outlined_position(vertex: u32) -> vec3<f32> {
  let position = vertex_position(outlined_caster, vertex);
  return vec3<f32>(
    dot_3(outlined_row(0u).xyz, position), dot_3(outlined_row(1u).xyz, position), dot_3(outlined_row(2u).xyz, position));
}

// Subtracts the camera's origin from the matrix first, like `view_for_caster`, for a better rounding.
fn outlined_offset(vertex: u32) -> vec3<f32> {
  let shift = vec3<f32>(outlined_row(0u).w, outlined_row(1u).w, outlined_row(2u).w);
  return outlined_position(vertex) + (shift - outline.origin);
}

// Callers mark edges of extractions only.
fn outlined_is_marked(edge: u32) -> bool { return false; }
