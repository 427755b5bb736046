//! The buffers of shadow volumes.

use super::pipelines::MOST_PARTS;
use super::sizes::VolumeSizes;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, check_bindings, guarded};
use crate::gpu::common::pass::Step;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::common::wanted::{Account, Wanted};
use crate::layout::{PieceDraws, ShadowDraw, ShadowDraws, ShadowShape, ShadowStatistics, StencilPencil, ViewLight};

/// Bytes of the box of a caster.
const BOX: u64 = 28;
/// Bytes of the counts of crossings of a pencil's half planes, for a batch of casters.
const CROSSINGS: u64 = 4 * 1028;
/// Bytes of the versions that the lists of a group, batch and view were made from: two words for each light.
const LIST_VERSIONS: u64 = 8 * 32;

/// The lists of a group for a batch of lights and a view.
#[derive(Debug)]
pub(crate) struct Lists<B = wgpu::Buffer> {
    pub(crate) sides: B,
    pub(crate) caps: B,
}

/// The buffers that bound stencil counts.
#[derive(Debug)]
pub(crate) struct BoundBuffers<B = wgpu::Buffer> {
    /// A [`StencilPencil`](crate::layout::StencilPencil) for each view and light.
    pub(crate) pencils: B,
    /// For each pencil a row of bins of half planes, with the sides that cross them, for each batch of casters.
    pub(crate) bin_rows: B,
}

/// The buffers that stages and draws share.
#[derive(Debug)]
pub(crate) struct VolumeBuffers<B = wgpu::Buffer> {
    /// A [`ViewLight`] for each view and light.
    pub(crate) view_lights: B,
    pub(crate) boxes: B,
    /// Choices, then measures.
    pub(crate) choices: B,
    /// The versions that the lists for views were made from.
    pub(crate) list_versions: B,
    /// The receivers of each view.
    pub(crate) receivers: B,
    /// Uniforms: a [`ShadowShape`] for each group and batch.
    pub(crate) shapes: B,
    /// Uniforms: a [`ShadowDraw`] for each batch of casters, view and light.
    pub(crate) draw_lights: B,
    /// Uniforms: the index of each part of trimmed polygons.
    pub(crate) polygon_parts: B,
    /// For each group [`ShadowDraws`] for each view and light.
    pub(crate) draws: Vec<B>,
    /// If the caller asks for a bound of counts.
    pub(crate) bound: Option<BoundBuffers<B>>,
    /// For each group and batch one for each view.
    pub(crate) lists: Vec<Vec<Lists<B>>>,
    /// For each group of a caster with polygons [`PieceDraws`] for each view and light.
    pub(crate) piece_draws: Vec<Option<B>>,
    /// For each group and batch the lights for which polygons of its caster are twisted.
    pub(crate) twisted_lights: B,
    pub(crate) statistics: B,
}

/// The buffers of volumes, and how large they are.
#[derive(Debug)]
pub(crate) struct SizedBuffers {
    pub(crate) sizes: VolumeSizes,
    pub(crate) of: VolumeBuffers,
    /// The size of all in bytes.
    pub(crate) bytes: u64,
}

impl SizedBuffers {
    /// Makes the buffers. `others` count for the memory limit, too.
    pub(crate) fn new(
        device: &wgpu::Device,
        mut sizes: VolumeSizes,
        others: Allocation,
        limits: &DispatchLimits,
    ) -> Result<Self, DeviceError> {
        // The host makes a table of draws, for as many views and batches of casters as the caller wants.
        let view_lights = sizes.view_lights() as u64;
        let draws = view_lights.saturating_mul(sizes.options.stencil.count_batches.into());
        let draw_bytes = draws.saturating_mul(UniformTable::stride::<ShadowDraw>() as u64);
        let of_views = [
            Allocation { label: "lights of views", bytes: view_lights * size_of::<ViewLight>() as u64 },
            Allocation { label: "shadow draw lights", bytes: draw_bytes },
        ];
        // Draws select both by offsets of 32 bits.
        check_bindings(&of_views, limits.binding.min(u32::MAX.into()))?;
        // `counting_methods` has a row of workgroups for each view.
        let (needed, there) = (sizes.views as u64, limits.workgroups);
        if needed > there {
            let (subject, limit) = ("an encode of so many views", "max_compute_workgroups_per_dimension");
            return Err(DeviceError::Limit { subject, limit, needed, there });
        }
        let account = |sizes: &VolumeSizes, tables: &[UniformTable; 3]| {
            let mut account = Account::default();
            VolumeBuffers::<()>::plan(sizes, tables, |wanted| account.note(&wanted));
            account.all
        };
        let mut tables = [shapes(&sizes), draw_lights(&sizes), polygon_parts()];
        let all: u64 = account(&sizes, &tables).iter().map(|allocation| allocation.bytes).sum();
        sizes.fit_memory(all + others.bytes);
        tables[0] = shapes(&sizes);
        let mut wanted = account(&sizes, &tables);
        check_bindings(&wanted, limits.binding)?;
        wanted.push(others);
        // No buffer is larger than a binding, and the others are there or were checked.
        let bytes = check(&wanted, u64::MAX, sizes.options.memory_limit)?;
        guarded(device, bytes, || {
            let mut bytes = 0;
            let of = VolumeBuffers::plan(&sizes, &tables, |wanted| {
                let made = wanted.make(device);
                bytes += made.size();
                made
            });
            Self { sizes, of, bytes }
        })
    }

    /// The steps before the first stage. The stage `relist` empties lists.
    pub(crate) fn clears(&self) -> Vec<Step> {
        let VolumeBuffers { boxes, statistics, draws, piece_draws, bound, .. } = &self.of;
        let bin_rows = bound.as_ref().map(|bound| &bound.bin_rows);
        let draws = draws.iter().chain(piece_draws.iter().flatten());
        [statistics, boxes].into_iter().chain(draws).chain(bin_rows).map(Step::clear).collect()
    }
}

impl<B> VolumeBuffers<B> {
    fn plan(
        sizes: &VolumeSizes,
        [shapes, draw_lights, polygon_parts]: &[UniformTable; 3],
        mut make: impl FnMut(Wanted<'_>) -> B,
    ) -> Self {
        let view_lights = sizes.view_lights() as u64;
        let [_, choices] = sizes.choice_bytes();
        let pencils = size_of::<StencilPencil>() as u64 * view_lights;
        let bin_rows = CROSSINGS * view_lights * u64::from(sizes.options.stencil.count_batches);
        let list_versions = LIST_VERSIONS * (sizes.parts.len() * sizes.views) as u64;
        // The receivers of the first view begin after a word.
        let receivers = 4 * (1 + sizes.views as u64 * sizes.receivers);
        let draws = Wanted::new("shadow draws", view_lights * size_of::<ShadowDraws>() as u64).indirect();
        let piece_draws = Wanted::new("piece draws", view_lights * size_of::<PieceDraws>() as u64).indirect().free();
        Self {
            view_lights: make(Wanted::new("lights of views", view_lights * size_of::<ViewLight>() as u64)),
            boxes: make(Wanted::new("caster boxes", BOX * sizes.casters as u64)),
            choices: make(Wanted::new("choices", choices)),
            list_versions: make(Wanted::new("versions of lists", list_versions)),
            receivers: make(Wanted::new("receivers", receivers)),
            shapes: make(Wanted::uniforms("shadow shapes", shapes)),
            draw_lights: make(Wanted::uniforms("shadow draw lights", draw_lights)),
            polygon_parts: make(Wanted::uniforms("parts of polygons", polygon_parts).free()),
            draws: sizes.groups().map(|_| make(draws)).collect(),
            bound: sizes.options.stencil.bound_counts.then(|| BoundBuffers {
                pencils: make(Wanted::new("stencil pencils", pencils)),
                bin_rows: make(Wanted::new("rows of stencil bins", bin_rows)),
            }),
            lists: sizes
                .parts
                .iter()
                .map(|part| {
                    let [sides, caps] = part.lists();
                    let mut of_view = |_| Lists {
                        sides: make(Wanted::new("lists of sides", sides)),
                        caps: make(Wanted::new("lists of cap faces", caps)),
                    };
                    (0..sizes.views).map(&mut of_view).collect()
                })
                .collect(),
            piece_draws: sizes
                .groups()
                .map(|part| (part.shape.piece_capacity > 0).then(|| make(piece_draws)))
                .collect(),
            twisted_lights: make(Wanted::new("twisted lights", 4 * sizes.parts.len() as u64).free()),
            statistics: make(Wanted::new("shadow statistics", size_of::<ShadowStatistics>() as u64).free()),
        }
    }
}

/// The shapes of all groups and batches.
fn shapes(sizes: &VolumeSizes) -> UniformTable {
    let mut shapes = UniformTable::default();
    for part in 0..sizes.parts.len() {
        shapes.push::<ShadowShape>(&sizes.shape(part));
    }
    shapes
}

fn polygon_parts() -> UniformTable {
    let mut parts = UniformTable::default();
    for part in 0..MOST_PARTS {
        parts.push(&[part, 0, 0, 0]);
    }
    parts
}

fn draw_lights(sizes: &VolumeSizes) -> UniformTable {
    let mut draws = UniformTable::default();
    // Without lights nothing bounds the batches.
    let count_batches = if sizes.view_lights() > 0 { sizes.options.stencil.count_batches } else { 0 };
    for count_batch in 0..count_batches {
        for view in 0..sizes.views as u32 {
            for light in 0..sizes.lights as u32 {
                draws.push(&ShadowDraw { light, first_light: light / 32 * 32, view, count_batch });
            }
        }
    }
    draws
}
