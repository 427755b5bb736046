//! The viewer without a display: events in, pictures out.

mod panel;
mod pictures;
mod support;

fn main() {
    let tests = panel::TESTS.iter().chain(&pictures::TESTS).copied();
    rimline_testkit::harness::run(rimline_testkit::harness::gpu_trials(tests));
}
