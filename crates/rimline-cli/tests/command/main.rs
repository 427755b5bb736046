//! The command, run as a user runs it.
//!
//! Tests on model files take those of the catalogue, and real ones from `RIMLINE_ASSETS`, or else `shared/assets` beside the
//! repository, where they are there.

mod archive;
mod bad_input;
#[cfg(feature = "bench")]
mod bench;
#[cfg(not(feature = "bench"))]
mod bench_left_out;
mod cases;
mod clipping;
mod colors;
mod contract;
mod data;
mod data_wrong;
mod depth_shadows;
mod drawings;
mod facts;
mod fallback;
mod given_depth;
mod info;
mod inputs;
mod instances;
mod jobs;
mod keys;
mod makers;
#[cfg(target_os = "linux")]
mod memory;
mod models;
mod models_of_code;
mod obj;
mod origin;
mod outlines;
mod pictures;
#[cfg(feature = "bench")]
mod plot_labels;
mod polygon_shadows;
mod polygon_surface;
mod query_on_faces;
mod run;
mod schema;
mod seams;
mod shadow;
#[cfg(unix)]
mod signals;
mod small_gltf;
mod soft;
mod verify;
#[cfg(feature = "view")]
mod view;
mod words;

use libtest_mimic::{Arguments, Failed, Trial};

/// A test's name and body.
type Test = (&'static str, fn() -> Outcome);
/// The result of a test: an error says what is wrong.
type Outcome = Result<(), String>;

/// Fails with a message unless the condition holds.
macro_rules! ensure {
    ($condition:expr, $($message:tt)+) => {
        if let false = $condition {
            return Err(format!($($message)+));
        }
    };
}
pub(crate) use ensure;

fn main() {
    let always = [
        archive::TESTS,
        #[cfg(feature = "bench")]
        bench::TESTS,
        #[cfg(not(feature = "bench"))]
        bench_left_out::TESTS,
        colors::TESTS,
        contract::TESTS,
        data_wrong::TESTS,
        depth_shadows::TESTS,
        drawings::files::TESTS,
        drawings::raster::TESTS,
        fallback::TESTS,
        given_depth::TESTS,
        inputs::TESTS,
        instances::TESTS,
        jobs::TESTS,
        keys::TESTS,
        #[cfg(target_os = "linux")]
        memory::TESTS,
        obj::TESTS,
        origin::TESTS,
        outlines::TESTS,
        #[cfg(feature = "bench")]
        plot_labels::TESTS,
        polygon_shadows::TESTS,
        polygon_surface::TESTS,
        query_on_faces::TESTS,
        schema::TESTS,
        seams::TESTS,
        shadow::TESTS,
        #[cfg(unix)]
        signals::TESTS,
        soft::TESTS,
        verify::TESTS,
        #[cfg(feature = "view")]
        view::TESTS,
        words::TESTS,
    ];
    let mut trials: Vec<Trial> = always
        .concat()
        .into_iter()
        .map(|(name, test)| Trial::test(name, move || test().map_err(Failed::from)))
        .collect();
    let on_files = [
        bad_input::trials(),
        cases::trials(),
        clipping::trials(),
        data::trials(),
        drawings::raster::trials(),
        info::trials(),
        models::trials(),
        origin::trials(),
        outlines::trials(),
        seams::trials(),
        shadow::trials(),
        verify::trials(),
    ];
    trials.extend(on_files.into_iter().flatten());
    let conclusion = libtest_mimic::run(&Arguments::from_args(), trials);
    rimline_testkit::device::Gpu::close();
    conclusion.exit();
}
