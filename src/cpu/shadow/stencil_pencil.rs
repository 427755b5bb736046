//! Stencil pencil: the pencil of half planes that bounds the stencil counts of a light, from the boxes of the casters.

use glam::Vec3;

use crate::layout::StencilPencil;

/// Bins of a pencil.
pub(super) const BINS: usize = 1024;
/// Values of [`StencilPencil::kind`].
const PARALLEL: u32 = 0;
const FAN: u32 = 1;
pub(super) const AROUND: u32 = 2;

/// A caster that casts: the corners of its box in world space, and the number of its faces.
#[derive(Clone, Copy, Debug)]
pub struct CastingBox {
    /// The lowest corner.
    pub low: [f32; 3],
    /// The highest corner.
    pub high: [f32; 3],
    /// Faces.
    pub faces: u32,
}

impl CastingBox {
    fn corners(&self) -> [Vec3; 2] {
        [self.low.into(), self.high.into()]
    }
}

/// The pencil for `light`, which is homogeneous in world space, and the casters that cast for it. It has no meaning
/// without casters.
pub fn stencil_pencil(light: [f32; 4], casters: &[CastingBox]) -> StencilPencil {
    let corners = casters.iter().map(CastingBox::corners);
    let whole = corners.reduce(|[low, high], [other_low, other_high]| [low.min(other_low), high.max(other_high)]);
    let [low, high] = whole.unwrap_or_default();
    let [x, y, z, w] = light;
    let mut by: StencilPencil = bytemuck::Zeroable::zeroed();
    by.kind = if w > 0.0 { FAN } else { PARALLEL };
    let place = if by.kind == FAN { Vec3::new(x, y, z) / w } else { Vec3::ZERO };
    by.place = place.to_array();
    let forward = if by.kind == FAN { place.clamp(low, high) - place } else { -Vec3::new(x, y, z) };
    let size = forward.abs().max_element();
    if by.kind == FAN && size <= slack(place, low, high) {
        return around(by, casters);
    }
    let forward = forward / size;
    let a = forward.abs();
    let aside = if a.y <= a.x && a.y <= a.z {
        Vec3::new(-forward.z, 0.0, forward.x)
    } else if a.z <= a.x {
        Vec3::new(forward.y, -forward.x, 0.0)
    } else {
        Vec3::new(0.0, forward.z, -forward.y)
    };
    (by.forward, by.aside) = (forward.to_array(), aside.to_array());
    let corner =
        |number: u32| Vec3::from_array(std::array::from_fn(|axis| [low, high][(number >> axis & 1) as usize][axis]));
    let places = (0..8).map(|number| by.half_plane(corner(number)));
    let (first, last) =
        places.fold((f32::INFINITY, f32::NEG_INFINITY), |(first, last), at| (first.min(at), last.max(at)));
    (by.first, by.scale) = (first, BINS as f32 / (last - first).max(1e-30));
    by
}

/// The pencil around the coordinate axis that may meet the fewest faces.
fn around(by: StencilPencil, casters: &[CastingBox]) -> StencilPencil {
    let faces_met = |axis: usize| -> u32 {
        let met = casters.iter().filter(|caster| axis_meets(by.place.into(), axis, caster));
        met.map(|caster| caster.faces).sum()
    };
    let [x, y, z] = [0, 1, 2].map(faces_met);
    let axis = if y <= x && y <= z {
        1
    } else if z <= x {
        2
    } else {
        0
    };
    let unit = |axis: usize| std::array::from_fn(|at| if at == axis % 3 { 1.0 } else { 0.0 });
    let (forward, aside) = (unit(axis + 1), unit(axis + 2));
    StencilPencil { kind: AROUND, forward, aside, first: 0.0, scale: BINS as f32 / 4.0, ..by }
}

/// Whether the coordinate axis through `place` may meet the caster's box.
fn axis_meets(place: Vec3, axis: usize, caster: &CastingBox) -> bool {
    let [low, high] = caster.corners();
    let slack = slack(place, low, high);
    let within = |at: usize| low[at] - slack <= place[at] && place[at] <= high[at] + slack;
    (0..3).all(|at| at == axis || within(at))
}

/// How near the light may be to a box before nothing is said about the side that it is on.
fn slack(place: Vec3, low: Vec3, high: Vec3) -> f32 {
    4.0 * (4e-6 * low.abs().max(high.abs()).max(place.abs())).max_element()
}

impl StencilPencil {
    /// Whether the axis of the pencil may meet a caster's box.
    pub(super) fn meets(&self, caster: &CastingBox) -> bool {
        let is_axis = |axis: &usize| self.forward[*axis] == 0.0 && self.aside[*axis] == 0.0;
        let axis = (0..3).find(is_axis).unwrap_or(2);
        self.kind == AROUND && axis_meets(self.place.into(), axis, caster)
    }

    /// The number of the half plane in which a position is.
    pub(super) fn half_plane(&self, position: Vec3) -> f32 {
        let d = position - Vec3::from(self.place);
        let dot = |[x, y, z]: [f32; 3]| x * d.x + y * d.y + z * d.z;
        let v = dot(self.aside);
        match self.kind {
            PARALLEL => v,
            FAN => v / dot(self.forward),
            _ => turn(dot(self.forward), v),
        }
    }
}

/// From 0 to 4, once around. It grows with the angle.
fn turn(u: f32, v: f32) -> f32 {
    let along = u / (u.abs() + v.abs()).max(1e-30);
    if v >= 0.0 { 1.0 - along } else { 3.0 + along }
}
