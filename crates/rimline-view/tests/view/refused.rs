//! Overlays, devices and viewers that a renderer cannot go on with.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;
use rimline_testkit::harness::Test;
use rimline_view::{
    Action, Body, BodyError, Event, Gpu, LampKind, Overlays, Panel, Renderer, Source, Tone, Viewer, scenes,
};

use crate::support::{Outcome, block, finish, gpu, hold, picture, rest, say, viewer, window};

pub(crate) const TESTS: [Test; 7] = [
    ("models that cannot be drawn are removed, and each is named", refused_models),
    ("a light that is nowhere is told once, and the viewer goes on", light_that_is_nowhere),
    ("overlays that are refused are switched off, and the model and the picture stay", refused_overlays),
    ("an error of the device that nobody expects is told, and no panic", unexpected),
    ("a device that is lost changes nothing of the viewer", lost_device),
    ("a renderer takes viewers in turn", viewers_in_turn),
    ("models that a caller adds or takes out are noticed", models_of_a_caller),
];

/// A block whose next pose fails on request.
struct Failing(rimline::Model, Arc<AtomicBool>);

impl Source for Failing {
    fn model(&self) -> &rimline::Model {
        &self.0
    }

    fn pose(&self, _: Option<usize>, _: f32) -> Result<rimline::Pose, BodyError> {
        if self.1.swap(false, Ordering::Relaxed) { Err(BodyError::NoFaces) } else { rest() }
    }
}

fn refused_overlays() -> Outcome {
    let fails = Arc::new(AtomicBool::new(false));
    let body = Body::new("block", None, Failing(block()?, Arc::clone(&fails))).map_err(say)?;
    let (mut viewer, mut renderer) = (Viewer::new(vec![body]), Renderer::new(gpu()?).map_err(say)?);
    viewer.handle(Event::Resized([120, 80]));
    viewer.handle(Event::Acted(Action::Boxes));
    let before = picture(&viewer, &mut renderer)?;
    viewer.handle(Event::Acted(Action::Silhouettes));
    fails.store(true, Ordering::Relaxed);
    hold(!renderer.show(&mut viewer), "the same picture was drawn again")?;
    let only_boxes = Overlays { boxes: true, ..Overlays::default() };
    hold(viewer.bodies.len() == 1 && viewer.options.overlays == only_boxes, format!("{viewer:?}"))?;
    let said = viewer.message.as_ref().map(|message| message.text.clone()).unwrap_or_default();
    hold(said.starts_with("overlays of block: "), said)?;
    hold(picture(&viewer, &mut renderer)? == before, "the picture is another one")?;
    viewer.handle(Event::Acted(Action::Silhouettes));
    viewer.handle(Event::Resized([60, 40]));
    fails.store(true, Ordering::Relaxed);
    hold(renderer.draw(&viewer).is_err(), "overlays are drawn without a pose")?;
    let last = renderer.read().ok_or("the last picture is gone")?;
    hold(finish(&renderer, last)? == before, "a picture that fails takes the place of the last one")
}

fn refused_models() -> Outcome {
    let flags = [0; 3].map(|_| Arc::new(AtomicBool::new(false)));
    let body = |name, fails: &Arc<AtomicBool>| Body::new(name, None, Failing(block()?, Arc::clone(fails))).map_err(say);
    let bodies = vec![body("first", &flags[0])?, body("second", &flags[1])?, body("third", &flags[2])?];
    let (mut viewer, mut renderer) = (Viewer::new(bodies), Renderer::new(gpu()?).map_err(say)?);
    viewer.handle(Event::Resized([120, 80]));
    viewer.handle(Event::Opened(Err(("bad.glb".into(), "it is no glTF".into()))));
    flags.iter().step_by(2).for_each(|fails| fails.store(true, Ordering::Relaxed));
    hold(renderer.show(&mut viewer), "nothing is drawn")?;
    let names: Vec<_> = viewer.bodies.iter().map(|body| body.name.as_str()).collect();
    hold(names == ["second"], format!("{names:?} are left"))?;
    let said = viewer.message.as_ref().map(|message| message.text.clone()).unwrap_or_default();
    let named: Vec<_> = said.lines().filter_map(|line| Some(line.split_once(':')?.0)).collect();
    hold(named == ["bad.glb", "first", "third"], said.clone())
}

fn light_that_is_nowhere() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::moebius, [120, 80])?;
    let before = picture(&viewer, &mut renderer)?;
    let was = std::mem::replace(&mut viewer.lamps[0].kind, LampKind::Point(Vec3::NAN));
    for _ in 0..2 {
        hold(!renderer.show(&mut viewer), "a light that is nowhere was drawn")?;
        let message = viewer.message.as_ref().ok_or("nothing is told")?;
        hold(message.tone == Tone::Error && message.text.lines().count() == 1, message.text.clone())?;
    }
    viewer.lamps[0].kind = was;
    hold(renderer.show(&mut viewer), "it is not drawn again")?;
    hold(picture(&viewer, &mut renderer)? == before, "the picture is another one")
}

/// A device of the test's own.
fn opened() -> Result<Gpu, String> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
    let options = wgpu::RequestAdapterOptions::default();
    let adapter = pollster::block_on(instance.request_adapter(&options)).map_err(say)?;
    pollster::block_on(Gpu::open(&adapter)).map_err(say)
}

fn unexpected() -> Outcome {
    let gpu = opened()?;
    gpu.check().map_err(say)?;
    let (usage, mapped_at_creation) = (wgpu::BufferUsages::empty(), false);
    for label in ["useless", "second"] {
        let label = Some(label);
        let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size: 4, usage, mapped_at_creation });
    }
    let said = gpu.check().err().map(|error| error.to_string()).unwrap_or_default();
    let is_first = said.contains(&gpu.name) && said.contains("useless") && !said.contains("second");
    hold(is_first && said.lines().count() == 1, said)?;
    // The window takes another device then.
    gpu.device.destroy();
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(say)?;
    hold(gpu.is_lost() && gpu.check().is_ok(), "a lost device refuses something")
}

fn lost_device() -> Outcome {
    [false, true].into_iter().try_for_each(lost_before_a_frame)
}

/// Loses a device before or after the first picture.
fn lost_before_a_frame(has_picture: bool) -> Outcome {
    let (gpu, size) = (opened()?, [120, 80]);
    let target = window(&gpu, size);
    let mut panel = Panel::new(&gpu, target.texture().format());
    let mut renderer = Renderer::new(gpu.clone()).map_err(say)?;
    let mut viewer = Viewer::new(scenes::moebius().map_err(say)?);
    viewer.handle(Event::Resized(size));
    if has_picture {
        hold(renderer.show(&mut viewer), format!("{:?}", viewer.message))?;
    }
    gpu.device.destroy();
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(say)?;
    hold(gpu.is_lost(), "the device is not lost")?;
    let screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size.map(|side| side as f32).into()));
    for action in [Action::TurnLeft, Action::Silhouettes] {
        viewer.handle(Event::Acted(action));
        let overlays = viewer.options.overlays;
        let output = panel.run(egui::RawInput { screen_rect, ..Default::default() }, &mut viewer, &mut renderer);
        panel.paint(&gpu, &target, size, &output);
        hold(renderer.pictures() == u64::from(has_picture), "a lost device drew a picture")?;
        let is_same = viewer.bodies.len() == 1 && viewer.options.overlays == overlays && viewer.message.is_none();
        hold(is_same, format!("{viewer:?}"))?;
    }
    Ok(())
}

fn viewers_in_turn() -> Outcome {
    let (viewer_a, mut renderer) = viewer(scenes::moebius, [120, 80])?;
    picture(&viewer_a, &mut renderer)?;
    let (viewer_b, mut other) = viewer(scenes::still_life, [120, 80])?;
    let expected = picture(&viewer_b, &mut other)?;
    hold(picture(&viewer_b, &mut renderer)? == expected, "models of one viewer are shown for another")
}

fn models_of_a_caller() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::moebius, [120, 80])?;
    // Volumes of a renderer's first frame end elsewhere than later ones, so a pixel at a border may differ.
    viewer.options.shadows = false;
    viewer.handle(Event::Acted(Action::Silhouettes));
    let before = picture(&viewer, &mut renderer)?;
    viewer.bodies.extend(scenes::still_life().map_err(say)?);
    let more = picture(&viewer, &mut renderer)?;
    let mut other = Renderer::new(gpu()?).map_err(say)?;
    hold(more != before && more == picture(&viewer, &mut other)?, "models that were added are not drawn")?;
    viewer.bodies.truncate(1);
    hold(picture(&viewer, &mut renderer)? == before, "models that were taken out are still drawn")
}
