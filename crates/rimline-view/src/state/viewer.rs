//! The viewer's state, and how events change it.

use glam::{Vec2, Vec3};
use rimline::Origin;
use rimline_picture::{Bounds, Mode};

use super::body::Body;
use super::camera::{Camera, Orbit};
use super::clock::Clock;
use super::event::{Button, Event, Modifiers};
use super::keys::Action;
use super::lamp::{Lamp, LampKind, sun_distance};
use super::options::{COUNTINGS, Options};

/// Lights that there may be at a time.
pub(crate) const MAX_LAMPS: usize = 8;

/// Requests of the viewer to the shell that runs it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Request {
    /// Ask for files, and open them.
    OpenFiles,
    /// Show the next of the built-in scenes.
    NextScene,
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

/// The state of the viewer.
#[derive(Debug)]
pub struct Viewer {
    /// Models that are shown.
    pub bodies: Vec<Body>,
    /// Lights.
    pub lamps: Vec<Lamp>,
    /// Where the eye is.
    pub orbit: Orbit,
    /// Options of the picture.
    pub options: Options,
    /// The time of animations.
    pub clock: Clock,
    /// The light that keys move.
    pub selected: Option<usize>,
    /// The light whose handle the pointer is on.
    pub hovered: Option<usize>,
    /// A message for the user.
    pub message: Option<(Tone, String)>,
    /// Whether the panel is shown.
    pub shows_panel: bool,
    /// Whether the list of keys is shown.
    pub shows_help: bool,
    /// The origin of models with large coordinates.
    pub origin: Origin,
    /// How near to a handle the pointer drags it, in pixels.
    pub handle_radius: f32,
    /// Requests to the shell, which takes them out.
    pub requests: Vec<Request>,
    size: [u32; 2],
    generation: u64,
    pointer: Vec2,
    drag: Option<Drag>,
    /// Whether models of the viewer's own are shown, which those of files replace.
    is_built_in: bool,
}

/// The thing that the pointer drags.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Drag {
    Turn,
    Pan,
    Lamp(usize, Modifiers),
}

/// Degrees for each pixel that the pointer moves.
const TURN: f32 = 0.35;
/// Degrees for each press of a key.
const STEP: f32 = 6.0;

impl Viewer {
    /// Shows these models, with three lights around them.
    pub fn new(bodies: Vec<Body>) -> Self {
        let mut viewer = Self {
            bodies: Vec::new(),
            lamps: Vec::new(),
            orbit: Orbit { target: Vec3::ZERO, azimuth: 0.0, elevation: 0.0, distance: 1.0, fov: 35.0 },
            options: Options::default(),
            clock: Clock::default(),
            selected: Some(0),
            hovered: None,
            message: None,
            shows_panel: true,
            shows_help: false,
            origin: Origin::ZERO,
            handle_radius: 16.0,
            requests: Vec::new(),
            size: [1280, 800],
            generation: 0,
            pointer: Vec2::ZERO,
            drag: None,
            is_built_in: true,
        };
        viewer.replace(bodies);
        viewer
    }

    /// Width and height of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// A number that changes whenever models come or go, or play something else.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// The box of all models.
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

    /// The longest animation that plays, in seconds.
    pub fn duration(&self) -> f32 {
        self.bodies.iter().map(Body::duration).fold(0.0, f32::max)
    }

    /// Whether the picture changes by itself.
    pub fn is_animated(&self) -> bool {
        self.clock.is_running && self.clock.speed != 0.0 && self.duration() > 0.0
    }

    /// Whether the pointer drags something.
    pub fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }

    /// Takes a model out, as one that the device has no room for.
    pub fn remove_body(&mut self, index: usize) {
        if index < self.bodies.len() {
            self.bodies.remove(index);
            self.generation += 1;
        }
    }

    /// Lets another animation of a model play, or none.
    pub fn play(&mut self, index: usize, animation: Option<usize>) {
        if let Some(body) = self.bodies.get_mut(index).filter(|body| body.animation != animation) {
            body.animation = animation;
            self.generation += 1;
        }
    }

    /// Does what an event asks for.
    pub fn handle(&mut self, event: Event) {
        match event {
            Event::Resized(size) => self.size = size.map(|side| side.max(1)),
            Event::Moved(to) => self.moved(Vec2::from(to)),
            Event::Pressed(button, modifiers) => self.pressed(button, modifiers),
            Event::Released => self.drag = None,
            Event::Scrolled([x, y], modifiers) if modifiers.shift => self.pan(Vec2::new(x, y) * 40.0),
            Event::Scrolled([_, y], _) => self.zoom((-0.12 * y).exp()),
            Event::Pinched(factor) => self.zoom(factor.max(0.1).recip()),
            Event::Acted(action) => self.act(action),
            Event::Flown(by, seconds) => self.orbit.shift(Vec3::from(by) * 0.7 * seconds * self.bounds().extent()),
            Event::Passed(seconds) => self.clock.advance(seconds, self.duration()),
            Event::Opened(Ok(body)) => self.add(*body),
            Event::Opened(Err((name, why))) => self.message = Some((Tone::Error, format!("{name}: {why}"))),
            Event::Replaced(bodies) => self.replace(bodies),
            Event::Told(text) => self.message = Some((Tone::Note, text)),
        }
    }

    fn replace(&mut self, bodies: Vec<Body>) {
        self.bodies = bodies;
        self.is_built_in = true;
        self.origin = Origin::ZERO;
        self.arrange();
    }

    /// Adds a model of a file. The first one takes the place of models of the viewer's own.
    fn add(&mut self, body: Body) {
        if self.is_built_in {
            self.bodies.clear();
        }
        self.is_built_in = false;
        self.message = Some((Tone::Note, format!("{}: {} faces", body.name, body.report().faces)));
        self.bodies.push(body);
        self.arrange();
    }

    /// Places camera and lights for new models.
    fn arrange(&mut self) {
        self.generation += 1;
        self.drag = None;
        self.clock.seconds = 0.0;
        let bounds = self.bounds();
        self.lamps = self.bodies.first().map_or_else(Vec::new, |body| lamps_of(body, &bounds));
        if self.lamps.is_empty() {
            self.lamps = (0..3).map(|number| Lamp::around(&bounds, number)).collect();
        }
        self.selected = Some(0);
        self.reset_camera();
    }

    fn reset_camera(&mut self) {
        let [width, height] = self.size.map(|side| side as f32);
        let bounds = self.bounds();
        // Handles are within reach, but those of lights far away would make the models small.
        let is_near = |handle: &Vec3| handle.distance(bounds.centre()) < 1.6 * bounds.extent();
        let handles: Vec<Vec3> = self.lamps.iter().map(|lamp| lamp.handle(&bounds)).filter(is_near).collect();
        self.orbit = Orbit::showing(&bounds, &handles, width / height);
    }

    fn zoom(&mut self, factor: f32) {
        self.orbit.zoom(factor, self.bounds().extent());
    }

    /// Moves the camera so that the target follows the pointer.
    fn pan(&mut self, pixels: Vec2) {
        let length = self.camera().pixel() * self.orbit.distance;
        self.orbit.shift(Vec3::new(-pixels.x, pixels.y, 0.0) * length);
    }

    fn pressed(&mut self, button: Button, modifiers: Modifiers) {
        self.drag = Some(match (button, self.handle_at(self.pointer)) {
            (Button::Primary, Some(lamp)) => {
                self.selected = Some(lamp);
                Drag::Lamp(lamp, modifiers)
            }
            (Button::Primary, None) if !modifiers.shift => Drag::Turn,
            _ => Drag::Pan,
        });
    }

    fn moved(&mut self, to: Vec2) {
        let by = to - self.pointer;
        self.pointer = to;
        match self.drag {
            Some(Drag::Turn) => self.orbit.turn(-TURN * by.x, TURN * by.y),
            Some(Drag::Pan) => self.pan(by),
            Some(Drag::Lamp(lamp, modifiers)) => self.drag_lamp(lamp, to, modifiers),
            None => self.hovered = self.handle_at(to),
        }
    }

    /// The light whose handle is at a pixel, the nearest one.
    fn handle_at(&self, pixel: Vec2) -> Option<usize> {
        let (camera, bounds) = (self.camera(), self.bounds());
        let distance = |lamp: &Lamp| Some(camera.project(lamp.handle(&bounds))?.distance(pixel));
        let all = self.lamps.iter().enumerate().filter_map(|(number, lamp)| Some((number, distance(lamp)?)));
        let nearest = all.min_by(|(_, a), (_, b)| a.total_cmp(b));
        nearest.filter(|(_, distance)| *distance <= self.handle_radius).map(|(number, _)| number)
    }

    /// Moves a light to where the pointer is: in a plane that faces the eye, at its height, or up and down.
    fn drag_lamp(&mut self, number: usize, pixel: Vec2, modifiers: Modifiers) {
        let (camera, bounds) = (self.camera(), self.bounds());
        let Some(lamp) = self.lamps.get_mut(number) else { return };
        let (ray, from) = (camera.ray(pixel), camera.eye);
        let at = lamp.handle(&bounds);
        // Where the ray meets a plane through the light, but not farther than can be worked with.
        let meet = |normal: Vec3| {
            let along = (at - from).dot(normal) / ray.dot(normal);
            let most = 200.0 * bounds.extent();
            (along.is_finite() && along > 0.0 && along < most).then(|| from + along * ray)
        };
        let moved = if modifiers.shift {
            let level = Vec3::new(camera.forward.x, 0.0, camera.forward.z).normalize_or(camera.up);
            meet(level).map(|there| Vec3::new(at.x, there.y, at.z))
        } else if modifiers.control {
            meet(Vec3::Y)
        } else {
            meet(camera.forward)
        };
        match &mut lamp.kind {
            LampKind::Point(place) => *place = moved.unwrap_or(at),
            LampKind::Sun(towards) => {
                *towards = on_sphere(from, ray, bounds.centre(), sun_distance(&bounds), at).normalize_or(*towards);
            }
        }
    }

    fn act(&mut self, action: Action) {
        let overlays = &mut self.options.overlays;
        let flip = |switch: &mut bool| *switch = !*switch;
        match action {
            Action::Help => flip(&mut self.shows_help),
            Action::Panel => flip(&mut self.shows_panel),
            Action::OpenFile => self.requests.push(Request::OpenFiles),
            Action::NextScene => self.requests.push(Request::NextScene),
            Action::ResetCamera => self.reset_camera(),
            Action::TurnLeft => self.orbit.turn(-STEP, 0.0),
            Action::TurnRight => self.orbit.turn(STEP, 0.0),
            Action::TurnUp => self.orbit.turn(0.0, STEP),
            Action::TurnDown => self.orbit.turn(0.0, -STEP),
            Action::Nearer => self.zoom(0.9),
            Action::Farther => self.zoom(1.0 / 0.9),
            Action::Play => flip(&mut self.clock.is_running),
            Action::StepBack => self.step(-1.0 / 30.0),
            Action::StepOn => self.step(1.0 / 30.0),
            Action::Slower => self.clock.speed = (self.clock.speed * 0.5).max(0.125),
            Action::Faster => self.clock.speed = (self.clock.speed * 2.0).min(8.0),
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
            Action::Silhouettes => flip(&mut overlays.silhouettes),
            Action::LightSilhouettes => flip(&mut overlays.light_silhouettes),
            Action::Volumes => flip(&mut overlays.volumes),
            Action::Caps => flip(&mut overlays.caps),
            Action::Boundary => flip(&mut overlays.boundary),
            Action::NonManifold => flip(&mut overlays.non_manifold),
            Action::Creases => flip(&mut overlays.creases),
            Action::Boxes => flip(&mut overlays.boxes),
            Action::Ground => flip(&mut self.options.ground),
            Action::Shadows => flip(&mut self.options.shadows),
            Action::Smooth => flip(&mut self.options.smooth),
            Action::Colors => flip(&mut self.options.colors),
            Action::NextMode => self.options.mode = Mode::ALL[(self.options.mode as usize + 1) % Mode::ALL.len()].0,
            Action::NextCounting => {
                let at = COUNTINGS.iter().position(|(of, _)| *of == self.options.counting).unwrap_or(0);
                self.options.counting = COUNTINGS[(at + 1) % COUNTINGS.len()].0;
            }
            Action::Screenshot => self.requests.push(Request::Screenshot { scale: 1 }),
            Action::LargeScreenshot => self.requests.push(Request::Screenshot { scale: 4 }),
            Action::CopyCommand => self.requests.push(Request::Copy(self.command())),
            Action::Close if self.shows_help => self.shows_help = false,
            Action::Close => self.requests.push(Request::Close),
            Action::NextLight => {}
        }
    }

    /// Stops, and shows another moment.
    fn step(&mut self, seconds: f32) {
        self.clock.is_running = false;
        let duration = self.duration();
        if duration > 0.0 {
            self.clock.seconds = (self.clock.seconds + seconds).rem_euclid(duration);
        }
    }

    fn next_animation(&mut self) {
        let Some(index) = self.bodies.iter().position(|body| !body.animations().is_empty()) else { return };
        let count = self.bodies[index].animations().len();
        let next = self.bodies[index].animation.map_or(0, |animation| (animation + 1) % count);
        self.play(index, Some(next));
        self.clock.seconds = 0.0;
    }

    fn lamp(&mut self) -> Option<&mut Lamp> {
        self.lamps.get_mut(self.selected?)
    }

    fn add_lamp(&mut self) {
        if self.lamps.len() >= MAX_LAMPS {
            self.message = Some((Tone::Error, format!("the viewer has at most {MAX_LAMPS} lights; remove one first")));
            return;
        }
        self.lamps.push(Lamp::around(&self.bounds(), self.lamps.len()));
        self.selected = Some(self.lamps.len() - 1);
    }

    fn remove_lamp(&mut self) {
        let Some(number) = self.selected.filter(|&number| number < self.lamps.len()) else { return };
        self.lamps.remove(number);
        self.hovered = None;
        self.selected = self.lamps.len().checked_sub(1).map(|last| number.min(last));
    }

    /// Moves the selected light by a step: right and ahead as the eye sees it, on the level, and up.
    fn shift_lamp(&mut self, by: Vec3) {
        let (bounds, [right, _, forward]) = (self.bounds(), self.orbit.axes());
        let ahead = Vec3::new(forward.x, 0.0, forward.z).normalize_or(Vec3::NEG_Z);
        let by = (by.x * right + by.y * Vec3::Y + by.z * ahead) * 0.06 * bounds.extent();
        let Some(lamp) = self.lamp() else { return };
        let handle = lamp.handle(&bounds) + by;
        lamp.kind = match lamp.kind {
            LampKind::Point(_) => LampKind::Point(handle),
            LampKind::Sun(towards) => LampKind::Sun((handle - bounds.centre()).normalize_or(towards)),
        };
    }
}

/// The lights of a file, as many as the viewer has; the brightest counts as 1.
fn lamps_of(body: &Body, bounds: &Bounds) -> Vec<Lamp> {
    let lights = body.lights();
    let illuminance = |light: &rimline::gltf::SceneLight| {
        if light.light.w == 0.0 {
            return light.intensity;
        }
        let distance = (Vec3::from(light.light.xyz) - bounds.centre()).length().max(0.5 * bounds.extent());
        light.intensity / (distance * distance)
    };
    let brightest = lights.iter().map(illuminance).fold(0.0, f32::max);
    let lamp = |light| Lamp::of_file(light, if brightest > 0.0 { illuminance(light) / brightest } else { 1.0 });
    lights.iter().take(MAX_LAMPS).map(lamp).collect()
}

/// From the middle of a sphere to where a ray meets it, the meeting nearest to `at`; or to where the ray is nearest.
fn on_sphere(from: Vec3, ray: Vec3, centre: Vec3, radius: f32, at: Vec3) -> Vec3 {
    let (ray, to) = (ray.normalize(), centre - from);
    let middle = to.dot(ray);
    let half = (radius * radius - (to - middle * ray).length_squared()).max(0.0).sqrt();
    let meetings = [middle - half, middle + half].map(|along| from + along * ray);
    let [near, far] = meetings;
    if near.distance_squared(at) <= far.distance_squared(at) { near - centre } else { far - centre }
}
