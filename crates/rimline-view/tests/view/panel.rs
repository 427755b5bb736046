//! The panel by egui's own events, without a window.

use std::time::Duration;

use egui::{Event as Heard, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2, vec2};
use glam::Vec3;
use rimline_testkit::device::Gpu as Device;
use rimline_testkit::harness::Test;
use rimline_testkit::textures::texels;
use rimline_view::{
    Action, Event, Handle, LampKind, Message, Panel, PanelOutput, Renderer, Request, Tone, Viewer, scenes,
};

use crate::support::{Outcome, handle, hold, say, viewer, window};

pub(crate) const TESTS: [Test; 13] = [
    ("a still panel asks for no repaint", a_still_panel_asks_for_no_repaint),
    ("the pointer drags a light on the picture", the_pointer_drags_a_light),
    ("what the pointer does within one frame has its order", a_frame_of_many_events),
    ("the wheel with Shift moves what is seen as far as it scrolls, at every scale", scrolled_sideways),
    ("a bad file gives a message and the viewer goes on", a_bad_file),
    ("an error is seen without the panel, too", error_without_the_panel),
    ("a key that is held acts once, or step by step", held_keys),
    ("Escape closes a menu and not the window", escape_in_a_menu),
    ("a light that is removed is let go, and none may be left", no_lights),
    ("the picture shows everything in every shape until the user moves the camera", other_shapes),
    ("a window of a pixel has a picture of a pixel", tiny),
    ("boxes are drawn around models, over the picture", boxes),
    ("a picture drawn in a hurry is drawn again when nothing moves", refined),
];

pub(crate) const SIZE: [u32; 2] = [900, 560];

/// A viewer with a panel, and a target that stands for the window.
pub(crate) struct Stage {
    size: [u32; 2],
    pub(crate) viewer: Viewer,
    renderer: Renderer,
    pub(crate) panel: Panel,
    target: wgpu::TextureView,
    time: f64,
    /// Pixels of a point.
    scale: f32,
}

impl Stage {
    pub(crate) fn new(scene: scenes::Make) -> Result<Self, String> {
        Self::of_size(scene, SIZE)
    }

    /// With a window of this size. One sample a pixel is drawn faster than four, once nothing moves.
    pub(crate) fn of_size(scene: scenes::Make, size: [u32; 2]) -> Result<Self, String> {
        let (mut viewer, renderer) = viewer(scene, size)?;
        viewer.options.samples = 1;
        let target = window(renderer.gpu(), size);
        let panel = Panel::new(renderer.gpu(), target.texture().format());
        // A letter is drawn once, and not for each fourth of a pixel that it may begin at.
        panel.context().all_styles_mut(|style| style.visuals.text_options.subpixel_binning = false);
        Ok(Self { size, viewer, renderer, panel, target, time: 0.0, scale: 1.0 })
    }

    /// Runs the panel, and paints nothing.
    pub(crate) fn run(&mut self, events: Vec<Heard>) -> PanelOutput {
        self.time += 0.05;
        let size = self.size.map(|side| side as f32 / self.scale);
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size.into())),
            time: Some(self.time),
            focused: true,
            events,
            ..RawInput::default()
        };
        input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = Some(self.scale);
        self.panel.run(input, &mut self.viewer, &mut self.renderer)
    }

    /// Pixels of the window's part with the picture.
    fn pixels(&self) -> Result<Vec<u8>, String> {
        let all = texels(&*Device::shared()?, self.target.texture(), 0)?;
        let [width, height] = self.viewer.size().map(|side| side as usize);
        let rows = all.chunks_exact(4 * self.size[0] as usize).take(height);
        Ok(rows.flat_map(|row| &row[..4 * width]).copied().collect())
    }

    /// Runs until nothing is on its way, paints that, and returns what the last run asked for.
    pub(crate) fn settle(&mut self) -> Result<Duration, String> {
        for _ in 0..40 {
            let output = self.run(Vec::new());
            self.renderer.gpu().device.poll(wgpu::PollType::wait_indefinitely()).map_err(say)?;
            if output.repaint_after > Duration::from_secs(1) {
                self.panel.paint(self.renderer.gpu(), &self.target, self.size, &output);
                return Ok(output.repaint_after);
            }
        }
        Err("it does not come to rest".into())
    }
}

pub(crate) fn button(at: Pos2, pressed: bool) -> Heard {
    Heard::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

pub(crate) fn key(key: Key, modifiers: Modifiers) -> Heard {
    Heard::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
}

pub(crate) fn release(key: Key) -> Heard {
    Heard::Key { key, physical_key: None, pressed: false, repeat: false, modifiers: Modifiers::NONE }
}

fn scrolled_sideways() -> Outcome {
    for scale in [1.0, 2.0] {
        let mut stage = Stage::new(scenes::still_life)?;
        stage.scale = scale;
        stage.settle()?;
        stage.run(vec![Heard::PointerMoved(pos2(30.0, 100.0))]);
        let before = stage.viewer.orbit;
        // So few points are not spread over frames.
        let wheel = Heard::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: vec2(5.0, 0.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers: Modifiers::SHIFT,
        };
        stage.run(vec![Heard::ModifiersChanged(Modifiers::SHIFT), wheel]);
        let after = stage.viewer.orbit;
        let pixels = (after.target - before.target).length() / (stage.viewer.camera().pixel() * before.distance);
        hold((pixels - 5.0 * scale).abs() < 0.05, format!("5 points at scale {scale} moved it by {pixels} pixels"))?;
        hold(after.distance == before.distance, "it came nearer, too")?;
    }
    Ok(())
}

fn a_still_panel_asks_for_no_repaint() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    // Later pictures have other numbers.
    for _ in 0..2 {
        stage.run(Vec::new());
        stage.renderer.gpu().device.poll(wgpu::PollType::wait_indefinitely()).map_err(say)?;
    }
    let counters = stage.renderer.counters();
    hold(counters.scene.is_some_and(|scene| scene.faces > 0), "no counters arrived")?;
    let (made, all) = (counters.bytes, counters.device_bytes);
    hold(made > 0 && all.is_none_or(|all| all > made), format!("{made} bytes of {all:?} on the device"))?;
    stage.settle()?;
    let pictures = stage.renderer.pictures();
    stage.settle()?;
    hold(stage.renderer.pictures() == pictures, "a picture was drawn")?;
    // Nothing that is shown changes by that.
    let lamps = &mut stage.viewer.lamps;
    for (lamp, color) in lamps.iter_mut().zip([[1.0, 0.93, 0.8], [0.42, 0.62, 1.0], [1.0, 0.5, 0.28]]) {
        lamp.color = color;
    }
    (lamps[0].kind, lamps[0].radius) = (LampKind::Sun(Vec3::new(0.36, 0.48, 0.8)), Some(0.05));
    (lamps[1].range, lamps[1].cone) = (Some(3.3), Some((Vec3::NEG_Y, 0.7)));
    let before = (stage.viewer.lamps.clone(), stage.viewer.orbit);
    for number in 0..before.0.len() {
        stage.viewer.selected = Some(number);
        stage.settle()?;
        let after = (stage.viewer.lamps.clone(), stage.viewer.orbit);
        hold(after == before, format!("light {number} was shown: {before:?} became {after:?}"))?;
    }
    Ok(())
}

fn the_pointer_drags_a_light() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    let at = handle(&stage.viewer, 1)?;
    let (from, to) = (pos2(at.x, at.y), pos2(at.x - 60.0, at.y + 25.0));
    let (orbit, before) = (stage.viewer.orbit, stage.viewer.lamps[1].clone());
    stage.run(vec![Heard::PointerMoved(from)]);
    hold(stage.viewer.hovered == Some(Handle::Lamp(1)), "the pointer is on the handle")?;
    stage.run(vec![button(from, true)]);
    stage.run(vec![Heard::PointerMoved(to)]);
    stage.run(vec![button(to, false)]);
    let there = handle(&stage.viewer, 1)?;
    hold((there.x - to.x).hypot(there.y - to.y) < 1.0, format!("the handle is at {there}, not {to}"))?;
    hold(stage.viewer.lamps[1] != before && stage.viewer.orbit == orbit, "only the light moves")?;
    hold(stage.viewer.selected == Some(1) && !stage.viewer.is_dragging(), "it is selected and let go")?;
    // Elsewhere the camera turns.
    let [from, to] = [pos2(30.0, 500.0), pos2(90.0, 480.0)];
    for events in [vec![Heard::PointerMoved(from)], vec![button(from, true)], vec![Heard::PointerMoved(to)]] {
        stage.run(events);
    }
    hold(stage.viewer.orbit != orbit && stage.viewer.is_dragging(), "the camera does not turn")?;
    // A page whose tab is left hears of no release.
    stage.run(vec![Heard::WindowFocused(false)]);
    hold(!stage.viewer.is_dragging(), "it drags on without the keyboard")
}

fn a_frame_of_many_events() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    let (at, orbit) = (handle(&stage.viewer, 1)?, stage.viewer.orbit);
    let (from, to, past) = (pos2(at.x, at.y), pos2(at.x - 60.0, at.y + 25.0), pos2(at.x - 200.0, at.y + 90.0));
    let is_at = |viewer: &Viewer, to: Pos2| {
        let there = handle(viewer, 1)?;
        hold((there.x - to.x).hypot(there.y - to.y) < 1.0, format!("the handle is at {there}, not {to}"))
    };
    // The move after the release is not the light's.
    stage.run(vec![Heard::PointerMoved(from), button(from, true)]);
    stage.run(vec![Heard::PointerMoved(to), button(to, false), Heard::PointerMoved(past)]);
    is_at(&stage.viewer, to)?;
    hold(!stage.viewer.is_dragging(), "it is not let go")?;
    // All of a drag, and the press of the next.
    let moved = |to| Heard::PointerMoved(to);
    stage.run(vec![moved(to), button(to, true), moved(from), button(from, false), moved(past)]);
    is_at(&stage.viewer, from)?;
    stage.run(vec![moved(from), button(from, true)]);
    stage.run(vec![moved(to), button(to, false), moved(past), button(past, true)]);
    is_at(&stage.viewer, to)?;
    hold(stage.viewer.orbit == orbit && stage.viewer.is_dragging(), "the camera turned before the second drag moved")?;
    // A press on the panel is not one on the picture behind.
    stage.run(vec![button(past, false)]);
    let on_panel = pos2(SIZE[0] as f32 - 20.0, 300.0);
    stage.run(vec![moved(on_panel), button(on_panel, true), moved(past), button(past, false)]);
    hold(stage.viewer.orbit == orbit && !stage.viewer.is_dragging(), "the panel turns the camera")
}

fn a_bad_file() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    let pictures = stage.renderer.pictures();
    stage.viewer.handle(Event::Opened(Err(("bad.glb".into(), "it is no glTF".into()))));
    stage.settle()?;
    hold(stage.viewer.message == Some(Message::new(Tone::Error, "bad.glb: it is no glTF")), "no message")?;
    hold(stage.viewer.bodies.len() == 5 && stage.renderer.pictures() == pictures, "the scene changed")?;
    stage.run(vec![key(Key::ArrowLeft, Modifiers::NONE)]);
    hold(stage.renderer.pictures() == pictures + 1, "the viewer does not go on")
}

fn error_without_the_panel() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.viewer.shows_panel = false;
    stage.settle()?;
    let before = stage.pixels()?;
    stage.viewer.handle(Event::Opened(Err(("bad.glb".into(), "it is no glTF".into()))));
    stage.settle()?;
    let after = stage.pixels()?;
    let changed = after.chunks(4).zip(before.chunks(4)).filter(|(now, before)| now != before).count();
    hold((500..120_000).contains(&changed), format!("{changed} pixels are of the error"))?;
    for message in [None, Some(Message::new(Tone::Note, "wrote a picture"))] {
        stage.viewer.message = message;
        stage.settle()?;
        hold(stage.pixels()? == before, format!("{:?} is over the picture", stage.viewer.message))?;
    }
    Ok(())
}

fn held_keys() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    // A window repeats the press of a key that is held.
    let hold_down = |stage: &mut Stage, of: Key| {
        for _ in 0..3 {
            stage.run(vec![key(of, Modifiers::NONE)]);
        }
        stage.run(vec![release(of)]);
    };
    let azimuth = stage.viewer.orbit.azimuth;
    hold_down(&mut stage, Key::ArrowRight);
    let turned = (stage.viewer.orbit.azimuth - azimuth).rem_euclid(360.0);
    hold((turned - 18.0).abs() < 1e-3, format!("three steps turn by {turned}°"))?;
    hold_down(&mut stage, Key::P);
    hold(stage.viewer.requests == [Request::Screenshot { scale: 1 }], format!("{:?}", stage.viewer.requests))?;
    hold_down(&mut stage, Key::G);
    hold(!stage.viewer.options.ground, "the ground is switched once")?;
    hold_down(&mut stage, Key::G);
    hold(stage.viewer.options.ground, "the ground is switched again after the key went up")?;
    // Another key that is tapped meanwhile leaves it held, and so does Shift.
    let tapped = [key(Key::F, Modifiers::NONE), release(Key::F)];
    stage.run([key(Key::G, Modifiers::NONE)].into_iter().chain(tapped).collect());
    stage.run(vec![key(Key::G, Modifiers::NONE), key(Key::P, Modifiers::NONE), key(Key::P, Modifiers::SHIFT)]);
    stage.run(vec![release(Key::G), release(Key::P)]);
    hold(!stage.viewer.options.ground && !stage.viewer.options.smooth, "a held key repeats after another was tapped")?;
    hold(stage.viewer.requests.len() == 2, format!("a key acts anew as Shift joins it: {:?}", stage.viewer.requests))?;
    // A key that Shift gives a name may go up without it.
    for is_shown in [true, false] {
        stage.run(vec![key(Key::Questionmark, Modifiers::SHIFT), release(Key::Slash)]);
        hold(stage.viewer.shows_help == is_shown, "? opens the list of keys and closes it")?;
    }
    // Where a window knows the key itself, one that went down elsewhere lets go of no other.
    let of = |key, at, pressed| {
        let (physical_key, modifiers) = (Some(at), Modifiers::NONE);
        Heard::Key { key, physical_key, pressed, repeat: false, modifiers }
    };
    let (down, up) = (of(Key::Questionmark, Key::Slash, true), of(Key::Slash, Key::Slash, false));
    for is_shown in [true, false] {
        stage.run(vec![down.clone(), of(Key::X, Key::X, false), down.clone(), up.clone()]);
        hold(stage.viewer.shows_help == is_shown, "? opens the list of keys and closes it by its key")?;
    }
    // It closes the list of keys, and does not go on to close the window.
    stage.viewer.handle(Event::Acted(Action::Help));
    stage.viewer.requests.clear();
    hold_down(&mut stage, Key::Escape);
    hold(!stage.viewer.shows_help && stage.viewer.requests.is_empty(), "Escape does more than to close the list")?;
    // On a Mac these are the system's.
    stage.run(vec![key(Key::H, Modifiers { mac_cmd: true, command: true, ..Modifiers::NONE })]);
    hold(stage.viewer.options.shadows, "Command with H hides shadows")
}

fn escape_in_a_menu() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    let context = stage.panel.context().clone();
    egui::Popup::open_id(&context, egui::Id::unique("menu"));
    stage.run(vec![key(Key::Escape, Modifiers::NONE)]);
    hold(stage.viewer.requests.is_empty(), "Escape closes the window behind the menu")?;
    egui::Popup::close_all(&context);
    stage.run(vec![release(Key::Escape)]);
    stage.run(vec![key(Key::Escape, Modifiers::NONE)]);
    hold(stage.viewer.requests == [Request::Close], "Escape closes nothing")
}

fn no_lights() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    let at = handle(&stage.viewer, 0)?;
    let from = pos2(at.x, at.y);
    stage.run(vec![Heard::PointerMoved(from), button(from, true)]);
    let others = stage.viewer.lamps[1..].to_vec();
    stage.run(vec![key(Key::Delete, Modifiers::NONE), release(Key::Delete)]);
    stage.run(vec![Heard::PointerMoved(from + vec2(40.0, 30.0))]);
    hold(stage.viewer.lamps == others, "another light is dragged after the first is gone")?;
    stage.run(vec![button(from + vec2(40.0, 30.0), false)]);
    // The number that is selected may be of no light.
    stage.viewer.lamps.clear();
    stage.run(Vec::new());
    stage.viewer.selected = None;
    stage.settle().map(|_| ())
}

fn other_shapes() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    let is_all_seen = |viewer: &Viewer| {
        let (camera, bounds) = (viewer.camera(), viewer.bounds());
        let pixels = bounds.corners().map(|corner| camera.project(corner));
        let is_seen = |pixel: glam::Vec2| pixel.cmpge(glam::Vec2::ZERO).all() && pixel.cmple(camera.size).all();
        pixels.iter().all(|pixel| pixel.is_some_and(is_seen))
    };
    for size in [[2000, 300], [130, 900], [900, 560]] {
        stage.viewer.handle(Event::Resized(size));
        hold(is_all_seen(&stage.viewer), format!("{size:?} does not show everything"))?;
    }
    stage.viewer.handle(Event::Acted(Action::TurnLeft));
    let orbit = stage.viewer.orbit;
    stage.viewer.handle(Event::Resized([130, 900]));
    hold(stage.viewer.orbit == orbit, "another shape moves a camera that the user turned")?;
    // The panel takes a part of the window, and the picture is of what is left.
    stage.viewer.handle(Event::Acted(Action::ResetCamera));
    stage.settle()?;
    hold(stage.viewer.size() != SIZE && is_all_seen(&stage.viewer), "the panel covers a part of what is to be seen")?;
    moving(&mut stage)
}

/// The panel and the time line take all of a window that is too small for them.
fn tiny() -> Outcome {
    for size in [[1, 1], [1, 400], [400, 1]] {
        let mut stage = Stage::of_size(scenes::walking_figure, size)?;
        stage.settle()?;
        let of = stage.viewer.size();
        hold(of.into_iter().zip(size).all(|(side, most)| (1..=most).contains(&side)), format!("{of:?} of {size:?}"))?;
        hold(stage.viewer.message.is_none() && stage.viewer.orbit.distance.is_finite(), format!("{size:?}"))?;
    }
    Ok(())
}

/// While it moves, a large picture has half the rows and columns, and fills the same part of the window.
fn moving(stage: &mut Stage) -> Outcome {
    stage.viewer.handle(Event::Acted(Action::TurnLeft));
    let output = stage.run(Vec::new());
    stage.panel.paint(stage.renderer.gpu(), &stage.target, stage.size, &output);
    hold(stage.renderer.step() == 2, "it has all rows and columns")?;
    let coarse = stage.pixels()?;
    stage.settle()?;
    let full = stage.pixels()?;
    hold(stage.renderer.step() == 1 && coarse.len() == full.len(), "it stays coarse")?;
    let is_other = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 40);
    let differing = full.chunks(4).zip(coarse.chunks(4)).filter(is_other).count();
    let turned = full.chunks(4).zip(coarse.chunks(4).rev()).filter(is_other).count();
    println!("{differing} pixels differ, {turned} turned");
    hold(80 * differing < full.len(), format!("{differing} pixels differ"))?;
    hold(80 * turned > full.len(), format!("negative control: {turned} pixels differ"))
}

fn refined() -> Outcome {
    let mut stage = Stage::of_size(scenes::walking_figure, [500, 300])?;
    (stage.viewer.options.samples, stage.viewer.clock.is_running) = (4, true);
    (0..12).for_each(|_| drop(stage.run(Vec::new())));
    hold(stage.renderer.is_coarse(&stage.viewer), "a software device draws with all samples while something moves")?;
    stage.run(vec![key(Key::Space, Modifiers::NONE), release(Key::Space)]);
    stage.settle()?;
    let pictures = stage.renderer.pictures();
    hold(!stage.renderer.is_coarse(&stage.viewer), "the last picture stays coarse")?;
    stage.settle()?;
    hold(stage.renderer.pictures() == pictures, "it is drawn once more again and again")
}

fn boxes() -> Outcome {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    let before = stage.pixels()?;
    let pictures = stage.renderer.pictures();
    stage.run(vec![key(Key::Num9, Modifiers::NONE), release(Key::Num9)]);
    stage.settle()?;
    let with_boxes = stage.pixels()?;
    let changed = with_boxes.chunks(4).zip(before.chunks(4)).filter(|(now, before)| now != before).count();
    // Twelve edges around each of five models.
    hold((500..50_000).contains(&changed), format!("{changed} pixels are of boxes"))?;
    hold(stage.renderer.pictures() == pictures, "the picture behind was drawn again")?;
    stage.run(vec![key(Key::Num9, Modifiers::NONE), release(Key::Num9)]);
    stage.settle()?;
    hold(stage.pixels()? == before, "boxes are left")
}
