//! glTF loading: good and bad files of the catalogue and of the shared models, hand-made files, and mutated ones.
//!
//! Tests on the shared models are ignored where the folder is not there: `RIMLINE_ASSETS`, else `../shared/assets` beside the crate.

mod animate;
mod bad;
mod cameras;
mod check;
mod colors;
mod details;
mod good;
mod instances;
mod mutate;
mod origin;
mod outside;
mod refuse;
mod rows;
mod shape;
mod visible;
mod warned;

use libtest_mimic::{Arguments, Failed, Trial};
use rimline_models::maker;

/// Result of a test.
type Outcome = Result<(), Failed>;

fn main() {
    let tests = [
        check::tests(),
        good::tests(),
        bad::tests(),
        shape::tests(),
        instances::tests(),
        animate::tests(),
        visible::tests(),
        warned::tests(),
        refuse::tests(),
        outside::tests(),
        details::tests(),
        mutate::tests(),
        origin::tests(),
        colors::tests(),
        cameras::tests(),
    ];
    libtest_mimic::run(&Arguments::from_args(), tests.into_iter().flatten().collect()).exit();
}

/// A test that runs everywhere.
fn test(name: impl Into<String>, run: impl FnOnce() -> Outcome + Send + 'static) -> Trial {
    Trial::test(name, run)
}

/// Fails with a message unless the condition holds.
fn ensure(condition: bool, message: impl FnOnce() -> String) -> Outcome {
    if condition { Ok(()) } else { Err(message().into()) }
}

fn same<T: PartialEq + std::fmt::Debug>(found: &T, expected: &T, what: &str) -> Outcome {
    ensure(found == expected, || format!("{what}: {found:?}, expected {expected:?}"))
}
