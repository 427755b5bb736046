//! Zero of anything on the GPU: meshes without a triangle, no lights, no points. Nothing is found, and nothing fails.

use rimline::gpu::{
    Extractor, ExtractorOptions, ListOptions, PositionBuffer, ShadowFormat, ShadowPipelines, ShadowQuery,
    ShadowQueryOptions,
};
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{Counting, DepthDirection, Light, Mesh, ShadowCamera};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{one_caster, text};

pub(crate) const TESTS: &[Test] = &[("meshes_without_a_triangle_are_taken", without_triangles)];

const CORNERS: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const LIGHTS: [Light; 2] = [Light::point([0.0, 0.0, 2.0]), Light::directional([0.0, 0.0, 1.0])];

/// An edge walked both ways and a hole that is its loop, as polygons and as triangles; and a face of one vertex.
fn meshes() -> Result<Vec<Mesh>, String> {
    let walked_back = PolygonLoops { polygon_loops: &[1], loop_sizes: &[4], loop_corners: &[0, 1, 1, 0] };
    let filled = PolygonLoops { polygon_loops: &[2], loop_sizes: &[3, 3], loop_corners: &[0, 1, 2, 2, 1, 0] };
    let mut meshes = vec![Mesh::from_faces(3, vec![[0; 3]]).map_err(text)?];
    for loops in [walked_back, filled] {
        meshes.push(Mesh::from_polygons(&CORNERS, loops, Weld::Keep).map_err(text)?);
        meshes.push(Mesh::from_polygons_by_loop(&CORNERS, loops, Weld::Keep).map_err(text)?);
    }
    Ok(meshes)
}

fn without_triangles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let buffers = [gpu.storage(&CORNERS), gpu.storage(&[[0.2_f32, 0.2, -1.0]])];
    let [positions, points] = [0, 1].map(|at| PositionBuffer { buffer: &buffers[at], offset: 0, stride: 12 });
    let view_projection = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.1, 0.0]];
    let camera = ShadowCamera { view_projection, origin: [0.0, 0.0, 4.0], depth: DepthDirection::Reversed };
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    for (number, mesh) in meshes()?.iter().enumerate() {
        let what = |error: &dyn std::fmt::Display| format!("mesh {number}: {error}");
        for lists in [None, Some(ListOptions::default()), Some(ListOptions { ordered: true, ..Default::default() })] {
            let options =
                ExtractorOptions { max_lights: 40, masks: true, lists, for_volumes: true, ..Default::default() };
            let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(|error| what(&error))?;
            for lights in [&LIGHTS[..], &[]] {
                gpu.submit(|encoder| extractor.encode(encoder, positions, lights).map(drop).map_err(text))
                    .map_err(|error| what(&error))?;
            }
            if lists.is_none() {
                continue;
            }
            let options = OneCasterOptions { bound_counts: true, ..Default::default() };
            let mut caster = one_caster(gpu, &pipelines, mesh, options).map_err(|error| what(&error))?;
            gpu.submit(|encoder| {
                extractor.encode(encoder, positions, &LIGHTS).map_err(text)?;
                caster.encode(encoder, positions, &LIGHTS, Some(&camera), None).map(drop).map_err(text)
            })
            .map_err(|error| what(&error))?;
        }
        for max_points in [0, 1] {
            let options = ShadowQueryOptions { max_points, max_lights: 2, ..Default::default() };
            let mut query = ShadowQuery::new(&gpu.pipelines, mesh, options).map_err(|error| what(&error))?;
            for lights in [&LIGHTS[..], &[]] {
                gpu.submit(|encoder| query.encode_at(encoder, positions, points, max_points, lights).map_err(text))
                    .map_err(|error| what(&error))?;
            }
            gpu.submit(|encoder| query.encode_at(encoder, positions, points, max_points, &LIGHTS).map_err(text))?;
            let depths: Vec<i32> = gpu.read(query.occluder_counts(), 2 * max_points as usize)?;
            if depths.iter().any(|&depth| depth != 0) {
                return Err(format!("mesh {number}: depths {depths:?}"));
            }
        }
    }
    Ok(())
}
