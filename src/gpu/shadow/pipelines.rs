//! Render pipelines that count shadow volumes in a stencil buffer.

use std::sync::OnceLock;

use wgpu::{CompareFunction, StencilOperation};

use super::errors::ShadowError;
use super::format::{Casters, Count, Drawn, Polygons, ShadowFormat, VolumeKey};
use crate::gpu::common::bindings::{READ, UNIFORM, entries};
use crate::gpu::common::drawing::{self, depth_stencil, unchanged};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::{Pipelines, switch};
use crate::gpu::common::requirements::Subject;
use crate::shadow::{Counting, DepthDirection};
use crate::stages::{CAP_FACES, PIECE_VOLUMES, SIDES};

/// The kind of the first list of light and dark caps in `wgsl/shadow/draw_lists.wgsl`. Near caps begin at 0.
const FAR: u32 = 2;

/// The most parts of a trimmed polygon.
pub(crate) const MOST_PARTS: u32 = 7;

/// The layouts of the bind groups that draws use.
#[derive(Clone, Debug)]
pub(crate) struct Layouts {
    /// Casters, camera and lights, and the part of trimmed polygons.
    pub(crate) frame: wgpu::BindGroupLayout,
    /// Edges and the lists of sides.
    pub(crate) side_data: wgpu::BindGroupLayout,
    /// Faces and their lists.
    pub(crate) cap_data: wgpu::BindGroupLayout,
    /// The lists of pieces.
    pub(crate) piece_data: wgpu::BindGroupLayout,
}

/// An indirect draw, which is made once for each part of trimmed polygons.
#[derive(Debug)]
pub(crate) struct PartDraw {
    pub(super) drawn: Drawn,
    pub(super) pipeline: wgpu::RenderPipeline,
    pub(super) polygon_parts: u32,
}

// Indices of the fields of `ShadowDraws`. The first four are those of `PieceDraws`, too. Caps have two, by their kind: 0 or
// 2, then 1 or 3.
const PLAIN: u64 = 0;
const CLIPPED: u64 = 1;
const NEAR_CAPS: u64 = 2;
const FAR_CAPS: u64 = 4;
const LIGHT_CAPS: u64 = 6;

// The last fields of `PieceDraws`.
const PIECE_LIGHT_CAP: u64 = 4;
const PIECE_DARK_CAP: u64 = 5;

/// Draws that are made together, and drawn by the same casters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Sides and caps that all casters have.
    All,
    /// Dark caps of volumes that end, with z-pass.
    Ends,
    /// Light caps of casters that are not in the depth buffer, with z-pass and ZP+.
    Proxies,
    /// Pieces of twisted polygons.
    Pieces,
}

impl Part {
    /// Its draws with a counting method.
    fn draws(self, counting: Counting) -> Vec<Drawn> {
        let is_fail = counting.may_fail();
        let count = if is_fail { Count::Behind } else { Count::Before };
        let drawn = |polygons, entry_point, count, argument| Drawn {
            polygons,
            entry_point,
            kind: 0,
            count,
            is_swapped: false,
            argument,
        };
        let side = |entry_point, count, argument| drawn(Polygons::Sides, entry_point, count, argument);
        // Caps of the kinds `first` and `first` + 1 (`wgsl/shadow/draw_lists.wgsl`).
        let caps = |entry_point, count, first: u32, argument: u64| {
            [0, 1].map(|back: u32| Drawn {
                kind: first + back,
                // A dark cap is seen from its other side.
                is_swapped: (back == 1) != (entry_point == "dark_cap"),
                ..drawn(Polygons::Caps, entry_point, count, argument + u64::from(back))
            })
        };
        let piece = |entry_point, count, argument| drawn(Polygons::Pieces, entry_point, count, argument);
        let may_clip = matches!(counting, Counting::Auto | Counting::ZpPlus);
        let mut all = Vec::new();
        match self {
            Self::All => {
                let near = match counting {
                    _ if may_clip => Some(("side_clipped", "near_cap")),
                    counting if counting.is_zp_plus_2005() => Some(("zp_plus_2005_side", "zp_plus_2005_cap")),
                    _ => None,
                };
                all.extend(near.iter().flat_map(|(_, cap)| caps(*cap, Count::Always, 0, NEAR_CAPS)));
                if is_fail {
                    all.extend(caps("light_cap", Count::Behind, FAR, FAR_CAPS));
                    all.extend(caps("dark_cap", Count::Behind, FAR, FAR_CAPS));
                }
                all.extend(near.map(|(clipped, _)| side(clipped, Count::Before, CLIPPED)));
                all.push(side("side", count, PLAIN));
            }
            Self::Ends if matches!(counting, Counting::Auto | Counting::ZPass) => {
                all.extend(caps("dark_cap", Count::Before, FAR, FAR_CAPS));
            }
            Self::Proxies if !is_fail => all.extend(caps("seen_light_cap", Count::Before, FAR, LIGHT_CAPS)),
            Self::Ends | Self::Proxies => {}
            Self::Pieces => {
                if may_clip {
                    let cap = piece("piece_near_cap", Count::Always, NEAR_CAPS);
                    all.push(piece("piece_side_clipped", Count::Before, CLIPPED));
                    all.extend([cap, Drawn { is_swapped: true, argument: NEAR_CAPS + 1, ..cap }]);
                }
                all.extend([
                    piece("piece_side", count, PLAIN),
                    piece("piece_light_cap", count, PIECE_LIGHT_CAP),
                    Drawn { is_swapped: true, ..piece("piece_dark_cap", count, PIECE_DARK_CAP) },
                ]);
            }
        }
        all
    }
}

/// The properties in which volumes and the pipelines that draw them must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Convention {
    pub(crate) counting: Counting,
    pub(crate) depth: DepthDirection,
    /// z-fail draws caps that a far plane does not clip.
    pub(crate) is_unclipped: bool,
    /// How many low bits of the stencil hold counts.
    pub(crate) count_bits: u32,
    /// Pictures are mirror images: front faces are clockwise.
    pub(crate) mirrors: bool,
}

impl Convention {
    pub(crate) fn front_face(self) -> wgpu::FrontFace {
        if self.mirrors { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw }
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

/// The render pipelines of one counting method for one [`ShadowFormat`](crate::gpu::ShadowFormat).
#[derive(Debug)]
pub(crate) struct VolumePipelines {
    pub(crate) shared: Pipelines,
    pub(crate) convention: Convention,
    /// The draws of each [`Part`], in order. All but the first are made for the first casters that have them.
    parts: [OnceLock<Vec<PartDraw>>; 4],
    format: ShadowFormat,
    casters: Casters,
}

impl VolumePipelines {
    /// Makes the pipelines.
    pub(crate) fn of_casters(
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
        let convention = Convention {
            counting,
            depth: format.depth,
            is_unclipped: counting.may_fail() && format.has_far_plane,
            count_bits: format.count_bits,
            mirrors: format.front_face == wgpu::FrontFace::Cw,
        };
        let parts = [const { OnceLock::new() }; 4];
        let pipelines = Self { shared, convention, parts, format: format.clone(), casters };
        pipelines.of(Part::All);
        pipelines
    }

    /// The draws of a part. The first call makes their pipelines.
    pub(crate) fn of(&self, part: Part) -> &[PartDraw] {
        self.parts[part as usize].get_or_init(|| {
            let layouts = layouts(&self.shared);
            let draws = part.draws(self.convention.counting);
            let keys: Vec<_> = draws.iter().map(|&drawn| self.key(drawn)).collect();
            self.shared.make_volumes(&keys, |key| make(&self.shared, &layouts, key));
            let draw = |(drawn, key): (Drawn, &VolumeKey)| PartDraw {
                drawn,
                pipeline: self.shared.volume(key, || make(&self.shared, &layouts, key)),
                polygon_parts: self.polygon_parts(drawn.entry_point),
            };
            draws.into_iter().zip(&keys).map(draw).collect()
        })
    }

    fn key(&self, drawn: Drawn) -> VolumeKey {
        let Drawn { polygons, entry_point, kind, count, is_swapped, .. } = drawn;
        let format = &self.format;
        let topology = if is_list(entry_point) {
            wgpu::PrimitiveTopology::TriangleList
        } else {
            wgpu::PrimitiveTopology::TriangleStrip
        };
        let unclipped_depth = count == Count::Behind && format.has_far_plane;
        let front_face = format.front_face;
        let compare = if count == Count::Always { CompareFunction::Always } else { format.depth.nearer() };
        let stencil = stencil(count, is_swapped, self.casters.largest_count(format.count_bits));
        VolumeKey {
            polygons,
            entry_point,
            kind,
            is_trimmed: self.polygon_parts(entry_point) > 1,
            primitive: wgpu::PrimitiveState { topology, front_face, unclipped_depth, ..Default::default() },
            depth_stencil: depth_stencil(format.depth_stencil, false, compare, stencil),
            samples: format.samples,
            colors: format.colors.clone(),
        }
    }

    /// How many parts of its polygons a draw has.
    fn polygon_parts(&self, entry_point: &str) -> u32 {
        if self.format.trim { polygon_parts(entry_point) } else { 1 }
    }
}

/// The layouts of the bind groups that draws use.
pub(crate) fn layouts(pipelines: &Pipelines) -> Layouts {
    let dynamic = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: true, min_binding_size: None };
    let uniform = dynamic(wgpu::BufferBindingType::Uniform);
    let view_light = dynamic(wgpu::BufferBindingType::Storage { read_only: true });
    let layout = |label, types: &[wgpu::BindingType]| {
        pipelines.layout(label, entries(wgpu::ShaderStages::VERTEX, (0..).zip(types.iter().copied())))
    };
    Layouts {
        frame: layout("shadow frame", &[UNIFORM, uniform, view_light, READ, uniform]),
        side_data: layout("shadow sides", &[READ; 6]),
        cap_data: layout("shadow caps", &[READ; 5]),
        piece_data: layout("shadow pieces", &[READ]),
    }
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

/// Refuses counts of bits that are too few or too many.
pub(crate) fn check_count_bits(given: u32, casters: Casters) -> Result<(), ShadowError> {
    let least = if casters == Casters::Batches { 2 } else { 1 };
    if (least..=8).contains(&given) { Ok(()) } else { Err(ShadowError::CountBits { given, least }) }
}

/// The sample counts that a format may have on a device. An adapter may allow more than every device does, but wgpu names
/// them only for adapters.
fn sample_counts(device: &wgpu::Device, format: wgpu::TextureFormat) -> Vec<u32> {
    if device.features().contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES) {
        return vec![1, 2, 4, 8, 16];
    }
    format.guaranteed_format_features(device.features()).flags.supported_sample_counts()
}

fn make(shared: &Pipelines, layouts: &Layouts, key: &VolumeKey) -> wgpu::RenderPipeline {
    let &VolumeKey { polygons, entry_point, kind, is_trimmed, primitive, ref depth_stencil, samples, ref colors } = key;
    let Layouts { frame, side_data, cap_data, piece_data } = layouts;
    let (stage, data) = match polygons {
        Polygons::Sides => (&SIDES, side_data),
        Polygons::Caps => (&CAP_FACES, cap_data),
        Polygons::Pieces => (&PIECE_VOLUMES, piece_data),
    };
    let module = shared.module(stage.name, &stage.wgsl());
    let unclipped = switch(primitive.unclipped_depth);
    let constants = [("TRIM", switch(is_trimmed)), ("UNCLIPPED", unclipped), ("CAP_KIND", f64::from(kind))];
    shared.draws(&drawing::Drawn {
        label: entry_point,
        layouts: &[frame, data],
        vertex: (&module, entry_point),
        fragment: Some((&module, "nothing")),
        constants: if polygons == Polygons::Caps { &constants } else { &constants[..2] },
        primitive,
        depth_stencil: Some(depth_stencil.clone()),
        samples,
        targets: &unchanged(colors),
    })
}

/// Whether an entry point draws lists of triangles instead of strips.
fn is_list(entry_point: &str) -> bool {
    matches!(entry_point, "light_cap" | "dark_cap" | "zp_plus_2005_cap" | "piece_dark_cap")
}

/// The parts of the largest polygon that trimming at six planes leaves: two triangles of a strip each, or one of a list. Entry
/// points that do not trim have one.
fn polygon_parts(entry_point: &str) -> u32 {
    match entry_point {
        "light_cap" | "zp_plus_2005_side" | "zp_plus_2005_cap" => 1,
        // Nine corners, ten, eleven.
        "dark_cap" | "piece_dark_cap" => MOST_PARTS,
        "side" | "piece_side" => 4,
        _ => 5,
    }
}

/// An operation adds to the whole byte. A carry out of the bits of `write_mask`, which are the lowest, is not written.
pub(crate) fn stencil(count: Count, is_swapped: bool, write_mask: u32) -> wgpu::StencilState {
    let face = |is_front: bool| {
        let ups = is_front == (count != Count::Behind);
        let operation =
            if ups == is_swapped { StencilOperation::DecrementWrap } else { StencilOperation::IncrementWrap };
        let keep = StencilOperation::Keep;
        let (fail, pass) = if count == Count::Behind { (operation, keep) } else { (keep, operation) };
        wgpu::StencilFaceState { compare: CompareFunction::Always, fail_op: keep, depth_fail_op: fail, pass_op: pass }
    };
    wgpu::StencilState { front: face(true), back: face(false), read_mask: 0xff, write_mask }
}
