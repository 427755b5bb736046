//! The viewer's page in headless Chromium, by its protocol for debuggers. `cargo xtask web --test` builds the page, and names its folder in
//! `RIMLINE_PAGE`; without it the tests are ignored by name.

#[cfg(unix)]
mod browser;
#[cfg(unix)]
mod check;
#[cfg(unix)]
mod gone;
#[cfg(unix)]
mod pictures;
#[cfg(unix)]
mod server;
#[cfg(unix)]
mod session;

use libtest_mimic::{Arguments, Trial};

fn main() {
    libtest_mimic::run(&Arguments::from_args(), trials()).exit();
}

#[cfg(unix)]
fn trials() -> Vec<Trial> {
    use libtest_mimic::Failed;
    let is_absent = std::env::var_os("RIMLINE_PAGE").is_none();
    let trial = |(name, test): (&str, fn() -> Result<(), String>)| {
        Trial::test(name, move || test().map_err(Failed::from)).with_ignored_flag(is_absent)
    };
    [session::TEST].into_iter().chain(check::TESTS).chain(gone::TESTS).map(trial).collect()
}

#[cfg(not(unix))]
fn trials() -> Vec<Trial> {
    vec![Trial::test("the page in Chromium", || Ok(())).with_ignored_flag(true)]
}
