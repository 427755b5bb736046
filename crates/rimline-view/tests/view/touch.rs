//! Fingers on a screen, by the events that the window and the page both make of them: the first finger is a pointer, too.

use egui::{Event as Heard, Pos2, TouchPhase, Vec2, pos2, vec2};
use rimline_testkit::harness::Test;
use rimline_view::{Orbit, scenes};

use crate::panel::{Stage, button};
use crate::support::{Outcome, handle, hold};

pub(crate) const TESTS: [Test; 5] = [
    ("one finger turns the camera and drags a light", one_finger),
    ("two fingers pinch and move sideways, and turn nothing", two_fingers),
    ("two fingers that come at once turn nothing", two_at_once),
    ("a finger that the system takes away lets go", cancelled),
    ("a button shows and hides the panel where there is no keyboard", panel_button),
];

fn touch(id: u64, phase: TouchPhase, pos: Pos2) -> Heard {
    Heard::Touch { device_id: egui::TouchDeviceId(0), id: egui::TouchId(id), phase, pos, force: None }
}

fn down(at: Pos2) -> Vec<Heard> {
    vec![touch(0, TouchPhase::Start, at), Heard::PointerMoved(at), button(at, true)]
}

fn moved(to: Pos2) -> Vec<Heard> {
    vec![touch(0, TouchPhase::Move, to), Heard::PointerMoved(to)]
}

fn up(at: Pos2) -> Vec<Heard> {
    vec![touch(0, TouchPhase::End, at), button(at, false), Heard::PointerGone]
}

fn stage() -> Result<Stage, String> {
    let mut stage = Stage::new(scenes::still_life)?;
    stage.settle()?;
    Ok(stage)
}

/// Turns by a finger, from a pixel where no handle is.
fn is_turned(stage: &mut Stage, at: Pos2) -> bool {
    let before = stage.viewer.orbit;
    for events in [down(at), moved(at + vec2(20.0, 0.0)), up(at + vec2(20.0, 0.0))] {
        stage.run(events);
    }
    let after = stage.viewer.orbit;
    after.azimuth != before.azimuth && Orbit { azimuth: before.azimuth, ..after } == before
}

fn one_finger() -> Outcome {
    let mut stage = stage()?;
    hold(is_turned(&mut stage, pos2(60.0, 480.0)), "a finger does not turn the camera, or does more")?;
    let (at, orbit) = (handle(&stage.viewer, 1)?, stage.viewer.orbit);
    let (from, to) = (pos2(at.x, at.y), pos2(at.x - 50.0, at.y + 30.0));
    for events in [down(from), moved(to), up(to)] {
        stage.run(events);
    }
    let there = handle(&stage.viewer, 1)?;
    hold((there.x - to.x).hypot(there.y - to.y) < 1.0, format!("the handle is at {there}, not {to}"))?;
    hold(stage.viewer.orbit == orbit && !stage.viewer.is_dragging(), "the camera moves with the light")?;
    hold(stage.viewer.hovered.is_none(), "a finger that is gone is still on the handle")
}

/// Moves two fingers that are down.
fn both(stage: &mut Stage, a: Pos2, b: Pos2) {
    let second = touch(1, TouchPhase::Move, b);
    stage.run(moved(a).into_iter().chain([second]).collect());
}

fn two_fingers() -> Outcome {
    let mut stage = stage()?;
    let [a, b] = [pos2(60.0, 480.0), pos2(140.0, 480.0)];
    stage.run(down(a));
    hold(stage.viewer.is_dragging(), "one finger drags nothing")?;
    stage.run(vec![touch(1, TouchPhase::Start, b)]);
    hold(!stage.viewer.is_dragging(), "the first finger goes on dragging beside a second")?;
    let before = stage.viewer.orbit;
    both(&mut stage, a - vec2(40.0, 0.0), b + vec2(40.0, 0.0));
    let nearer = stage.viewer.orbit;
    hold((nearer.distance / before.distance - 0.5).abs() < 1e-4, format!("{before:?} became {nearer:?}"))?;
    hold(Orbit { distance: before.distance, ..nearer } == before, "a pinch does more than to go nearer")?;
    let [right, down_by] = [30.0, 12.0];
    let by = Vec2::new(right, down_by);
    both(&mut stage, a - vec2(40.0, 0.0) + by, b + vec2(40.0, 0.0) + by);
    let aside = stage.viewer.orbit;
    hold((aside.distance / nearer.distance - 1.0).abs() < 1e-4, "moving sideways goes nearer")?;
    hold((aside.azimuth, aside.elevation) == (nearer.azimuth, nearer.elevation), "moving sideways turns the camera")?;
    let camera = stage.viewer.camera();
    let pixel = camera.project(nearer.target).ok_or("the target is behind the eye")? - 0.5 * camera.size;
    hold(pixel.distance(glam::Vec2::new(right, down_by)) < 0.5, format!("what was in the middle is {pixel} from it"))?;
    // The finger that stays moves nothing, until it comes again.
    stage.run(vec![touch(1, TouchPhase::End, b)]);
    let last = a + vec2(50.0, 20.0);
    stage.run(moved(last));
    stage.run(up(last));
    hold(stage.viewer.orbit == aside, "the finger that stays turns the camera")?;
    hold(is_turned(&mut stage, a), "a finger turns nothing after two")
}

fn two_at_once() -> Outcome {
    let mut stage = stage()?;
    let [a, b] = [pos2(60.0, 480.0), pos2(140.0, 480.0)];
    let orbit = stage.viewer.orbit;
    stage.run(down(a).into_iter().chain([touch(1, TouchPhase::Start, b)]).collect());
    both(&mut stage, a - vec2(20.0, 0.0), b + vec2(20.0, 0.0));
    both(&mut stage, a - vec2(40.0, 0.0), b + vec2(40.0, 0.0));
    let after = stage.viewer.orbit;
    hold(
        after.distance < orbit.distance && Orbit { distance: orbit.distance, ..after } == orbit,
        format!("{after:?}"),
    )?;
    // At one point they have no distance.
    both(&mut stage, a, a);
    both(&mut stage, a, a);
    both(&mut stage, a, b);
    hold(stage.viewer.orbit.distance.is_finite() && stage.viewer.orbit.target.is_finite(), "the camera is nowhere")
}

fn cancelled() -> Outcome {
    let mut stage = stage()?;
    let at = pos2(60.0, 480.0);
    stage.run(down(at));
    stage.run(vec![touch(0, TouchPhase::Cancel, at), Heard::PointerGone]);
    hold(!stage.viewer.is_dragging(), "it goes on dragging without a finger")?;
    stage.settle()?;
    hold(is_turned(&mut stage, at), "the next finger turns nothing")
}

fn panel_button() -> Outcome {
    let mut stage = stage()?;
    let tap = |stage: &mut Stage, at: Pos2| {
        for events in [down(at), up(at), Vec::new(), Vec::new()] {
            stage.run(events);
        }
    };
    let width = |stage: &Stage| stage.viewer.size()[0];
    // Nothing is there before the first touch.
    let (narrow, orbit) = (width(&stage), stage.viewer.orbit);
    tap(&mut stage, pos2(60.0, 480.0));
    hold(stage.viewer.shows_panel && stage.viewer.orbit == orbit, "a tap on the picture does something")?;
    tap(&mut stage, pos2(narrow as f32 - 20.0, 18.0));
    let wide = width(&stage);
    hold(!stage.viewer.shows_panel && wide > narrow, "the button does not hide the panel")?;
    tap(&mut stage, pos2(wide as f32 - 20.0, 18.0));
    hold(stage.viewer.shows_panel && width(&stage) == narrow, "the button does not show the panel again")
}
