//! Pools of topology: the faces, edge records, positions and clusters of many meshes in few buffers.

use std::ops::Range;

use range_alloc::RangeAllocator;
use slotmap::{DefaultKey, SlotMap};

use super::topology::Topology;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, any_error, check, guarded};
use crate::gpu::common::wanted::Wanted;

/// The kinds of elements in a page: faces, edge records, vertices, and words of clusters.
const KINDS: usize = 4;
/// Elements of each kind in the first page. Page k has 4^k times as many, so few pages hold any scene. Where memory is short,
/// it is as large as an earlier one.
const FIRST: [u64; KINDS] = [1 << 14, 3 << 13, 1 << 14, 1 << 13];
/// Pages from this one on have the same size.
const LARGEST: usize = 10;
/// Bytes of a face, an edge record in one of its two buffers, a vertex, and a word.
const BYTES: [u64; KINDS] = [12, 8, 12, 4];
const WHAT: [&str; KINDS] = ["faces", "edge records", "rest positions", "clusters"];

/// The page of a mesh, and its elements there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Region {
    pub(crate) page: DefaultKey,
    /// Faces, edge records, vertices, and words of clusters.
    pub(crate) ranges: [Range<u32>; KINDS],
}

/// The buffers of a page.
#[derive(Clone, Debug)]
pub(crate) struct PageBuffers<B = wgpu::Buffer> {
    pub(crate) faces: B,
    pub(crate) edge_vertices: B,
    pub(crate) edge_faces: B,
    pub(crate) positions: B,
    /// The words of [`Topology::clusters`].
    pub(crate) clusters: B,
}

/// The buffers of a page, and what is free there.
#[derive(Debug)]
struct Page {
    buffers: PageBuffers,
    /// Whether it is for one mesh alone, which begins it and takes it along when it goes.
    is_of_one: bool,
    /// The size of the buffers.
    bytes: u64,
    /// Free ranges of each kind.
    free: [RangeAllocator<u32>; KINDS],
}

/// All pages of a scene. A scene grows by further pages, so it copies nothing.
#[derive(Debug, Default)]
pub(crate) struct Pages {
    all: SlotMap<DefaultKey, Page>,
    /// The regions that were freed since the last encode, and between it and the one before.
    freed: [Vec<Region>; 2],
    /// The size of all pages in bytes.
    pub(crate) bytes: u64,
}

impl<B> PageBuffers<B> {
    fn plan(items: [u64; KINDS], mut make: impl FnMut(Wanted<'static>) -> B) -> Self {
        let [faces, edges, vertices, words] = bytes_of(items);
        Self {
            faces: make(Wanted::new("scene faces", faces)),
            edge_vertices: make(Wanted::new("scene edge vertices", edges)),
            edge_faces: make(Wanted::new("scene edge faces", edges)),
            positions: make(Wanted::new("scene rest positions", vertices)),
            clusters: make(Wanted::new("scene clusters", words)),
        }
    }
}

impl PageBuffers {
    /// The size of all in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let Self { faces, edge_vertices, edge_faces, positions, clusters } = self;
        [faces, edge_vertices, edge_faces, positions, clusters].into_iter().map(wgpu::Buffer::size).sum()
    }
}

impl Page {
    /// A page for this many elements of each kind.
    fn new(
        device: &wgpu::Device,
        sizes: [u64; KINDS],
        is_of_one: bool,
        used: u64,
        memory_limit: Option<u64>,
        limits: &DispatchLimits,
    ) -> Result<Self, DeviceError> {
        let mut all = Vec::new();
        PageBuffers::plan(sizes, |Wanted { label, bytes, .. }| all.push(Allocation { label, bytes }));
        let bytes = check(&all, limits.buffer, None)?;
        all.push(Allocation { label: "the rest of the scene", bytes: used });
        check(&all, u64::MAX, memory_limit)?;
        let buffers = guarded(device, bytes + used, || PageBuffers::plan(sizes, |wanted| wanted.make(device)))?;
        let free = sizes.map(|items| RangeAllocator::new(0..items as u32));
        Ok(Self { buffers, is_of_one, bytes, free })
    }

    /// Ranges of `items` elements of each kind, if there is room for all.
    fn allocate(&mut self, items: [u64; KINDS]) -> Option<[Range<u32>; KINDS]> {
        let mut ranges = [const { 0..0 }; KINDS];
        for (kind, free) in self.free.iter_mut().enumerate() {
            let Ok(range) = free.allocate_range(items[kind] as u32) else {
                let allocated = ranges.into_iter().take(kind);
                self.free.iter_mut().zip(allocated).for_each(|(free, range)| free.free_range(range));
                return None;
            };
            ranges[kind] = range;
        }
        Some(ranges)
    }
}

impl Pages {
    pub(crate) fn get(&self, page: DefaultKey) -> Option<&PageBuffers> {
        self.all.get(page).map(|page| &page.buffers)
    }

    /// Allocates a mesh, in a new page if the others have no room. `used` are the bytes of the scene so far. If
    /// `is_alone`, the mesh gets a page of its size.
    pub(crate) fn add(
        &mut self,
        device: &wgpu::Device,
        mesh: &Topology<'_>,
        vertices: u32,
        is_alone: bool,
        used: u64,
        memory_limit: Option<u64>,
    ) -> Result<Region, DeviceError> {
        // The allocator refuses empty ranges.
        let items = [mesh.faces.len(), mesh.edge_faces.len(), vertices as usize, mesh.clusters.len()];
        let items = items.map(|n| n.max(1) as u64);
        for (page, pool) in self.all.iter_mut().filter(|(_, pool)| !is_alone && !pool.is_of_one) {
            if let Some(ranges) = pool.allocate(items) {
                return Ok(Region { page, ranges });
            }
        }
        let limits = DispatchLimits::new(&device.limits());
        let shared = self.all.values().filter(|page| !page.is_of_one).count();
        let make = |page: usize| {
            let sizes = page_sizes(page, items, limits.binding)?;
            Page::new(device, if is_alone { items } else { sizes }, is_alone, used, memory_limit, &limits)
        };
        let largest = if is_alone { 0 } else { shared.min(LARGEST) };
        let mut made = make(largest);
        for smaller in (0..largest).rev() {
            let is_short = matches!(made, Err(DeviceError::MemoryLimit { .. } | DeviceError::OutOfMemory { .. }));
            if !is_short {
                break;
            }
            made = make(smaller);
        }
        let mut made = made?;
        // A page is at least as large as the mesh.
        let ranges = made.allocate(items).unwrap_or([const { 0..0 }; KINDS]);
        self.bytes += made.bytes;
        Ok(Region { page: self.all.insert(made), ranges })
    }

    /// Uploads a mesh and its positions. The queue writes them before the commands of its next submission. No command that
    /// was recorded before reads this region; see [`Self::free`].
    pub(crate) fn upload(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        region: &Region,
        mesh: &Topology<'_>,
        positions: &[[f32; 3]],
    ) -> Result<(), DeviceError> {
        let Some(page) = self.get(region.page) else { return Ok(()) };
        let [faces, edges, vertices, words] = bytes_of(region.ranges.clone().map(|range| u64::from(range.start)));
        let write = || {
            queue.write_buffer(&page.faces, faces, bytemuck::cast_slice(&mesh.faces));
            queue.write_buffer(&page.edge_vertices, edges, bytemuck::cast_slice(&mesh.edge_vertices));
            queue.write_buffer(&page.edge_faces, edges, bytemuck::cast_slice(&mesh.edge_faces));
            queue.write_buffer(&page.clusters, words, bytemuck::cast_slice(&mesh.clusters));
            queue.write_buffer(&page.positions, vertices, bytemuck::cast_slice(positions));
        };
        any_error(device, write).map_err(|message| DeviceError::Refused { message })
    }

    /// Frees a region. Recorded frames may still read it. So the region of a page for many waits, and the buffers of a page
    /// for one, which nothing writes again, live as long as those frames.
    pub(crate) fn free(&mut self, region: Region) {
        if self.all.get(region.page).is_some_and(|page| page.is_of_one) {
            self.bytes -= self.all.remove(region.page).map_or(0, |page| page.bytes);
        } else {
            self.freed[0].push(region);
        }
    }

    /// Makes regions available that were freed before the encode before this one. Each encode calls it at its end. The queue
    /// would otherwise write them before frames that are recorded but not yet submitted.
    pub(crate) fn reclaim(&mut self) {
        let [since_last, before] = &mut self.freed;
        for region in std::mem::replace(before, std::mem::take(since_last)) {
            if let Some(page) = self.all.get_mut(region.page) {
                page.free.iter_mut().zip(region.ranges).for_each(|(free, range)| free.free_range(range));
            }
        }
    }
}

/// The bytes of some elements of each kind.
fn bytes_of(items: [u64; KINDS]) -> [u64; KINDS] {
    std::array::from_fn(|kind| BYTES[kind] * items[kind])
}

/// The elements of each kind in a new page: at least those of the mesh.
fn page_sizes(page: usize, items: [u64; KINDS], binding: u64) -> Result<[u64; KINDS], DeviceError> {
    let grown = 4_u64.pow(page.min(LARGEST) as u32);
    let mut sizes = [0; KINDS];
    for (kind, size) in sizes.iter_mut().enumerate() {
        let most = binding / BYTES[kind];
        if items[kind] > most {
            return Err(DeviceError::BindingTooLarge {
                what: WHAT[kind],
                bytes: items[kind] * BYTES[kind],
                limit: binding,
            });
        }
        *size = (FIRST[kind] * grown).min(most).max(items[kind]);
    }
    Ok(sizes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_grow_and_large_meshes_get_their_size() {
        let binding = 128 << 20;
        assert_eq!(page_sizes(0, [1; KINDS], binding), Ok(FIRST));
        assert_eq!(page_sizes(1, [1, 1, 1 << 20, 1], binding), Ok([4 * FIRST[0], 4 * FIRST[1], 1 << 20, 4 * FIRST[3]]));
        let most = BYTES.map(|bytes| binding / bytes);
        assert_eq!(page_sizes(usize::MAX, [1; KINDS], binding), Ok(most));
        let refused = page_sizes(0, [1, most[1] + 1, 1, 1], binding);
        assert!(matches!(refused, Err(DeviceError::BindingTooLarge { what: "edge records", .. })), "{refused:?}");
    }
}
