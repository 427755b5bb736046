//! Sessions of a user.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

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

#[expect(clippy::needless_pass_by_value, reason = "it is for `map_err`")]
fn say(error: impl ToString) -> String {
    error.to_string()
}

fn viewer(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rimline-view"));
    command.current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env_remove("DISPLAY");
    command.env("XDG_RUNTIME_DIR", folder).env("NODEVICE_SELECT", "1").env("RUST_LOG", "warn");
    command
}

/// Waits for the picture with a number, and returns its pixels.
fn picture(folder: &Path, number: usize, child: &mut Child) -> Result<Vec<u8>, String> {
    let path = folder.join(format!("rimline-{number}.png"));
    let until = Instant::now() + PATIENCE;
    while Instant::now() < until {
        if let Some(status) = child.try_wait().map_err(say)? {
            return Err(format!("the viewer ended: {status}"));
        }
        // A file that is still being written does not decode.
        if let Ok(file) = fs::File::open(&path)
            && let Ok(mut reader) = png::Decoder::new(std::io::BufReader::new(file)).read_info()
        {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap_or(0)];
            if reader.next_frame(&mut pixels).is_ok() {
                return Ok(pixels);
            }
        }
        sleep(Duration::from_millis(50));
    }
    Err(format!("no {} was written", path.display()))
}

fn a_session() -> Result<(), String> {
    let display = Display::start()?;
    let folder = tempfile::tempdir().map_err(say)?;
    for (name, text) in [("bad.glb", "this is no model"), ("block.obj", BLOCK)] {
        fs::write(folder.path().join(name), text).map_err(say)?;
    }
    let mut command = viewer(folder.path());
    let mut child = command.args(["bad.glb", "block.obj"]).env("DISPLAY", &display.name).spawn().map_err(say)?;
    let outcome = steps(&display, folder.path(), &mut child);
    if outcome.is_err() {
        let _ = child.kill();
    }
    let output = child.wait_with_output().map_err(say)?;
    let said = String::from_utf8_lossy(&output.stderr);
    outcome.map_err(|error| format!("{error}\n{said}"))?;
    if !said.contains("rimline: bad.glb: ") {
        return Err(format!("nothing is said of the bad file: {said}"));
    }
    if !output.status.success() || said.to_lowercase().contains("validation") || said.contains("panicked") {
        return Err(format!("{}: {said}", output.status));
    }
    Ok(())
}

fn steps(display: &Display, folder: &Path, child: &mut Child) -> Result<(), String> {
    let window = display.window(PATIENCE)?;
    // Stops the animation, and takes a picture: keys are heard once the first frame is there.
    let mut number = 0;
    let mut take = |child: &mut Child| {
        number += 1;
        display.press(window, u32::from('p'))?;
        picture(folder, number, child)
    };
    take(child)?;
    let title = display.title(window)?;
    if title != "block.obj – Rimline" {
        return Err(format!("the title is `{title}`"));
    }
    // The text is there as long as the window has it.
    display.press(window, u32::from('c'))?;
    let until = Instant::now() + PATIENCE;
    while !display.has_clipboard()? {
        if Instant::now() > until {
            return Err("nothing is on the clipboard".into());
        }
        sleep(Duration::from_millis(50));
    }
    sleep(Duration::from_millis(300));
    if !display.has_clipboard()? {
        return Err("the clipboard was emptied".into());
    }
    display.press(window, u32::from(' '))?;
    let still = take(child)?;
    if take(child)? != still {
        return Err("a still viewer shows another picture".into());
    }
    // Elsewhere than on a handle, dragging turns the camera.
    display.drag([60, 600], [160, 560])?;
    let turned = take(child)?;
    if turned == still {
        return Err("dragging changed nothing".into());
    }
    display.press(window, u32::from('3'))?;
    let volumes = take(child)?;
    if volumes == turned {
        return Err("switching volumes on changed nothing".into());
    }
    // The next scene, then another size.
    display.press(window, u32::from('n'))?;
    let scene = take(child)?;
    display.resize(window, [700, 500])?;
    sleep(Duration::from_millis(500));
    let small = take(child)?;
    if scene == volumes || small.len() >= scene.len() {
        return Err("another scene or size changed nothing".into());
    }
    // Escape.
    display.press(window, 0xff1b)?;
    let until = Instant::now() + PATIENCE;
    while child.try_wait().map_err(say)?.is_none() {
        if Instant::now() > until {
            return Err("Escape did not close the window".into());
        }
        sleep(Duration::from_millis(50));
    }
    Ok(())
}

fn without_a_display() -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(say)?;
    let output = viewer(folder.path()).output().map_err(say)?;
    let said = String::from_utf8_lossy(&output.stderr);
    let is_clear = said.contains("`rimline shadow`") && said.contains("no display") && !said.contains(".rs:");
    if output.status.success() || !is_clear {
        return Err(format!("{}: {said}", output.status));
    }
    Ok(())
}

fn without_a_gpu() -> Result<(), String> {
    let (display, folder) = (Display::start()?, tempfile::tempdir().map_err(say)?);
    let hidden =
        viewer(folder.path()).env("DISPLAY", &display.name).env("WGPU_BACKEND", "noop").output().map_err(say)?;
    let said = String::from_utf8_lossy(&hidden.stderr);
    if hidden.status.success() || !said.contains("no GPU was found") {
        return Err(format!("{}: {said}", hidden.status));
    }
    Ok(())
}

fn without_a_file() -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(say)?;
    fs::write(folder.path().join("empty.obj"), "").map_err(say)?;
    let output = viewer(folder.path()).args(["nope.obj", "empty.obj", "."]).output().map_err(say)?;
    let said = String::from_utf8_lossy(&output.stderr);
    let are_named = ["rimline: nope.obj: ", "rimline: empty.obj: ", "no file can be shown"];
    // There is no display, either: files come first.
    if output.status.success() || said.contains("no display") || !are_named.iter().all(|part| said.contains(part)) {
        return Err(format!("{}: {said}", output.status));
    }
    Ok(())
}
