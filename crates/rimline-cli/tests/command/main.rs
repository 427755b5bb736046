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
mod contract;
mod covered;
mod depth_shadows;
mod draw;
mod fallback;
mod film;
mod foreign;
mod given_depth;
mod given_depth_wrong;
mod info;
mod inputs;
mod instances;
mod keys;
mod load;
#[cfg(target_os = "linux")]
mod memory;
mod messages;
mod models;
mod npz_bounds;
mod npz_input;
mod npz_polygons;
mod obj_input;
mod origin;
mod outlines;
mod outputs;
#[cfg(unix)]
mod outputs_unix;
mod own_gltf;
mod parts;
#[cfg(feature = "bench")]
mod plot_labels;
mod polygon_shadows;
mod polygon_surface;
mod query;
mod query_on_faces;
mod run;
#[cfg(feature = "bench")]
mod schema;
mod seams;
mod shadow;
mod shadow_wrong;
#[cfg(unix)]
mod signals;
mod soft;
mod usage;
mod verify;
mod verify_wrong;
mod warm_up;
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
        usage::TESTS,
        npz_bounds::TESTS,
        npz_input::TESTS,
        npz_polygons::TESTS,
        origin::TESTS,
        obj_input::TESTS,
        contract::TESTS,
        covered::TESTS,
        depth_shadows::TESTS,
        given_depth::TESTS,
        given_depth_wrong::TESTS,
        draw::TESTS,
        outlines::TESTS,
        shadow::TESTS,
        shadow_wrong::TESTS,
        film::TESTS,
        #[cfg(feature = "bench")]
        plot_labels::TESTS,
        polygon_shadows::TESTS,
        polygon_surface::TESTS,
        soft::TESTS,
        instances::TESTS,
        query::TESTS,
        query_on_faces::TESTS,
        verify_wrong::TESTS,
        #[cfg(feature = "bench")]
        schema::TESTS,
        words::TESTS,
        keys::TESTS,
        #[cfg(feature = "bench")]
        bench::TESTS,
        #[cfg(not(feature = "bench"))]
        bench_left_out::TESTS,
        outputs::TESTS,
        inputs::TESTS,
        fallback::TESTS,
        #[cfg(unix)]
        outputs_unix::TESTS,
        #[cfg(unix)]
        signals::TESTS,
        load::TESTS,
        messages::TESTS,
        foreign::TESTS,
        warm_up::TESTS,
        #[cfg(target_os = "linux")]
        memory::TESTS,
        parts::TESTS,
        seams::TESTS,
    ];
    let mut trials: Vec<Trial> = always
        .concat()
        .into_iter()
        .map(|(name, test)| Trial::test(name, move || test().map_err(Failed::from)))
        .collect();
    trials.extend(bad_input::trials());
    trials.extend(models::trials());
    trials.extend(outlines::trials());
    trials.extend(info::trials());
    trials.extend(origin::trials());
    trials.extend(seams::trials());
    trials.extend(cases::trials());
    trials.extend(shadow::trials());
    trials.extend(clipping::trials());
    trials.extend(film::trials());
    trials.extend(verify::trials());
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
