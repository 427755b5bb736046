//! The casters of a frame as all ways to shadows take them.

use std::ops::Range;

use rimline::gpu::{LightHandle, Scene, ShadowError};
use rimline::{Light, LightError, ShadowCamera, wgpu};

use super::posed_model::PosedModel;

/// The casters of a frame, the viewer's camera, and the lights.
#[derive(Clone, Copy)]
pub(crate) struct CastInputs<'a> {
    pub(crate) bodies: &'a [PosedModel<'a>],
    /// Bodies that depth maps of the lights must see: `bodies`, or those that they stand in for.
    pub(crate) seen: &'a [PosedModel<'a>],
    pub(crate) camera: &'a ShadowCamera,
    pub(crate) lights: &'a [Light],
}

#[derive(Default)]
pub(crate) struct FacingMasks {
    /// Faces whose masks lie in one buffer for each batch of 32 lights.
    pub(super) runs: Vec<(Range<u32>, Vec<wgpu::Buffer>)>,
    /// The place of each face in its buffer.
    pub(super) slots: Vec<u32>,
}

/// Gives a scene these lights: their handles are in order.
pub(super) fn set_lights(
    scene: &mut Scene,
    handles: &mut Vec<LightHandle>,
    lights: &[Light],
) -> Result<(), ShadowError> {
    for (number, &light) in lights.iter().enumerate() {
        // The scene sees one light.
        let numbered = |error| match error {
            ShadowError::Light(LightError::NegativeWeight { w, .. }) => {
                LightError::NegativeWeight { index: number, w }.into()
            }
            error => error,
        };
        match handles.get(number) {
            Some(&handle) => scene.set_light(handle, light).map_err(numbered)?,
            None => handles.push(scene.add_light(light).map_err(numbered)?),
        }
    }
    Ok(())
}

/// Puts `made` in the place of what has this number, or behind the last.
pub(super) fn put<T>(list: &mut Vec<T>, number: usize, made: T) {
    match list.get_mut(number) {
        Some(old) => *old = made,
        None => list.push(made),
    }
}
