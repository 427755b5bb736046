//! The stages on the GPU, recorded into the caller's encoder. Nothing here reads back but [`read_back`] itself and
//! [`StageTimer::read`].

mod binder;
mod buffers;
mod cache;
mod deformer;
mod extractor;
mod frame;
mod include;
mod memory;
mod model_data;
mod pass;
mod pipelines;
mod positions;
mod readback;
mod results;
mod shadow;
mod shadow_plan;
mod shadow_query;
mod split;
mod timer;

pub use deformer::{DeformError, Deformer, DeformerOptions};
pub use extractor::{EncodeError, Extractor, ExtractorError, ExtractorOptions, ListOptions};
pub use include::{IncludeError, include_wgsl, results_bind_group_layout};
pub use memory::{Allocation, MemoryError};
pub use pipelines::Pipelines;
pub use positions::{PositionBuffer, PositionError};
pub use readback::{ReadError, read_back, read_back_vec};
pub use results::Results;
pub use shadow::{
    ShadowDrawError, ShadowError, ShadowFormat, ShadowFormatError, ShadowOptions, ShadowPipelines, ShadowVolumes,
};
pub use shadow_query::{QueryError, ShadowQuery, ShadowQueryError, ShadowQueryOptions};
pub use timer::StageTimer;
