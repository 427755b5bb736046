//! The surface of a model, and the sides that its faces turn to the lights.

use std::ops::Range;

use rimline::gpu::{CasterHandle, SceneFrame, ShadowError};

use crate::resources::Resources;

/// Front and back of the first, second … model; then from the beginning again.
const CLAYS: [[[f32; 3]; 2]; 4] = [
    [[0.62, 0.60, 0.565], [0.50, 0.33, 0.24]],
    [[0.36, 0.49, 0.56], [0.58, 0.40, 0.29]],
    [[0.60, 0.42, 0.31], [0.33, 0.45, 0.51]],
    [[0.46, 0.54, 0.38], [0.58, 0.40, 0.29]],
];

/// Layout of `Clay` in `surface.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Clay {
    front: [f32; 3],
    is_colored: u32,
    back: [f32; 3],
    reserved: u32,
}

/// Flag of a slot, as in `surface.wgsl`: the face is shown as the one that it coincides with, which runs the other way
/// around.
pub const TURNED: u32 = 1 << 31;
/// With [`TURNED`]: the mask at the slot is the face's own, whose opposite is the other's.
pub const OPPOSITE: u32 = 1 << 30;

/// Where the facing masks of a model's faces are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FacingMasks {
    /// Faces whose masks lie in one buffer for each batch of 32 lights.
    pub runs: Vec<(Range<u32>, Vec<wgpu::Buffer>)>,
    /// The slot of each face in its buffer.
    pub slots: Vec<u32>,
}

impl FacingMasks {
    /// The masks of casters whose faces follow each other.
    ///
    /// # Errors
    /// [`ShadowError`] if the frame lacks one of them, or a later encode overwrites it.
    pub fn of_scene(frame: &SceneFrame, casters: impl IntoIterator<Item = CasterHandle>) -> Result<Self, ShadowError> {
        let results = frame.results()?;
        let buffers = |group: usize| -> Vec<wgpu::Buffer> {
            results.groups.iter().filter(|of| of.group == group).map(|of| of.facing.clone()).collect()
        };
        let mut masks = Self::default();
        let mut last = None;
        for caster in casters {
            let removed = ShadowError::Removed { what: "caster" };
            let (group, slots) = frame.face_slots(caster).ok_or(removed)?;
            let first = masks.slots.len();
            masks.slots.extend(slots.clone());
            if let Some(faces) = frame.slot_order(caster) {
                for (slot, &face) in slots.zip(faces) {
                    masks.slots[first + face as usize] = slot;
                }
            }
            let end = masks.slots.len() as u32;
            match masks.runs.last_mut().filter(|_| last == Some(group)) {
                Some((faces, _)) => faces.end = end,
                None => masks.runs.push((first as u32..end, buffers(group))),
            }
            last = Some(group);
        }
        Ok(masks)
    }
}

/// Buffers of a surface, beside those of [`FacingMasks`].
#[derive(Clone, Copy, Debug)]
pub struct SurfaceBuffers<'a> {
    /// Positions in world space, three `f32` each.
    pub positions: &'a wgpu::Buffer,
    /// Three vertices a face.
    pub faces: &'a wgpu::Buffer,
    /// A normal a corner, as [`crate::corner_normals`] has them.
    pub normals: &'a wgpu::Buffer,
    /// The slot of each face, perhaps with [`TURNED`] and [`OPPOSITE`]. Normals and colours of a turned face's corners must be
    /// those of the face that it is shown as.
    pub slots: &'a wgpu::Buffer,
    /// A base colour a corner, as [`crate::corner_colors`] has them. `None`: the model is of clay.
    pub colors: Option<&'a wgpu::Buffer>,
}

/// The draws of a model: corners of faces that one buffer has the facing masks of, for each batch of 32 lights.
#[derive(Clone, Debug)]
pub struct Surface(Vec<(Range<u32>, Vec<wgpu::BindGroup>)>);

impl Surface {
    /// The model with this number.
    pub fn new(resources: &Resources, number: usize, buffers: SurfaceBuffers<'_>, masks: &FacingMasks) -> Self {
        let SurfaceBuffers { positions, faces, normals, slots, colors } = buffers;
        let [front, back] = CLAYS[number % CLAYS.len()];
        let clay = Clay { front, is_colored: u32::from(colors.is_some()), back, reserved: 0 };
        let clay = resources.factory.uniform("clay", bytemuck::bytes_of(&clay));
        // Nothing reads colours that are not there.
        let colors = colors.unwrap_or(slots);
        let group = |facing: &wgpu::Buffer| {
            let buffers = [&clay, positions, faces, normals, slots, facing, colors];
            resources.factory.group(&resources.surface, &buffers.map(wgpu::Buffer::as_entire_binding))
        };
        let run = |(faces, facing): &(Range<u32>, Vec<wgpu::Buffer>)| {
            // Without lights there are no masks, and nothing reads them.
            let groups = if facing.is_empty() { vec![group(slots)] } else { facing.iter().map(group).collect() };
            (3 * faces.start..3 * faces.end, groups)
        };
        Self(masks.runs.iter().map(run).collect())
    }

    /// Draws it for a light that is selected, with a pipeline of [`crate::ReceiverPass::surface_pipeline`].
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) {
        for (corners, groups) in &self.0 {
            if let Some(group) = groups.get(light / 32) {
                pass.set_bind_group(2, group, &[]);
                pass.draw(corners.clone(), 0..1);
            }
        }
    }
}
