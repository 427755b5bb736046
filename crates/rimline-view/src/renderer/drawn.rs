//! The state that a picture was drawn from.

use crate::state::camera::Orbit;
use crate::state::lamp::Lamp;
use crate::state::options::{Options, Overlays as ShownOverlays};
use crate::state::viewer::Viewer;

/// All that a picture depends on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawn {
    generation: u64,
    bodies: usize,
    size: [u32; 2],
    orbit: Orbit,
    lamps: Vec<Lamp>,
    options: Options,
    seconds: f32,
}

impl Drawn {
    pub(super) fn of(viewer: &Viewer) -> Self {
        Self {
            generation: viewer.generation(),
            bodies: viewer.bodies.len(),
            size: viewer.size(),
            orbit: viewer.orbit,
            lamps: viewer.lamps.clone(),
            // Boxes are drawn by the panel.
            options: Options { overlays: ShownOverlays { boxes: false, ..viewer.options.overlays }, ..viewer.options },
            seconds: viewer.clock.seconds,
        }
    }
}
