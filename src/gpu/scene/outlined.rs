//! Groups of casters whose outlines are drawn for a light.

use super::frame::SceneFrame;
use super::handles::LightHandle;
use super::sources::GroupTopology;
use super::structure::{GroupBatch, Structure};
use crate::ShadowCamera;
use crate::gpu::common::bindings::{Resource, part, whole};
use crate::layout::{CHUNK, DrawArguments, OutlinedGroup};

/// A group of casters and a light.
#[derive(Clone, Copy)]
pub(crate) struct Outlined<'a> {
    structure: &'a Structure,
    part: &'a GroupBatch,
    pub(crate) topology: &'a GroupTopology,
    bit: u32,
}

impl<'a> Outlined<'a> {
    /// The uniform of the draw.
    pub(crate) fn uniform(self) -> OutlinedGroup {
        let Self { part: GroupBatch { dispatch, sizes, .. }, bit, .. } = self;
        OutlinedGroup {
            edge_chunks_offset: dispatch.edge_chunks_offset,
            relevant_lights_offset: dispatch.batch * dispatch.casters,
            capacity: sizes.capacity,
            twisted_offset: if sizes.polygons.is_some() { CHUNK * dispatch.face_chunks } else { 0 },
            bit,
            reserved_0: 0,
            reserved_1: 0,
            reserved_2: 0,
        }
    }

    /// The resources of the draw beside the uniform, in the order of its bindings.
    pub(crate) fn resources(self) -> [Resource<'a>; 7] {
        let Self { structure, part: GroupBatch { sizes, buffers, .. }, topology, .. } = self;
        let (positions, range) = &topology.positions;
        [
            whole(&structure.table),
            whole(&structure.buffers.relevant_lights),
            part(positions, range.clone()),
            whole(&topology.page.edge_vertices),
            whole(&topology.page.edge_faces),
            part(&buffers.facing, 0..sizes.facing()),
            part(&buffers.lists, 0..sizes.lists),
        ]
    }

    /// The edge slots.
    pub(crate) fn edges(self) -> u32 {
        CHUNK * self.part.dispatch.edge_chunks
    }

    /// The arguments of the draw of the light's list, or of all edge slots if it overflowed.
    pub(crate) fn arguments(self) -> (&'a wgpu::Buffer, u64) {
        (&self.part.buffers.draws, u64::from(self.bit) * size_of::<DrawArguments>() as u64)
    }
}

impl SceneFrame {
    /// The groups of casters, for the outlines of a light of the frame.
    pub(crate) fn outlined(&self, light: LightHandle) -> impl Iterator<Item = Outlined<'_>> {
        let (structure, batch) = (&*self.structure, light.bit as usize / 32);
        let parts = structure.parts.iter().filter(move |part| part.batch == batch);
        parts.filter_map(move |part| {
            Some(Outlined { structure, part, topology: structure.topology.get(part.group)?, bit: light.bit % 32 })
        })
    }

    /// Whether each caster that a camera sees has its positions. Instances of models that no view needs have none.
    pub(crate) fn has_positions_for(&self, camera: &ShadowCamera) -> bool {
        !self.has_models || self.views.is_empty() || self.views.iter().any(|view| view.camera == *camera)
    }
}
