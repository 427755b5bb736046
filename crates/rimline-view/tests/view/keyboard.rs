//! The keyboard: each key does what the list says, and Tab reaches everything of the panel.

use egui::output::OutputEvent;
use egui::{Event as Heard, Key, Modifiers, Role};
use glam::Vec3;
use rimline_testkit::harness::Test;
use rimline_view::{Action, Clock, Counting, KEYS, Lamp, Mode, Options, Orbit, Request, Viewer, scenes};

use crate::panel::{SIZE, Stage, key, release};
use crate::support::{Outcome, hold};

pub(crate) const TESTS: [Test; 5] = [
    ("each key does what the list says, and nothing else", each_key),
    ("keys move the selected light the way they say", keys_move_a_light),
    ("keys that are held fly", flying),
    ("Tab reaches lights, levels of skipping and models", tab_reaches_everything),
    ("arrow keys stay within the range of a number", ranges),
];

/// A window whose picture is small beside the panel, so that many are drawn fast.
const NARROW: [u32; 2] = [360, SIZE[1]];

/// The parts of the state that keys change.
#[derive(Clone, Debug, PartialEq)]
struct Seen {
    orbit: Orbit,
    options: Options,
    clock: Clock,
    selected: Option<usize>,
    lamps: Vec<Lamp>,
    shows_help: bool,
    shows_panel: bool,
    requests: Vec<Request>,
}

impl Seen {
    fn of(viewer: &Viewer) -> Self {
        Self {
            orbit: viewer.orbit,
            options: viewer.options,
            clock: viewer.clock,
            selected: viewer.selected,
            lamps: viewer.lamps.clone(),
            shows_help: viewer.shows_help,
            shows_panel: viewer.shows_panel,
            requests: viewer.requests.clone(),
        }
    }

    fn put_into(self, viewer: &mut Viewer) {
        (viewer.orbit, viewer.options, viewer.clock) = (self.orbit, self.options, self.clock);
        (viewer.selected, viewer.lamps) = (self.selected, self.lamps);
        (viewer.shows_help, viewer.shows_panel, viewer.requests) = (self.shows_help, self.shows_panel, self.requests);
    }
}

/// Changes the state of a viewer as the list says. Returns whether this is an action of the camera or of the window.
fn look(action: Action, seen: &mut Seen, viewer: &Viewer, first: Orbit) -> bool {
    let extent = viewer.bounds().extent();
    match action {
        Action::Help => seen.shows_help = true,
        Action::Panel => seen.shows_panel = false,
        Action::OpenFile => seen.requests.push(Request::OpenFiles),
        Action::ResetCamera => seen.orbit = first,
        // The scene has none.
        Action::NextCamera => {}
        Action::TurnLeft => seen.orbit.turn(-6.0, 0.0),
        Action::TurnRight => seen.orbit.turn(6.0, 0.0),
        Action::TurnUp => seen.orbit.turn(0.0, 6.0),
        Action::TurnDown => seen.orbit.turn(0.0, -6.0),
        Action::Nearer => seen.orbit.zoom(0.9, extent),
        Action::Farther => seen.orbit.zoom(1.0 / 0.9, extent),
        Action::Screenshot => seen.requests.push(Request::Screenshot { scale: 1 }),
        Action::LargeScreenshot => seen.requests.push(Request::Screenshot { scale: 4 }),
        Action::CopyCommand => seen.requests.push(Request::Copy(viewer.command())),
        Action::Close => seen.requests.push(Request::Close),
        _ => return false,
    }
    true
}

/// The same for time and lights.
fn play(action: Action, seen: &mut Seen, viewer: &Viewer) -> bool {
    let (bounds, duration) = (viewer.bounds(), viewer.duration());
    match action {
        Action::Play => seen.clock.is_running = true,
        Action::StepBack => seen.clock.seconds = (seen.clock.seconds - 1.0 / 30.0).rem_euclid(duration),
        Action::StepOn => seen.clock.seconds = (seen.clock.seconds + 1.0 / 30.0).rem_euclid(duration),
        Action::Slower => seen.clock.speed = 0.5,
        Action::Faster => seen.clock.speed = 2.0,
        Action::NextAnimation => seen.clock.seconds = 0.0,
        Action::NextLight => seen.selected = Some(1),
        Action::AddLight => {
            seen.lamps.push(Lamp::around(&bounds, seen.lamps.len()));
            seen.selected = Some(seen.lamps.len() - 1);
        }
        Action::RemoveLight => _ = seen.lamps.remove(0),
        Action::SwitchLight => seen.lamps[0].is_on = false,
        Action::ChangeLightKind => seen.lamps[0].change_kind(&bounds),
        _ => return false,
    }
    true
}

/// The same for options of the picture.
fn draw(action: Action, options: &mut Options) -> bool {
    let overlays = &mut options.overlays;
    let switch = match action {
        Action::Silhouettes => &mut overlays.silhouettes,
        Action::LightSilhouettes => &mut overlays.light_silhouettes,
        Action::Volumes => &mut overlays.volumes,
        Action::Caps => &mut overlays.caps,
        Action::Boundary => &mut overlays.boundary,
        Action::NonManifold => &mut overlays.non_manifold,
        Action::Creases => &mut overlays.creases,
        Action::Exact => &mut overlays.exact,
        Action::Clusters => &mut overlays.clusters,
        Action::Receivers => &mut overlays.receivers,
        Action::Boxes => &mut overlays.boxes,
        Action::Ground => &mut options.ground,
        Action::Shadows => &mut options.shadows,
        Action::Smooth => &mut options.smooth,
        Action::Colors => &mut options.colors,
        Action::NextCounting => {
            options.counting = Counting::ZpPlus;
            return true;
        }
        Action::NextMode => {
            let at = Mode::ALL.iter().position(|(mode, _)| *mode == options.mode).unwrap_or(0);
            options.mode = Mode::ALL[(at + 1) % Mode::ALL.len()].0;
            return true;
        }
        _ => return false,
    };
    *switch = !*switch;
    true
}

/// Keys that move the selected light, and where to, of right, up and ahead as the eye sees it.
const MOVES: [(Action, Vec3); 6] = [
    (Action::LightLeft, Vec3::NEG_X),
    (Action::LightRight, Vec3::X),
    (Action::LightUp, Vec3::Y),
    (Action::LightDown, Vec3::NEG_Y),
    (Action::LightAhead, Vec3::Z),
    (Action::LightBack, Vec3::NEG_Z),
];

/// Presses the key of an action, and lets it go.
fn act(stage: &mut Stage, action: Action) -> Outcome {
    let binding = KEYS.iter().find(|binding| binding.action == action).ok_or_else(|| format!("{action:?}: no key"))?;
    let modifiers = if binding.shift { Modifiers::SHIFT } else { Modifiers::NONE };
    stage.run(vec![key(binding.key, modifiers), release(binding.key)]);
    Ok(())
}

fn each_key() -> Outcome {
    let mut stage = Stage::of_size(scenes::walking_figure, NARROW)?;
    stage.settle()?;
    let first = stage.viewer.orbit;
    // Not the camera that sees everything, which a picture of another size moves.
    stage.viewer.orbit.turn(1.0, 0.0);
    stage.viewer.clock.seconds = 0.25;
    let start = Seen::of(&stage.viewer);
    let others = |action: &Action| *action == Action::NextScene || MOVES.iter().any(|(of, _)| of == action);
    for action in KEYS.iter().map(|binding| binding.action).filter(|action| !others(action)) {
        start.clone().put_into(&mut stage.viewer);
        stage.run(Vec::new());
        let mut expected = start.clone();
        let viewer = &stage.viewer;
        let is_known = look(action, &mut expected, viewer, first)
            || play(action, &mut expected, viewer)
            || draw(action, &mut expected.options);
        hold(is_known, format!("{action:?} is not tested"))?;
        act(&mut stage, action)?;
        let after = Seen::of(&stage.viewer);
        hold(after == expected, format!("{action:?}: {after:?} instead of {expected:?}"))?;
    }
    // The list is closed before the window.
    start.clone().put_into(&mut stage.viewer);
    stage.viewer.shows_help = true;
    act(&mut stage, Action::Close)?;
    hold(Seen::of(&stage.viewer) == start, "Escape does more than to close the list")?;
    act(&mut stage, Action::NextScene)?;
    hold(stage.viewer.bodies.len() == 5, "the next scene is not the still life")
}

fn keys_move_a_light() -> Outcome {
    let mut stage = Stage::of_size(scenes::still_life, NARROW)?;
    stage.settle()?;
    let (orbit, bounds) = (stage.viewer.orbit, stage.viewer.bounds());
    let [right, _, forward] = orbit.axes();
    let ahead = forward.with_y(0.0).normalize();
    for (action, Vec3 { x, y, z }) in MOVES {
        let before = stage.viewer.lamps.clone();
        act(&mut stage, action)?;
        let after = &stage.viewer.lamps;
        let by = after[0].handle(&bounds) - before[0].handle(&bounds);
        let towards = x * right + y * Vec3::Y + z * ahead;
        let is_so = by.length() > 0.01 * bounds.extent() && by.normalize().distance(towards) < 1e-3;
        hold(is_so, format!("{action:?} moves by {by}, not towards {towards}"))?;
        hold(after[1..] == before[1..] && stage.viewer.orbit == orbit, format!("{action:?} moves more than a light"))?;
    }
    Ok(())
}

fn flying() -> Outcome {
    let mut stage = Stage::of_size(scenes::still_life, NARROW)?;
    stage.settle()?;
    let [right, up, forward] = stage.viewer.orbit.axes();
    for (held, towards) in
        [(Key::D, right), (Key::A, -right), (Key::E, up), (Key::Q, -up), (Key::W, forward), (Key::S, -forward)]
    {
        let before = stage.viewer.orbit;
        stage.run(vec![key(held, Modifiers::NONE)]);
        stage.run(Vec::new());
        stage.run(vec![release(held)]);
        let after = stage.viewer.orbit;
        let by = after.target - before.target;
        hold(by.length() > 0.0 && by.normalize().distance(towards) < 1e-3, format!("{held:?} flies by {by}"))?;
        hold(Orbit { target: before.target, ..after } == before, format!("{held:?} turns, too"))?;
        stage.run(Vec::new());
        hold(stage.viewer.orbit == after, format!("it flies on after {held:?} went up"))?;
    }
    Ok(())
}

fn press(stage: &mut Stage, pressed: Key) {
    stage.run(vec![key(pressed, Modifiers::NONE), release(pressed)]);
}

/// Presses Tab until a widget with this role, and with this label if one is given, has the keyboard.
fn tab_to(stage: &mut Stage, role: Role, label: Option<&str>) -> Outcome {
    for _ in 0..150 {
        let output = stage.run(vec![key(Key::Tab, Modifiers::NONE), release(Key::Tab)]);
        let is_it = output.platform.events.iter().any(|event| match event {
            OutputEvent::FocusGained(widget) => {
                widget.role == role && label.is_none_or(|label| widget.label.as_deref() == Some(label))
            }
            _ => false,
        });
        if is_it {
            // Widgets take arrow keys from the next frame on.
            stage.run(Vec::new());
            return Ok(());
        }
    }
    Err(format!("Tab reaches no {role:?} {label:?}"))
}

/// Types a number instead of the one that has the keyboard.
fn enter(stage: &mut Stage, text: &str) {
    stage.run(vec![Heard::Text(text.to_owned())]);
    stage.run(Vec::new());
}

/// Whether the widget that has the keyboard is within the window.
fn is_in_view(stage: &Stage) -> bool {
    let context = stage.panel.context();
    let widget = context.memory(egui::Memory::focused).and_then(|id| context.read_response(id));
    widget.is_some_and(|widget| widget.rect.top() >= 0.0 && widget.rect.bottom() <= SIZE[1] as f32)
}

/// Whether a light is other than before.
type IsChanged = fn(&Lamp) -> bool;

/// Boxes that give a light something more.
const GIVEN: [(&str, IsChanged); 3] = [
    ("range", |lamp| lamp.range.is_some()),
    ("radius", |lamp| lamp.radius.is_some()),
    ("spot", |lamp| lamp.cone.is_some()),
];

fn tab_reaches_everything() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    let (orbit, before) = (stage.viewer.orbit, stage.viewer.lamps[0].clone());
    tab_to(&mut stage, Role::ColorWell, None)?;
    press(&mut stage, Key::Space);
    // A menu finds its size before it listens.
    (0..3).for_each(|_| drop(stage.run(Vec::new())));
    tab_to(&mut stage, Role::SpinButton, None)?;
    enter(&mut stage, "10");
    hold(stage.viewer.lamps[0].color != before.color, "the colour stays")?;
    // Escape closes the colours and not the window.
    press(&mut stage, Key::Escape);
    stage.run(Vec::new());
    hold(stage.viewer.requests.is_empty(), "Escape closes the window behind the colours")?;

    tab_to(&mut stage, Role::Slider, None)?;
    press(&mut stage, Key::ArrowLeft);
    hold(stage.viewer.lamps[0].intensity < before.intensity, "the intensity stays")?;
    for (name, is_given) in GIVEN {
        tab_to(&mut stage, Role::CheckBox, Some(name))?;
        press(&mut stage, Key::Space);
        hold(is_given(&stage.viewer.lamps[0]), format!("{name} cannot be given"))?;
    }
    let cone = |stage: &Stage| stage.viewer.lamps[0].cone.ok_or("it is no spot");
    let (axis, angle) = cone(&stage)?;
    tab_to(&mut stage, Role::SpinButton, None)?;
    press(&mut stage, Key::ArrowUp);
    hold(cone(&stage)?.1 > angle, "the angle of the spot stays")?;
    tab_to(&mut stage, Role::SpinButton, None)?;
    enter(&mut stage, "0.5");
    hold(cone(&stage)?.0 != axis, "the aim of the spot stays")?;

    tab_to(&mut stage, Role::DisclosureTriangle, Some("Skipping"))?;
    press(&mut stage, Key::Space);
    tab_to(&mut stage, Role::CheckBox, Some("lists of what did not change"))?;
    stage.settle()?;
    hold(is_in_view(&stage), "the panel does not scroll to where the keyboard is")?;
    press(&mut stage, Key::Space);
    hold(!stage.viewer.options.skipping.lists, "the level of skipping stays")?;
    hold(stage.viewer.orbit == orbit, "a key for the panel turns the camera")?;
    tab_to(&mut stage, Role::Button, Some("×"))?;
    press(&mut stage, Key::Space);
    hold(stage.viewer.bodies.len() == 4, "the model stays")?;
    // The keyboard comes back to the picture.
    tab_to(&mut stage, Role::CheckBox, Some("spot"))?;
    press(&mut stage, Key::Escape);
    hold(stage.viewer.requests.is_empty(), "Escape closes the window, and not only leaves the panel")?;
    press(&mut stage, Key::ArrowLeft);
    hold(stage.viewer.orbit != orbit, "the camera does not turn after Escape")
}

fn ranges() -> Outcome {
    let mut stage = Stage::of_size(scenes::still_life, NARROW)?;
    let extent = stage.viewer.bounds().extent();
    stage.viewer.lamps[0].range = Some(0.1 * extent);
    stage.settle()?;
    tab_to(&mut stage, Role::CheckBox, Some("range"))?;
    tab_to(&mut stage, Role::SpinButton, None)?;
    for _ in 0..10 {
        press(&mut stage, Key::ArrowDown);
    }
    let range = stage.viewer.lamps[0].range.ok_or("the range is gone")?;
    hold((range - 0.05 * extent).abs() < 1e-3 * extent, format!("the range is {range} of {extent}"))
}
