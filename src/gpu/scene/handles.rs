//! Handles. Each names one thing of one scene, and nothing else after its removal.

use std::sync::atomic::{AtomicU64, Ordering};

use slotmap::DefaultKey;

use crate::gpu::shadow::errors::ShadowError;

/// The identity of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SceneId(u64);

impl SceneId {
    pub(crate) fn next() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Declares handles with a key.
macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident of a $what:literal;)*) => { $(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct $name {
            pub(crate) scene: SceneId,
            pub(crate) key: DefaultKey,
        }

        impl $name {
            pub(crate) fn key_in(self, scene: SceneId) -> Result<DefaultKey, ShadowError> {
                if self.scene == scene { Ok(self.key) } else { Err(ShadowError::OtherScene { what: $what }) }
            }
        }
    )* };
}

handles! {
    /// A mesh of a [`Scene`](crate::gpu::Scene).
    MeshHandle of a "mesh";
    /// A caster of a [`Scene`](crate::gpu::Scene).
    CasterHandle of a "caster";
    /// A model of a [`Scene`](crate::gpu::Scene).
    ModelHandle of a "model";
}

/// A light of a [`Scene`](crate::gpu::Scene). It keeps its bit until it is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightHandle {
    pub(crate) scene: SceneId,
    pub(crate) bit: u32,
    /// How many lights had this bit before.
    pub(crate) generation: u64,
}

impl LightHandle {
    /// The light's bit: bit `bit mod 32`, least significant first, of batch `bit div 32`. No two lights of a scene have
    /// the same bit at the same time.
    pub const fn bit(self) -> u32 {
        self.bit
    }
}
