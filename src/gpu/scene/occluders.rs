//! Occluders: polygons on casters that cull the casters behind them. docs/numerics/scene.md, "Occluders".

use std::cmp::Reverse;
use std::sync::Arc;

use glam::{DVec3, DVec4};
use slotmap::{DefaultKey, SlotMap};

use super::caster::{CasterEntry, Content, MeshEntry, Placement, Rigid};
use super::mask::LightMask;
use super::table::{Part, Table};
use crate::Transform;
use crate::gpu::shadow::errors::ShadowError;
use crate::layout::bits;
use crate::light_batch::ScaledLight;

/// The most corners of an occluder.
pub(crate) const MOST_CORNERS: usize = 8;
/// The most occluders that are tested, and the slack, as in `wgsl/scene/cull_lights.wgsl`.
const MOST_OCCLUDERS: usize = 128;
const SLACK: f64 = 1.0 / 262_144.0;

/// The occluders in the table.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OccluderLayout {
    /// The offset of the occluders: for each batch and occluder a part.
    pub(crate) offset: usize,
    pub(crate) count: usize,
    /// The offset of the scaled lights in world space: for each batch 32 parts.
    pub(crate) lights_offset: usize,
}

/// Refuses polygons with too few or too many corners, or outside the box of the mesh.
pub(crate) fn check(number: usize, corners: &[[f32; 3]], mesh: &MeshEntry) -> Result<(), ShadowError> {
    if !(3..=MOST_CORNERS).contains(&corners.len()) {
        return Err(ShadowError::OccluderCorners { number, corners: corners.len() });
    }
    for (corner, &position) in corners.iter().enumerate() {
        if !(0..3).all(|axis| (mesh.low[axis]..=mesh.high[axis]).contains(&position[axis])) {
            return Err(ShadowError::OccluderOutside { number, corner, position });
        }
    }
    Ok(())
}

/// The occluders of a scene, with their casters.
fn occluders<'a>(
    order: &'a [DefaultKey],
    casters: &'a SlotMap<DefaultKey, CasterEntry>,
) -> impl Iterator<Item = (&'a CasterEntry, &'a Arc<[[f32; 3]]>)> {
    let casters = order.iter().filter_map(|&key| casters.get(key));
    casters.flat_map(|caster| caster.occluders.iter().map(move |corners| (caster, corners)))
}

impl OccluderLayout {
    /// Offsets from part `next` on, and the offset behind.
    pub(crate) fn new(
        order: &[DefaultKey],
        casters: &SlotMap<DefaultKey, CasterEntry>,
        batches: usize,
        next: usize,
    ) -> (Self, usize) {
        let (count, corners) =
            occluders(order, casters).fold((0, 0), |(count, all), (_, corners)| (count + 1, all + corners.len()));
        if count == 0 {
            return (Self::default(), next);
        }
        let lights_offset = next + count * batches;
        (Self { offset: next, count, lights_offset }, lights_offset + 32 * batches + corners)
    }

    /// Writes the occluders and the lights.
    pub(crate) fn write(&self, table: &mut Table, order: &[DefaultKey], content: &Content) {
        let Content { casters, lights, .. } = content;
        if self.count == 0 {
            return;
        }
        let scaled = |bit: u32| lights.get(bit).map(|light| ScaledLight::new(light.to_array()).light);
        let scaled: Vec<[f32; 4]> = (0..32 * table.batches as u32).map(|bit| scaled(bit).unwrap_or_default()).collect();
        table.put(self.lights_offset, bytemuck::cast_slice(&scaled));
        let mut corners_offset = self.lights_offset + scaled.len();
        let mut all: Vec<_> = occluders(order, casters).collect();
        if all.len() > MOST_OCCLUDERS {
            all.sort_by_cached_key(|(caster, corners)| Reverse(area(corners, &caster.placement).to_bits()));
        }
        for (number, (caster, corners)) in all.into_iter().enumerate() {
            let Placement::Rigid(rigid) = &caster.placement else { continue };
            let corners = in_world(corners, rigid);
            // A caster with excluded faces culls nothing.
            let may_cull = !caster.is_excluding() && rigid.space.is_some();
            let allowed = if may_cull { caster.lights.and(&lights.used) } else { LightMask::NONE };
            for batch in 0..table.batches {
                let [mut usable, mut facing] = [0_u32; 2];
                for bit in bits(allowed.word(batch)) {
                    let Some(&light) = scaled.get(32 * batch + bit as usize) else { continue };
                    if let Some(is_facing) = culling_side(&corners, light, rigid.is_mirrored, caster.mesh.is_closed) {
                        usable |= 1 << bit;
                        facing |= u32::from(is_facing) << bit;
                    }
                }
                let part = [usable, facing, caster.index, corners_offset as u32];
                table.put(self.offset + batch * self.count + number, &[part]);
            }
            let parts = corners.iter().map(|corner| {
                let [x, y, z] = corner.map(f32::to_bits);
                [x, y, z, corners.len() as u32]
            });
            let parts: Vec<Part> = parts.collect();
            table.put(corners_offset, &parts);
            corners_offset += parts.len();
        }
    }
}

/// Corners in world space, rounded once.
fn in_world(corners: &[[f32; 3]], rigid: &Rigid) -> Vec<[f32; 3]> {
    let matrix = Transform::from(rigid.rows).to_f64();
    corners
        .iter()
        .map(|corner| matrix.transform_point3(DVec3::from(corner.map(f64::from))).as_vec3().to_array())
        .collect()
}

/// Twice the area of a polygon in world space, whose bits do not depend on where the caster is. 0: it culls nothing.
fn area(corners: &[[f32; 3]], placement: &Placement) -> f64 {
    let Placement::Rigid(Rigid { rows, space: Some(_), .. }) = placement else { return 0.0 };
    let matrix = Transform::from(*rows).to_f64();
    let corners: Vec<DVec3> =
        corners.iter().map(|corner| matrix.transform_vector3(DVec3::from(corner.map(f64::from)))).collect();
    let Some(&first) = corners.first() else { return 0.0 };
    corners.iter().zip(corners.iter().skip(1)).map(|(&a, &b)| (a - first).cross(b - first)).sum::<DVec3>().length()
}

/// Whether a light sees the polygon counter-clockwise in world space. `None`: the polygon culls nothing for this light,
/// because it is not convex as seen from the light, is front-facing on a closed caster, or rounding leaves that open.
fn culling_side(corners: &[[f32; 3]], light: [f32; 4], is_mirrored: bool, is_closed: bool) -> Option<bool> {
    let DVec4 { x, y, z, w } = DVec4::from_array(light.map(f64::from));
    if w < 0.0 || light == [0.0; 4] {
        return None;
    }
    let corners: Vec<DVec3> = corners.iter().map(|corner| DVec3::from(corner.map(f64::from))).collect();
    let size = corners.iter().map(|corner| sum(*corner)).fold(0.0, f64::max);
    let light = DVec3::new(x, y, z);
    // The side of three corners that the light is on, 0 if rounding leaves it open.
    let sign = |a: DVec3, b: DVec3, c: DVec3| {
        let (u, v, t) = (b - a, c - a, light - w * a);
        let (light_bound, spread) = (sum(light) + w * size, sum(u) + sum(v));
        let error = SLACK * light_bound * (size * spread + 2.0 * sum(u) * sum(v)) + f64::from(f32::MIN_POSITIVE);
        let d = u.cross(v).dot(t);
        if d > error { 1 } else { -i32::from(d < -error) }
    };
    let &[first, second, third, ..] = &*corners else { return None };
    let facing = sign(first, second, third);
    let edges = corners.iter().zip(corners.iter().cycle().skip(1)).enumerate();
    let is_convex = edges.into_iter().all(|(number, (&a, &b))| {
        let others =
            corners.iter().enumerate().filter(|(other, _)| *other != number && *other != (number + 1) % corners.len());
        others.into_iter().all(|(_, &c)| sign(a, b, c) == facing)
    });
    let is_back_facing = (facing < 0) != is_mirrored;
    (facing != 0 && is_convex && (!is_closed || is_back_facing)).then_some(facing > 0)
}

/// The sum of the absolute coordinates.
fn sum(v: DVec3) -> f64 {
    v.x.abs() + v.y.abs() + v.z.abs()
}
