//! The viewer's state, and how events change it.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{Vec2, Vec3};
use rimline::Origin;
use rimline::gltf::SceneCamera;
use rimline_files::ReadOptions;
use rimline_picture::{Bounds, Mode};

use super::body::{Body, short};
use super::camera::{Camera, Orbit};
use super::clock::Clock;
use super::event::Event;
use super::handle::{Drag, Handle};
use super::lamp::{AREA_SAMPLES, Lamp, MAX_LAMPS};
use super::options::Options;

/// Points that may shine at a time, for all lights.
pub(crate) const MAX_SOURCES: usize = MAX_LAMPS * AREA_SAMPLES;

/// The last generation of all viewers.
static LAST: AtomicU64 = AtomicU64::new(0);

/// Requests of the viewer to the shell that runs it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Request {
    /// Ask for files, and open them. The next such request comes after [`Event::Answered`].
    OpenFiles,
    /// Write a picture, so many times as large each way.
    Screenshot {
        /// 1 or 4.
        scale: u32,
    },
    /// Put a line of text on the clipboard.
    Copy(String),
    /// Close the window.
    Close,
}

/// Whether a message is about a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Something was done.
    Note,
    /// Something failed.
    Error,
}

/// A message for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Whether it is about a failure.
    pub tone: Tone,
    /// A sentence.
    pub text: String,
    /// Shown while the pointer is on it, if not empty.
    pub details: String,
}

impl Message {
    /// A message without details.
    pub fn new(tone: Tone, text: impl Into<String>) -> Self {
        Self { tone, text: text.into(), details: String::new() }
    }
}

/// Models of files, and what belongs to them, while a built-in scene is shown.
#[derive(Debug)]
struct Opened {
    bodies: Vec<Body>,
    lamps: Vec<Lamp>,
    orbit: Orbit,
    origin: Origin,
    arranged: (Vec<Lamp>, Orbit),
    /// The size of the picture then.
    size: [u32; 2],
}

/// The state of the viewer.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "states that do not depend on each other")]
pub struct Viewer {
    /// Models that are shown. Renderers notice other ones by their number and by [`Self::generation`], which methods and
    /// events change.
    pub bodies: Vec<Body>,
    /// Lights, at most eight: files and keys make no more.
    pub lamps: Vec<Lamp>,
    /// Where the eye is.
    pub orbit: Orbit,
    /// Options of the picture.
    pub options: Options,
    /// The time of animations.
    pub clock: Clock,
    /// The light that keys move.
    pub selected: Option<usize>,
    /// The handle that the pointer is on.
    pub hovered: Option<Handle>,
    /// A message for the user.
    pub message: Option<Message>,
    /// Whether the panel is shown.
    pub shows_panel: bool,
    /// Whether the list of keys is shown.
    pub shows_help: bool,
    /// The origin of models with large coordinates.
    pub origin: Origin,
    /// How files are read from now on, which [`Self::command`] repeats.
    pub read: ReadOptions,
    /// How near to a handle the pointer drags it, in pixels. Each [`Panel::run`](crate::Panel::run) sets it.
    pub handle_radius: f32,
    /// Requests to the shell, which takes them out.
    pub requests: Vec<Request>,
    size: [u32; 2],
    generation: u64,
    pub(super) pointer: Vec2,
    pub(super) drag: Option<Drag>,
    /// Whether a dialog for files is open.
    pub(super) is_asking: bool,
    /// Whether models of the viewer's own are shown, which those of files replace.
    is_built_in: bool,
    /// Lights and camera as they were placed for the models: those that the user changed stay when a model is added, and
    /// the camera also when the picture gets another size.
    arranged: (Vec<Lamp>, Orbit),
    opened: Option<Opened>,
    /// The built-in scene that was shown last.
    pub(super) scene: usize,
}

impl Viewer {
    /// Shows these models, with the lights of the first one, at most eight, or with three around them. They count as a built-in
    /// scene: the first file that is opened replaces them.
    pub fn new(bodies: Vec<Body>) -> Self {
        let orbit = Orbit { target: Vec3::ZERO, azimuth: 0.0, elevation: 0.0, distance: 1.0, fov: 35.0 };
        let mut viewer = Self {
            bodies: Vec::new(),
            lamps: Vec::new(),
            orbit,
            options: Options::default(),
            clock: Clock::default(),
            selected: Some(0),
            hovered: None,
            message: None,
            shows_panel: true,
            shows_help: false,
            origin: Origin::ZERO,
            read: ReadOptions::default(),
            handle_radius: 16.0,
            requests: Vec::new(),
            size: [1280, 800],
            generation: 0,
            pointer: Vec2::ZERO,
            drag: None,
            is_asking: false,
            is_built_in: true,
            arranged: (Vec::new(), orbit),
            opened: None,
            scene: 0,
        };
        viewer.replace(bodies);
        viewer
    }

    /// Width and height of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// A number that changes whenever models come or go, or play something else. No other viewer has it.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// The box of all models as they were opened. Without any: a cube of size 1.
    pub fn bounds(&self) -> Bounds {
        let none = Bounds { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) };
        self.bodies.iter().map(Body::bounds).reduce(Bounds::with).unwrap_or(none)
    }

    /// The height of the ground.
    pub fn ground(&self) -> f32 {
        self.bounds().ground()
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        self.orbit.camera(self.size, &self.bounds(), self.ground())
    }

    /// Names and views of the files' cameras. One too far away to be looked through is left out.
    pub fn cameras(&self) -> Vec<(String, Orbit)> {
        let bounds = self.bounds();
        let cameras = self.bodies.iter().flat_map(Body::cameras).enumerate();
        let named = |(number, camera): (usize, &SceneCamera)| {
            let name = camera.name.as_deref().map_or_else(|| format!("camera {number}"), short);
            (name, Orbit::of_file(camera, &bounds))
        };
        let is_near = |(_, orbit): &(String, Orbit)| orbit.target.is_finite() && orbit.distance.is_finite();
        cameras.map(named).filter(is_near).collect()
    }

    /// The longest animation that plays, in seconds.
    pub fn duration(&self) -> f32 {
        self.bodies.iter().map(Body::duration).fold(0.0, f32::max)
    }

    /// The points that shine, each with the number of its light among those that are on. Only shadows that each take away the
    /// light of a point of an area add up to a soft one; other ways to draw shadows take the middle.
    pub fn sources(&self) -> Vec<(usize, Lamp)> {
        let has_areas = self.options.shadows && self.options.mode == Mode::Additive;
        let lamps = self.lamps.iter().filter(|lamp| lamp.is_on).enumerate();
        let sources = |lamp: &Lamp| if has_areas { lamp.sources() } else { vec![lamp.clone()] };
        lamps.flat_map(|(number, lamp)| sources(lamp).into_iter().map(move |source| (number, source))).collect()
    }

    /// Whether the picture changes by itself.
    pub fn is_animated(&self) -> bool {
        self.clock.is_running && self.clock.speed != 0.0 && self.duration() > 0.0
    }

    /// Whether the pointer drags something.
    pub fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }

    /// Takes a model out, and the message. Camera and lights stay.
    pub fn remove_body(&mut self, index: usize) {
        if index < self.bodies.len() {
            self.bodies.remove(index);
            self.change();
            self.message = None;
        }
    }

    /// Whether a built-in scene is shown.
    pub fn is_built_in(&self) -> bool {
        self.is_built_in
    }

    /// Shows the models of files again that a built-in scene replaced. Returns whether there are any.
    pub(super) fn show_opened(&mut self) -> bool {
        let Some(opened) = self.opened.take() else { return false };
        (self.bodies, self.lamps, self.orbit) = (opened.bodies, opened.lamps, opened.orbit);
        (self.origin, self.arranged) = (opened.origin, opened.arranged);
        self.is_built_in = false;
        if opened.size != self.size {
            self.resize(self.size);
        }
        self.begin();
        true
    }

    /// The origin of the models of files, if there are any.
    pub(super) fn opened_origin(&self) -> Option<Origin> {
        let opened = self.opened.as_ref().map(|opened| opened.origin);
        opened.or_else(|| self.bodies.iter().any(|body| body.file.is_some()).then_some(self.origin))
    }

    /// Lets an animation of a model play, or none. The time of all models starts again, also if it plays already. A damaged
    /// animation changes nothing but the message.
    pub fn play(&mut self, index: usize, animation: Option<usize>) {
        let Some(body) = self.bodies.get_mut(index) else { return };
        let before = std::mem::replace(&mut body.animation, animation);
        if let Err(error) = body.pose(0.0) {
            body.animation = before;
            self.message = Some(Message::new(Tone::Error, format!("{}: {error}", body.name)));
            return;
        }
        self.clock.seconds = 0.0;
        if before != animation {
            self.change();
        }
    }

    /// Notes that the models are others.
    fn change(&mut self) {
        self.generation = LAST.fetch_add(1, Ordering::Relaxed) + 1;
    }

    /// Does what an event asks for.
    pub fn handle(&mut self, event: Event) {
        match event {
            Event::Resized(size) => self.resize(size.map(|side| side.max(1))),
            Event::Moved(to) => self.moved(Vec2::from(to)),
            Event::Pressed(button, modifiers) => self.pressed(button, modifiers),
            Event::Released => self.drag = None,
            Event::Scrolled([x, y], modifiers) if modifiers.shift => self.pan(Vec2::new(x, y) * 40.0),
            Event::Scrolled([_, y], _) => self.zoom((-0.12 * y).exp()),
            Event::Panned(by) => self.pan(Vec2::from(by)),
            // Fingers at one point have no distance to compare.
            Event::Pinched(factor) if factor.is_nan() => {}
            Event::Pinched(factor) => self.zoom(factor.clamp(0.1, 10.0).recip()),
            Event::Acted(action) => self.act(action),
            Event::Flown(by, seconds) => self.orbit.shift(Vec3::from(by) * 0.7 * seconds * self.bounds().extent()),
            Event::Passed(seconds) => self.clock.advance(seconds, self.duration()),
            Event::Answered => self.is_asking = false,
            Event::Opening => self.message = None,
            Event::Opened(Ok(body)) => self.add(*body),
            Event::Opened(Err((name, why))) => self.add_error(&format!("{name}: {why}")),
            Event::Copied(how, line) => self.copied(how, line),
            Event::Message(text) => self.message = Some(Message::new(Tone::Note, text)),
        }
    }

    /// Takes another size. A camera that the user left alone still shows everything.
    fn resize(&mut self, size: [u32; 2]) {
        let is_arranged = self.orbit == self.arranged.1;
        self.size = size;
        if is_arranged {
            self.reset_camera();
        }
    }

    /// Shows models of the viewer's own. Models of files are kept.
    pub(super) fn replace(&mut self, bodies: Vec<Body>) {
        let bodies = std::mem::replace(&mut self.bodies, bodies);
        if !self.is_built_in && !bodies.is_empty() {
            let (lamps, arranged) = (std::mem::take(&mut self.lamps), self.arranged.clone());
            let (orbit, origin, size) = (self.orbit, self.origin, self.size);
            self.opened = Some(Opened { bodies, lamps, orbit, origin, arranged, size });
        }
        self.is_built_in = true;
        self.origin = Origin::ZERO;
        self.arrange();
        self.begin();
    }

    /// Says what failed, beside what failed before: in lines, and the rest in details.
    pub(crate) fn add_error(&mut self, error: &str) {
        const SHOWN: usize = 6;
        match &mut self.message {
            Some(Message { tone: Tone::Error, text, .. }) if text.lines().count() < SHOWN => {
                *text += "\n";
                *text += error;
            }
            Some(Message { tone: Tone::Error, text, details }) => {
                if details.is_empty() {
                    *text += "\n…";
                } else {
                    *details += "\n";
                }
                *details += error;
            }
            _ => self.message = Some(Message::new(Tone::Error, error)),
        }
    }

    /// Adds a model of a file. Models of files replace the built-in ones.
    fn add(&mut self, body: Body) {
        let failed = self.message.take().filter(|message| message.tone == Tone::Error);
        if self.is_built_in && !self.show_opened() {
            self.bodies.clear();
        }
        self.is_built_in = false;
        let text = format!("{}: {} faces", body.name, body.report().faces);
        let left_out = self.lights_left_out(&body);
        self.bodies.push(body);
        let (lamps, orbit) = (self.lamps.clone(), self.orbit);
        let is_first = self.bodies.len() == 1;
        let (keeps_lamps, keeps_orbit) = (!is_first && lamps != self.arranged.0, !is_first && orbit != self.arranged.1);
        self.arrange();
        if keeps_lamps {
            self.lamps = lamps;
        }
        if keeps_orbit {
            self.orbit = orbit;
        }
        // After the lights: it selects the first of those that there are now.
        self.begin();
        self.message = Some(failed.unwrap_or_else(|| Message::new(Tone::Note, text)));
        if let Some(error) = left_out {
            self.add_error(&error);
        }
    }

    /// Other models are shown: what belongs to those before ends.
    fn begin(&mut self) {
        self.change();
        self.drag = None;
        self.clock.seconds = 0.0;
        self.selected = (!self.lamps.is_empty()).then_some(0);
        self.hovered = None;
        self.message = None;
    }

    /// Places camera and lights for new models: lights of the first one, or three around all.
    fn arrange(&mut self) {
        let bounds = self.bounds();
        self.lamps = self.bodies.first().map_or_else(Vec::new, |body| Lamp::all_of_file(&body.lights(), &bounds));
        self.lamps.truncate(MAX_LAMPS);
        if self.lamps.is_empty() {
            self.lamps = (0..3).map(|number| Lamp::around(&bounds, number)).collect();
        }
        self.arranged.0 = self.lamps.clone();
        self.reset_camera();
    }

    /// Says that the command line was copied, and what it lacks.
    fn copied(&mut self, how: String, details: String) {
        let mut text = how;
        if self.is_built_in {
            text += "; a built-in scene has no file: replace FILE by one";
        }
        let lacking = self.not_in_command();
        if !lacking.is_empty() {
            text += "; not in it: ";
            text += &lacking.join(", ");
        }
        self.message = Some(Message { tone: Tone::Note, text, details });
    }

    pub(super) fn reset_camera(&mut self) {
        let [width, height] = self.size.map(|side| side as f32);
        let bounds = self.bounds();
        // Handles are within reach, but those of lights far away would make the models small.
        let is_near = |handle: &Vec3| handle.distance(bounds.centre()) < 1.6 * bounds.extent();
        let handles: Vec<Vec3> = self.lamps.iter().map(|lamp| lamp.handle(&bounds)).filter(is_near).collect();
        self.orbit = Orbit::showing(&bounds, &handles, width / height);
        self.arranged.1 = self.orbit;
    }
}
