//! Sessions of a user.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::display::Display;

type Test = (&'static str, fn() -> Result<(), String>);

pub(crate) const TESTS: [Test; 2] = [
    ("a window opens, and a light is dragged, overlays switched, a picture taken", a_session),
    ("without a display there is a clear error", without_a_display),
];

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
    let bad = folder.path().join("bad.glb");
    fs::write(&bad, "this is no model").map_err(say)?;
    let mut child = viewer(folder.path()).arg(&bad).env("DISPLAY", &display.name).spawn().map_err(say)?;
    let outcome = steps(&display, folder.path(), &mut child);
    if outcome.is_err() {
        let _ = child.kill();
    }
    let output = child.wait_with_output().map_err(say)?;
    let said = String::from_utf8_lossy(&output.stderr);
    outcome.map_err(|error| format!("{error}\n{said}"))?;
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
    if output.status.success() || !said.contains("`rimline shadow`") || !said.contains("no display") {
        return Err(format!("{}: {said}", output.status));
    }
    Ok(())
}
