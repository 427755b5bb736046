//! The stages on the GPU. They are recorded into the caller's encoder. Only [`read_back`], its variants,
//! [`StageTimer::read`], [`Extraction::read_edges`] and [`ShadowQuery::read_occluder_counts`] read anything back.

mod common;
mod deform;
#[cfg(feature = "depth-map")]
pub mod depth_map;
mod extract;
mod mask;
mod outline;
mod query;
mod scene;
mod shadow;
mod warm_up;

pub use crate::layout::{DrawArguments, EdgeMasks, ExtractionStatistics, SceneStatistics, ShadowStatistics};
pub use common::device_error::DeviceError;
pub use common::memory::Allocation;
pub use common::pipelines::Pipelines;
pub use common::positions::PositionBuffer;
pub use common::readback::{read_back, read_back_async, read_back_vec, read_back_vec_async};
pub use common::timer::{StageTimer, StageTimes};
pub use deform::deformer::{DeformError, Deformer, DeformerOptions, PoseInputs};
pub use extract::errors::ExtractorError;
pub use extract::extraction::{Extraction, ExtractionResults};
pub use extract::extractor::Extractor;
pub use extract::include::{include_wgsl, results_bind_group_layout};
pub use extract::options::{EdgeTopology, ExtractorOptions, ListOptions, MAX_BOUNDARY_EDGES};
pub use mask::shadow_masks::{MaskInputs, ShadowMasks};
pub use outline::{Outline, OutlineError, OutlineFormat, OutlineInputs, OutlinePipeline, OutlineSource, OutlineStyle};
pub use query::errors::QueryError;
pub use query::options::ShadowQueryOptions;
pub use query::points::QueryPoints;
pub use query::shadow_query::ShadowQuery;
pub use scene::caster::{Caster, CasterPositions};
pub use scene::frame::SceneFrame;
#[doc(hidden)]
pub use scene::frame::{SceneGroupResults, SceneResults};
pub use scene::handles::{CasterHandle, LightHandle, MeshHandle, ModelHandle};
pub use scene::mask::LightMask;
pub use scene::occluded_faces::OccludedCounts;
#[doc(hidden)]
pub use scene::options::Measuring;
pub use scene::options::{Capacities, SceneOptions, StencilCounts};
pub use scene::scene::Scene;
pub use scene::view::Receivers;
pub use scene::view::{FrameInputs, View};
pub use shadow::errors::ShadowError;
pub use shadow::{ShadowFormat, ShadowPipelines};
pub use warm_up::Use;
