//! A session of a user: files, a light that is dragged, screenshots.

use std::fs;
use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use glam::Vec3;
use rimline_files::{ReadOptions, read_bytes};
use rimline_view::{Action, Event, LampKind, Picture, Viewer, scenes};
use serde_json::json;

use crate::browser::{Browser, SIZE, say};
use crate::pictures::{TOLERANCE, decode, different, from_desktop};

pub(crate) const TEST: (&str, fn() -> Result<(), String>) =
    ("a file is dropped, a light dragged, a bad file refused, and pictures are those without a page", session);

/// A block above the ground, which comes from another model.
const BLOCK: &str = "\
v 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\nv 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\n\
f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n";
const PLATE: &str =
    "v -1 0 -1\nv 2 0 -1\nv 2 0 2\nv -1 0 2\nv 0.5 -0.2 0.5\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

/// Two triangles, whose positions are in a file beside.
const PAIR: &str = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }], "buffers": [{ "byteLength": 72, "uri": "a%20pair.bin" }],
    "bufferViews": [{ "buffer": 0, "byteLength": 72 }], "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 6,
    "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] }] }"#;
const PAIR_POSITIONS: [f32; 18] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 1., 0., 1., 1., 1., 0., 1.];

fn expect(is_true: bool, what: impl Into<String>) -> Result<(), String> {
    if is_true { Ok(()) } else { Err(what.into()) }
}

/// The viewer without a page after the same steps.
fn twin() -> Result<Viewer, String> {
    let mut viewer = Viewer::new(scenes::walking_figure().map_err(say)?);
    viewer.handle(Event::Resized(SIZE));
    for (name, content) in [("block.obj", BLOCK), ("plate.obj", PLATE)] {
        let file = read_bytes(content.as_bytes(), Some(Path::new(name)), &ReadOptions::default());
        viewer.open(name, name.to_owned(), file);
    }
    viewer.handle(Event::Acted(Action::ResetCamera));
    Ok(viewer)
}

/// Takes a screenshot in the page.
fn screenshot(browser: &mut Browser, number: u32) -> Result<Picture, String> {
    browser.press("p")?;
    decode(&browser.downloaded(&format!("rimline-{number}.png"))?)
}

/// Moves the twin's lights to where the page has them, by the command that the page copies.
fn follow(viewer: &mut Viewer, browser: &mut Browser) -> Result<(), String> {
    browser.press("c")?;
    let command = browser.wait_for("said", |said| said.contains(": rimline shadow"))?;
    let lights: Vec<&str> = command.split(" --light ").skip(1).collect();
    expect(lights.len() == viewer.lamps.len(), format!("{} lights in {command}", lights.len()))?;
    for (lamp, light) in viewer.lamps.iter_mut().zip(lights) {
        let numbers = light.split_once(':').map_or(light, |(_, numbers)| numbers).split(',').take(3);
        let numbers = numbers.map(str::parse).collect::<Result<Vec<f32>, _>>().map_err(say)?;
        let at = Vec3::from_slice(numbers.get(..3).ok_or("a light without three coordinates")?);
        lamp.kind = if light.starts_with("point") { LampKind::Point(at) } else { LampKind::Sun(at) };
    }
    Ok(())
}

/// Keeps the page from asking for files again by itself, which it may five seconds after it asked: `held` has what would let it.
const HOLD: &str = "window.held = []; const wait = window.setTimeout; \
                    window.setTimeout = (run, ms) => ms === 5000 ? held.push(run) : wait.call(window, run, ms)";

/// Asks for files twice, again once the dialog is closed, and again once the wait for a dialog that says nothing is over.
fn ask(browser: &mut Browser) -> Result<(), String> {
    // A dialog of the system would stay open.
    let count = "files = document.getElementById('files'); asked = 0; \
                 files.addEventListener('click', (event) => { event.preventDefault(); asked += 1 })";
    let (cancel, end_wait) = ("files.dispatchEvent(new Event('cancel'))", "held.shift()()");
    // The first wait is that of a dialog that is closed already.
    for (script, expected) in [(count, 1), (cancel, 2), (end_wait, 2), (end_wait, 3)] {
        browser.evaluate(&format!("{{ {script}; }} 0"))?;
        browser.press("o")?;
        browser.press("o")?;
        let asked = browser
            .evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(asked))))")?;
        expect(asked == expected, format!("{asked} dialogs are opened, not {expected}"))?;
    }
    Ok(())
}

fn session() -> Result<(), String> {
    let mut browser = Browser::open_after("", HOLD)?;
    let write = |name: &str, content: &[u8]| {
        let path = browser.folder().join(name);
        fs::write(&path, content).map(|()| path).map_err(say)
    };
    let (block, plate) = (write("block.obj", BLOCK.as_bytes())?, write("plate.obj", PLATE.as_bytes())?);
    let bad = write("bad.glb", b"this is no model")?;
    let gltf = write("pair.gltf", PAIR.as_bytes())?;
    let buffer = write("a pair.bin", &PAIR_POSITIONS.map(f32::to_le_bytes).concat())?;
    browser.wait_for("said", |said| said.starts_with("Ready"))?;

    // One by the dialog, one dropped.
    browser.choose_file(&block)?;
    browser.wait_for("said", |said| said == "block.obj: 12 faces")?;
    browser.drop_files(&[&plate])?;
    browser.wait_for("said", |said| said == "plate.obj: 6 faces")?;
    // Without the panel the picture has the whole page, from the next frame on.
    browser.press("u")?;
    screenshot(&mut browser, 1)?;
    browser.press("r")?;
    let (mut viewer, before) = (twin()?, screenshot(&mut browser, 2)?);
    let parts = from_desktop(&before, &viewer)?;
    println!("before: {:.3} % of the pixels differ from those without a page", 100.0 * parts);
    expect(parts <= TOLERANCE, format!("{parts} of the pixels differ before the drag"))?;

    // The light goes where the pointer goes, and the shadow with it.
    let handle = |viewer: &Viewer| viewer.camera().project(viewer.lamps[0].handle(&viewer.bounds()));
    let from = handle(&viewer).ok_or("no handle")?.round();
    let to = from + glam::Vec2::new(120.0, 60.0);
    browser.drag(from.into(), to.into())?;
    let after = screenshot(&mut browser, 3)?;
    follow(&mut viewer, &mut browser)?;
    let there = handle(&viewer).ok_or("no handle")?;
    expect(there.distance(to) < 3.0, format!("the pointer is at {to}, and the light at {there}"))?;
    let (moved, parts) = (different(&before, &after)?, from_desktop(&after, &viewer)?);
    println!(
        "after: {:.3} % differ from those before, {:.3} % from those without a page",
        100.0 * moved,
        100.0 * parts
    );
    expect(moved > 0.02, format!("only {moved} of the pixels changed as the light was dragged"))?;
    expect(parts <= TOLERANCE, format!("{parts} of the pixels differ after the drag"))?;

    // The canvas shows that picture, with handles of lights over it.
    let shown = browser.call("Page.captureScreenshot", &json!({ "format": "png" }))?;
    let shown = decode(&BASE64_STANDARD.decode(shown["data"].as_str().unwrap_or_default()).map_err(say)?)?;
    let parts = different(&shown, &after)?;
    expect(parts < 0.03, format!("{parts} of the pixels on the canvas are others"))?;

    browser.drop_files(&[&bad])?;
    let said = browser.wait_for("said", |said| said.starts_with("bad.glb"))?;
    viewer.open(
        "bad.glb",
        "bad.glb".into(),
        read_bytes(b"this is no model", Some(Path::new("bad.glb")), &ReadOptions::default()),
    );
    let message = viewer.message.as_ref().map(|message| message.text.as_str());
    expect(message == Some(said.as_str()), format!("`{said}` instead of {message:?}"))?;
    browser.drop_files(&[&buffer, &gltf])?;
    browser.wait_for("said", |said| said == "pair.gltf: 2 faces")?;
    ask(&mut browser)?;
    browser.press("g")?;
    let without = screenshot(&mut browser, 4)?;
    expect(different(&after, &without)? > 0.02, "after a bad file, switching the ground off changes nothing")?;
    browser.expect_no_errors()
}
