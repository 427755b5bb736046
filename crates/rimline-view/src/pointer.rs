//! Events of a browser's pointers as egui has them.

use egui::{Event, Modifiers, PointerButton, Pos2, TouchDeviceId, TouchId, TouchPhase};

/// An event of a mouse, a pen or a finger, as the browser tells it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pointer {
    pub(crate) is_touch: bool,
    /// Whether a finger is the first.
    pub(crate) is_primary: bool,
    pub(crate) id: i32,
    pub(crate) pos: Pos2,
    pub(crate) pressure: f32,
    /// The number of the button that changed, if one did.
    pub(crate) button: i16,
    /// Bits of the buttons that are down.
    pub(crate) buttons: u16,
    pub(crate) modifiers: Modifiers,
}

/// Where the last pointer was, and the buttons of mice and pens.
#[derive(Debug, Default)]
pub(crate) struct Pointers {
    at: Pos2,
    buttons: u16,
}

/// Numbers of buttons in events, their bits where all that are held are listed, and their names.
const BUTTONS: [(i16, u16, PointerButton); 5] = [
    (0, 1, PointerButton::Primary),
    (1, 4, PointerButton::Middle),
    (2, 2, PointerButton::Secondary),
    (3, 8, PointerButton::Extra1),
    (4, 16, PointerButton::Extra2),
];

impl Pointers {
    /// Makes egui's events of one of the browser. The first finger is a mouse, too.
    pub(crate) fn hear(&mut self, pointer: &Pointer, phase: TouchPhase) -> Vec<Event> {
        let Pointer { is_touch, is_primary, id, pos, pressure, button, buttons, modifiers } = *pointer;
        let mut events = vec![Event::ModifiersChanged(modifiers)];
        if is_touch {
            let (device_id, id) = (TouchDeviceId(0), TouchId::from(id));
            events.push(Event::Touch { device_id, id, phase, pos, force: Some(pressure) });
            if !is_primary {
                return events;
            }
        }
        if phase != TouchPhase::Cancel {
            events.push(Event::PointerMoved(pos));
            // While one button is held, others go down and up in moves.
            let changed = BUTTONS.iter().find(|(number, ..)| *number == button);
            events.extend(changed.map(|&(_, bit, button)| {
                let pressed = buttons & bit != 0;
                Event::PointerButton { pos, button, pressed, modifiers }
            }));
            (self.at, self.buttons) = (pos, if is_touch { 0 } else { buttons });
        } else if !is_touch {
            // A mouse or a pen was taken away. No release follows, and this event has no position.
            let held = std::mem::take(&mut self.buttons);
            let held = BUTTONS.iter().filter(|(_, bit, _)| held & bit != 0);
            let pos = self.at;
            events.extend(held.map(|&(_, _, button)| Event::PointerButton { pos, button, pressed: false, modifiers }));
        }
        if phase == TouchPhase::Cancel || phase == TouchPhase::End && is_touch {
            events.push(Event::PointerGone);
        }
        events
    }
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn a_mouse_that_is_taken_away_lets_go_where_it_was_and_is_no_finger() {
        let modifiers = Modifiers::NONE;
        for is_touch in [false, true] {
            let mut pointers = Pointers::default();
            let mut hear = |x: f32, button: i16, buttons: u16, phase| {
                let (is_primary, id, pos, pressure) = (true, 7, pos2(x, x), 0.5);
                let pointer = Pointer { is_touch, is_primary, id, pos, pressure, button, buttons, modifiers };
                pointers.hear(&pointer, phase)
            };
            let (primary, secondary) = (PointerButton::Primary, PointerButton::Secondary);
            let pressed = |x, button, pressed| Event::PointerButton { pos: pos2(x, x), button, pressed, modifiers };
            assert!(hear(10.0, 0, 1, TouchPhase::Start).contains(&pressed(10.0, primary, true)));
            assert!(hear(20.0, 2, 3, TouchPhase::Move).contains(&pressed(20.0, secondary, true)));
            hear(30.0, -1, 3, TouchPhase::Move);
            let events = hear(0.0, 0, 0, TouchPhase::Cancel);
            for button in [primary, secondary] {
                assert_eq!(events.contains(&pressed(30.0, button, false)), !is_touch, "{events:?}");
            }
            let is_finger = events.iter().any(|event| matches!(event, Event::Touch { .. }));
            assert!(is_finger == is_touch && events.last() == Some(&Event::PointerGone), "{events:?}");
            assert_eq!(hear(0.0, 0, 0, TouchPhase::Cancel).len(), if is_touch { 3 } else { 2 });
        }
    }
}
