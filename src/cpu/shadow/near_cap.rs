//! Near caps on the CPU, which benches compare with the caps of others. The WGSL is `wgsl/shadow/shadow.wgsl` and
//! `wgsl/shadow/vertices.wgsl`. docs/numerics/shadow-volumes.md.

use glam::{Vec3, Vec4};

use crate::layout::{ShadowLight, ShadowView};

/// An end of an edge: index and position of its vertex.
pub type End = (u32, [f32; 3]);

/// A vertex of a volume.
#[derive(Clone, Copy)]
struct Corner {
    /// The vertex in clip space.
    near: Vec4,
    /// The height over the near plane, positive in front of the camera.
    height: f32,
    /// The far vertex: the direction away from the light, times the light's w, in clip space.
    far: Vec4,
    /// The height of the far vertex over the near plane: the light's w times the height, less the light's height.
    far_height: f32,
    /// Whether the light is farther from the vertex than the origin of positions is. [`project_to_near_plane`] then
    /// computes with V, else with V − L.
    is_far: bool,
}

fn size_3(a: Vec3) -> f32 {
    a.x.abs().max(a.y.abs()).max(a.z.abs())
}

/// Makes the signs of `height` and `far_height` consistent despite rounding. A vertex above the near plane rises if the
/// light is below the plane. A vertex below it does not rise if the light is not below.
fn consistent_rise(light: &ShadowLight, height: f32, far_height: f32) -> f32 {
    match (light.height < 0.0, height < 0.0) {
        (false, true) => far_height.min(-1e-37),
        (true, false) => far_height.max(0.0),
        _ => far_height,
    }
}

/// Written out, so that all devices compute the same.
fn dot_3(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

fn columns(view: &ShadowView) -> [Vec4; 4] {
    view.view_projection.map(Vec4::from_array)
}

/// The normal and the constant of the near plane.
fn near_plane(view: &ShadowView) -> (Vec3, f32) {
    let [x, y, z, w] = view.near_plane;
    (Vec3::new(x, y, z), w)
}

/// A direction in the camera's frame.
fn turned(view: &ShadowView, d: Vec3) -> Vec3 {
    Vec3::from(view.placement.map(|[x, y, z, _]| dot_3(Vec3::new(x, y, z), d)))
}

/// A position in the camera's frame.
fn placed(view: &ShadowView, position: [f32; 3]) -> Vec3 {
    turned(view, Vec3::from(position)) + Vec3::from(view.placement.map(|[.., w]| w))
}

/// A position in clip space. A caller's depth pass gets the same bits if it computes positions in this way.
fn to_clip(view: &ShadowView, position: [f32; 3]) -> Vec4 {
    let q = placed(view, position);
    let [x, y, z, w] = columns(view);
    x * q.x + y * q.y + z * q.z + w
}

/// The vector from the light to a position, times the light's w, in the camera's frame.
fn extrusion(view: &ShadowView, light: &ShadowLight, position: [f32; 3]) -> Vec3 {
    let [x, y, z, w] = light.light;
    turned(view, w * Vec3::from(position) - Vec3::new(x, y, z))
}

/// A direction in clip space: a point at infinity.
fn direction_to_clip(view: &ShadowView, direction: Vec3) -> Vec4 {
    let [x, y, z, _] = columns(view);
    x * direction.x + y * direction.y + z * direction.z
}

/// Computes the values that a volume's vertices are made of.
fn corner(view: &ShadowView, light: &ShadowLight, position: [f32; 3]) -> Corner {
    let d = extrusion(view, light, position);
    let q = placed(view, position);
    let (normal, constant) = near_plane(view);
    let height = dot_3(normal, q) + constant;
    Corner {
        near: to_clip(view, position),
        height,
        far: direction_to_clip(view, d),
        far_height: consistent_rise(light, height, dot_3(normal, d)),
        is_far: size_3(d) > light.light[3] * size_3(q),
    }
}

/// The light's side of the near plane: −1 in front of the plane, on the eye's side, else 1.
fn light_side(light: &ShadowLight) -> f32 {
    if light.height < 0.0 { -1.0 } else { 1.0 }
}

/// The vertex, projected from the light onto the near plane.
fn project_to_near_plane(view: &ShadowView, light: &ShadowLight, v: &Corner) -> Vec4 {
    let s = light_side(light);
    let [x, y, ..] = light.clip;
    let (at_light, weight) = (glam::Vec2::new(x, y), light.light[3]);
    let (xy, w) = if v.is_far {
        (v.near.truncate().truncate() * light.height - at_light * v.height, view.near_w * v.far_height)
    } else {
        (v.far.truncate().truncate() * light.height - at_light * v.far_height, view.near_w * (weight * v.far_height))
    };
    let xy = s * xy;
    Vec4::new(xy.x, xy.y, -s * w * view.near_z, -s * w)
}

/// The intersection of an edge with the near plane. `a` is the vertex of lower index.
fn on_near_plane(view: &ShadowView, a: &Corner, b: &Corner) -> Vec4 {
    let t = a.height / (a.height - b.height);
    let xy = a.near + (b.near - a.near) * t;
    Vec4::new(xy.x, xy.y, view.near_z * view.near_w, view.near_w)
}

/// The point of an edge whose far direction is parallel to the near plane. `a` is the vertex of lower index.
fn parallel_to_near_plane(a: &Corner, b: &Corner) -> Vec4 {
    let t = a.far_height / (a.far_height - b.far_height);
    let xy = a.far + (b.far - a.far) * t;
    Vec4::new(xy.x, xy.y, 0.0, 0.0)
}

/// The part of a face between the light and the near plane, projected from the light onto the near plane, in clip
/// space. It has up to five vertices, or more only if rounding has moved a light onto the near plane. The shader draws
/// the first five.
pub fn near_cap(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> Vec<Vec4> {
    let corners = face.map(|(index, position)| (index, corner(view, light, position)));
    let [a, b, c] = corners;
    let mut polygon = Vec::with_capacity(5);
    for [(a_index, a), (b_index, b)] in [[a, b], [b, c], [c, a]] {
        let a_above = a.height >= 0.0;
        let a_rises = a.far_height >= 0.0;
        let (first, second) = if a_index < b_index { (&a, &b) } else { (&b, &a) };
        let meeting = (a_above != (b.height >= 0.0)).then(|| on_near_plane(view, first, second));
        let turning = (a_rises != (b.far_height >= 0.0)).then(|| parallel_to_near_plane(first, second));
        polygon.extend((a_above != a_rises).then(|| project_to_near_plane(view, light, &a)));
        if a_above == (light_side(light) > 0.0) {
            polygon.extend(turning.into_iter().chain(meeting));
        } else {
            polygon.extend(meeting.into_iter().chain(turning));
        }
    }
    polygon
}
