//! Events of the browser as egui has them.

use std::rc::Rc;

use egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, pos2, vec2};
use web_sys::{HtmlCanvasElement, KeyboardEvent, MouseEvent, PointerEvent, WheelEvent};

use super::page::listen;

/// Hears events. The first tells which keys are held.
type Hear = dyn Fn(&[Event]);

/// Lets `hear` hear all that happens on the canvas.
pub(super) fn listen_on(canvas: &HtmlCanvasElement, hear: Rc<Hear>) {
    pointers(canvas, &hear);
    keys(canvas, &hear);
    let heard = Rc::clone(&hear);
    listen(canvas, "wheel", move |event: WheelEvent| {
        event.prevent_default();
        let unit = match event.delta_mode() {
            WheelEvent::DOM_DELTA_LINE => MouseWheelUnit::Line,
            WheelEvent::DOM_DELTA_PAGE => MouseWheelUnit::Page,
            _ => MouseWheelUnit::Point,
        };
        let delta = -vec2(event.delta_x() as f32, event.delta_y() as f32);
        let (modifiers, phase, source) = (held(&event), TouchPhase::Move, MouseWheelSource::Unknown);
        let wheel = Event::MouseWheel { unit, delta, phase, source, modifiers };
        heard(&[Event::ModifiersChanged(modifiers), wheel]);
    });
    listen(canvas, "contextmenu", |event: web_sys::Event| event.prevent_default());
    for (kind, is_focused) in [("focus", true), ("blur", false)] {
        let heard = Rc::clone(&hear);
        listen(canvas, kind, move |_: web_sys::Event| heard(&[Event::WindowFocused(is_focused)]));
    }
}

fn held(event: &MouseEvent) -> Modifiers {
    modifiers(event.alt_key(), event.ctrl_key(), event.shift_key(), event.meta_key())
}

fn modifiers(alt: bool, ctrl: bool, shift: bool, meta: bool) -> Modifiers {
    Modifiers { alt, ctrl, shift, mac_cmd: meta, command: ctrl || meta }
}

/// Mice, pens and fingers. The first finger is a mouse, too.
fn pointers(canvas: &HtmlCanvasElement, hear: &Rc<Hear>) {
    let kinds = [
        ("pointerdown", TouchPhase::Start),
        ("pointermove", TouchPhase::Move),
        ("pointerup", TouchPhase::End),
        ("pointercancel", TouchPhase::Cancel),
    ];
    for (kind, phase) in kinds {
        let (heard, on) = (Rc::clone(hear), canvas.clone());
        listen(canvas, kind, move |event: PointerEvent| {
            if phase == TouchPhase::Start {
                // Keys go where the pointer went down, and a drag goes on outside.
                let _ = on.focus();
                let _ = on.set_pointer_capture(event.pointer_id());
            }
            heard(&of_pointer(&event, phase));
        });
    }
    let heard = Rc::clone(hear);
    listen(canvas, "pointerleave", move |_: PointerEvent| heard(&[Event::PointerGone]));
}

/// Numbers of buttons in events, their bits where all that are held are told, and their names.
const BUTTONS: [(i16, u16, PointerButton); 5] = [
    (0, 1, PointerButton::Primary),
    (1, 4, PointerButton::Middle),
    (2, 2, PointerButton::Secondary),
    (3, 8, PointerButton::Extra1),
    (4, 16, PointerButton::Extra2),
];

fn of_pointer(event: &PointerEvent, phase: TouchPhase) -> Vec<Event> {
    let (pos, modifiers): (Pos2, _) = (pos2(event.offset_x() as f32, event.offset_y() as f32), held(event));
    let is_touch = event.pointer_type() == "touch";
    let mut events = vec![Event::ModifiersChanged(modifiers)];
    // The viewer lets go also where a pen or a mouse was taken away.
    if is_touch || phase == TouchPhase::Cancel {
        let (device_id, id) = (egui::TouchDeviceId(0), egui::TouchId::from(event.pointer_id()));
        events.push(Event::Touch { device_id, id, phase, pos, force: Some(event.pressure()) });
    }
    if is_touch && !event.is_primary() {
        return events;
    }
    if phase != TouchPhase::Cancel {
        events.push(Event::PointerMoved(pos));
        // While one button is held, others go down and up in moves.
        let changed = BUTTONS.iter().find(|(number, ..)| *number == event.button());
        events.extend(changed.map(|&(_, bit, button)| {
            let pressed = event.buttons() & bit != 0;
            Event::PointerButton { pos, button, pressed, modifiers }
        }));
    }
    if phase == TouchPhase::Cancel || phase == TouchPhase::End && is_touch {
        events.push(Event::PointerGone);
    }
    events
}

fn keys(canvas: &HtmlCanvasElement, hear: &Rc<Hear>) {
    for (kind, pressed) in [("keydown", true), ("keyup", false)] {
        let heard = Rc::clone(hear);
        listen(canvas, kind, move |event: KeyboardEvent| {
            let modifiers = modifiers(event.alt_key(), event.ctrl_key(), event.shift_key(), event.meta_key());
            let (name, is_command) = (event.key(), modifiers.command || modifiers.alt);
            let key = Key::from_name(&name);
            // The browser keeps its own keys, and Shift with Tab leaves the canvas. A key that went down alone may go up with
            // others.
            let is_function = name.starts_with('F') && name.len() > 1 && key != Some(Key::F1);
            if pressed && (is_command || is_function || key == Some(Key::Tab) && modifiers.shift) {
                return;
            }
            event.prevent_default();
            let of_key = |key| Event::Key { key, physical_key: None, pressed, repeat: event.repeat(), modifiers };
            let text = (pressed && name.chars().count() == 1).then_some(Event::Text(name));
            let changed = Event::ModifiersChanged(modifiers);
            heard(&std::iter::once(changed).chain(key.map(of_key)).chain(text).collect::<Vec<_>>());
        });
    }
}
