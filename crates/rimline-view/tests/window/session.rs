//! Sessions of a user.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use glam::{Vec2, Vec3};
use rimline_files::{ReadOptions, read_bytes};
use rimline_testkit::on_gpu::text as say;
use rimline_view::{Event, LampKind, Viewer, scenes};
use x11rb::protocol::xproto::Window;

use crate::display::Display;

type Test = (&'static str, fn() -> Result<(), String>);

pub(crate) const TESTS: [Test; 4] = [
    ("a window opens, and a light is dragged, overlays switched, a picture taken", a_session),
    ("without a display there is a clear error", without_a_display),
    ("without a GPU there is a clear error", without_a_gpu),
    ("without a file that can be shown there is no window", without_a_file),
];

const BLOCK: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// A software driver on a busy machine compiles for long.
const PATIENCE: Duration = Duration::from_secs(75);

fn viewer(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rimline-view"));
    command.current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env_remove("DISPLAY");
    command.env("XDG_RUNTIME_DIR", folder).env("NODEVICE_SELECT", "1").env("RUST_LOG", "warn");
    command
}

fn expect(is_true: bool, what: impl Into<String>) -> Result<(), String> {
    if is_true { Ok(()) } else { Err(what.into()) }
}

fn wait(what: &str, mut is_done: impl FnMut() -> Result<bool, String>) -> Result<(), String> {
    let until = Instant::now() + PATIENCE;
    while !is_done()? {
        expect(Instant::now() < until, what)?;
        sleep(Duration::from_millis(50));
    }
    Ok(())
}

/// Waits for the picture with a number, and returns its pixels.
fn picture(folder: &Path, number: usize, child: &mut Child) -> Result<Vec<u8>, String> {
    let path = folder.join(format!("rimline-{number}.png"));
    let mut pixels = Vec::new();
    wait(&format!("no {} was written", path.display()), || {
        let ended = child.try_wait().map_err(say)?;
        ended.map_or(Ok(()), |status| Err(format!("the viewer ended: {status}")))?;
        // A file that is still being written does not decode.
        let Ok(file) = fs::File::open(&path) else { return Ok(false) };
        let Ok(mut reader) = png::Decoder::new(std::io::BufReader::new(file)).read_info() else { return Ok(false) };
        pixels = vec![0; reader.output_buffer_size().unwrap_or(0)];
        Ok(reader.next_frame(&mut pixels).is_ok())
    })?;
    Ok(pixels)
}

/// The file that lines are printed to.
const LINES: &str = "lines.txt";

/// Copies the view as a command, and returns its words. The window prints the line, too, as the one with this number.
fn copied(display: &Display, window: Window, folder: &Path, number: usize) -> Result<Vec<String>, String> {
    display.press(window, u32::from('c'))?;
    let mut words = Vec::new();
    wait("no command was printed", || {
        let text = fs::read_to_string(folder.join(LINES)).map_err(say)?;
        let line = text.split_inclusive('\n').nth(number).filter(|line| line.ends_with('\n'));
        words = line.unwrap_or_default().split_whitespace().map(str::to_owned).collect();
        Ok(!words.is_empty())
    })?;
    Ok(words)
}

/// The values of an option in a command.
fn values<'a>(words: &'a [String], option: &str) -> Result<Vec<&'a str>, String> {
    let pairs = words.windows(2).filter(|pair| pair[0] == option);
    let found: Vec<_> = pairs.map(|pair| pair[1].as_str()).collect();
    if found.is_empty() { Err(format!("no {option} in {words:?}")) } else { Ok(found) }
}

/// Numbers with a sign between them.
fn numbers(text: &str, between: char) -> Result<Vec<f32>, String> {
    text.split(between).map(|number| number.parse::<f32>().map_err(say)).collect()
}

/// The pixel of the first light's handle in the view of a command, from a viewer of the same file without a window.
fn handle(words: &[String]) -> Result<Vec2, String> {
    let mut viewer = Viewer::new(scenes::moebius().map_err(say)?);
    let file = read_bytes(BLOCK.as_bytes(), Some(Path::new("block.obj")), &ReadOptions::default());
    viewer.open("block.obj", "block.obj".into(), file);
    let size = numbers(values(words, "--size")?[0], 'x')?;
    viewer.handle(Event::Resized([size[0] as u32, size[1] as u32]));
    let line: Vec<String> = viewer.command().split_whitespace().map(str::to_owned).collect();
    expect(values(&line, "--eye")? == values(words, "--eye")?, format!("the camera is not as at first: {words:?}"))?;
    let light = values(words, "--light")?[0].strip_prefix("point:").ok_or("the first light is at no point")?;
    let at: Vec<&str> = light.split(',').take(3).collect();
    let at = Vec3::from_slice(&numbers(&at.join(","), ',')?);
    viewer.lamps[0].kind = LampKind::Point(at);
    viewer.camera().project(at).ok_or_else(|| "the handle is behind the eye".into())
}

/// Drags the first light by its handle, and sees by the copied command that the light went with the pointer, and nothing else.
fn drag_a_light(
    display: &Display,
    window: Window,
    folder: &Path,
    mut take: impl FnMut() -> Result<Vec<u8>, String>,
) -> Result<(), String> {
    let before = copied(display, window, folder, 1)?;
    let (from, by) = (handle(&before)?.round(), Vec2::new(90.0, 70.0));
    let [left, top] = display.corner(window)?;
    let on_screen = |at: Vec2| [left + at.x as i16, top + at.y as i16];
    display.drag(on_screen(from), on_screen(from + by))?;
    // A key that comes within the frame of the drag is heard before it: the picture ends that frame.
    take()?;
    let after = copied(display, window, folder, 2)?;
    let there = handle(&after)?;
    expect(there.distance(from + by) < 1.5, format!("the light is at {there}, and the pointer at {}", from + by))?;
    let [old, new] = [&before, &after].map(|words| values(words, "--light"));
    let (old, new) = (old?, new?);
    expect(old[0] != new[0] && old[1..] == new[1..], format!("{old:?} became {new:?}"))
}

fn a_session() -> Result<(), String> {
    let display = Display::start()?;
    let folder = tempfile::tempdir().map_err(say)?;
    for (name, text) in [("bad.glb", "this is no model"), ("block.obj", BLOCK)] {
        fs::write(folder.path().join(name), text).map_err(say)?;
    }
    let mut command = viewer(folder.path());
    command.stdout(fs::File::create(folder.path().join(LINES)).map_err(say)?);
    let mut child = command.args(["bad.glb", "block.obj"]).env("DISPLAY", &display.name).spawn().map_err(say)?;
    let outcome = steps(&display, folder.path(), &mut child);
    if outcome.is_err() {
        let _ = child.kill();
    }
    let output = child.wait_with_output().map_err(say)?;
    let said = String::from_utf8_lossy(&output.stderr);
    outcome.map_err(|error| format!("{error}\n{said}"))?;
    expect(said.contains("rimline: bad.glb: "), format!("nothing is said of the bad file: {said}"))?;
    let is_clean = !said.to_lowercase().contains("validation") && !said.contains("panicked");
    expect(output.status.success() && is_clean, format!("{}: {said}", output.status))
}

fn steps(display: &Display, folder: &Path, child: &mut Child) -> Result<(), String> {
    let window = display.window(PATIENCE)?;
    // Few pixels are drawn fast.
    display.resize(window, [640, 480])?;
    // Stops the animation, and takes a picture: keys are heard once the first frame is there.
    let mut number = 0;
    let mut take = |child: &mut Child| {
        number += 1;
        display.press(window, u32::from('p'))?;
        picture(folder, number, child)
    };
    take(child)?;
    let title = display.title(window)?;
    expect(title == "block.obj – Rimline", format!("the title is `{title}`"))?;
    // The text is there as long as the window has it.
    copied(display, window, folder, 0)?;
    wait("nothing is on the clipboard", || display.has_clipboard())?;
    sleep(Duration::from_millis(300));
    expect(display.has_clipboard()?, "the clipboard was emptied")?;
    display.press(window, u32::from(' '))?;
    let still = take(child)?;
    expect(take(child)? == still, "a still viewer shows another picture")?;
    drag_a_light(display, window, folder, || take(child))?;
    let dragged = take(child)?;
    expect(dragged != still, "dragging a light changed nothing")?;
    // Elsewhere than on a handle, dragging turns the camera.
    display.drag([40, 440], [140, 400])?;
    let turned = take(child)?;
    expect(turned != dragged, "dragging changed nothing")?;
    display.press(window, u32::from('3'))?;
    let volumes = take(child)?;
    expect(volumes != turned, "switching volumes on changed nothing")?;
    // The next scene, then another size.
    display.press(window, u32::from('n'))?;
    let scene = take(child)?;
    display.resize(window, [520, 400])?;
    sleep(Duration::from_millis(500));
    let small = take(child)?;
    expect(scene != volumes && small.len() < scene.len(), "another scene or size changed nothing")?;
    // Escape.
    display.press(window, 0xff1b)?;
    wait("Escape did not close the window", || Ok(child.try_wait().map_err(say)?.is_some()))
}

fn without_a_display() -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(say)?;
    let output = viewer(folder.path()).output().map_err(say)?;
    let said = String::from_utf8_lossy(&output.stderr);
    let is_clear = said.contains("`rimline shadow`") && said.contains("no display") && !said.contains(".rs:");
    expect(!output.status.success() && is_clear, format!("{}: {said}", output.status))
}

fn without_a_gpu() -> Result<(), String> {
    let (display, folder) = (Display::start()?, tempfile::tempdir().map_err(say)?);
    let output =
        viewer(folder.path()).env("DISPLAY", &display.name).env("WGPU_BACKEND", "noop").output().map_err(say)?;
    let said = String::from_utf8_lossy(&output.stderr);
    let is_clear = said.contains("no GPU was found");
    expect(!output.status.success() && is_clear, format!("{}: {said}", output.status))
}

fn without_a_file() -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(say)?;
    fs::write(folder.path().join("empty.obj"), "").map_err(say)?;
    let output = viewer(folder.path()).args(["nope.obj", "empty.obj", "."]).output().map_err(say)?;
    let said = String::from_utf8_lossy(&output.stderr);
    let are_named = ["rimline: nope.obj: ", "rimline: empty.obj: ", "no file can be shown"];
    // There is no display, either: files come first.
    let is_clear = !said.contains("no display") && are_named.iter().all(|part| said.contains(part));
    expect(!output.status.success() && is_clear, format!("{}: {said}", output.status))
}
