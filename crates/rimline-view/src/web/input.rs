//! Events of the browser as egui has them.

use std::cell::RefCell;
use std::rc::Rc;

use egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, TouchPhase, pos2, vec2};
use web_sys::{HtmlCanvasElement, KeyboardEvent, MouseEvent, PointerEvent, WheelEvent};

use super::page::listen;
use crate::pointer::{Pointer, Pointers};

/// Hears events. Those of pointers, wheels and keys begin with the keys that are held.
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

/// Mice, pens and fingers.
fn pointers(canvas: &HtmlCanvasElement, hear: &Rc<Hear>) {
    let kinds = [
        ("pointerdown", TouchPhase::Start),
        ("pointermove", TouchPhase::Move),
        ("pointerup", TouchPhase::End),
        ("pointercancel", TouchPhase::Cancel),
    ];
    let pointers = Rc::new(RefCell::new(Pointers::default()));
    for (kind, phase) in kinds {
        let (heard, on, pointers) = (Rc::clone(hear), canvas.clone(), Rc::clone(&pointers));
        listen(canvas, kind, move |event: PointerEvent| {
            if phase == TouchPhase::Start {
                // Keys go where the pointer went down, and a drag goes on outside.
                let _ = on.focus();
                let _ = on.set_pointer_capture(event.pointer_id());
            }
            let events = pointers.borrow_mut().hear(&of_pointer(&event), phase);
            heard(&events);
        });
    }
    let heard = Rc::clone(hear);
    listen(canvas, "pointerleave", move |_: PointerEvent| heard(&[Event::PointerGone]));
}

fn of_pointer(event: &PointerEvent) -> Pointer {
    Pointer {
        is_touch: event.pointer_type() == "touch",
        is_primary: event.is_primary(),
        id: event.pointer_id(),
        pos: pos2(event.offset_x() as f32, event.offset_y() as f32),
        pressure: event.pressure(),
        button: event.button(),
        buttons: event.buttons(),
        modifiers: held(event),
    }
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
