//! `?check` in the browser.

use crate::browser::Browser;

type Test = (&'static str, fn() -> Result<(), String>);

pub(crate) const TESTS: [Test; 3] = [
    ("the check finds no wrong bits", without_wrong_bits),
    ("the check finds a bit that is planted", with_one),
    ("the check names the GPU that it checks", of_one_gpu),
];

/// The table of a check, once it is done.
fn table(query: &str) -> Result<String, String> {
    let mut browser = Browser::open(query)?;
    browser.wait_for("said", |said| said.contains("done"))?;
    browser.expect_no_errors()?;
    browser.text("table")
}

fn without_wrong_bits() -> Result<(), String> {
    let table = table("?check")?;
    let scenes = table.lines().filter(|line| line.ends_with("  0")).count();
    println!("{table}");
    // Seven of the viewer, and the stress scenes.
    let whole = table.contains(": 0 wrong bits, 0 failed") && scenes == 7 + rimline_testkit::stress::names().len();
    if whole { Ok(()) } else { Err(table) }
}

fn with_one() -> Result<(), String> {
    let table = table("?check&plant")?;
    if table.contains(": 1 wrong bits, 0 failed") { Ok(()) } else { Err(table) }
}

/// A machine may have two, and the browser gives the one that is asked for.
fn of_one_gpu() -> Result<(), String> {
    let script = "const request = GPU.prototype.requestAdapter; window.asked = []; \
                  GPU.prototype.requestAdapter = function (how) { \
                  window.asked.push(how?.powerPreference); return request.call(this, how) }";
    let mut browser = Browser::open_after("?check", script)?;
    browser.wait_for("table", |table| !table.is_empty() && !table.starts_with("Compiling"))?;
    let asked = browser.evaluate("asked.join()")?;
    let is_one = asked.as_str() == Some("high-performance,high-performance");
    if is_one { Ok(()) } else { Err(format!("the page asked for {asked}")) }
}
