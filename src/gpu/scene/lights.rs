//! The lights of a scene. Each has a bit that it keeps.

use std::sync::Arc;

use super::handles::{LightHandle, SceneId};
use super::mask::LightMask;
use crate::gpu::shadow::errors::ShadowError;
use crate::light::{MAX_LIGHTS, check_room, check_shadow_lights};
use crate::{Cone, Light};

/// A bit, and the light that has it.
#[derive(Clone, Debug, Default)]
struct Bit {
    light: Option<Light>,
    generation: u64,
    /// The first encode with the light as it is.
    version: u32,
}

/// The lights of a scene, by their bits. A new light takes the lowest free bit, so that few lights take few batches.
/// (The crate slotmap gives the bit that became free last.)
#[derive(Debug)]
pub(crate) struct Lights {
    scene: SceneId,
    limit: usize,
    bits: Vec<Bit>,
    /// The bits in use.
    pub(crate) used: LightMask,
    /// Lights that changed since the last encode.
    pub(crate) moved: LightMask,
}

impl Lights {
    pub(crate) fn new(scene: SceneId, limit: usize) -> Result<Self, ShadowError> {
        check_room(limit)?;
        Ok(Self { scene, limit, bits: Vec::new(), used: LightMask::NONE, moved: LightMask::NONE })
    }

    pub(crate) fn add(&mut self, light: Light) -> Result<LightHandle, ShadowError> {
        check_shadow_lights(&[light], MAX_LIGHTS)?;
        let free = self.bits.iter().position(|bit| bit.light.is_none()).unwrap_or(self.bits.len());
        if free >= self.limit {
            return Err(ShadowError::NoLightBit { limit: self.limit });
        }
        if free == self.bits.len() {
            self.bits.push(Bit::default());
        }
        let generation = self.bits.get(free).map_or(0, |bit| bit.generation);
        let handle = LightHandle { scene: self.scene, bit: free as u32, generation };
        self.put(handle, Some(light));
        Ok(handle)
    }

    pub(crate) fn set(&mut self, handle: LightHandle, light: Light) -> Result<(), ShadowError> {
        self.check(handle)?;
        check_shadow_lights(&[light], MAX_LIGHTS)?;
        let cone_bits = |Cone { axis: [x, y, z], cosine }: Cone| [x, y, z, cosine].map(f32::to_bits);
        let bits =
            |light: Light| (light.to_array().map(f32::to_bits), light.range.to_bits(), light.cone.map(cone_bits));
        if self.get(handle.bit).map(bits) != Some(bits(light)) {
            self.put(handle, Some(light));
        }
        Ok(())
    }

    pub(crate) fn remove(&mut self, handle: LightHandle) -> Result<(), ShadowError> {
        self.check(handle)?;
        self.put(handle, None);
        Ok(())
    }

    pub(crate) fn check(&self, handle: LightHandle) -> Result<(), ShadowError> {
        if handle.scene != self.scene {
            return Err(ShadowError::OtherScene { what: "light" });
        }
        match self.bits.get(handle.bit as usize) {
            Some(bit) if bit.light.is_some() && bit.generation == handle.generation => Ok(()),
            _ => Err(ShadowError::Removed { what: "light" }),
        }
    }

    fn put(&mut self, handle: LightHandle, light: Option<Light>) {
        if let Some(bit) = self.bits.get_mut(handle.bit as usize) {
            bit.light = light;
            bit.generation = handle.generation + u64::from(light.is_none());
        }
        self.used.set(handle.bit, light.is_some());
        self.moved.set(handle.bit, true);
    }

    /// Gives this encode's version to lights that changed.
    pub(crate) fn update_versions(&mut self, encode: u32) {
        let Self { bits, moved, .. } = self;
        for (_, bit) in (0..).zip(bits).filter(|(bit, _)| moved.has(*bit)) {
            bit.version = encode;
        }
        *moved = LightMask::NONE;
    }

    pub(crate) fn version(&self, bit: u32) -> u32 {
        self.bits.get(bit as usize).map_or(0, |bit| bit.version)
    }

    pub(crate) fn get(&self, bit: u32) -> Option<Light> {
        self.bits.get(bit as usize).and_then(|bit| bit.light)
    }

    /// All lights, in the order of their bits.
    pub(crate) fn listed(&self) -> Arc<[(LightHandle, Light)]> {
        let listed = |(bit, &Bit { light, generation, .. }): (u32, &Bit)| {
            light.map(|light| (LightHandle { scene: self.scene, bit, generation }, light))
        };
        (0..).zip(&self.bits).filter_map(listed).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_free_bit_is_taken_and_old_handles_are_stale() {
        let light = Light::point([1.0, 2.0, 3.0]);
        let mut lights = Lights::new(SceneId::next(), 3).expect("room");
        let handles: Vec<_> = (0..3).map(|_| lights.add(light).expect("room")).collect();
        assert_eq!(handles.iter().map(|handle| handle.bit()).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(lights.add(light), Err(ShadowError::NoLightBit { limit: 3 }));
        lights.remove(handles[2]).expect("there");
        lights.remove(handles[0]).expect("there");
        let again = lights.add(light).expect("room");
        assert_eq!(again.bit(), 0);
        assert_ne!(again, handles[0]);
        assert_eq!(lights.set(handles[0], light), Err(ShadowError::Removed { what: "light" }));
        assert_eq!(lights.remove(handles[2]), Err(ShadowError::Removed { what: "light" }));
        let other = Lights::new(SceneId::next(), 3).expect("room");
        assert_eq!(other.check(again), Err(ShadowError::OtherScene { what: "light" }));
        assert_eq!(lights.listed().len(), 2);
    }
}
