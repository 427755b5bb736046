//! The pointer beside the drag of a light: wheels, trackpads and the other buttons move the camera.

use egui::{
    Event as Heard, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, Vec2, pos2, vec2,
};
use rimline_testkit::harness::Test;
use rimline_view::{Action, Event, Orbit, scenes};

use crate::panel::{SIZE, Stage};
use crate::support::{Outcome, handle, hold};

pub(crate) const TESTS: [Test; 3] = [
    ("wheels and trackpads come nearer and go farther, over the picture only", scrolling),
    ("a wheel with Shift moves sideways", scrolling_sideways),
    ("the right and the middle button move sideways, and so does Shift", panning),
];

/// A pixel of the picture where no handle is.
const FREE: Pos2 = pos2(60.0, 480.0);

fn wheel(unit: MouseWheelUnit, delta: Vec2, modifiers: Modifiers) -> Heard {
    let source = MouseWheelSource::Unknown;
    Heard::MouseWheel { unit, delta, phase: TouchPhase::Move, source, modifiers }
}

/// A stage with the pointer over a pixel.
fn stage(at: Pos2) -> Result<Stage, String> {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    stage.run(vec![Heard::PointerMoved(at)]);
    Ok(stage)
}

fn scrolling() -> Outcome {
    let mut stage = stage(FREE)?;
    let lines = |y: f32| wheel(MouseWheelUnit::Line, vec2(0.0, y), Modifiers::NONE);
    let points = |y: f32| wheel(MouseWheelUnit::Point, vec2(0.0, y), Modifiers::NONE);
    // Logarithms of how much nearer each comes. 40 points are a line.
    for (event, nearer) in [
        (lines(1.0), 0.12),
        (lines(-2.0), -0.24),
        (points(5.0), 0.015),
        (points(-60.0), -0.18),
        (Heard::Zoom(1.2), 1.2_f32.ln()),
        (Heard::Zoom(0.8), 0.8_f32.ln()),
    ] {
        let (before, what) = (stage.viewer.orbit, format!("{event:?}"));
        stage.run(vec![event]);
        stage.settle()?;
        let after = stage.viewer.orbit;
        let found = (before.distance / after.distance).ln();
        hold((found - nearer).abs() < 1e-3, format!("{what}: nearer by {found} instead of {nearer}"))?;
        hold(Orbit { distance: before.distance, ..after } == before, format!("{what} does more"))?;
    }
    // The panel scrolls by itself.
    let orbit = stage.viewer.orbit;
    stage.run(vec![Heard::PointerMoved(pos2(SIZE[0] as f32 - 60.0, 300.0)), lines(-3.0)]);
    stage.settle()?;
    hold(stage.viewer.orbit == orbit, "scrolling the panel moves the camera")
}

/// How far the target moved on the picture, in pixels, if nothing else changed.
fn moved(stage: &Stage, before: Orbit) -> Result<glam::Vec2, String> {
    let after = stage.viewer.orbit;
    hold(Orbit { target: before.target, ..after } == before, "the camera turns or comes nearer")?;
    let camera = stage.viewer.camera();
    let at = |point| camera.project(point).ok_or("the target is behind the eye");
    Ok(at(before.target)? - at(after.target)?)
}

fn scrolling_sideways() -> Outcome {
    let mut stage = stage(FREE)?;
    let before = stage.viewer.orbit;
    let down = Heard::ModifiersChanged(Modifiers::SHIFT);
    stage.run(vec![down, wheel(MouseWheelUnit::Line, vec2(0.0, 1.0), Modifiers::SHIFT)]);
    stage.settle()?;
    let by = moved(&stage, before)?;
    hold(by.distance(glam::Vec2::new(40.0, 0.0)) < 0.5, format!("the picture moves by {by}"))
}

fn panning() -> Outcome {
    let shift = Modifiers::SHIFT;
    let mut stage = stage(FREE)?;
    for (button, modifiers, is_on_handle) in [
        (PointerButton::Secondary, Modifiers::NONE, false),
        (PointerButton::Middle, Modifiers::NONE, false),
        (PointerButton::Primary, shift, false),
        // Only the left button takes hold of a light.
        (PointerButton::Secondary, Modifiers::NONE, true),
    ] {
        stage.viewer.handle(Event::Acted(Action::ResetCamera));
        let (before, lamps, at) = (stage.viewer.orbit, stage.viewer.lamps.clone(), handle(&stage.viewer, 1)?);
        let from = if is_on_handle { pos2(at.x, at.y) } else { FREE };
        let to = from + vec2(30.0, -20.0);
        let press = |pos, pressed| Heard::PointerButton { pos, button, pressed, modifiers };
        for event in [Heard::PointerMoved(from), press(from, true), Heard::PointerMoved(to), press(to, false)] {
            stage.run(vec![event]);
        }
        let by = moved(&stage, before)?;
        hold(by.distance(glam::Vec2::new(30.0, -20.0)) < 0.5, format!("{button:?}: the picture moves by {by}"))?;
        hold(stage.viewer.lamps == lamps && !stage.viewer.is_dragging(), format!("{button:?} moves a light"))?;
        let orbit = stage.viewer.orbit;
        stage.run(vec![Heard::PointerMoved(FREE)]);
        hold(stage.viewer.orbit == orbit, format!("{button:?} goes on after it went up"))?;
    }
    Ok(())
}
