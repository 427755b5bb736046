//! The content of a scene.

use slotmap::{DefaultKey, SlotMap};

use super::caster::{CasterEntry, MeshEntry};
use super::lights::Lights;
use super::pages::Pages;
use super::sources::Sources;

/// Meshes with the pages that hold them, casters with the sources of their positions, and lights.
#[derive(Debug)]
pub(crate) struct Content {
    pub(crate) meshes: SlotMap<DefaultKey, MeshEntry>,
    pub(crate) pages: Pages,
    pub(crate) casters: SlotMap<DefaultKey, CasterEntry>,
    pub(crate) sources: Sources,
    pub(crate) lights: Lights,
}
