//! The attachments that volumes are drawn into, and the key of a pipeline of volumes.

use crate::shadow::{CameraError, DepthDirection, ShadowCamera};

/// The attachments that volumes are drawn into. [`Self::of_pass`] takes them from the descriptor of a pass.
///
/// wgpu panics, or reports a validation error, where pipelines draw into a pass of other attachments, and a pass does
/// not tell its attachments. [`Self::begin_pass`] compares before it begins a pass.
///
/// # Near plane
///
/// With 24 bits, and with standard depth in either format, neighbouring depths are `distance² / (2²⁴ · near)` apart.
/// Keep the near plane farther away than `farthest / (2²⁴ · pixel)`. Here `farthest` is the distance of the farthest
/// visible shadows, and `pixel` is the size of a pixel at distance 1. For 1,080 rows and a field of view of 60° this is
/// an 18,000th of `farthest`. With a nearer plane, the borders of far shadows are off by more than a pixel. With a near
/// plane at a millionth of `farthest`, shadows may be missing or cover lit surfaces. See docs/numerics/rasterisers.md,
/// "Depth".
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ShadowFormat {
    /// The format of the depth-stencil attachment. It must have both depth and stencil. With reversed depth,
    /// `Depth32FloatStencil8` (an optional feature of devices) resolves distances to one part in 2²³, wherever the near
    /// plane is. Else keep the near plane away from the eye: see [the near plane](ShadowFormat#near-plane).
    pub depth_stencil: wgpu::TextureFormat,
    /// The depth direction. It must be that of the cameras.
    pub depth: DepthDirection,
    /// Samples for each pixel: 1 or 4. The device may allow others if it was made with
    /// `Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES`.
    pub samples: u32,
    /// The formats of the pass's colour attachments, which volumes do not change. Empty: the pass has none.
    pub colors: Vec<Option<wgpu::TextureFormat>>,
    /// The winding of front faces on the screen. It is `Ccw`, except for two cases with `Cw`: cameras that mirror, and
    /// mirrored instances whose positions stay in mesh space, so that the camera's matrix contains the instance's
    /// transform. Cameras of the other kind are refused.
    pub front_face: wgpu::FrontFace,
    /// Whether the far plane is at a finite distance, see [`crate::ShadowCamera::has_far_plane`]. Only z-fail and ZP+
    /// as published use this. They then need `Features::DEPTH_CLIP_CONTROL`.
    pub has_far_plane: bool,
    /// How many low bits of the stencil hold counts: 1 to 8, by default 8; volumes of meshes do not write the others.
    /// Take fewer if the stencil holds something else, too, such as the parities of
    /// [`DepthMapPipelines::beside_meshes`](crate::gpu::depth_map::DepthMapPipelines::beside_meshes): **beside 8 bits
    /// they would change counts.** Counts wrap at 2 to the power of this: with 7 bits, a point behind 128 casting faces
    /// looks lit, see [`StencilCounts::bound_counts`](crate::gpu::StencilCounts::bound_counts).
    /// [`ShadowPipelines::in_batches`](crate::gpu::ShadowPipelines::in_batches) need 2 or more, and take the highest
    /// as the dark bit.
    pub count_bits: u32,
    /// Whether vertex shaders cut sides and caps at the frustum. Default: false, the device clips them. Set it for a
    /// driver that clips slivers wrongly, such as `SwiftShader` (`rimline devices` names them): its shadows have lone
    /// wrong pixels where volumes leave the picture. Volumes then take several times as long, and z-fail may still show
    /// such pixels, because its light caps are not cut.
    pub trim: bool,
}

impl Default for ShadowFormat {
    /// 24-bit depth, because `Depth32FloatStencil8` is an optional feature; see [`ShadowFormat`] for the near plane that
    /// it needs. Reversed depth, one sample, no colour attachment, no far plane, counts in all eight bits of the
    /// stencil.
    fn default() -> Self {
        Self {
            depth_stencil: wgpu::TextureFormat::Depth24PlusStencil8,
            depth: DepthDirection::Reversed,
            samples: 1,
            colors: Vec::new(),
            front_face: wgpu::FrontFace::Ccw,
            has_far_plane: false,
            count_bits: 8,
            trim: false,
        }
    }
}

impl ShadowFormat {
    /// The default, for a camera: with its depth direction, its front face, and its far plane.
    ///
    /// # Errors
    /// [`CameraError`] if no shadow volumes can be drawn for the camera.
    pub fn of_camera(camera: &ShadowCamera) -> Result<Self, CameraError> {
        camera.check_any_hand()?;
        let front_face = if camera.mirrors() { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw };
        Ok(Self { depth: camera.depth, front_face, has_far_plane: camera.has_far_plane(), ..Self::default() })
    }

    /// The same without the difference between linear and sRGB formats.
    pub(super) fn without_srgb(&self) -> Self {
        let colors = self.colors.iter().map(|color| color.map(|color| color.remove_srgb_suffix())).collect();
        Self { colors, ..self.clone() }
    }

    /// The depth-stencil attachment of a light's pass: it keeps the depths of the depth pass, and clears the stencil to
    /// 0, where counts begin.
    pub fn attachment(view: &wgpu::TextureView) -> wgpu::RenderPassDepthStencilAttachment<'_> {
        let store = wgpu::StoreOp::Store;
        wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store }),
            stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store }),
        }
    }

    /// The depth-stencil state of a pipeline that adds a light, for the pass in which that light's volumes were drawn. It
    /// draws the surfaces that the depth pass left, and lights them where no volume was counted: where all eight bits of the
    /// stencil are 0, which is the reference that passes begin with. If you use bits above [`Self::count_bits`] for something
    /// else, leave them out of its `stencil.read_mask`. It writes neither depth nor stencil.
    ///
    /// The light pass must compute the same depths as the depth pass, bit for bit (`@invariant`). For a light pass that
    /// draws no surfaces take [`Self::full_screen_depth_stencil`].
    pub fn light_pass_depth_stencil(&self) -> wgpu::DepthStencilState {
        self.where_lit(wgpu::CompareFunction::Equal)
    }

    /// The same for a pipeline that adds a light by a triangle over the whole picture, or by a box around the light, at
    /// any depth, as deferred renderers do. The stencil alone says where there is light. The background is lit, too,
    /// where it has no shadow.
    pub fn full_screen_depth_stencil(&self) -> wgpu::DepthStencilState {
        self.where_lit(wgpu::CompareFunction::Always)
    }

    fn where_lit(&self, depth_compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
        let lit = wgpu::StencilFaceState { compare: wgpu::CompareFunction::Equal, ..wgpu::StencilFaceState::IGNORE };
        wgpu::DepthStencilState {
            format: self.depth_stencil,
            depth_write_enabled: Some(false),
            depth_compare: Some(depth_compare),
            stencil: wgpu::StencilState { front: lit, back: lit, read_mask: 0xff, write_mask: 0 },
            bias: wgpu::DepthBiasState::default(),
        }
    }
}

/// The attachments of a format, for messages.
pub(super) fn attachments(format: &ShadowFormat) -> String {
    let ShadowFormat { depth_stencil, samples, colors, .. } = format;
    format!("{depth_stencil:?}, colours {colors:?} and {samples} samples a pixel")
}

/// The fragments that count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Count {
    /// Fragments strictly nearer than the scene: fronts up, backs down.
    Before,
    /// The other fragments: fronts down, backs up.
    Behind,
    /// All fragments: fronts up, backs down.
    Always,
}

/// The polygons that are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Polygons {
    Sides,
    Caps,
    Pieces,
}

/// The casters that pipelines draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Casters {
    /// The casters of a scene.
    Scene,
    /// The casters of a scene, counted in batches: the highest bit is set where earlier batches cast a shadow.
    Batches,
}

impl Casters {
    /// The largest count with `count_bits` bits of the stencil. It is also the mask of the bits that count.
    pub(crate) fn largest_count(self, count_bits: u32) -> u32 {
        let bits = if self == Self::Batches { count_bits.saturating_sub(1) } else { count_bits };
        (1 << bits.min(8)) - 1
    }
}

/// An indirect draw of a list of polygons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Drawn {
    pub(super) polygons: Polygons,
    pub(super) entry_point: &'static str,
    /// The kind of its list of cap faces.
    pub(super) kind: u32,
    pub(super) count: Count,
    /// Swaps the counting of fronts and backs. The vertex order and so the bits of depth stay the same.
    pub(super) is_swapped: bool,
    /// The index of its arguments among the fields of `ShadowDraws`, or of `PieceDraws`.
    pub(super) argument: u64,
}

/// Everything that a pipeline of volumes depends on, and nothing that leaves it as it is.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct VolumeKey {
    pub(super) polygons: Polygons,
    pub(super) entry_point: &'static str,
    /// The kind of its list of cap faces.
    pub(super) kind: u32,
    /// Whether the vertex shader cuts at the frustum.
    pub(super) is_trimmed: bool,
    pub(super) primitive: wgpu::PrimitiveState,
    pub(super) depth_stencil: wgpu::DepthStencilState,
    pub(super) samples: u32,
    pub(super) colors: Vec<Option<wgpu::TextureFormat>>,
}
