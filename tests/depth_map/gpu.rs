//! Volumes from depth maps on the GPU: lists against exact arithmetic and goldens, pictures against rays. Without an
//! adapter these tests fail; they are never passed over.

mod boundary;
#[path = "../shadow/classes.rs"]
#[allow(dead_code, reason = "only its frames are used here")]
mod classes;
mod closed;
mod contact;
mod contours;
mod crossings;
mod cube;
mod distances;
mod exact;
mod extremes;
mod lookup;
mod made_refusals;
mod maps;
mod mesh_depth;
mod metric;
mod near;
mod near_contours;
mod near_rectangles;
mod parity;
mod picture;
mod planes;
mod refusals;
mod rules;
#[path = "../shadow/scene.rs"]
#[allow(dead_code, reason = "only its cameras and rays are used here")]
mod scene;
mod scene_depth;
mod shadows;
mod sheets;
#[path = "../shadow/shells.rs"]
#[allow(dead_code, reason = "only its frames are used here")]
mod shells;
mod stages;
mod vertices;
mod views;
mod wall_vertices;
mod worlds;

use rimline_testkit::harness;

fn main() {
    let tests = [
        // The longest first: threads take them in this order.
        shadows::TESTS,
        lookup::TESTS,
        stages::TESTS,
        metric::TESTS,
        cube::TESTS,
        parity::TESTS,
        contours::TESTS,
        closed::TESTS,
        refusals::TESTS,
        made_refusals::TESTS,
        mesh_depth::TESTS,
        scene_depth::TESTS,
        near::TESTS,
        vertices::TESTS,
        wall_vertices::TESTS,
        near_contours::TESTS,
        near_rectangles::TESTS,
        planes::TESTS,
        contact::TESTS,
        sheets::TESTS,
        crossings::TESTS,
        extremes::TESTS,
    ];
    harness::run(harness::gpu_trials(tests.concat()));
}
