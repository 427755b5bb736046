//! Render pipelines that count shadow volumes in a stencil buffer.

use std::sync::OnceLock;

use wgpu::{CompareFunction, StencilOperation};

use super::errors::ShadowError;
use super::format::{Casters, Count, Polygons, ShadowFormat, VolumeKey};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::Subject;
use crate::shadow::{Counting, DepthDirection};
use crate::stages::{CAP_FACES, PIECES, SIDES};

/// The first list of caps that are no near caps, as `casting.wgsl` numbers them.
const FAR: u32 = 2;

/// The layouts of the bind groups that draws use.
#[derive(Clone, Debug)]
pub(crate) struct Layouts {
    /// Casters, camera and lights.
    pub(crate) frame: wgpu::BindGroupLayout,
    /// Edges and the lists of sides.
    pub(crate) side_data: wgpu::BindGroupLayout,
    /// Faces and their lists.
    pub(crate) cap_data: wgpu::BindGroupLayout,
    /// The lists of pieces.
    pub(crate) piece_data: wgpu::BindGroupLayout,
}

/// The pipelines for a list of polygons: one, or one for each part of trimmed polygons.
pub(crate) type Drawing = Vec<wgpu::RenderPipeline>;

/// A list of polygons that is drawn, and how.
#[derive(Clone, Copy)]
struct Drawn {
    polygons: Polygons,
    entry_point: &'static str,
    /// The list of cap faces.
    kind: u32,
    count: Count,
    /// Swaps the counting of fronts and backs. The vertex order and so the bits of depth stay the same.
    turned: bool,
}

impl Drawn {
    fn side(entry_point: &'static str, count: Count) -> Self {
        Self { polygons: Polygons::Sides, entry_point, kind: 0, count, turned: false }
    }

    /// A near cap of a class.
    fn near_cap(entry_point: &'static str, class: u32) -> Self {
        Self { polygons: Polygons::Caps, entry_point, kind: class, count: Count::Always, turned: class == 1 }
    }

    /// A light cap of a class.
    fn light_cap(entry_point: &'static str, class: u32, count: Count) -> Self {
        Self { polygons: Polygons::Caps, entry_point, kind: FAR + class, count, turned: class == 1 }
    }

    /// A dark cap is seen from its other side.
    fn dark_cap(class: u32, count: Count) -> Self {
        Self { polygons: Polygons::Caps, entry_point: "dark_cap", kind: FAR + class, count, turned: class != 1 }
    }

    fn piece(entry_point: &'static str, count: Count, turned: bool) -> Self {
        Self { polygons: Polygons::Pieces, entry_point, kind: 0, count, turned }
    }
}

/// The pipelines that draw pieces of L-twisted polygons.
#[derive(Debug)]
pub(crate) struct PiecePipelines {
    pub(crate) side: Drawing,
    /// Clipped sides, and near caps that count up on their front and on their back.
    pub(crate) near: Option<(Drawing, [Drawing; 2])>,
    pub(crate) light_cap: Drawing,
    pub(crate) dark_cap: Drawing,
}

/// The properties in which volumes and the pipelines that draw them must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Convention {
    pub(crate) counting: Counting,
    pub(crate) depth: DepthDirection,
    /// z-fail draws caps that a far plane does not clip.
    pub(crate) is_unclipped: bool,
    /// The low bits of the stencil that counts own.
    pub(crate) count_bits: u32,
    /// Pictures are mirror images: front faces turn clockwise.
    pub(crate) mirrors: bool,
}

impl Convention {
    fn front_face(self) -> wgpu::FrontFace {
        if self.mirrors { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw }
    }

    /// Whether dark caps are drawn at infinity, where a far plane would clip them.
    pub(crate) fn needs_far_end(self) -> bool {
        self.counting.may_fail() && !self.is_unclipped
    }

    /// Refuses to draw volumes of this convention by pipelines of another.
    pub(crate) fn check_drawn_by(self, pipelines: Self) -> Result<(), ShadowError> {
        if self.counting != pipelines.counting {
            return Err(ShadowError::OtherCounting { volumes: self.counting, pipelines: pipelines.counting });
        }
        if self.depth != pipelines.depth {
            return Err(ShadowError::OtherDepth { volumes: self.depth, pipelines: pipelines.depth });
        }
        if self.mirrors != pipelines.mirrors {
            return Err(ShadowError::OtherFrontFace { volumes: self.front_face(), pipelines: pipelines.front_face() });
        }
        if self.is_unclipped && !pipelines.is_unclipped {
            return Err(ShadowError::OtherFarPlane);
        }
        if self.count_bits != pipelines.count_bits {
            return Err(ShadowError::OtherCountBits { volumes: self.count_bits, pipelines: pipelines.count_bits });
        }
        Ok(())
    }
}

/// The render pipelines of one counting method for one [`ShadowFormat`](crate::gpu::ShadowFormat). Casters share them,
/// and with them the compute pipelines that choose.
#[derive(Debug)]
pub struct ShadowPipelines {
    shared: Pipelines,
    pub(crate) convention: Convention,
    /// Sides with z-pass and ZP+, or with z-fail, which ZP+ as published may change to.
    pub(crate) side: Drawing,
    /// Clipped sides, and the near caps that count up on their front and on their back; of ZP+, or of ZP+ as published.
    pub(crate) near: Option<(Drawing, [Drawing; 2])>,
    /// Dark caps of volumes that end, with z-pass: one for each list. Made for the first volumes that may end.
    ends: OnceLock<[Drawing; 2]>,
    /// Light caps of casters that are not in the depth buffer, with z-pass and ZP+: one for each list. Made for the first
    /// such casters.
    light_caps: OnceLock<[Drawing; 2]>,
    /// Light and dark caps with z-fail: those of faces that count up on their front, then the others.
    pub(crate) caps: Option<[[Drawing; 2]; 2]>,
    /// Made for the first caster with polygons.
    pieces: OnceLock<PiecePipelines>,
    format: ShadowFormat,
    casters: Casters,
}

impl ShadowPipelines {
    /// Makes the pipelines. `pipelines` is the caller's device, or the [`Pipelines`] that other formats, counting
    /// methods and extractors share.
    ///
    /// # Errors
    /// [`ShadowError`] if the device lacks what shadow volumes need, or cannot draw into the attachments.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        counting: Counting,
    ) -> Result<Self, ShadowError> {
        Self::make(pipelines.into(), format, counting, Casters::One)
    }

    /// The pipelines for one caster or for those of a scene.
    pub(crate) fn make(
        pipelines: Pipelines,
        format: &ShadowFormat,
        counting: Counting,
        casters: Casters,
    ) -> Result<Self, ShadowError> {
        pipelines.clone().construct(Subject::Shadow, || {
            check(pipelines.device(), format, counting.may_fail())?;
            check_count_bits(format.count_bits, casters)?;
            let device = pipelines.device().clone();
            any_error(&device, || Self::with(pipelines, format, counting, casters))
                .map_err(|message| ShadowError::Refused { message })
        })
    }

    fn with(shared: Pipelines, format: &ShadowFormat, counting: Counting, casters: Casters) -> Self {
        let is_fail = counting.may_fail();
        let count = if is_fail { Count::Hidden } else { Count::Visible };
        let side = Drawn::side("side", count);
        let near = match counting {
            Counting::Auto | Counting::ZpPlus => Some(("side_clipped", "near_cap")),
            counting if counting.is_zp_plus_2005() => Some(("zp_plus_2005_side", "zp_plus_2005_cap")),
            _ => None,
        };
        let near = near
            .map(|(side, cap)| (Drawn::side(side, Count::Visible), [Drawn::near_cap(cap, 0), Drawn::near_cap(cap, 1)]));
        let caps = is_fail.then(|| {
            [0, 1].map(|class| {
                [Drawn::light_cap("light_cap", class, Count::Hidden), Drawn::dark_cap(class, Count::Hidden)]
            })
        });
        let mut all = vec![side];
        all.extend(near.iter().flat_map(|&(side, caps)| [side].into_iter().chain(caps)));
        all.extend(caps.iter().flatten().flatten());
        let maker = Maker::new(&shared, format, casters);
        maker.make_together(&all);
        Self {
            convention: Convention {
                counting,
                depth: format.depth,
                is_unclipped: is_fail && format.has_far_plane,
                count_bits: format.count_bits,
                mirrors: format.front_face == wgpu::FrontFace::Cw,
            },
            side: maker.drawing(side),
            near: near.map(|(side, caps)| (maker.drawing(side), caps.map(|cap| maker.drawing(cap)))),
            ends: OnceLock::new(),
            light_caps: OnceLock::new(),
            caps: caps.map(|caps| caps.map(|caps| caps.map(|cap| maker.drawing(cap)))),
            shared,
            pieces: OnceLock::new(),
            format: format.clone(),
            casters,
        }
    }

    /// Dark caps of volumes that end, with z-pass: one for each list.
    pub(crate) fn ends(&self) -> Option<&[Drawing; 2]> {
        let may_pass = matches!(self.convention.counting, Counting::Auto | Counting::ZPass);
        let classes = [0, 1].map(|class| Drawn::dark_cap(class, Count::Visible));
        may_pass.then(|| self.ends.get_or_init(|| self.both(classes)))
    }

    /// Light caps of casters that are not in the depth buffer, with z-pass and ZP+: one for each list.
    pub(crate) fn light_caps(&self) -> Option<&[Drawing; 2]> {
        let classes = [0, 1].map(|class| Drawn::light_cap("seen_light_cap", class, Count::Visible));
        (!self.convention.counting.may_fail()).then(|| self.light_caps.get_or_init(|| self.both(classes)))
    }

    fn both(&self, classes: [Drawn; 2]) -> [Drawing; 2] {
        let maker = Maker::new(&self.shared, &self.format, self.casters);
        maker.make_together(&classes);
        classes.map(|drawn| maker.drawing(drawn))
    }

    /// The pipelines that draw pieces of L-twisted polygons.
    pub(crate) fn pieces(&self) -> &PiecePipelines {
        self.pieces.get_or_init(|| {
            let counting = self.convention.counting;
            let count = if counting.may_fail() { Count::Hidden } else { Count::Visible };
            let is_clipped = matches!(counting, Counting::Auto | Counting::ZpPlus);
            let side = Drawn::piece("piece_side", count, false);
            let near = is_clipped.then(|| {
                let cap = |class| Drawn::piece("piece_near_cap", Count::Always, class == 1);
                (Drawn::piece("piece_side_clipped", Count::Visible, false), [0, 1].map(cap))
            });
            let light_cap = Drawn::piece("piece_light_cap", count, false);
            // A dark cap is seen from its other side.
            let dark_cap = Drawn::piece("piece_dark_cap", count, true);
            let mut all = vec![side, light_cap, dark_cap];
            all.extend(near.iter().flat_map(|&(side, caps)| [side].into_iter().chain(caps)));
            let maker = Maker::new(&self.shared, &self.format, self.casters);
            maker.make_together(&all);
            PiecePipelines {
                side: maker.drawing(side),
                near: near.map(|(side, caps)| (maker.drawing(side), caps.map(|cap| maker.drawing(cap)))),
                light_cap: maker.drawing(light_cap),
                dark_cap: maker.drawing(dark_cap),
            }
        })
    }

    /// The shared pipelines that these belong to.
    pub(crate) fn shared(&self) -> &Pipelines {
        &self.shared
    }

    /// The counting method of these pipelines.
    pub fn counting(&self) -> Counting {
        self.convention.counting
    }
}

/// The layouts of the bind groups that draws use.
pub(crate) fn layouts(pipelines: &Pipelines) -> Layouts {
    let uniform = |dynamic| wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: dynamic,
        min_binding_size: None,
    };
    let storage = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let seen = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: true,
        min_binding_size: None,
    };
    let frame = pipelines.layout("shadow frame", entries(&[uniform(false), uniform(true), seen, storage]));
    let side_data = pipelines.layout("shadow sides", entries(&[storage; 6]));
    let cap_data = pipelines.layout("shadow caps", entries(&[storage; 5]));
    let piece_data = pipelines.layout("shadow pieces", entries(&[storage]));
    Layouts { frame, side_data, cap_data, piece_data }
}

/// Refuses attachments that the device cannot draw volumes into.
pub(crate) fn check(device: &wgpu::Device, format: &ShadowFormat, is_fail: bool) -> Result<(), ShadowError> {
    let depth_stencil = format.depth_stencil;
    if !(depth_stencil.has_stencil_aspect() && depth_stencil.has_depth_aspect()) {
        return Err(ShadowError::NoStencil(depth_stencil));
    }
    let needed = depth_stencil.required_features();
    if !device.features().contains(needed) {
        return Err(ShadowError::Feature { format: depth_stencil, needed });
    }
    let supported = sample_counts(device, depth_stencil);
    if !supported.contains(&format.samples) {
        return Err(ShadowError::Samples { samples: format.samples, format: depth_stencil, supported });
    }
    if is_fail && format.has_far_plane && !device.features().contains(wgpu::Features::DEPTH_CLIP_CONTROL) {
        return Err(ShadowError::DepthClip);
    }
    Ok(())
}

/// Refuses numbers of bits that counts cannot own.
pub(crate) fn check_count_bits(given: u32, casters: Casters) -> Result<(), ShadowError> {
    let least = casters.least_bits();
    if (least..=8).contains(&given) { Ok(()) } else { Err(ShadowError::CountBits { given, least }) }
}

/// The sample counts that a format may have on a device. An adapter may add some to those of every device, but wgpu
/// tells which only for adapters.
fn sample_counts(device: &wgpu::Device, format: wgpu::TextureFormat) -> Vec<u32> {
    if device.features().contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES) {
        return vec![1, 2, 4, 8, 16];
    }
    format.guaranteed_format_features(device.features()).flags.supported_sample_counts()
}

fn entries(types: &[wgpu::BindingType]) -> Vec<wgpu::BindGroupLayoutEntry> {
    let entry = |(binding, &ty): (u32, &wgpu::BindingType)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX,
        ty,
        count: None,
    };
    (0..).zip(types).map(entry).collect()
}

/// Makes pipelines for one format.
struct Maker<'a> {
    shared: &'a Pipelines,
    format: &'a ShadowFormat,
    casters: Casters,
    layouts: Layouts,
}

impl<'a> Maker<'a> {
    fn new(shared: &'a Pipelines, format: &'a ShadowFormat, casters: Casters) -> Self {
        Self { shared, format, casters, layouts: layouts(shared) }
    }

    /// Makes all pipelines of these at the same time.
    fn make_together(&self, all: &[Drawn]) {
        let keys: Vec<_> = all.iter().flat_map(|&drawn| self.keys(drawn)).collect();
        self.shared.make_volumes(&keys, |key| self.make(key));
    }

    fn drawing(&self, drawn: Drawn) -> Drawing {
        self.keys(drawn).iter().map(|key| self.shared.volume(key, || self.make(key))).collect()
    }

    fn keys(&self, drawn: Drawn) -> Vec<VolumeKey> {
        let Drawn { polygons, entry_point, kind, count, turned } = drawn;
        let parts = if self.format.trim { parts(entry_point) } else { 1 };
        let (casters, format) = (self.casters, self.format);
        let key =
            |part| VolumeKey { polygons, entry_point, part, kind, casters, count, turned, format: format.clone() };
        (0..parts).map(key).collect()
    }

    fn make(&self, key: &VolumeKey) -> wgpu::RenderPipeline {
        let &VolumeKey { polygons, entry_point, part, kind, casters, count, turned, ref format } = key;
        let device = self.shared.device();
        let Layouts { frame, side_data, cap_data, piece_data } = &self.layouts;
        let (stage, data) = match polygons {
            Polygons::Sides => (&SIDES, side_data),
            Polygons::Caps => (&CAP_FACES, cap_data),
            Polygons::Pieces => (&PIECES, piece_data),
        };
        let module = self.shared.module(stage.name, &stage.wgsl());
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(stage.name),
            bind_group_layouts: &[frame, data].map(Some),
            immediate_size: 0,
        });
        let is_reversed = format.depth == DepthDirection::Reversed;
        let nearer = if is_reversed { CompareFunction::Greater } else { CompareFunction::Less };
        let compare = if count == Count::Always { CompareFunction::Always } else { nearer };
        let stencil = stencil(count, turned, casters.most_count(format.count_bits));
        let unclipped_depth = count == Count::Hidden && format.has_far_plane;
        let switch = |is_on: bool| f64::from(u8::from(is_on));
        let constants = [
            ("MANY", switch(casters != Casters::One)),
            ("TRIM", switch(format.trim)),
            ("PART", f64::from(part)),
            ("UNCLIPPED", switch(unclipped_depth)),
            ("CAP_KIND", f64::from(kind)),
        ];
        let constants = if polygons == Polygons::Caps { &constants[..] } else { &constants[..4] };
        let targets: Vec<_> = format
            .colors
            .iter()
            .map(|color| {
                color.map(|format| wgpu::ColorTargetState {
                    format,
                    blend: None,
                    write_mask: wgpu::ColorWrites::empty(),
                })
            })
            .collect();
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState {
                topology: if is_list(entry_point) {
                    wgpu::PrimitiveTopology::TriangleList
                } else {
                    wgpu::PrimitiveTopology::TriangleStrip
                },
                front_face: format.front_face,
                unclipped_depth,
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: format.depth_stencil,
                depth_write_enabled: Some(false),
                depth_compare: Some(compare),
                stencil,
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: format.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("nothing"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Whether an entry point draws lists of triangles instead of strips.
fn is_list(entry_point: &str) -> bool {
    matches!(entry_point, "light_cap" | "dark_cap" | "zp_plus_2005_cap" | "piece_dark_cap")
}

/// The parts of the largest polygon that trimming at six planes leaves: two triangles of a strip each, or one of a list.
fn parts(entry_point: &str) -> u32 {
    match entry_point {
        "light_cap" | "zp_plus_2005_side" | "zp_plus_2005_cap" => 1,
        // Nine corners, ten, eleven.
        "dark_cap" | "piece_dark_cap" => 7,
        "side" | "piece_side" => 4,
        _ => 5,
    }
}

/// An operation adds to the whole byte. A carry out of the bits of `write_mask`, which are the lowest, is not written.
pub(crate) fn stencil(count: Count, turned: bool, write_mask: u32) -> wgpu::StencilState {
    let face = |is_front: bool| {
        let ups = is_front == (count != Count::Hidden);
        let operation = if ups == turned { StencilOperation::DecrementWrap } else { StencilOperation::IncrementWrap };
        let keep = StencilOperation::Keep;
        let (fail, pass) = if count == Count::Hidden { (operation, keep) } else { (keep, operation) };
        wgpu::StencilFaceState { compare: CompareFunction::Always, fail_op: keep, depth_fail_op: fail, pass_op: pass }
    };
    wgpu::StencilState { front: face(true), back: face(false), read_mask: 0xff, write_mask }
}
