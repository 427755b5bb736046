//! The sources that casters read their positions from.

use std::collections::HashMap;
use std::ops::Range;

use slotmap::{DefaultKey, SlotMap};

use super::caster::Placement;
use super::pages::Page;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::PositionBuffer;
use crate::gpu::shadow::errors::ShadowError;

/// A source of positions that casters of one page use.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) page: usize,
    /// `None`: the positions of the page.
    pub(crate) buffer: Option<BoundBuffer>,
    casters: usize,
}

impl Source {
    /// The buffer of the positions, and its bound part in bytes.
    pub(crate) fn bound_positions<'a>(&'a self, page: &'a Page) -> (&'a wgpu::Buffer, Range<u64>) {
        match &self.buffer {
            Some(bound) => (&bound.buffer, bound.range.clone()),
            None => (&page.positions, 0..page.positions.size()),
        }
    }

    /// The buffers that stages and draws of its casters read.
    pub(crate) fn topology(&self, page: &Page) -> GroupTopology {
        let (positions, range) = self.bound_positions(page);
        GroupTopology {
            faces: page.faces.clone(),
            edge_vertices: page.edge_vertices.clone(),
            edge_faces: page.edge_faces.clone(),
            positions: (positions.clone(), range),
            clusters: page.clusters.clone(),
            are_at_rest: self.buffer.is_none(),
        }
    }
}

/// The topology and positions of a group of casters.
#[derive(Debug)]
pub(crate) struct GroupTopology {
    pub(crate) faces: wgpu::Buffer,
    pub(crate) edge_vertices: wgpu::Buffer,
    pub(crate) edge_faces: wgpu::Buffer,
    pub(crate) positions: (wgpu::Buffer, Range<u64>),
    /// The clusters of its page.
    pub(crate) clusters: wgpu::Buffer,
    /// Whether the positions are those of the page, in the boxes that the table has.
    pub(crate) are_at_rest: bool,
}

/// The part of a caller's buffer that is bound.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct BoundBuffer {
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) range: Range<u64>,
}

/// All sources that have casters.
#[derive(Debug, Default)]
pub(crate) struct Sources {
    sources: SlotMap<DefaultKey, Source>,
    /// By page and buffer: casters with the same ones share a source.
    by_key: HashMap<(usize, Option<BoundBuffer>), DefaultKey>,
}

impl Sources {
    pub(crate) fn get(&self, source: DefaultKey) -> Option<&Source> {
        self.sources.get(source)
    }

    /// The source of a further caster.
    pub(crate) fn acquire(&mut self, page: usize, buffer: Option<BoundBuffer>) -> DefaultKey {
        let Self { sources, by_key } = self;
        let new = |key: &(usize, Option<BoundBuffer>)| {
            sources.insert(Source { page: key.0, buffer: key.1.clone(), casters: 0 })
        };
        let source = *by_key.entry((page, buffer)).or_insert_with_key(new);
        if let Some(source) = sources.get_mut(source) {
            source.casters += 1;
        }
        source
    }

    /// Removes a caster of the source. The last one releases the buffer.
    pub(crate) fn release(&mut self, source: DefaultKey) {
        let is_unused = self.sources.get_mut(source).is_some_and(|source| {
            source.casters = source.casters.saturating_sub(1);
            source.casters == 0
        });
        if is_unused && let Some(source) = self.sources.remove(source) {
            self.by_key.remove(&(source.page, source.buffer));
        }
    }
}

/// Checks a caller's buffer. A buffer that one binding holds is bound whole, so that its casters share a group.
pub(crate) fn bind(
    pipelines: &Pipelines,
    positions: &PositionBuffer<'_>,
    vertices: u32,
) -> Result<(Placement, BoundBuffer), ShadowError> {
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
    let placement = Placement::World { offset, stride: (positions.stride / 4) as u32 };
    Ok((placement, BoundBuffer { buffer: positions.buffer.clone(), range }))
}
