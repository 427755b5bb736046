//! The command, run as a user runs it.
//!
//! Tests on model files take those of the catalogue, and real ones from `RIMLINE_ASSETS`, or else `shared/assets` beside the
//! repository, where they are there.

mod archive;
#[cfg(feature = "bench")]
mod bench;
#[cfg(not(feature = "bench"))]
mod bench_left_out;
mod cases;
mod clipping;
mod data;
mod data_wrong;
mod drawings;
mod facts;
mod info;
mod instances;
mod keys;
mod makers;
#[cfg(target_os = "linux")]
mod memory;
mod models_of_code;
mod outlines;
mod pictures;
#[cfg(feature = "bench")]
mod plot_labels;
mod run;
mod schema;
mod shadow;
#[cfg(unix)]
mod signals;
mod small_gltf;
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
        data_wrong::TESTS,
        drawings::files::TESTS,
        drawings::raster::TESTS,
        instances::TESTS,
        keys::TESTS,
        #[cfg(target_os = "linux")]
        memory::TESTS,
        outlines::TESTS,
        #[cfg(feature = "bench")]
        plot_labels::TESTS,
        schema::TESTS,
        #[cfg(unix)]
        signals::TESTS,
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
        cases::trials(),
        clipping::trials(),
        data::trials(),
        drawings::raster::trials(),
        info::trials(),
        outlines::trials(),
        shadow::trials(),
        verify::trials(),
    ];
    trials.extend(on_files.into_iter().flatten());
    let conclusion = libtest_mimic::run(&Arguments::from_args(), trials);
    rimline_testkit::device::Gpu::close();
    conclusion.exit();
}
