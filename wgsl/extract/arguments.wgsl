// Arguments: a compute stage that makes the indirect draw of each light's list of silhouette edges, for callers that draw them,
// and counts lists that overflowed in the statistics. Dispatched once at the end of an extraction, an invocation a light; in a
// scene for each group of casters and batch of up to 32 lights. The draw of a list that overflowed goes over all edges, and the
// caller's vertex shader rejects those that are no silhouettes (extract/results.wgsl): slower, never wrong.

#import common/extraction

@group(0) @binding(0) var<uniform> shape: DrawShape;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
@group(0) @binding(2) var<storage, read_write> draw_arguments: array<DrawArguments>;
@group(0) @binding(3) var<storage, read_write> statistics: ExtractionStatistics;

fn write_arguments(light: u32) {
  var instances = counts[light];
  if (instances > shape.capacity) {
    atomicAdd(&statistics.overflowed_lists, 1u);
    instances = shape.edges;
  }
  draw_arguments[light] = DrawArguments(shape.vertices_per_edge, instances, 0u, 0u);
}

@compute @workgroup_size(64)
fn arguments(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // Turns: 16.
  for (var light = id.x; light < shape.lights; light += 64u * groups.x) {
    write_arguments(light);
  }
}
