//! The sources that casters read their positions from.

use std::ops::Range;

use slotmap::DefaultKey;

use super::caster::{BoundBuffer, CasterEntry, CasterPositions, Placement, Rigid};
use super::pages::PageBuffers;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::PositionBuffer;
use crate::gpu::shadow::errors::ShadowError;

/// A source of positions that casters of one page use.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Source {
    pub(crate) page: DefaultKey,
    /// `None`: the positions of the page.
    buffer: Option<BoundBuffer>,
}

impl Source {
    /// The source of a caster.
    pub(crate) fn of(caster: &CasterEntry) -> Self {
        let buffer = match &caster.placement {
            Placement::Rigid(_) => None,
            Placement::World { bound, .. } => Some(bound.clone()),
        };
        Self { page: caster.mesh.region.page, buffer }
    }

    /// The buffer of the positions, and its bound part in bytes.
    pub(crate) fn bound_positions(&self, page: &PageBuffers) -> (wgpu::Buffer, Range<u64>) {
        match &self.buffer {
            Some(BoundBuffer { buffer, range }) => (buffer.clone(), range.clone()),
            None => (page.positions.clone(), 0..page.positions.size()),
        }
    }

    /// The buffers that stages and draws of its casters read.
    pub(crate) fn topology(&self, page: &PageBuffers) -> GroupTopology {
        let positions = self.bound_positions(page);
        GroupTopology { page: page.clone(), positions, are_at_rest: self.buffer.is_none() }
    }
}

/// The topology and positions of a group of casters.
#[derive(Debug)]
pub(crate) struct GroupTopology {
    pub(crate) page: PageBuffers,
    /// The buffer of the positions, and its bound part in bytes.
    pub(crate) positions: (wgpu::Buffer, Range<u64>),
    /// Whether the positions are those of the page, in the boxes that the table has.
    pub(crate) are_at_rest: bool,
}

impl Placement {
    /// The placement of a caster of a mesh. Checks a caller's buffer.
    pub(crate) fn new(pipelines: &Pipelines, positions: CasterPositions, vertices: u32) -> Result<Self, ShadowError> {
        match positions {
            CasterPositions::Rigid(transform) => Ok(Self::Rigid(Rigid::new(transform.rows()))),
            CasterPositions::Buffer { buffer, offset, stride } => {
                bind(pipelines, &PositionBuffer { buffer: &buffer, offset, stride }, vertices)
            }
        }
    }
}

/// A buffer that one binding holds is bound whole, so that its casters share a group.
fn bind(pipelines: &Pipelines, positions: &PositionBuffer<'_>, vertices: u32) -> Result<Placement, ShadowError> {
    let end = positions.end(vertices)?;
    pipelines.check_bindable(positions.buffer)?;
    let limits = DispatchLimits::new(&pipelines.device().limits());
    let whole = positions.buffer.size() / 4 * 4;
    let base = if whole <= limits.binding { 0 } else { limits.align_down(positions.offset) };
    let range = base..whole.min(base + limits.binding);
    if end > range.end {
        let bytes = end - base;
        return Err(DeviceError::BindingTooLarge { what: "positions of a caster", bytes, limit: limits.binding }.into());
    }
    let offset = ((positions.offset - base) / 4) as u32;
    let bound = BoundBuffer { buffer: positions.buffer.clone(), range };
    Ok(Placement::World { bound, offset, stride: (positions.stride / 4) as u32 })
}
