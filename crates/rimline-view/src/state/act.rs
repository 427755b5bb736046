//! Actions of keys and buttons.

use glam::Vec3;
use rimline_picture::Mode;

use super::camera::Orbit;
use super::keys::Action;
use super::lamp::{Lamp, MAX_LAMPS};
use super::options::{COUNTINGS, SWITCHES};
use super::viewer::{Message, Request, Tone, Viewer};
use crate::scenes;

/// Degrees for each press of a key.
const STEP: f32 = 6.0;

impl Viewer {
    pub(super) fn act(&mut self, action: Action) {
        let flip = |switch: &mut bool| *switch = !*switch;
        if let Some((.., switch)) = SWITCHES.iter().find(|(of, ..)| *of == action) {
            return flip(switch(&mut self.options));
        }
        match action {
            Action::Help => flip(&mut self.shows_help),
            Action::Panel => flip(&mut self.shows_panel),
            Action::OpenFile => self.ask_for_files(),
            Action::NextScene => self.next_scene(),
            Action::ResetCamera => self.reset_camera(),
            Action::NextCamera => self.next_camera(),
            Action::TurnLeft => self.orbit.turn(-STEP, 0.0),
            Action::TurnRight => self.orbit.turn(STEP, 0.0),
            Action::TurnUp => self.orbit.turn(0.0, STEP),
            Action::TurnDown => self.orbit.turn(0.0, -STEP),
            Action::Nearer => self.zoom(0.9),
            Action::Farther => self.zoom(1.0 / 0.9),
            Action::Play => flip(&mut self.clock.is_running),
            Action::StepBack => self.step(-1.0 / 30.0),
            Action::StepOn => self.step(1.0 / 30.0),
            Action::Slower => self.clock.change_speed(0.5),
            Action::Faster => self.clock.change_speed(2.0),
            Action::NextAnimation => self.next_animation(),
            Action::NextLight if !self.lamps.is_empty() => {
                self.selected = Some(self.selected.map_or(0, |lamp| (lamp + 1) % self.lamps.len()));
            }
            Action::AddLight => self.add_lamp(),
            Action::RemoveLight => self.remove_lamp(),
            Action::SwitchLight => _ = self.lamp().map(|lamp| flip(&mut lamp.is_on)),
            Action::ChangeLightKind => {
                let bounds = self.bounds();
                _ = self.lamp().map(|lamp| lamp.change_kind(&bounds));
            }
            Action::LightLeft => self.shift_lamp(Vec3::NEG_X),
            Action::LightRight => self.shift_lamp(Vec3::X),
            Action::LightUp => self.shift_lamp(Vec3::Y),
            Action::LightDown => self.shift_lamp(Vec3::NEG_Y),
            Action::LightAhead => self.shift_lamp(Vec3::Z),
            Action::LightBack => self.shift_lamp(Vec3::NEG_Z),
            Action::NextMode => self.options.mode = Mode::ALL[(self.options.mode as usize + 1) % Mode::ALL.len()].0,
            Action::NextCounting => {
                let at = COUNTINGS.iter().position(|(of, _)| *of == self.options.counting).unwrap_or(0);
                self.options.counting = COUNTINGS[(at + 1) % COUNTINGS.len()].0;
            }
            Action::Screenshot => self.ask_for_screenshot(1),
            Action::LargeScreenshot => self.ask_for_screenshot(4),
            Action::CopyCommand => self.requests.push(Request::Copy(self.command())),
            Action::Close if self.shows_help => self.shows_help = false,
            Action::Close => self.requests.push(Request::Close),
            // No light, or a switch.
            _ => {}
        }
    }

    /// Asks for files, unless the dialog of the last time is still open.
    fn ask_for_files(&mut self) {
        if !std::mem::replace(&mut self.is_asking, true) {
            self.requests.push(Request::OpenFiles);
        }
    }

    /// Its message replaces those before.
    fn ask_for_screenshot(&mut self, scale: u32) {
        self.message = None;
        self.requests.push(Request::Screenshot { scale });
    }

    /// Stops, and shows another moment.
    fn step(&mut self, seconds: f32) {
        self.clock.is_running = false;
        let duration = self.duration();
        if duration > 0.0 {
            self.clock.seconds = (self.clock.seconds + seconds).rem_euclid(duration);
        }
    }

    /// Shows the next scene. Models of files are one of them, before the first that is built in.
    fn next_scene(&mut self) {
        let next = if self.is_built_in() { self.scene + 1 } else { 0 };
        if next == scenes::ALL.len() && self.show_opened() {
            return;
        }
        self.scene = next % scenes::ALL.len();
        match scenes::ALL[self.scene].1() {
            Ok(bodies) => self.replace(bodies),
            Err(error) => self.message = Some(Message::new(Tone::Note, error.to_string())),
        }
    }

    fn next_camera(&mut self) {
        let cameras = self.cameras();
        let first = |orbit: &Orbit| cameras.iter().position(|(_, other)| other == orbit);
        let after = first(&self.orbit).map_or(0, |current| current + 1);
        let mut others = (after..after + cameras.len()).map(|index| index % cameras.len());
        // One with the view of an earlier one would be taken for that, and those after it not be reached.
        let next = others.find(|&index| first(&cameras[index].1) == Some(index));
        match next.map(|index| &cameras[index]) {
            Some((name, orbit)) => {
                self.orbit = *orbit;
                self.message = Some(Message::new(Tone::Note, format!("camera {name}")));
            }
            None => self.message = Some(Message::new(Tone::Note, "these models have no cameras")),
        }
    }

    fn next_animation(&mut self) {
        let Some(index) = self.bodies.iter().position(|body| !body.animations().is_empty()) else { return };
        let body = &self.bodies[index];
        let (count, after) = (body.animations().len(), body.animation.map_or(0, |animation| animation + 1));
        // Damaged ones are passed over.
        let next = (after..after + count).map(|animation| animation % count).find(|&animation| body.plays(animation));
        if next.is_some() {
            self.play(index, next);
        }
    }

    pub(super) fn lamp(&mut self) -> Option<&mut Lamp> {
        self.lamps.get_mut(self.selected?)
    }

    fn add_lamp(&mut self) {
        if self.lamps.len() >= MAX_LAMPS {
            let text = format!("the viewer has at most {MAX_LAMPS} lights; remove one first");
            self.message = Some(Message::new(Tone::Error, text));
            return;
        }
        let (bounds, count) = (self.bounds(), self.lamps.len());
        let mut others = (count..count + MAX_LAMPS).map(|number| Lamp::around(&bounds, number));
        // The pointer takes hold of only the first of two at one point.
        let lamp = others.find(|lamp| self.lamps.iter().all(|other| other.kind != lamp.kind));
        self.lamps.push(lamp.unwrap_or_else(|| Lamp::around(&bounds, count)));
        self.selected = Some(count);
    }

    fn remove_lamp(&mut self) {
        let Some(number) = self.selected.filter(|&number| number < self.lamps.len()) else { return };
        self.lamps.remove(number);
        // Numbers of the others change, so nothing may go on with the old ones.
        (self.hovered, self.drag) = (None, None);
        self.selected = self.lamps.len().checked_sub(1).map(|last| number.min(last));
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rimline::gltf::{CameraProjection, SceneCamera};
    use rimline_files::{File, ReadOptions, read_bytes};

    use super::*;
    use crate::state::body::{Body, BodyError, Source};
    use crate::state::event::Event;

    /// A triangle with three animations, the second of which is damaged, and five cameras.
    struct Filmed(File);

    impl Source for Filmed {
        fn model(&self) -> &rimline::Model {
            self.0.model()
        }

        fn pose(&self, animation: Option<usize>, seconds: f32) -> Result<rimline::Pose, BodyError> {
            if animation == Some(1) { Err(BodyError::NoFaces) } else { Ok(self.0.pose(&[], seconds)?) }
        }

        fn animations(&self) -> Vec<(String, f32)> {
            [("walk", 3.0), ("damaged", 2.0), ("run", 1.0)].map(|(name, duration)| (name.to_owned(), duration)).into()
        }

        fn cameras(&self) -> Vec<SceneCamera> {
            let projection = CameraProjection::Perspective { yfov: 0.5, aspect_ratio: None, znear: 0.1, zfar: None };
            let forward = Vec3::new(-1.0, 0.0, -1.0).normalize().into();
            let of = |(name, x): (&str, f32)| {
                let (name, eye, up) = (Some(name.to_owned()), [x, 0.0, x], Vec3::Y.into());
                SceneCamera { name, eye, forward, up, projection }
            };
            [("a", 2.0), ("b", 3.0), ("a again", 2.0), ("c", 4.0), ("too far", 3e38)].map(of).into()
        }
    }

    fn viewer() -> Viewer {
        let triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let file = read_bytes(triangle, Some(Path::new("a.obj")), &ReadOptions::default()).expect("a triangle");
        Viewer::new(vec![Body::new("a.glb", None, Filmed(file)).expect("a triangle")])
    }

    #[test]
    fn an_animation_that_is_chosen_starts_at_its_beginning() {
        let choices: [fn(&mut Viewer); 2] =
            [|viewer| viewer.play(0, Some(2)), |viewer| viewer.handle(Event::Acted(Action::NextAnimation))];
        for choose in choices {
            let mut viewer = viewer();
            viewer.handle(Event::Passed(2.5));
            let before = viewer.generation();
            choose(&mut viewer);
            assert_eq!((viewer.clock.seconds, viewer.duration()), (0.0, 1.0));
            assert_ne!(viewer.generation(), before);
        }
    }

    #[test]
    fn a_damaged_animation_leaves_the_one_that_plays() {
        let mut viewer = viewer();
        viewer.handle(Event::Passed(2.5));
        let before = viewer.generation();
        viewer.play(0, Some(1));
        let is_error = viewer.message.as_ref().is_some_and(|message| message.tone == Tone::Error);
        assert!(is_error && viewer.bodies[0].animation == Some(0) && viewer.clock.seconds == 2.5);
        assert_eq!(viewer.generation(), before);
    }

    #[test]
    fn no_light_is_added_where_another_is() {
        let mut viewer = viewer();
        for removed in [0, 1, 7] {
            (0..MAX_LAMPS).for_each(|_| viewer.handle(Event::Acted(Action::AddLight)));
            assert_eq!((viewer.lamps.len(), viewer.selected), (MAX_LAMPS, Some(MAX_LAMPS - 1)));
            for (number, lamp) in viewer.lamps.iter().enumerate() {
                assert!(viewer.lamps.iter().skip(number + 1).all(|other| other.kind != lamp.kind), "{number}");
            }
            viewer.selected = Some(removed);
            viewer.handle(Event::Acted(Action::RemoveLight));
        }
    }

    #[test]
    fn every_view_of_the_cameras_is_reached() {
        let mut viewer = viewer();
        for name in ["a", "b", "c", "a"] {
            viewer.handle(Event::Acted(Action::NextCamera));
            let said = viewer.message.as_ref().map(|message| message.text.as_str());
            assert_eq!(said, Some(format!("camera {name}").as_str()));
            assert!(viewer.orbit.eye().is_finite());
        }
    }
}
