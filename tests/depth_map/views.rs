//! Views of scenes that are known exactly: what casts, a light with its maps, an eye, and what both see along `f64`
//! rays. Pictures are compared with rays to the light.

use std::cell::OnceCell;

use glam::{DVec2, DVec3, DVec4};
use rimline::ShadowCamera;
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Eye, Rays};
use rimline_testkit::random::Random;
use rimline_testkit::shapes;
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::parity::{clip, device_depth, middle};
use crate::picture::{Maps, REVERSED, STANDARD, look};
use crate::worlds::World;

/// Pixels along the side of what the eye sees, and texels of a map.
const SIDE: u32 = 96;
/// The distance between what casts and what is next to it as the light sees it, to tell a border from a fold.
const APART: f64 = 0.15;
/// The distance that shadow rays begin over a surface.
const OVER: f64 = 1e-6;

/// A light with the cameras of its map, or of its six.
pub(crate) struct Sun {
    /// A position, or a direction.
    at: DVec3,
    pub(crate) is_parallel: bool,
    pub(crate) cameras: Vec<ShadowCamera>,
    /// Texels along the side of a map.
    pub(crate) side: u32,
    pub(crate) rays: Vec<Rays>,
}

impl Sun {
    pub(crate) fn new(at: DVec3, is_parallel: bool, cameras: Vec<ShadowCamera>, side: u32) -> Self {
        let rays = cameras.iter().map(|camera| Rays::new(camera, side)).collect();
        Self { at, is_parallel, cameras, side, rays }
    }

    /// The position, or the direction to a light at infinity.
    pub(crate) fn homogeneous(&self) -> DVec4 {
        self.at.extend(if self.is_parallel { 0.0 } else { 1.0 })
    }

    pub(crate) fn is_lit(&self, world: &World, (point, normal): (DVec3, DVec3)) -> bool {
        let from = point + OVER * normal;
        let way = if self.is_parallel { self.at } else { self.at - from };
        let length = if self.is_parallel { f64::INFINITY } else { way.length() };
        world.first(from, way.normalize()).is_none_or(|(t, _)| t >= length)
    }

    pub(crate) fn is_back_facing(&self, (point, normal): (DVec3, DVec3)) -> bool {
        let way = if self.is_parallel { self.at } else { self.at - point };
        way.dot(normal) <= 0.0
    }

    /// The map that has a position: in a cube that whose axis is nearest to the way there.
    fn face(&self, position: DVec3) -> usize {
        let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let towards = |&face: &usize| axes[face].dot(position - self.at);
        (0..self.cameras.len()).max_by(|a, b| towards(a).total_cmp(&towards(b))).unwrap_or(0)
    }

    /// Where a point is in its map: from 0 to 1 to the right and down, and its device depth.
    pub(crate) fn in_map(&self, point: DVec3) -> DVec3 {
        let clip = clip(&self.cameras[self.face(point)], point);
        let [x, y, z] = [clip.x, clip.y, clip.z].map(|c| c / clip.w);
        DVec3::new(f64::midpoint(x, 1.0), (1.0 - y) / 2.0, z)
    }

    /// Kind of boundary within some texels of a point, seen from the light: a border if there is one, else a fold.
    fn near(&self, world: &World, (point, normal): (DVec3, DVec3), within: f64) -> Near {
        let texels = self.in_map(point).truncate() * f64::from(self.side);
        let rays = &self.rays[self.face(point)];
        let is_lit = self.is_lit(world, (point, normal));
        let at = |number: u32| {
            let offset = (DVec2::new(f64::from(number % 11), f64::from(number / 11)) / 5.0 - 1.0) * within;
            let (from, direction) = rays.at(texels + offset);
            let t = (point - from).dot(normal) / direction.dot(normal);
            let moved = (from + t * direction, normal);
            if t.is_nan() || t <= 0.0 || self.is_back_facing(moved) {
                return Near::Border;
            }
            let first = world.first(from, direction).map_or(f64::INFINITY, |(t, _)| t);
            match (is_lit, self.is_lit(world, moved)) {
                (false, true) => Near::Border,
                (true, _) if (first - t).abs() > APART => Near::Border,
                (true, false) => Near::Fold,
                (true, true) if first > t + APART / 3.0 => Near::Fold,
                _ => Near::Nothing,
            }
        };
        let mut nearest = Near::Nothing;
        for number in 0..121 {
            nearest = nearest.max(at(number));
            // There is nothing more to find.
            if nearest == Near::Border {
                break;
            }
        }
        nearest
    }
}

/// Kind of shadow boundary within some texels of a point, seen from the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Near {
    Nothing,
    /// The surface bends towards the light, so the boundary is before it.
    Fold,
    /// A border of a shadow, on the plane of the surface or where the surface ends.
    Border,
}

pub(crate) fn worlds(random: &mut Random) -> Vec<World> {
    let mut centre =
        |height: f64| DVec3::new(f64::from(random.between(-1.0, 1.0)), height, f64::from(random.between(-1.0, 1.0)));
    vec![
        World::Sphere { centre: centre(1.5), radius: 1.0 },
        World::Sphere { centre: centre(0.8), radius: 1.0 },
        World::Torus { centre: centre(1.0), major: 1.5, minor: 0.4 },
        World::Cuboid { centre: centre(1.0), half: DVec3::new(0.7, 1.0, 1.2) },
        World::Cuboid { centre: centre(2.0), half: DVec3::new(1.5, 0.02, 1.5) },
        World::mesh(&shapes::torus(24, 16, 1.5, 0.5), 1.0, centre(1.6)),
        World::mesh(&shapes::blob(3, 0.3, 5), 1.4, centre(1.9)),
    ]
}

/// The point seen through a pixel, and its normal.
pub(crate) type Seen = Option<(DVec3, DVec3)>;

/// The points that the pixels of a picture see.
fn seen(world: &World, rays: &Rays, side: u32) -> Vec<Seen> {
    let hit = |pixel| {
        let (from, direction) = rays.at(middle(pixel, side));
        world.first(from, direction).map(|(t, normal)| (from + t * direction, normal))
    };
    (0..side * side).map(hit).collect()
}

/// Device depths of what is seen.
fn depths(camera: &ShadowCamera, seen: &[Seen]) -> Vec<f32> {
    let far = if camera.depth == REVERSED { 0.0 } else { 1.0 };
    seen.iter().map(|seen| seen.map_or(far, |(position, _)| device_depth(camera, position))).collect()
}

/// A surface that the eye sees, front-facing to the light.
pub(crate) struct Receiver {
    pub(crate) pixel: usize,
    pub(crate) seen: (DVec3, DVec3),
    pub(crate) is_lit: bool,
    /// Pixels that are near, for as many bits of the stencil.
    near: [OnceCell<Near>; 8],
}

/// A world that casts, a light and an eye, and what both see, pixel by pixel.
pub(crate) struct View<'a> {
    pub(crate) world: &'a World,
    pub(crate) sun: Sun,
    light_seen: OnceCell<Vec<Vec<Seen>>>,
    pub(crate) eye: ShadowCamera,
    pub(crate) eye_seen: Vec<Seen>,
    pub(crate) receivers: Vec<Receiver>,
}

impl<'a> View<'a> {
    /// The eye sees the world `drawn`, in `pixels` along a side.
    pub(crate) fn new((world, drawn): (&'a World, &World), sun: Sun, eye: ShadowCamera, pixels: u32) -> Self {
        let rays = Rays::new(&eye, pixels);
        let eye_seen = seen(drawn, &rays, pixels);
        let receivers = (0..).zip(&eye_seen).filter_map(|(pixel, seen)| {
            let seen = (*seen)?;
            let near = [const { OnceCell::new() }; 8];
            (!sun.is_back_facing(seen)).then(|| Receiver { pixel, seen, is_lit: sun.is_lit(world, seen), near })
        });
        let receivers = receivers.collect();
        Self { world, sun, light_seen: OnceCell::new(), eye, eye_seen, receivers }
    }

    /// `None` if the near rectangle is in a body: what is seen there is no surface.
    pub(crate) fn random(random: &mut Random, world: &'a World) -> Option<Self> {
        let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
        let towards = DVec3::new(between(-0.7, 0.7), 1.0, between(-0.7, 0.7)).normalize();
        let is_parallel = between(0.0, 1.0) < 0.4;
        let depth = if between(0.0, 1.0) < 0.5 { REVERSED } else { STANDARD };
        let position = towards * 9.0;
        let (far, half_width) = if is_parallel { (Some(20.0), Some(5.0)) } else { (Some(30.0), None) };
        let camera = Eye { depth, far, half_width, ..look(position, -towards, 1.0) }.camera();
        let sun = Sun::new(if is_parallel { towards } else { position }, is_parallel, vec![camera], SIDE);
        let position = DVec3::new(between(-5.0, 5.0), between(0.6, 5.0), between(-5.0, 5.0));
        let forward = DVec3::new(between(-1.0, 1.0), between(0.0, 1.5), between(-1.0, 1.0)) - position;
        let near = if between(0.0, 1.0) < 0.3 { 1.0 } else { 0.1 };
        let eye = Eye { is_relative: false, ..look(position, forward, near) }.camera();
        let near = Rays::new(&eye, SIDE);
        let mut corners = (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
        let is_cut = corners.any(|position| world.is_inside(near.at(position).0));
        (!is_cut).then(|| Self::new((world, world), sun, eye, SIDE))
    }

    /// The points that the light sees in each map.
    pub(crate) fn light_seen(&self) -> &[Vec<Seen>] {
        let Sun { rays, side, .. } = &self.sun;
        self.light_seen.get_or_init(|| rays.iter().map(|rays| seen(self.world, rays, *side)).collect())
    }

    pub(crate) fn maps(&self, gpu: &Gpu, format: TextureFormat) -> Result<Maps, String> {
        self.moved_maps(gpu, format, 0)
    }

    /// The maps with all texels moved by so many: negative controls.
    pub(crate) fn moved_maps(&self, gpu: &Gpu, format: TextureFormat, by: usize) -> Result<Maps, String> {
        let map = |(camera, seen): (&ShadowCamera, &Vec<Seen>)| {
            let mut depths = depths(camera, seen);
            depths.rotate_right(by);
            Some(Map { size: [self.sun.side; 2], is_reversed: camera.depth == REVERSED, depths })
        };
        let maps: Vec<_> = self.sun.cameras.iter().zip(self.light_seen()).map(map).collect();
        Maps::all(gpu, (&maps, self.sun.side), format, &self.sun.cameras)
    }

    pub(crate) fn eye_depths(&self) -> Vec<f32> {
        depths(&self.eye, &self.eye_seen)
    }

    /// Kind of boundary around a receiver within a texel, and as much as bits of the stencil move it.
    pub(crate) fn near(&self, receiver: &Receiver, bits: u32) -> Near {
        let within = 1.5 - 0.5 / f64::from(bits);
        *receiver.near[bits as usize - 1].get_or_init(|| self.sun.near(self.world, receiver.seen, within))
    }
}

/// Receivers of pictures, and wrong ones.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) dark: usize,
    pub(crate) lit: usize,
    pub(crate) at_borders: usize,
    pub(crate) at_folds: usize,
    /// Elsewhere.
    pub(crate) wrong: usize,
    /// The sum of the squares of what the shares of dark bits are off by.
    pub(crate) squares: f64,
}

impl Tally {
    /// Compares the stencil of a picture with rays to the light.
    pub(crate) fn add(&mut self, view: &View<'_>, stencil: &[u8], bits: u32) {
        for receiver in &view.receivers {
            let is_lit = receiver.is_lit;
            *(if is_lit { &mut self.lit } else { &mut self.dark }) += 1;
            let dark = f64::from(stencil[receiver.pixel].count_ones()) / f64::from(bits);
            let off = dark - if is_lit { 0.0 } else { 1.0 };
            self.squares += off * off;
            if off == 0.0 {
                continue;
            }
            match view.near(receiver, bits) {
                Near::Border => self.at_borders += 1,
                Near::Fold => self.at_folds += 1,
                Near::Nothing => {
                    self.wrong += 1;
                    if self.wrong < 5 {
                        println!("pixel {}: {:?}, lit {is_lit}, stencil {dark}", receiver.pixel, receiver.seen);
                    }
                }
            }
        }
    }

    pub(crate) fn sum(&mut self, other: Self) {
        self.dark += other.dark;
        self.lit += other.lit;
        self.at_borders += other.at_borders;
        self.at_folds += other.at_folds;
        self.wrong += other.wrong;
        self.squares += other.squares;
    }

    pub(crate) fn pixels(&self) -> usize {
        self.dark + self.lit
    }
}
