//! Handles, which the pointer takes hold of.

use super::event::Modifiers;

/// A handle on the picture, by the number of its light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// A light.
    Lamp(usize),
    /// The point that the selected light is aimed at, if it is a spot.
    Target(usize),
}

/// The thing that the pointer drags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Drag {
    Turn,
    Pan,
    Handle(Handle, Modifiers),
}
