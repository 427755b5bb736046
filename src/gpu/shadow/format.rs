//! What volumes are drawn into, and what tells one of their pipelines from another.

use crate::gpu::common::requirements::DeviceError;
use crate::shadow::DepthDirection;

/// The attachments that volumes are drawn into.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ShadowFormat {
    /// The format of the depth-stencil attachment; it must have both.
    ///
    /// With reversed depth, `Depth32FloatStencil8` (an optional feature of devices) tells apart distances that differ by a
    /// 2⁻²³th part, wherever the near plane is. With 24 bits, and with standard depth in either format, numbers next to
    /// each other are `distance² / (2²⁴ · near)` apart. Then keep the near plane farther away than `farthest / (2²⁴ · pixel)`,
    /// where `farthest` is the distance of the farthest shadows that are seen and `pixel` the size of a pixel at distance
    /// 1: farther than an 18,000th of `farthest` for 1,080 rows and a field of view of 60°. With a nearer one shadows'
    /// borders there are off by more than a pixel, and with one at a millionth shadows may be missing or spread over what is lit.
    /// NUMERICS.md, "What depth must tell apart".
    pub depth_stencil: wgpu::TextureFormat,
    /// Which depth is near: the cameras'.
    pub depth: DepthDirection,
    /// Samples a pixel: 1 or 4, and others where the adapter has them and the device was made with
    /// `Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES`.
    pub samples: u32,
    /// Formats of the pass's colour attachments, which are left as they are. Empty: a pass without any.
    pub colors: Vec<Option<wgpu::TextureFormat>>,
    /// Front faces on the screen: `Ccw`, but `Cw` for cameras that mirror, and for mirrored instances whose positions stay in
    /// the mesh's space (the camera's matrix then has the instance's transform in it).
    pub front_face: wgpu::FrontFace,
    /// The far plane is at a finite distance, see [`crate::ShadowCamera::has_far_plane`]. Only z-fail and ZP+ as published
    /// mind: they then need `Features::DEPTH_CLIP_CONTROL`.
    pub has_far_plane: bool,
}

impl Default for ShadowFormat {
    /// `Depth32FloatStencil8` is an optional feature, so 24 bits, which ask for a near plane that is not too near (see
    /// [`Self::depth_stencil`]); reversed, one sample, no colour, infinite far plane.
    fn default() -> Self {
        Self {
            depth_stencil: wgpu::TextureFormat::Depth24PlusStencil8,
            depth: DepthDirection::Reversed,
            samples: 1,
            colors: Vec::new(),
            front_face: wgpu::FrontFace::Ccw,
            has_far_plane: false,
        }
    }
}

impl ShadowFormat {
    /// The depth-stencil state of a pipeline that adds a light, for the pass in which that light's volumes were drawn. It
    /// meets the surfaces that the depth pass left, and lights them where no volume was counted: where the stencil is 0,
    /// which is the reference that passes begin with. It writes neither depth nor stencil.
    ///
    /// The light pass must compute the same depths as the depth pass, bit for bit (`@invariant`). A renderer whose light pass draws no surfaces,
    /// such as a full-screen triangle, sets `depth_compare` to `Always`.
    pub fn light_pass_depth_stencil(&self) -> wgpu::DepthStencilState {
        let lit = wgpu::StencilFaceState { compare: wgpu::CompareFunction::Equal, ..wgpu::StencilFaceState::IGNORE };
        wgpu::DepthStencilState {
            format: self.depth_stencil,
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Equal),
            stencil: wgpu::StencilState { front: lit, back: lit, read_mask: 0xff, write_mask: 0 },
            bias: wgpu::DepthBiasState::default(),
        }
    }
}

/// Why pipelines cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowFormatError {
    /// The device lacks what shadow volumes need, or is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// Counting needs a stencil, and telling near from far a depth.
    #[error("{0:?} does not hold both depth and stencil; take Depth24PlusStencil8 or Depth32FloatStencil8")]
    NoStencil(wgpu::TextureFormat),
    /// The device was not asked for the format's feature.
    #[error("{format:?} needs {needed:?}, which the device was not made with")]
    Feature {
        /// The format.
        format: wgpu::TextureFormat,
        /// What the device lacks.
        needed: wgpu::Features,
    },
    /// No pipeline has so many samples.
    #[error("{samples} samples a pixel of {format:?} are not to be had; take one of {supported:?}")]
    Samples {
        /// Samples given.
        samples: u32,
        /// The depth-stencil format.
        format: wgpu::TextureFormat,
        /// What every device has, or with `Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES` what some have.
        supported: Vec<u32>,
    },
    /// The device makes no pipelines for the attachments: such as formats that cannot be drawn into, more of them than the
    /// device has, or samples that this adapter lacks.
    #[error("the device refuses pipelines for these attachments: {message}")]
    Refused {
        /// What the device said.
        message: String,
    },
    /// Dark caps would be cut off at the far plane.
    #[error("z-fail with a far plane needs DEPTH_CLIP_CONTROL; use an infinite far plane, or `Counting::Auto`")]
    DepthClip,
}

/// Which fragments count.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Count {
    /// Those strictly nearer than the scene: fronts up, backs down.
    Visible,
    /// The others: fronts down, backs up.
    Hidden,
    /// All: fronts up, backs down.
    Always,
}

/// All that a pipeline of volumes depends on.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct VolumeKey {
    pub(super) entry_point: &'static str,
    /// Of cap faces: which list.
    pub(super) class: u32,
    pub(super) count: Count,
    pub(super) turned: bool,
    pub(super) format: ShadowFormat,
}
