//! Lights with a range, and boxes at its very end, near the origin of the boxes' space and far away from it.

use glam::{DMat3, DVec3};
use rimline::internals::layout::{ShadowLight, ShadowView};
use rimline::internals::shadow;
use rimline::{Light, ShadowCamera};

use crate::random::Random;
use crate::scenes::direction;

/// A light and the box of a caster, in the space of the caster's positions.
pub struct RangeCase {
    /// The light as the stages have it. It has no range.
    pub light: ShadowLight,
    /// At most the smallest factor from lengths in this space to lengths in the world.
    pub scale: f32,
    pub low: [f32; 3],
    pub high: [f32; 3],
    /// From light to box, times `scale`.
    pub distance: f64,
    /// The largest coordinate of light and box, times `scale`.
    pub size: f64,
}

impl RangeCase {
    /// The caster is in world space, or rigid. `product` multiplies the light of a rigid one, as `light_for_caster` does
    /// (wgsl/shadow/caster.wgsl). `None` if the caster's matrix has no inverse.
    pub fn random(
        random: &mut Random,
        (camera, view): (&ShadowCamera, &ShadowView),
        mut product: impl FnMut(f32, f32) -> f32,
    ) -> Option<Self> {
        let far = random.between(-20.0, 30.0).exp2();
        let w = [1.0, 3.0, random.between(0.1, 5.0), random.between(-20.0, 10.0).exp2()][random.below(4)];
        let [x, y, z] = random.direction().map(|c| c * far * w);
        let given = Light::homogeneous([x, y, z, w]);
        let mut light = shadow::light(camera, view, given);
        let mut position = DVec3::from_array(given.xyz.map(f64::from)) / f64::from(w);
        let mut scale = 1.0_f32;
        if random.below(2) == 0 {
            let (matrix, translation) = placement(random, f64::from(far));
            let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, translation].map(|column| column.to_array());
            let moved = given.to_mesh_space(&columns)?;
            for (scaled, moved) in light.light.iter_mut().zip(moved.xyz) {
                *scaled = product(moved, light.scale);
            }
            let inverse = matrix.inverse();
            position = inverse * (position - translation);
            // The norm is at least the largest singular value.
            let norm = inverse.to_cols_array().iter().map(|c| c * c).sum::<f64>().sqrt();
            scale = (norm.recip() as f32).next_down();
        }
        let [low, high] = box_beside(random, position);
        let [lowest, highest] = [low, high].map(|corner| DVec3::from_array(corner.map(f64::from)));
        let apart = (lowest - position).max(position - highest).max(DVec3::ZERO).length();
        let largest = lowest.abs().max(highest.abs()).max(position.abs()).max_element();
        let factor = f64::from(scale);
        Some(Self { light, scale, low, high, distance: factor * apart, size: factor * largest })
    }

    /// A range that just reaches the box, by more than `f64` rounds.
    pub fn reaching(&self) -> f32 {
        let range = self.distance + 1e-11 * self.size;
        let near = range as f32;
        if f64::from(near) < range { near.next_up() } else { near }
    }

    /// A range that clearly does not reach the box, if there is one.
    pub fn short(&self) -> Option<f32> {
        let range = self.distance * (1.0 - 1e-5) - 2e-6 * self.size;
        (range > 0.0).then_some(range as f32)
    }
}

/// A matrix of numbers that `f32` holds, and a translation.
fn placement(random: &mut Random, far: f64) -> (DMat3, DVec3) {
    let turn = |random: &mut Random| DMat3::from_axis_angle(direction(random), f64::from(random.between(0.0, 6.0)));
    let sizes = DVec3::from_array([0; 3].map(|_: i32| f64::from(random.between(-4.0, 4.0)).exp2()));
    let matrix = turn(random) * DMat3::from_diagonal(sizes) * turn(random);
    let translation = direction(random) * [0.0, far][random.below(2)];
    (DMat3::from_cols_array(&matrix.to_cols_array().map(|c| f64::from(c as f32))), translation.as_vec3().as_dvec3())
}

/// A box whose sides are on either side of a position, or around it, and small beside its coordinates, or large.
fn box_beside(random: &mut Random, position: DVec3) -> [[f32; 3]; 2] {
    let near = position.abs().max_element() * f64::from(random.between(-22.0, 3.0)).exp2();
    let sides = position.to_array().map(|c| {
        let unit = f64::from(random.between(-1.0, 1.0));
        let [from, extent] = [[unit, 0.5 * unit.abs()], [unit, 0.0], [-1.0, 2.0]][random.below(3)];
        [c + near * from, c + near * (from + extent)].map(|side| side as f32)
    });
    [sides.map(|[low, _]| low), sides.map(|[_, high]| high)]
}
