//! Inputs of encoding, for casters of all kinds.

use rimline::reference::layout::ShadowStatistics;
use rimline::{Light, ShadowCamera};

use super::posed_model::PosedModel;
use crate::device::Gpu;

/// The casters of a frame, the viewer's camera, and the lights.
#[derive(Clone, Copy)]
pub(crate) struct CastInputs<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) bodies: &'a [PosedModel<'a>],
    /// Bodies that depth maps of the lights must see: `bodies`, or those that they stand in for.
    pub(crate) seen: &'a [PosedModel<'a>],
    pub(crate) camera: &'a ShadowCamera,
    pub(crate) lights: &'a [Light],
}

/// Puts `made` in the place of what has this number, or behind the last.
pub(super) fn put<T>(list: &mut Vec<T>, number: usize, made: T) {
    match list.get_mut(number) {
        Some(old) => *old = made,
        None => list.push(made),
    }
}

/// No volume of a mesh, and a count of 0 or 1.
pub(super) fn parity() -> ShadowStatistics {
    ShadowStatistics { count_bound: 1, ..bytemuck::Zeroable::zeroed() }
}
