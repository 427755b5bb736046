//! The scene table, as the CPU references read it.

use bytemuck::Zeroable;

use crate::layout::SceneCaster;

/// The scene table, in units of 16 bytes. Reading past its end gives zero.
#[derive(Clone, Copy, Debug)]
pub struct SceneTable<'a>(pub &'a [[u32; 4]]);

impl SceneTable<'_> {
    /// A caster.
    pub fn caster(&self, index: u32) -> SceneCaster {
        let first = 8 * index as usize;
        let parts = self.0.get(first..first + 8).map(bytemuck::cast_slice::<_, SceneCaster>);
        parts.and_then(|casters| casters.first().copied()).unwrap_or(SceneCaster::zeroed())
    }

    /// Four words.
    pub fn part(&self, at: u32) -> [u32; 4] {
        self.0.get(at as usize).copied().unwrap_or_default()
    }

    /// Word `index` from part `at` on.
    pub fn word(&self, at: u32, index: u32) -> u32 {
        self.part(at + index / 4)[index as usize % 4]
    }
}
