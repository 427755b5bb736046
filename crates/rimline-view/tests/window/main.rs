//! The viewer in a window, under Xvfb: open, drag, switch, screenshot, close. Without Xvfb the tests fail where `cargo xtask
//! test` can install it, and are ignored by name elsewhere.

#[cfg(target_os = "linux")]
mod display;
#[cfg(target_os = "linux")]
mod session;

use libtest_mimic::{Arguments, Trial};

fn main() {
    libtest_mimic::run(&Arguments::from_args(), trials()).exit();
}

#[cfg(target_os = "linux")]
fn trials() -> Vec<Trial> {
    use libtest_mimic::Failed;
    let is_missing = !display::is_installed();
    // Where there is apt, `cargo xtask test` installs it.
    let can_be_ignored = is_missing && !std::path::Path::new("/usr/bin/apt-get").exists();
    let trial = |(name, test): (&str, fn() -> Result<(), String>)| {
        Trial::test(name, move || test().map_err(Failed::from)).with_ignored_flag(can_be_ignored)
    };
    session::TESTS.into_iter().map(trial).collect()
}

#[cfg(not(target_os = "linux"))]
fn trials() -> Vec<Trial> {
    vec![Trial::test("a window under Xvfb", || Ok(())).with_ignored_flag(true)]
}
