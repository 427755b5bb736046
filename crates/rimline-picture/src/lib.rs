//! The pictures of Rimline's command and viewer: models as matte clay on a ground, lit by lights whose shadows are
//! counted in the stencil.
//!
//! [`Resources`] has what all pictures of a device share. [`PicturePipelines`] draws a [`Subject`], which knows its surfaces
//! and draws its own shadow volumes, into [`Targets`]. Nothing here waits for the device. The crate makes no promise of
//! stability.

mod bindings;
mod bounds;
mod camera;
mod colors;
mod factory;
mod frame;
mod lights;
mod normals;
mod overlay;
mod passes;
mod resources;
mod smoothing;
mod surface;
mod targets;

pub use bindings::{READ_ONLY, UNIFORM, depth_format, filled, group, layout, read_texture};
pub use bounds::{Bounds, SceneBounds};
pub use camera::Camera;
pub use colors::corner_colors;
pub use factory::{
    COMMON, LARGEST, MULTIPLY, PipelineDescriptor, PipelineFactory, color_pass, depth_state, plain_texture, view,
};
pub use frame::{PARTS, Part, SceneView};
pub use lights::{ShadedLight, reach};
pub use normals::corner_normals;
pub use overlay::{OVERLAY, VolumeOverlay, overlay_descriptor};
pub use passes::{Mode, Onto, PicturePipelines, ReceiverPass, ReceiverPipelines, Subject};
pub use resources::Resources;
pub use smoothing::{NormalPipeline, Normals, Smoothing};
pub use surface::{FacingMasks, OPPOSITE, Surface, SurfaceBuffers, TURNED};
pub use targets::{Attachments, PictureFormat, Target, Targets};
