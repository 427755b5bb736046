//! Queries of occluder counts on the GPU. Without an adapter these tests fail; they are never passed over.

mod on_faces_gpu;
mod shadow_query;

use rimline_testkit::harness;

fn main() {
    harness::run(harness::gpu_trials([shadow_query::TESTS, on_faces_gpu::TESTS].into_iter().flatten().copied()));
}
