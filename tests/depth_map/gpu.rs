//! Volumes from depth maps on the GPU: lists against exact arithmetic and goldens, pictures against rays. Without an adapter these tests fail;
//! they are never passed over.

mod analytic;
mod boundary;
mod cells;
#[path = "../shadow/classes.rs"]
#[allow(dead_code, reason = "only its frames are used here")]
mod classes;
mod contact;
mod contours;
mod cube;
mod distances;
mod exact;
mod extremes;
mod eye_formats;
mod flaps;
mod hostile;
mod large_picture;
mod lookup;
mod maps;
mod merge;
mod mesh_depth;
mod metric;
mod missed;
mod near;
mod near_contours;
mod near_places;
mod near_rectangles;
mod parity;
mod picture;
mod places;
mod refusals;
mod rules;
#[path = "../shadow/scene.rs"]
#[allow(dead_code, reason = "only its cameras and rays are used here")]
mod scene;
mod scene_depth;
mod scene_depth_choices;
mod shadow_classes;
mod sheets;
#[path = "../shadow/shells.rs"]
#[allow(dead_code, reason = "only its frames are used here")]
mod shells;
mod stages;
mod statistics;
mod textures;
mod units;
mod vertices;
mod views;
mod wall_vertices;
mod worlds;
mod zero;

use rimline_testkit::{harness, probe};

fn main() {
    let tests = [
        // The longest first: threads take them in this order.
        analytic::TESTS,
        lookup::TESTS,
        shadow_classes::TESTS,
        stages::TESTS,
        merge::TESTS,
        metric::TESTS,
        cube::TESTS,
        parity::TESTS,
        contours::TESTS,
        extremes::TESTS,
        refusals::TESTS,
        mesh_depth::TESTS,
        scene_depth::TESTS,
        scene_depth_choices::TESTS,
        near::TESTS,
        statistics::TESTS,
        vertices::TESTS,
        near_places::TESTS,
        wall_vertices::TESTS,
        eye_formats::TESTS,
        missed::TESTS,
        near_contours::TESTS,
        flaps::TESTS,
        near_rectangles::TESTS,
        units::TESTS,
        hostile::TESTS,
        large_picture::TESTS,
        contact::TESTS,
        sheets::TESTS,
        zero::TESTS,
        cells::TESTS,
        places::TESTS,
    ];
    harness::run(harness::gpu_trials(tests.concat()));
}
