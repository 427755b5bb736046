//! Lights as stages have them.

use bytemuck::Zeroable;

use crate::Light;
use crate::layout::LightBatch;
#[cfg(feature = "gpu")]
use crate::{Cone, layout::LightCone};

impl LightBatch {
    /// The batch of up to 32 `lights`.
    pub fn new(lights: &[Light], position_offset: u32, position_stride: u32) -> Self {
        let of_bit = |bit: usize| lights.get(bit).map(|light| light.to_array());
        Self::of_bits(of_bit, lights.len() as u32, position_offset, position_stride)
    }

    /// The batch of the lights that some of the lowest `count` bits have. The others have no bit in any mask; they
    /// repeat a light, so that nothing is left undecided for them.
    pub(crate) fn of_bits(
        light: impl Fn(usize) -> Option<[f32; 4]>,
        count: u32,
        position_offset: u32,
        position_stride: u32,
    ) -> Self {
        let mut batch = Self { count, ..Self::zeroed() };
        let last = (0..count as usize).rev().find_map(&light);
        for slot in 0..32 {
            let of_slot = if slot < count as usize { light(slot) } else { None };
            let Some(given) = of_slot.or(last) else { break };
            batch.active_bits |= u32::from(of_slot.is_some()) << slot;
            let scaled = ScaledLight::new(given);
            let [x, y, z, w] = scaled.light.map(f32::abs);
            let w = w.max(scaled.inexact_w);
            batch.lights[slot] = scaled.light;
            batch.light_bits[slot] = given.map(f32::to_bits);
            batch.inexact_w[slot / 4][slot % 4] = scaled.inexact_w;
            batch.magnitudes = [batch.magnitudes[0].max(x).max(y).max(z), batch.magnitudes[1].max(w)];
        }
        Self { position_offset, position_stride, ..batch }
    }
}

/// A w below this may be lost in scaling and products.
const TINY_W: f32 = f32::from_bits((127 - 60) << 23);
/// The value that replaces such a w in the error bounds.
const LEAST_INEXACT_W: f32 = f32::from_bits((127 - 36) << 23);

/// A light as the filter sees it. See docs/numerics/facing.md, "Filter".
pub(crate) struct ScaledLight {
    pub(crate) light: [f32; 4],
    pub(crate) inexact_w: f32,
}

impl ScaledLight {
    pub(crate) fn new(given: [f32; 4]) -> Self {
        let largest = given.iter().fold(0.0_f64, |largest, &c| largest.max(f64::from(c).abs()));
        // `check_lights` makes sure that lights are finite. Other lights give meaningless bits, but no panic.
        // In f64 neither the power of two nor the product rounds, for any finite f32.
        let scale = if largest == 0.0 || !largest.is_finite() {
            1.0
        } else {
            f64::from_bits((2046 - (largest.to_bits() >> 52)) << 52)
        };
        let light = given.map(|c| (f64::from(c) * scale) as f32);
        let w = light[3].abs();
        let is_power_of_two = w == 0.0 || w.to_bits().trailing_zeros() >= 23;
        let inexact_w = if given[3] != 0.0 && w < TINY_W {
            LEAST_INEXACT_W
        } else if is_power_of_two {
            0.0
        } else {
            w
        };
        Self { light, inexact_w }
    }
}

#[cfg(feature = "gpu")]
impl LightCone {
    /// The cone of a light. Zeros if it has none, or is at infinity.
    pub(crate) fn of(light: &Light) -> Self {
        let Some(Cone { axis, cosine }) = light.cone.filter(|_| light.w != 0.0) else { return Self::zeroed() };
        // In f64 squares of finite f32 neither overflow nor vanish.
        let [x, y, z] = axis.map(f64::from);
        let length = (x * x + y * y + z * z).sqrt();
        let [x, y, z] = [x, y, z].map(|c| (c / length) as f32);
        let [apex_x, apex_y, apex_z] = light.xyz.map(|c| (f64::from(c) / f64::from(light.w)) as f32);
        Self { apex: [apex_x, apex_y, apex_z, 1.0], axis: [x, y, z, cosine] }
    }
}
