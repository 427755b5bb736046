//! The scene table, as the twins read it.

use bytemuck::Zeroable;

use crate::layout::{CasterLights, LightCone, SceneCaster, SceneDispatch};

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

    /// The lights of a caster in a batch.
    pub fn lights(&self, group: &SceneDispatch, index: u32, batch: u32) -> CasterLights {
        bytemuck::cast(self.part(group.lights_at + batch * group.casters + index))
    }

    /// The cone of a light.
    pub fn cone(&self, group: &SceneDispatch, light: u32) -> LightCone {
        let at = group.ranges_at + 16 * group.batches + 1 + 2 * light;
        bytemuck::cast([self.part(at), self.part(at + 1)])
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
