//! Zero of anything on the GPU: meshes without a triangle, no lights, no points. Nothing is found, and nothing fails. Scenes
//! of such meshes: `tests/scene/zero.rs`.

use rimline::Light;
use rimline::gpu::{Extractor, ExtractorOptions, ListOptions, PositionBuffer, ShadowQuery, ShadowQueryOptions};
use rimline_testkit::cases::{CORNERS, without_extent};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::same;

pub(crate) const TESTS: &[Test] = &[("meshes_without_a_triangle_are_taken", without_triangles)];

const LIGHTS: [Light; 2] = [Light::point([0.0, 0.0, 2.0]), Light::directional([0.0, 0.0, 1.0])];

fn without_triangles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let buffers = [gpu.storage(&CORNERS), gpu.storage(&[[0.2_f32, 0.2, -1.0], [f32::NAN; 3]])];
    let [positions, points] = [0, 1].map(|at| PositionBuffer { buffer: &buffers[at], offset: 0, stride: 12 });
    for (number, mesh) in without_extent().iter().enumerate() {
        let what = |error: &dyn std::fmt::Display| format!("mesh {number}: {error}");
        for lists in [None, Some(ListOptions::default()), Some(ListOptions { ordered: true, ..Default::default() })] {
            let options =
                ExtractorOptions { max_lights: 40, masks: true, lists, for_volumes: true, ..Default::default() };
            let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(|error| what(&error))?;
            for lights in [&LIGHTS[..], &[]] {
                gpu.submit(|encoder| {
                    extractor.encode(encoder, positions, lights).map(drop).map_err(|error| what(&error))
                })?;
            }
        }
        for max_points in [0, 2] {
            let options = ShadowQueryOptions { max_points, max_lights: 2, ..Default::default() };
            let mut query = ShadowQuery::new(&gpu.pipelines, mesh, options).map_err(|error| what(&error))?;
            for lights in [&[][..], &LIGHTS] {
                gpu.submit(|encoder| {
                    let encoded = query.encode_at(encoder, positions, points, max_points, lights);
                    encoded.map_err(|error| what(&error))
                })?;
            }
            let depths: Vec<i32> = gpu.read(query.occluder_counts(), 2 * max_points as usize)?;
            // The second point is not finite.
            same("depths", &depths, &[0, 0, -1, -1][..depths.len()])?;
        }
    }
    Ok(())
}
