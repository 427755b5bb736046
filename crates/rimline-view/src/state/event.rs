//! Events: everything that comes from outside.

use super::body::Body;
use super::keys::Action;

/// A button of the pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// The left one, or a finger: drags a light, or turns the camera.
    Primary,
    /// The right one: moves the camera sideways.
    Secondary,
    /// The middle one: likewise.
    Middle,
}

/// Keys that are held down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modifiers {
    /// Shift: a light moves up and down, the camera sideways.
    pub shift: bool,
    /// Control or Command: a light moves at its height.
    pub control: bool,
}

/// An event. Positions are pixels of the picture, from its upper left corner.
#[derive(Debug)]
#[non_exhaustive]
pub enum Event {
    /// The picture has another size, in pixels. A camera that the user left alone still shows everything.
    Resized([u32; 2]),
    /// The pointer is somewhere else.
    Moved([f32; 2]),
    /// A button went down where the pointer is.
    Pressed(Button, Modifiers),
    /// A button went up.
    Released,
    /// The wheel or two fingers scrolled: lines to the right and up. Up is nearer. With Shift a line moves the camera sideways
    /// by 40 pixels; [`Event::Panned`] says how many.
    Scrolled([f32; 2], Modifiers),
    /// Two fingers moved the picture by so many pixels to the right and down.
    Panned([f32; 2]),
    /// Two fingers pinched: a factor above 1 is nearer.
    Pinched(f32),
    /// A key was pressed, or a button of the panel: see [`KEYS`](crate::KEYS).
    Acted(Action),
    /// Keys are held that fly: to the right, up and ahead, each from −1 to 1, for so many seconds.
    Flown([f32; 3], f32),
    /// Seconds passed.
    Passed(f32),
    /// The dialog for files that [`Request::OpenFiles`](crate::Request::OpenFiles) asked for is closed, or was never shown.
    Answered,
    /// Files were chosen or dropped, and each comes as [`Event::Opened`]. Errors of these are shown together.
    Opening,
    /// A model was opened, or could not be: its name and why.
    Opened(Result<Box<Body>, (String, String)>),
    /// The command line of the view was copied, or what became of it instead, in words: it and the line.
    Copied(String, String),
    /// Something else to tell the user.
    Message(String),
}
