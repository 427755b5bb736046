//! Faces that other faces hide from a light, as the scene keeps them.

use std::sync::Arc;

use slotmap::DefaultKey;

use super::handles::LightHandle;

/// The hidden faces that were found for a light, and their casters.
#[derive(Debug)]
pub(super) struct HiddenOfLight {
    pub(super) light: LightHandle,
    /// The light's bits at the time.
    pub(super) bits: [u32; 4],
    pub(super) casters: Vec<HiddenSource>,
    /// All hidden faces.
    pub(super) count: usize,
    /// Whether the scene leaves these faces out.
    pub(super) is_used: bool,
}

#[derive(Debug)]
pub(super) struct HiddenSource {
    pub(super) key: DefaultKey,
    pub(super) version: Option<u64>,
    /// Slots of hidden faces.
    pub(super) slots: Arc<[u32]>,
}
