//! Browsers that have no GPU for the page, or take it back.

use crate::browser::Browser;

type Test = (&'static str, fn() -> Result<(), String>);

pub(crate) const TESTS: [Test; 3] = [
    ("without WebGPU there are pictures, and which browsers have it", without_webgpu),
    ("a device that is lost is told, and the page offers to be loaded again", lost),
    ("so is an error of the device that nobody expects", refused),
];

fn expect(browser: &mut Browser, condition: &str) -> Result<(), String> {
    if browser.evaluate(condition)? == true { Ok(()) } else { Err(format!("not so: {condition}")) }
}

fn without_webgpu() -> Result<(), String> {
    let script = "Object.defineProperty(Navigator.prototype, 'gpu', { value: undefined })";
    let mut browser = Browser::open_after("", script)?;
    browser.wait_for("why", |why| why == "This browser has no WebGPU.")?;
    expect(&mut browser, "document.getElementById('fallback').checkVisibility()")?;
    expect(&mut browser, "document.getElementById('fallback').textContent.includes('Firefox from')")?;
    let decoded =
        "Promise.all([...document.images].map((image) => image.decode())).then(() => document.images.length == 2)";
    expect(&mut browser, decoded)?;
    browser.expect_no_errors()
}

fn lost() -> Result<(), String> {
    stopped("window.device.destroy()", "the device was lost")
}

fn refused() -> Result<(), String> {
    stopped("window.device.createBuffer({ size: 4, usage: 0 }); 0", "refused what the viewer needs")
}

/// Waits for a reason that the page gives after a script did something to its device.
fn stopped(happening: &str, reason: &str) -> Result<(), String> {
    let script = "const request = GPUAdapter.prototype.requestDevice; \
                  GPUAdapter.prototype.requestDevice = async function (how) { \
                  return window.device = await request.call(this, how) }";
    let mut browser = Browser::open_after("", script)?;
    browser.wait_for("said", |said| said.starts_with("Ready"))?;
    browser.evaluate(happening)?;
    browser.wait_for("reason", |said| said.contains(reason))?;
    expect(&mut browser, "document.querySelector('#stopped button').checkVisibility()")
}
