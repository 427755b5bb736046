//! The command line that draws a view.

use std::fmt::Write as _;

use super::lamp::LampKind;
use super::options::counting_name;
use super::viewer::Viewer;

/// The command that draws what a viewer shows: `rimline shadow`, or without shadows `draw` or `lines`.
pub(crate) fn command(viewer: &Viewer) -> String {
    let options = &viewer.options;
    let verb = match (options.shadows, options.overlays.creases) {
        (true, _) => "shadow",
        (false, true) => "lines",
        (false, false) => "draw",
    };
    let mut line = format!("rimline {verb}");
    let mut files = viewer.bodies.iter().map(|body| body.file.as_deref().unwrap_or("FILE"));
    // `draw` and `lines` take one file.
    let taken = if verb == "shadow" { usize::MAX } else { 1 };
    for file in files.by_ref().take(taken) {
        let _ = write!(line, " {}", quoted(file));
    }
    let moved = |point: glam::Vec3| {
        let origin = viewer.origin.to_array();
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(point[axis]) + origin[axis]);
        if origin == [0.0; 3] { format!("{},{},{}", point.x, point.y, point.z) } else { format!("{x},{y},{z}") }
    };
    if let Some(body) = viewer.bodies.iter().find(|body| body.duration() > 0.0) {
        if let Some(index) = body.animation {
            let _ = write!(line, " --animation {index}");
        }
        let _ = write!(line, " --time {}", viewer.clock.seconds);
    }
    let orbit = &viewer.orbit;
    let [width, height] = viewer.size();
    let _ = write!(
        line,
        " --eye {} --target {} --fov {} --size {width}x{height}",
        moved(orbit.eye()),
        moved(orbit.target),
        orbit.fov
    );
    if verb == "shadow" {
        let ground = f64::from(viewer.ground()) + viewer.origin.to_array()[1];
        let _ = write!(line, " --ground {}", ground as f32);
        for lamp in viewer.lamps.iter().filter(|lamp| lamp.is_on) {
            let _ = match lamp.kind {
                LampKind::Point(at) => write!(line, " --light point:{}", moved(at)),
                LampKind::Sun(towards) => write!(line, " --light dir:{},{},{}", towards.x, towards.y, towards.z),
            };
            let [r, g, b] = lamp.color;
            let _ = write!(line, ",color={r},{g},{b},intensity={}", lamp.intensity);
            if let (LampKind::Point(_), Some(range)) = (lamp.kind, lamp.range) {
                let _ = write!(line, ",range={range}");
            }
        }
        let _ = write!(line, " --method {} --mode {}", counting_name(options.counting), options.mode.name());
        if options.overlays.volumes {
            line += " --volumes";
        }
    }
    let ending = if verb == "lines" { "svg" } else { "png" };
    line + &format!(" --out view.{ending}")
}

/// A word for a shell, in quotes if it needs them.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:,".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("a/b-1.glb"), "a/b-1.glb");
        assert_eq!(quoted("my model.glb"), "'my model.glb'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted("$HOME"), "'$HOME'");
    }
}
