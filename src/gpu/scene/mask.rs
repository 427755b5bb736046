//! Sets of lights, by their bits.

use super::handles::LightHandle;
use crate::light::{MAX_LIGHTS, batches};

/// Words of a mask.
const WORDS: usize = batches(MAX_LIGHTS);

/// A set of lights: those for which a caster throws shadows, or whose shadows a view draws. A mask holds bits, not
/// lights: a light that takes the bit of a removed one replaces it in the masks, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightMask([u32; WORDS]);

impl LightMask {
    /// All lights, also those that are added later.
    pub const ALL: Self = Self([u32::MAX; WORDS]);
    /// No light.
    pub const NONE: Self = Self([0; WORDS]);

    /// Only these lights.
    pub fn only(lights: impl IntoIterator<Item = LightHandle>) -> Self {
        lights.into_iter().fold(Self::NONE, Self::with)
    }

    /// This mask with a light.
    #[must_use]
    pub fn with(mut self, light: LightHandle) -> Self {
        self.set(light.bit, true);
        self
    }

    /// This mask without a light.
    #[must_use]
    pub fn without(mut self, light: LightHandle) -> Self {
        self.set(light.bit, false);
        self
    }

    /// Whether a light is in it.
    pub fn contains(&self, light: LightHandle) -> bool {
        self.has(light.bit)
    }

    /// The bits of a batch.
    pub(crate) fn word(&self, batch: usize) -> u32 {
        self.0.get(batch).copied().unwrap_or(0)
    }

    /// The lights in both masks.
    pub(crate) fn and(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] & other.0[word]))
    }

    pub(crate) fn has(&self, bit: u32) -> bool {
        self.word(bit as usize / 32) >> (bit % 32) & 1 != 0
    }

    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::NONE
    }

    /// The number of bits up to the last light.
    pub(crate) fn bits(&self) -> u32 {
        let last = self.0.iter().rposition(|&word| word != 0);
        last.map_or(0, |last| 32 * last as u32 + 32 - self.word(last).leading_zeros())
    }

    /// The number of batches up to the last light.
    pub(crate) fn batches(&self) -> usize {
        batches(self.bits() as usize)
    }

    /// The number of lights in the first `batches` batches.
    pub(crate) fn count(&self, batches: usize) -> u32 {
        self.0.iter().take(batches).map(|word| word.count_ones()).sum()
    }

    pub(crate) fn set(&mut self, bit: u32, is_set: bool) {
        if let Some(word) = self.0.get_mut(bit as usize / 32) {
            *word = *word & !(1 << (bit % 32)) | u32::from(is_set) << (bit % 32);
        }
    }
}

/// All lights.
impl Default for LightMask {
    fn default() -> Self {
        Self::ALL
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::scene::handles::SceneId;

    #[test]
    fn masks_hold_the_bits_of_their_lights() {
        let scene = SceneId::next();
        let light = |bit| LightHandle { scene, bit, generation: 0 };
        let mask = LightMask::only([light(0), light(31), light(32), light(1023)]);
        assert_eq!([mask.word(0), mask.word(1), mask.word(31)], [1 << 31 | 1, 1, 1 << 31]);
        assert_eq!((mask.count(1), mask.count(32), mask.batches(), mask.bits()), (2, 4, 32, 1024));
        assert_eq!((LightMask::only([light(33)]).bits(), LightMask::NONE.bits()), (34, 0));
        assert!(mask.contains(light(31)) && !mask.contains(light(30)));
        assert_eq!(mask.without(light(1023)).batches(), 2);
        assert_eq!(LightMask::ALL.and(&mask), mask);
        assert!(LightMask::NONE.is_empty() && LightMask::NONE.batches() == 0);
        assert_eq!(crate::layout::bits(1 << 31 | 5).collect::<Vec<_>>(), [0, 2, 31]);
    }
}
