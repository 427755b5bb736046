//! Volumes from depth maps on the GPU: lists against exact arithmetic and goldens, pictures against rays. Without an
//! adapter these tests fail; they are never passed over.

mod boundary;
mod contours;
mod cube;
mod distances;
mod maps;
mod metric;
mod near_contours;
mod near_rectangles;
mod parity;
mod picture;
mod planes;
mod refusals;
mod rules;
mod scene_depth;
mod shadows;
mod stages;
mod vertices;
mod views;
mod worlds;

use rimline_testkit::harness;

fn main() {
    let tests = [
        // The longest first: threads take them in this order.
        shadows::TESTS,
        stages::TESTS,
        metric::TESTS,
        cube::TESTS,
        parity::TESTS,
        contours::TESTS,
        refusals::TESTS,
        scene_depth::TESTS,
        near_contours::TESTS,
        near_rectangles::TESTS,
        planes::TESTS,
        vertices::TESTS,
    ];
    harness::run(harness::gpu_trials(tests.concat()));
}
