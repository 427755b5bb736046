//! Uniforms of a frame and of its lights.

use glam::{Mat4, Vec3};

use crate::state::bounds::Bounds;
use crate::state::camera::Camera;
use crate::state::lamp::{Lamp, LampKind};
use crate::state::viewer::Viewer;

/// Layout of `Frame` in `scene.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Frame {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 3],
    ground: f32,
    right: [f32; 3],
    scale_x: f32,
    up: [f32; 3],
    scale_y: f32,
    forward: [f32; 3],
    exposure: f32,
    ambient: [f32; 3],
    fade_begin: f32,
    backdrop: [f32; 3],
    fade_end: f32,
    size: [f32; 2],
    centre: [f32; 2],
    is_smooth: u32,
    reserved: [u32; 3],
}

/// Layout of `Lamp` in `scene.wgsl`, at the distance that offsets of uniforms need.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct LampData {
    light: [f32; 4],
    color: [f32; 3],
    range: f32,
    axis: [f32; 3],
    cone_scale: f32,
    cone_offset: f32,
    number: u32,
    reserved: [u32; 50],
}

/// Ambient light, of all lights' together, and the share of light that the ground reflects.
const AMBIENT: f32 = 0.27;
const GROUND: Vec3 = Vec3::new(0.80, 0.79, 0.77);

impl Frame {
    pub(super) fn new(viewer: &Viewer, camera: &Camera) -> Self {
        let (bounds, ground) = (viewer.bounds(), viewer.ground());
        let lamps = || viewer.lamps.iter().filter(|lamp| lamp.is_on);
        let brightest = lamps().map(Lamp::shine).sum::<Vec3>().max_element();
        let brightest = if brightest > 0.0 { brightest } else { 1.0 };
        let ambient = AMBIENT * brightest * Vec3::new(0.86, 0.95, 1.08);
        let centre = bounds.centre().with_y(ground);
        // No shadow fades with the ground.
        let begin = (1.8 * bounds.extent()).max(1.1 * reach(viewer, &bounds, ground));
        let around = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|side| centre + 2.6 * begin * side);
        // The backdrop is as bright as the lit ground, so that the ground fades into it unseen.
        let lit = |lamp: &Lamp| around.iter().map(|&place| on_ground(lamp, place)).sum::<f32>() / 4.0 * lamp.shine();
        let backdrop = GROUND * (ambient + lamps().map(lit).sum::<Vec3>());
        let view_projection: Mat4 = camera.view_projection();
        Self {
            view_projection: view_projection.to_cols_array_2d(),
            eye: camera.eye.into(),
            ground: ground - camera.eye.y,
            right: camera.right.into(),
            scale_x: camera.scale.x,
            up: camera.up.into(),
            scale_y: camera.scale.y,
            forward: camera.forward.into(),
            exposure: 1.12 / ((1.0 + AMBIENT) * brightest),
            ambient: ambient.into(),
            fade_begin: begin,
            backdrop: backdrop.into(),
            fade_end: 3.3 * begin,
            size: camera.size.into(),
            centre: [centre.x - camera.eye.x, centre.z - camera.eye.z],
            is_smooth: u32::from(viewer.options.smooth),
            reserved: [0; 3],
        }
    }

    /// Whether the ground is seen from above.
    pub(super) fn sees_ground(&self) -> bool {
        self.ground < 0.0
    }
}

/// How far from below the models their shadows on the ground lie, within some extents.
fn reach(viewer: &Viewer, bounds: &Bounds, ground: f32) -> f32 {
    const MOST: f32 = 12.0;
    let most = MOST * bounds.extent();
    let shadow = |lamp: &Lamp, corner: Vec3| {
        let away = match lamp.kind {
            LampKind::Point(at) => corner - at,
            LampKind::Sun(towards) => -towards,
        };
        let along = (ground - corner.y) / away.y;
        let there = if along > 0.0 && along.is_finite() { corner + along * away } else { corner };
        (there - bounds.centre()).with_y(0.0).length()
    };
    let lamps = viewer.lamps.iter().filter(|lamp| lamp.is_on);
    lamps.flat_map(|lamp| bounds.corners().map(|corner| shadow(lamp, corner))).fold(0.0, f32::max).min(most)
}

/// The share of a light that a place on the ground gets, if nothing is in between.
fn on_ground(lamp: &Lamp, place: Vec3) -> f32 {
    match lamp.kind {
        LampKind::Sun(towards) => towards.y.max(0.0),
        LampKind::Point(at) => {
            let towards = at - place;
            let share = lamp.range.map_or(1.0, |range| (1.0 - towards.length() / range).clamp(0.0, 1.0));
            let [scale, offset] = cone_ramp(lamp);
            let axis = lamp.cone.map_or(Vec3::ZERO, |(axis, _)| axis);
            let within = (offset - scale * axis.dot(towards.normalize_or_zero())).clamp(0.0, 1.0);
            share * within * within * towards.normalize_or_zero().y.max(0.0)
        }
    }
}

/// Scale and offset of the cosine that make the square root of a cone's share.
fn cone_ramp(lamp: &Lamp) -> [f32; 2] {
    lamp.cone.map_or([0.0, 1.0], |(_, angle)| {
        let [inner, outer] = [0.8 * angle, angle].map(f32::cos);
        let scale = (inner - outer).max(1e-3).recip();
        [scale, -outer * scale]
    })
}

impl LampData {
    /// Bytes from one to the next.
    pub(super) const STRIDE: u64 = size_of::<Self>() as u64;
    /// Bytes that shaders see.
    pub(super) const BOUND: u64 = 64;

    pub(super) fn new(lamp: &Lamp, number: usize, eye: Vec3) -> Self {
        let light = match lamp.kind {
            LampKind::Point(at) => (at - eye).extend(1.0),
            LampKind::Sun(towards) => towards.extend(0.0),
        };
        let [cone_scale, cone_offset] = cone_ramp(lamp);
        let is_point = matches!(lamp.kind, LampKind::Point(_));
        let cone = lamp.cone.filter(|_| is_point);
        Self {
            light: light.into(),
            color: lamp.shine().into(),
            range: lamp.range.filter(|_| is_point).unwrap_or(0.0),
            axis: cone.map_or([0.0; 3], |(axis, _)| axis.into()),
            cone_scale: if cone.is_some() { cone_scale } else { 0.0 },
            cone_offset: if cone.is_some() { cone_offset } else { 1.0 },
            number: number as u32,
            reserved: [0; 50],
        }
    }
}
