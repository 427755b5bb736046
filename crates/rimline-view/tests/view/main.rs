//! The viewer without a display: events in, pictures out.

mod panel;
mod pictures;
mod support;
mod touch;

fn main() {
    let tests = panel::TESTS.iter().chain(&touch::TESTS).chain(&pictures::TESTS).copied();
    rimline_testkit::harness::run(rimline_testkit::harness::gpu_trials(tests));
}
