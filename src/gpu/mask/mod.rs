//! Shadow masks: which lights are in shadow at each pixel, for renderers whose depth has no stencil.
//!
//! ```text
//! the caller's depth ─► mask_depth ─► depth ┐ of Rimline
//! volumes of a light ───────────────► counts┘ in the stencil ─► mask_bit ─► bits of up to 32 lights ─► mask_byte, mask_word
//!                                       ▲                           │                                  or mask_share ─► target
//!                                       └──── 0 again ──────────────┘
//! ```
//!
//! For each 32 lights one render pass records all but the last draw. `mask_bit` draws where the stencil is not 0, adds
//! the bit of the light to a colour attachment, and sets the stencil back to 0. So lights share passes and clears, depth
//! and stencil stay in the tiles of a tiled GPU, and no shader reads the stencil, which OpenGL cannot. The bits are
//! integers of 8 bits in channels of `Unorm` textures, because integer formats do not blend. Each bit is added once, so
//! nothing is rounded. A single light needs no sum: with a depth of one sample it is drawn into the target.

mod light_bounds;
mod passes;
mod pipelines;
pub(crate) mod shadow_masks;
