//! Hidden volumes: whether no receiver can be in the shadow volume of a box. The WGSL is `wgsl/shadow/visibility.wgsl`.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use super::choose::{distance_below, length_of};
use super::pyramid::{SLACK, clip_size, height_size, is_out};
use super::receivers::{RECEIVERS_HEAD, TILE, depth_of_key};
use super::seen::{Bounds, extrusion_size};
use super::shadow::{direction_to_clip, dot_3, extrusion, near_plane, placed, to_clip};
use crate::layout::{ShadowLight, ShadowView};

/// How far a volume goes until it has left the box of the receivers.
enum Reach {
    /// No receiver is beyond any place of the caster.
    Nowhere,
    /// To the far vertices `d + factor · light`, of a light at a place.
    Place(f32),
    /// To the far vertices `V + factor · d`, of a light at infinity.
    Far(f32),
    /// To infinity, of a light at infinity.
    Endless,
}

/// Whether no receiver can be in the shadow volume of a box of [`bounds`](super::bounds::bounds), in the space of the camera.
/// `receivers` is what [`receiver_pyramid`](super::receiver_pyramid::receiver_pyramid) returns.
pub fn is_hidden(view: &ShadowView, light: &ShadowLight, bounds: [u32; 7], receivers: &[u32]) -> bool {
    let word = |at: usize| receivers.get(at).copied().unwrap_or(0);
    if word(4) == 0 {
        return true;
    }
    let Some(caster) = Bounds::of(bounds) else { return false };
    let reach = reach(view, light, caster, receivers);
    if matches!(reach, Reach::Nowhere) {
        return true;
    }
    let mut hull = Hull::new(view);
    for position in caster.corners() {
        let terms = placed_size(view, position);
        let place = placed(view, position);
        let near = Vertex {
            clip: to_clip(view, position),
            size: clip_size(view, terms),
            height: dot_3(near_plane(view).0, place) + near_plane(view).1,
            height_size: height_size(view, terms),
        };
        hull.take(view, &near);
        let (away, terms) = (extrusion(view, light, position), extrusion_size(view, light, position));
        let mut far = Vertex {
            clip: direction_to_clip(view, away),
            size: clip_size(view, terms),
            height: dot_3(near_plane(view).0, away),
            height_size: dot_3(near_plane(view).0.abs(), terms),
        };
        match reach {
            Reach::Place(factor) => {
                let clip = Vec4::from_array(light.clip);
                far.clip += factor * clip;
                far.size += factor * clip.abs();
                far.height += factor * light.height;
                far.height_size += factor * light.height.abs();
            }
            Reach::Far(factor) => {
                far = Vertex {
                    clip: near.clip + factor * far.clip,
                    size: near.size + factor * far.size,
                    height: near.height + factor * far.height,
                    height_size: near.height_size + factor * far.height_size,
                }
            }
            Reach::Nowhere | Reach::Endless => {}
        }
        hull.take(view, &far);
    }
    hull.is_hidden(view, receivers)
}

fn reach(view: &ShadowView, light: &ShadowLight, caster: Bounds, receivers: &[u32]) -> Reach {
    let word = |at: usize| receivers.get(at).copied().unwrap_or(0);
    let corner = |at: usize| Vec3::from([0, 1, 2].map(|axis| f32::from_bits(word(at + axis))));
    let (is_limited, near, far) = (word(5) != 0, corner(6), corner(9));
    let [x, y, z, w] = light.light;
    if w > 0.0 {
        if !is_limited {
            return Reach::Place(0.0);
        }
        let l = [x / w, y / w, z / w];
        let place = placed(view, l);
        let size = near.abs().max(far.abs()) + placed_size(view, l);
        let apart = (near - place).abs().max((far - place).abs()) + SLACK * size;
        let factor = (1.0 - SLACK) * distance_below(light, caster) / length_of(apart);
        let most = f32::from_bits((127 + 100) << 23);
        return match factor {
            factor if factor > 1.0 && factor < most => Reach::Nowhere,
            factor if factor > 0.0 && factor <= 1.0 => Reach::Place(factor),
            _ => Reach::Place(0.0),
        };
    }
    if !is_limited {
        return Reach::Endless;
    }
    let d = extrusion(view, light, [0.0; 3]);
    let (mut farthest, mut size) = (0.0, 0.0);
    for axis in 0..3 {
        farthest += (near[axis] * d[axis]).max(far[axis] * d[axis]);
        size += near[axis].abs().max(far[axis].abs()) * d[axis].abs();
    }
    let mut nearest = f32::from_bits((127 + 127) << 23);
    for position in caster.corners() {
        nearest = nearest.min(dot_3(placed(view, position), d));
        size = size.max(dot_3(placed_size(view, position), d.abs()));
    }
    let beyond = farthest - nearest + 4.0 * SLACK * size;
    if beyond < 0.0 { Reach::Nowhere } else { Reach::Far((1.0 + SLACK) * beyond.max(0.0) / dot_3(d, d)) }
}

/// Bounds on the terms whose sums are a place in the camera's frame.
fn placed_size(view: &ShadowView, position: [f32; 3]) -> Vec3 {
    let q = Vec3::from(position).abs();
    Vec3::from(view.placement.map(|[x, y, z, w]| dot_3(Vec3::new(x, y, z).abs(), q) + w.abs()))
}

/// A vertex in clip space, its height over the near plane, and bounds on the terms of both.
struct Vertex {
    clip: Vec4,
    size: Vec4,
    height: f32,
    height_size: f32,
}

/// The hull of vertices in clip space.
struct Hull {
    /// Whether all are outside the left, right, bottom and top plane.
    out: [bool; 4],
    is_before: bool,
    /// Whether all are in front of the near plane. Only then the rest is known.
    is_ahead: bool,
    low: Vec2,
    high: Vec2,
    nearest: f32,
}

impl Hull {
    fn new(view: &ShadowView) -> Self {
        let most = f32::from_bits((127 + 127) << 23);
        let (low, high, nearest) = (Vec2::splat(most), Vec2::splat(-most), 1.0 - view.near_z);
        Self { out: [true; 4], is_before: true, is_ahead: true, low, high, nearest }
    }

    fn take(&mut self, view: &ShadowView, &Vertex { clip, size, height, height_size }: &Vertex) {
        let values = [clip.w + clip.x, clip.w - clip.x, clip.w + clip.y, clip.w - clip.y];
        let sizes = [size.w + size.x, size.w + size.x, size.w + size.y, size.w + size.y];
        for ((out, value), size) in self.out.iter_mut().zip(values).zip(sizes) {
            *out &= is_out(value, size);
        }
        self.is_before &= is_out(height, height_size);
        let [tiny, huge] = [f32::from_bits((127 - 10) << 23), f32::from_bits((127 + 100) << 23)];
        let is_finite = size.to_array().iter().all(|&size| size < huge);
        self.is_ahead &= height > SLACK * height_size && clip.w > tiny * size.w && is_finite;
        if self.is_ahead {
            let place = clip.xyz() / clip.w;
            let error = 2.0 * SLACK * (size.xyz() + place.abs() * size.w) / clip.w;
            self.low = self.low.min(place.truncate() - error.truncate());
            self.high = self.high.max(place.truncate() + error.truncate());
            self.nearest = if view.near_z == 0.0 {
                self.nearest.min(place.z - error.z)
            } else {
                self.nearest.max(place.z + error.z)
            };
        }
    }

    fn is_hidden(&self, view: &ShadowView, receivers: &[u32]) -> bool {
        if self.out.contains(&true) || self.is_before {
            return true;
        }
        if !self.is_ahead {
            return false;
        }
        match farthest_through(self.low, self.high, receivers) {
            0 => true,
            key if view.near_z == 0.0 => self.nearest > depth_of_key(key, 0.0),
            key => self.nearest < depth_of_key(key, view.near_z),
        }
    }
}

/// The key of the farthest receiver that is seen through a rectangle, and a pixel around.
fn farthest_through(low: Vec2, high: Vec2, receivers: &[u32]) -> u32 {
    let word = |at: u32| receivers.get(at as usize).copied().unwrap_or(0);
    let pixels = Vec2::new(word(2) as f32, word(3) as f32);
    let begin = (Vec2::new(low.x, -high.y) * 0.5 + 0.5) * pixels - 1.0;
    let end = (Vec2::new(high.x, -low.y) * 0.5 + 0.5) * pixels + 1.0;
    let tile = |place: Vec2| place.clamp(Vec2::ZERO, pixels - 1.0).to_array().map(|c| c as u32 / TILE);
    let (mut first, mut last, mut cells) = (tile(begin), tile(end), [word(0), word(1)]);
    let mut level = RECEIVERS_HEAD as u32;
    while last[0] - first[0] > 3 || last[1] - first[1] > 3 {
        level += cells[0] * cells[1];
        cells = cells.map(|cells| cells.div_ceil(2));
        (first, last) = (first.map(|at| at / 2), last.map(|at| at / 2));
    }
    let rows = first[1]..=last[1];
    rows.flat_map(|y| (first[0]..=last[0]).map(move |x| word(level + y * cells[0] + x))).max().unwrap_or(0)
}
