// The functions of interface/outlined.wgsl for the edges of an extraction. Group 0 is that of extract/results.wgsl.
//
// Expects: `outline`.

#import extract/results

// A bit for each edge record, set if the caller marked the edge. Only `outline_feature` reads them, and only if the class
// MARKED is drawn: without marks another buffer is bound.
@group(1) @binding(3) var<storage, read> outline_marks: array<u32>;

fn outlined_silhouette(instance: u32) -> RimlineSilhouette { return rimline_silhouette(outline.light, instance); }
fn outlined_record(slot: u32) -> RimlineSilhouette { return rimline_edge(outline.light, slot); }
fn outlined_faces(edge: u32) -> vec2<u32> { return rimline_edge_faces[edge]; }
fn outlined_first_face() -> u32 { return 0u; }
fn outlined_position(vertex: u32) -> vec3<f32> { return rimline_position(vertex); }
fn outlined_offset(vertex: u32) -> vec3<f32> { return rimline_position(vertex) - outline.origin; }
fn outlined_is_marked(edge: u32) -> bool { return ((outline_marks[edge >> 5u] >> (edge & 31u)) & 1u) != 0u; }
