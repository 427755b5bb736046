//! The viewer without a display: events in, pictures out.

mod keyboard;
mod normals;
mod panel;
mod pictures;
mod pointer;
mod refused;
mod support;
mod touch;

fn main() {
    let of_panel = panel::TESTS.iter().chain(&keyboard::TESTS).chain(&pointer::TESTS).chain(&touch::TESTS);
    let tests = of_panel.chain(&pictures::TESTS).chain(&refused::TESTS).chain(&normals::TESTS).copied();
    rimline_testkit::harness::run(rimline_testkit::harness::gpu_trials(tests));
}
