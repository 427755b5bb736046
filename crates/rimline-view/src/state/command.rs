//! The command line that draws a view.

use std::fmt::Write as _;

use rimline::mesh::Weld;
use rimline_files::{ReadOptions, Up};
use rimline_picture::Mode;

use super::body::Body;
use super::lamp::{AREA_SAMPLES, Lamp, LampKind};
use super::options::counting_name;
use super::viewer::Viewer;

impl Viewer {
    fn verb(&self) -> &'static str {
        match (self.options.shadows, self.options.overlays.creases) {
            (false, true) => "lines",
            // It takes one file.
            (false, false) if self.bodies.len() == 1 => "draw",
            _ => "shadow",
        }
    }

    /// Lists how this view differs from the picture of [`Self::command`], in words.
    pub fn not_in_command(&self) -> Vec<String> {
        let (options, verb) = (&self.options, self.verb());
        let is_shaded = verb == "shadow";
        let shown = &options.overlays;
        let differs = [
            (is_shaded && !options.shadows, "shadows off"),
            (is_shaded && !self.lamps.iter().any(|lamp| lamp.is_on), "lights off"),
            (verb != "lines" && !options.ground, "ground off"),
            (!is_shaded, "lights"),
            (verb == "lines" && options.colors, "colours"),
            (verb != "lines" && !options.smooth, "flat faces"),
            (is_shaded && shown.silhouettes, "silhouettes"),
            (shown.light_silhouettes, "silhouettes of the lights"),
            (!is_shaded && shown.volumes, "volumes"),
            (shown.caps, "light caps"),
            (verb != "lines" && shown.boundary, "boundary"),
            (shown.non_manifold, "non-manifold edges"),
            (verb != "lines" && shown.creases, "creases"),
            (shown.exact, "faces decided exactly"),
            (shown.clusters, "clusters"),
            (shown.receivers, "receivers"),
            (shown.boxes, "boxes"),
        ];
        let differs = differs.into_iter().filter(|(is_so, _)| *is_so).map(|(_, what)| what.to_owned());
        // `--animation` plays the animation with one number in each file that has it.
        let played = self.played();
        let is_other = |body: &&Body| body.animation != played.filter(|&index| index < body.animations().len());
        let still = self.bodies.iter().filter(is_other).map(|body| match body.animation {
            Some(index) => format!("animation {index} of {}", body.name),
            None => format!("{} at rest", body.name),
        });
        differs.chain(still).collect()
    }

    /// The animation that the command names: that of the first model that moves, or else that one poses.
    fn played(&self) -> Option<usize> {
        let moving = self.bodies.iter().find(|body| body.duration() > 0.0);
        moving.or_else(|| self.bodies.iter().find(|body| body.animation.is_some()))?.animation
    }

    /// The command line that draws this view: `rimline shadow`, or without shadows `draw` or `lines`.
    pub fn command(&self) -> String {
        let (options, verb) = (&self.options, self.verb());
        let mut line = format!("rimline {verb}");
        let files: Vec<_> = self.bodies.iter().filter_map(|body| body.file.as_deref()).map(quoted).collect();
        let _ = write!(line, " {}", if files.is_empty() { "FILE".to_owned() } else { files.join(" ") });
        line += &reading(&self.read);
        let origin = self.origin.to_array();
        // Digits of a single number where they say all of it.
        let along = |axis: usize, value: f32| {
            if self.origin.is_zero() { value.to_string() } else { (f64::from(value) + origin[axis]).to_string() }
        };
        let moved = |point: glam::Vec3| [0, 1, 2].map(|axis| along(axis, point[axis])).join(",");
        if let Some(index) = self.played() {
            let _ = write!(line, " --animation {index} --time {}", self.clock.seconds);
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
            let _ = write!(line, " --ground {}", along(1, self.ground()));
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

/// The options of files that are not read as by default.
fn reading(options: &ReadOptions) -> String {
    let default = ReadOptions::default();
    let mut words = match options.weld {
        Weld::Data => String::new(),
        Weld::Position => " --weld position".to_owned(),
        Weld::Keep => " --no-weld".to_owned(),
        Weld::Distance(distance) => {
            let position = if distance.is_across_data() { " --weld position" } else { "" };
            format!("{position} --weld-distance {}", distance.get())
        }
    };
    if options.memory_limit != default.memory_limit {
        let _ = write!(words, " --memory-limit {}", options.memory_limit);
    }
    if let Some(format) = options.format {
        let _ = write!(words, " --input-format {}", format.name());
    }
    if options.allow_outside {
        words += " --allow-outside";
    }
    if options.up == Up::Z {
        words += " --up z";
    }
    words
}

/// The name of a file for a shell, in quotes if it needs them.
fn quoted(file: &str) -> String {
    // A dash begins options, and is standard input.
    let file = if file.starts_with('-') { format!("./{file}") } else { file.to_owned() };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:,".contains(c);
    if !file.is_empty() && file.chars().all(is_plain) {
        file
    } else if file.contains(char::is_control) {
        // A terminal acts on these when they are printed or pasted, in quotes, too.
        file.chars().fold("$'".to_owned(), escaped) + "'"
    } else {
        format!("'{}'", file.replace('\'', r"'\''"))
    }
}

/// Adds a character of what stands between `$'` and `'`.
fn escaped(mut text: String, c: char) -> String {
    match c {
        '\'' | '\\' => text.extend(['\\', c]),
        c if c.is_control() => c.to_string().bytes().for_each(|byte| _ = write!(text, "\\{byte:03o}")),
        c => text.push(c),
    }
    text
}

#[cfg(test)]
mod tests {
    use rimline::mesh::{Weld, WeldDistance};
    use rimline_files::{Format, ReadOptions, Up};

    use super::{quoted, reading};
    use crate::state::body::{Body, BodyError, Source};
    use crate::state::event::Event;
    use crate::state::keys::Action;
    use crate::state::viewer::Viewer;

    fn block(name: &str) -> (String, rimline_files::File) {
        let cube = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let options = rimline_files::ReadOptions::default();
        let file = rimline_files::read_bytes(cube, Some(std::path::Path::new("a.obj")), &options);
        (name.to_owned(), file.expect("a triangle"))
    }

    fn viewer(files: usize) -> Viewer {
        let mut viewer = Viewer::new(crate::scenes::moebius().expect("a band"));
        for number in 0..files {
            let (name, file) = block(&format!("{number}.obj"));
            viewer.open(&name, name.clone(), Ok(file));
        }
        viewer
    }

    #[test]
    fn all_files_are_in_the_line_and_the_message_says_what_is_not() {
        let mut viewer = viewer(2);
        assert!(viewer.command().starts_with("rimline shadow 0.obj 1.obj --eye "), "{}", viewer.command());
        assert!(viewer.not_in_command().is_empty(), "{:?}", viewer.not_in_command());
        for action in [Action::Shadows, Action::Smooth, Action::Silhouettes, Action::Ground] {
            viewer.handle(Event::Acted(action));
        }
        // `draw` would take one file.
        assert!(viewer.command().starts_with("rimline shadow 0.obj 1.obj --eye "), "{}", viewer.command());
        viewer.handle(Event::Copied("copied".into(), viewer.command()));
        let message = viewer.message.as_ref().expect("it was copied");
        assert_eq!(message.text, "copied; not in it: shadows off, ground off, flat faces, silhouettes");
        assert_eq!(message.details, viewer.command());
        viewer.remove_body(1);
        assert!(viewer.message.is_none(), "the message is of the models before");
        assert!(viewer.command().starts_with("rimline draw 0.obj --eye "), "{}", viewer.command());
        assert_eq!(viewer.not_in_command(), ["ground off", "lights", "flat faces"]);
        viewer.read.up = rimline_files::Up::Z;
        assert!(viewer.command().starts_with("rimline draw 0.obj --up z --eye "), "{}", viewer.command());
        viewer.read.up = rimline_files::Up::Y;
        viewer.handle(Event::Acted(Action::Creases));
        assert!(viewer.command().starts_with("rimline lines 0.obj --eye "), "{}", viewer.command());
    }

    #[test]
    fn options_of_files_are_in_the_line() {
        let all = ReadOptions::default();
        assert_eq!(reading(&all), "");
        let near = WeldDistance::new(0.25).expect("a distance");
        for (weld, words) in [
            (Weld::Position, " --weld position"),
            (Weld::Keep, " --no-weld"),
            (Weld::Distance(near), " --weld-distance 0.25"),
            (Weld::Distance(near.across_data()), " --weld position --weld-distance 0.25"),
        ] {
            assert_eq!(reading(&ReadOptions { weld, ..all }), words);
        }
        let format = Some(Format::Stl);
        let others = ReadOptions { memory_limit: 1 << 20, format, allow_outside: true, up: Up::Z, ..all };
        assert_eq!(reading(&others), " --memory-limit 1048576 --input-format stl --allow-outside --up z");
        let mut viewer = viewer(1);
        viewer.read = others;
        let begin = format!("rimline shadow 0.obj{} --eye ", reading(&others));
        assert!(viewer.command().starts_with(&begin), "{}", viewer.command());
    }

    #[test]
    fn an_animation_of_another_number_is_not_in_the_line() {
        let mut viewer = Viewer::new(crate::scenes::walking_figure().expect("a figure"));
        assert!(viewer.command().contains(" --animation 0 --time 0 "), "{}", viewer.command());
        let more = crate::scenes::walking_figure().expect("a figure");
        viewer.bodies.extend(more);
        assert!(viewer.not_in_command().is_empty(), "{:?}", viewer.not_in_command());
        viewer.play(1, None);
        assert_eq!(viewer.not_in_command(), ["Walking figure at rest"]);
        viewer.handle(Event::Copied("copied".into(), viewer.command()));
        let text = &viewer.message.as_ref().expect("it was copied").text;
        assert!(text.starts_with("copied; a built-in scene has no file"), "{text}");
        assert_eq!(viewer.command().matches("FILE").count(), 1);
    }

    /// A file with an animation of one key.
    struct Posed(rimline_files::File);

    impl Source for Posed {
        fn model(&self) -> &rimline::Model {
            self.0.model()
        }

        fn pose(&self, _: Option<usize>, seconds: f32) -> Result<rimline::Pose, BodyError> {
            Ok(self.0.pose(&[], seconds)?)
        }

        fn animations(&self) -> Vec<(String, f32)> {
            vec![("bend".to_owned(), 0.0)]
        }
    }

    #[test]
    fn an_animation_of_one_key_is_in_the_line() {
        let (name, file) = block("bent.glb");
        let body = Body::new(&name, Some(name.clone()), Posed(file)).expect("a triangle");
        let mut viewer = Viewer::new(vec![body]);
        viewer.handle(Event::Acted(Action::StepOn));
        assert!(viewer.command().contains(" bent.glb --animation 0 --time 0 "), "{}", viewer.command());
        assert!(viewer.not_in_command().is_empty() && !viewer.is_animated(), "{:?}", viewer.not_in_command());
    }

    #[test]
    fn lights_that_are_off_and_files_that_are_missing_are_not_in_the_line() {
        let mut viewer = viewer(1);
        viewer.lamps.iter_mut().for_each(|lamp| lamp.is_on = false);
        assert!(!viewer.command().contains("--light"), "{}", viewer.command());
        assert_eq!(viewer.not_in_command(), ["lights off"]);
        viewer.remove_body(0);
        assert!(viewer.command().starts_with("rimline shadow FILE --eye "), "{}", viewer.command());
    }

    #[test]
    fn large_coordinates_keep_their_digits() {
        let mut viewer = viewer(0);
        let far = b"v 5000000 6000000.25 0\nv 5000001 6000000.25 0\nv 5000000 6000001.25 0\nf 1 2 3\n";
        let options = rimline_files::ReadOptions::default();
        let file = rimline_files::read_bytes(far, Some(std::path::Path::new("far.obj")), &options);
        viewer.open("far.obj", "far.obj".into(), file);
        assert!(viewer.origin.to_array()[1] > 5e6, "{:?}", viewer.origin);
        assert!(viewer.command().contains(" --ground 6000000.25 "), "{}", viewer.command());
    }

    #[test]
    fn without_lights_a_second_file_selects_none() {
        let mut viewer = viewer(1);
        (0..3).for_each(|_| viewer.handle(Event::Acted(Action::RemoveLight)));
        let (name, file) = block("second.obj");
        viewer.open(&name, name.clone(), Ok(file));
        assert!(viewer.lamps.is_empty() && viewer.selected.is_none());
        (0..=crate::scenes::ALL.len()).for_each(|_| viewer.handle(Event::Acted(Action::NextScene)));
        assert!(!viewer.is_built_in() && viewer.lamps.is_empty() && viewer.selected.is_none());
    }

    #[test]
    fn a_second_file_keeps_what_the_user_changed() {
        let mut viewer = viewer(1);
        viewer.handle(Event::Acted(Action::TurnLeft));
        viewer.handle(Event::Acted(Action::LightUp));
        let (orbit, lamps) = (viewer.orbit, viewer.lamps.clone());
        let (name, file) = block("second.obj");
        viewer.open(&name, name.clone(), Ok(file));
        assert!(viewer.orbit == orbit && viewer.lamps == lamps && viewer.bodies.len() == 2);
        // They are there again after all built-in scenes.
        let show_next = |viewer: &mut Viewer| viewer.handle(Event::Acted(Action::NextScene));
        for _ in crate::scenes::ALL {
            show_next(&mut viewer);
            assert!(viewer.is_built_in());
        }
        show_next(&mut viewer);
        assert!(!viewer.is_built_in() && viewer.orbit == orbit && viewer.lamps == lamps && viewer.bodies.len() == 2);
        // A file that is dropped on a built-in scene joins the others.
        show_next(&mut viewer);
        let (name, file) = block("third.obj");
        viewer.open(&name, name.clone(), Ok(file));
        assert!(viewer.lamps == lamps && viewer.bodies.len() == 3);
        (0..3).for_each(|_| viewer.remove_body(0));
        assert!(viewer.bodies.is_empty() && !viewer.is_built_in());
    }

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("a/b-1.glb"), "a/b-1.glb");
        assert_eq!(quoted("my model.glb"), "'my model.glb'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted("$HOME"), "'$HOME'");
        assert_eq!(quoted("-"), "./-");
        assert_eq!(quoted("-a b.obj"), "'./-a b.obj'");
        assert_eq!(quoted("a\u{15}it's\\\n\u{9b}b"), r"$'a\025it\'s\\\012\302\233b'");
    }
}
