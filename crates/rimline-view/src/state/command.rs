//! The command line that draws a view.

use std::fmt::Write as _;

use super::lamp::{AREA_SAMPLES, Lamp, LampKind};
use super::options::counting_name;
use super::viewer::Viewer;
use rimline_picture::Mode;

impl Viewer {
    /// The command line that draws this view: `rimline shadow`, or without shadows `draw` or `lines`.
    pub fn command(&self) -> String {
        let options = &self.options;
        let verb = match (options.shadows, options.overlays.creases) {
            (true, _) => "shadow",
            (false, true) => "lines",
            (false, false) => "draw",
        };
        let mut line = format!("rimline {verb}");
        let files = self.bodies.iter().map(|body| body.file.as_deref().unwrap_or("FILE"));
        // `draw` takes one file.
        for file in files.take(if verb == "draw" { 1 } else { usize::MAX }) {
            let _ = write!(line, " {}", quoted(file));
        }
        let moved = |point: glam::Vec3| {
            let origin = self.origin.to_array();
            let [x, y, z] = [0, 1, 2].map(|axis| f64::from(point[axis]) + origin[axis]);
            if origin == [0.0; 3] { format!("{},{},{}", point.x, point.y, point.z) } else { format!("{x},{y},{z}") }
        };
        if let Some(body) = self.bodies.iter().find(|body| body.duration() > 0.0) {
            if let Some(index) = body.animation {
                let _ = write!(line, " --animation {index}");
            }
            let _ = write!(line, " --time {}", self.clock.seconds);
        }
        let orbit = &self.orbit;
        let [width, height] = self.size();
        let _ = write!(line, " --eye {} --target {} --fov {}", moved(orbit.eye()), moved(orbit.target), orbit.fov);
        if verb != "lines" {
            let _ = write!(line, " --size {width}x{height}");
        }
        if verb != "lines" && !options.colors {
            line += " --plain";
        }
        if verb == "shadow" {
            let ground = f64::from(self.ground()) + self.origin.to_array()[1];
            let _ = write!(line, " --ground {}", ground as f32);
            let lamps = || self.lamps.iter().filter(|lamp| lamp.is_on);
            let radius = |lamp: &Lamp| lamp.radius.filter(|_| options.mode == Mode::Additive);
            for lamp in lamps() {
                let _ = match lamp.kind {
                    LampKind::Point(at) => write!(line, " --light point:{}", moved(at)),
                    LampKind::Sun(towards) => write!(line, " --light dir:{},{},{}", towards.x, towards.y, towards.z),
                };
                let [r, g, b] = lamp.color;
                let _ = write!(line, ",color={r},{g},{b},intensity={}", lamp.intensity);
                if let (LampKind::Point(_), Some(range)) = (lamp.kind, lamp.range) {
                    let _ = write!(line, ",range={range}");
                }
                if let (Some(target), Some(cone)) = (lamp.target(&self.bounds()), lamp.spot_cone()) {
                    let [inner, outer] = [cone.inner_angle, cone.outer_angle].map(f32::to_degrees);
                    let _ = write!(line, ",cone={inner},{outer},target={}", moved(target));
                }
                if let Some(radius) = radius(lamp) {
                    let _ = write!(line, ",radius={radius}");
                }
            }
            if lamps().any(|lamp| radius(lamp).is_some()) {
                let _ = write!(line, " --samples {AREA_SAMPLES} --one-pattern");
            }
            let _ = write!(line, " --method {} --mode {}", counting_name(options.counting), options.mode.name());
            if options.overlays.volumes {
                line += " --volumes";
            }
        }
        let ending = if verb == "lines" { "svg" } else { "png" };
        line + &format!(" --out view.{ending}")
    }
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
