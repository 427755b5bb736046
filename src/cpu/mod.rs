//! The stages on the CPU: each a twin of the WGSL file of the same name, which tests compare bit for bit. They need no
//! driver and serve as `--device cpu`.
//!
//! Masks are laid out as on the GPU: word after word of 32 lights, within a word item after item.

mod arguments;
mod batch;
mod bounds;
mod cap_faces;
mod caps;
mod casting;
mod choose;
mod compact;
mod deform;
mod depth_arguments;
mod determinant;
mod edges;
mod exact_facing;
mod exact_shadow_depth;
mod exact_sign;
mod extraction;
mod facing;
mod filter;
mod fixed_sign;
mod paper;
mod paper_cases;
mod parallel;
mod per_edge;
mod pyramid;
mod shadow;
mod shadow_arguments;
mod shadow_boxes;
mod shadow_depth;
mod sides;
mod stencil_bound;

pub use arguments::arguments;
pub use bounds::bounds;
pub use cap_faces::{dark_cap, hole_edge, hole_side, hole_side_clipped, light_cap, near_cap, paper_cap};
pub use caps::caps;
pub use casting::{cap_class, casts};
pub use choose::choose;
pub use compact::{CompactedList, WINDING, compact};
pub use deform::{Displace, deform};
pub use depth_arguments::depth_arguments;
pub use edges::{edges, silhouettes_into};
pub use exact_facing::exact_facing;
pub use exact_shadow_depth::exactly_between;
pub use extraction::{CpuExtraction, extract};
pub use facing::{FacingCounts, facing, facing_into, is_finite};
pub use paper_cases::paper_cases;
pub use parallel::Threads;
pub(crate) use per_edge::edge_corners;
pub use per_edge::per_edge;
pub use shadow::{
    Corner, away, corner, direction_to_clip, far_end, light_side, on_near_plane, parallel_to_near_plane, star, to_clip,
};
pub use shadow_arguments::shadow_arguments;
pub(crate) use shadow_boxes::clustered;
pub use shadow_boxes::shadow_boxes;
pub use shadow_depth::shadow_depth;
pub use sides::{End, paper_side, side, side_clipped};
pub use stencil_bound::stencil_bound;
