//! The content of a scene.

use std::sync::Arc;

use slotmap::{DefaultKey, SlotMap};

use super::caster::{CasterEntry, MeshEntry};
use super::lights::Lights;
use super::pages::Pages;

/// Meshes with the pages that hold them, casters, and lights.
#[derive(Debug)]
pub(crate) struct Content {
    /// Each caster of a mesh has it, too.
    pub(crate) meshes: SlotMap<DefaultKey, Arc<MeshEntry>>,
    pub(crate) pages: Pages,
    pub(crate) casters: SlotMap<DefaultKey, CasterEntry>,
    pub(crate) lights: Lights,
}
