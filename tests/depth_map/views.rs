//! Views of scenes that are known exactly: what casts, a light with its map, an eye, and what both see along `f64` rays.

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};
use rimline::gpu::depth_map::DepthMetric;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::random::Random;
use rimline_testkit::shapes;

use crate::distances::Measured;
use crate::parity::device_depth;
use crate::scene::{Eye, Rays};
use crate::worlds::World;

/// Pixels along the side of what the eye sees, and of a map if nothing else is said.
pub(crate) const SIDE: u32 = 96;
/// The distance between what casts and what is next to it as the light sees it, to tell a border from a fold.
const APART: f64 = 0.15;
/// The distance that shadow rays begin over a surface.
const OVER: f64 = 1e-6;

pub(crate) struct Sun {
    /// A place, or a direction.
    at: DVec3,
    pub(crate) is_parallel: bool,
    pub(crate) camera: ShadowCamera,
}

impl Sun {
    /// A light at a place, or in a direction, with the camera of its map or one of them.
    pub(crate) fn new(at: DVec3, is_parallel: bool, camera: ShadowCamera) -> Self {
        Self { at, is_parallel, camera }
    }

    /// The place, or the direction to a light at infinity.
    pub(crate) fn homogeneous(&self) -> DVec4 {
        self.at.extend(if self.is_parallel { 0.0 } else { 1.0 })
    }

    pub(crate) fn is_lit(&self, world: &World, point: DVec3, normal: DVec3) -> bool {
        let from = point + OVER * normal;
        let way = if self.is_parallel { self.at } else { self.at - from };
        let length = if self.is_parallel { f64::INFINITY } else { way.length() };
        world.first(from, way.normalize()).is_none_or(|(t, _)| t >= length)
    }

    pub(crate) fn is_averted(&self, point: DVec3, normal: DVec3) -> bool {
        let way = if self.is_parallel { self.at } else { self.at - point };
        way.dot(normal) <= 0.0
    }

    /// Where a point is in the map: from 0 to 1 to the right and down, and its device depth.
    pub(crate) fn in_map(&self, point: DVec3) -> DVec3 {
        let origin = DVec3::from_array(self.camera.origin.map(f64::from));
        let matrix = Mat4::from_cols_array_2d(&self.camera.view_projection).as_dmat4();
        let clip = matrix * (point - origin).extend(1.0);
        let [x, y, z] = [clip.x, clip.y, clip.z].map(|c| c / clip.w);
        DVec3::new(f64::midpoint(x, 1.0), (1.0 - y) / 2.0, z)
    }
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
pub(crate) fn seen(world: &World, rays: &Rays, size: [u32; 2]) -> Vec<Seen> {
    let place = |texel: u32| DVec2::new(f64::from(texel % size[0]) + 0.5, f64::from(texel / size[0]) + 0.5);
    let hit = |texel| {
        let (from, direction) = rays.at(place(texel));
        world.first(from, direction).map(|(t, normal)| (from + t * direction, normal))
    };
    (0..size[0] * size[1]).map(hit).collect()
}

/// Device depths of what is seen.
pub(crate) fn depths(camera: &ShadowCamera, seen: &[Seen]) -> Vec<f32> {
    let far = if camera.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    seen.iter().map(|seen| seen.map_or(far, |(place, _)| device_depth(camera, place))).collect()
}

/// The map of a cube that looks a way.
pub(crate) fn face_towards(way: DVec3) -> usize {
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    (0..6).max_by(|&a, &b| axes[a].dot(way).total_cmp(&axes[b].dot(way))).unwrap_or(0)
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

/// Kind of boundary around a point that a pixel sees: a border if there is one, else a fold.
pub(crate) fn what_is_near(
    (world, sun): (&World, &Sun),
    (rays, side): (&Rays, u32),
    within: f64,
    (point, normal): (DVec3, DVec3),
) -> Near {
    let texels = sun.in_map(point).truncate() * f64::from(side);
    let is_lit = sun.is_lit(world, point, normal);
    let at = |number: u32| {
        let offset = (DVec2::new(f64::from(number % 11), f64::from(number / 11)) / 5.0 - 1.0) * within;
        let (from, direction) = rays.at(texels + offset);
        let t = (point - from).dot(normal) / direction.dot(normal);
        let moved = from + t * direction;
        if t.is_nan() || t <= 0.0 || sun.is_averted(moved, normal) {
            return Near::Border;
        }
        let first = world.first(from, direction).map_or(f64::INFINITY, |(t, _)| t);
        match (is_lit, sun.is_lit(world, moved, normal)) {
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

/// How the map of a light is taken.
#[derive(Clone, Copy)]
pub(crate) struct MapOf {
    /// Texels along the side.
    pub(crate) side: u32,
    /// The near and the far plane, if they are others.
    pub(crate) planes: Option<(f64, Option<f64>)>,
    /// The angle by which it is turned around the light's direction.
    pub(crate) turn: f64,
}

impl Default for MapOf {
    fn default() -> Self {
        Self { side: SIDE, planes: None, turn: 0.0 }
    }
}

/// A world, a light and an eye, and what both see of it, pixel by pixel.
pub(crate) struct View<'a> {
    pub(crate) world: &'a World,
    pub(crate) sun: Sun,
    /// Texels along the side of the map.
    pub(crate) side: u32,
    pub(crate) light_rays: Rays,
    pub(crate) light_seen: Vec<Seen>,
    pub(crate) eye: ShadowCamera,
    pub(crate) eye_seen: Vec<Seen>,
}

impl<'a> View<'a> {
    /// `None` if the near rectangle is in a body: what is seen there is no surface.
    pub(crate) fn random(random: &mut Random, world: &'a World) -> Option<Self> {
        Self::lit(random, world, MapOf::default())
    }

    /// The same with another map.
    pub(crate) fn lit(random: &mut Random, world: &'a World, MapOf { side, planes, turn }: MapOf) -> Option<Self> {
        let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
        let towards = DVec3::new(between(-0.7, 0.7), 1.0, between(-0.7, 0.7)).normalize();
        let is_parallel = between(0.0, 1.0) < 0.4;
        let depth = if between(0.0, 1.0) < 0.5 { DepthDirection::Reversed } else { DepthDirection::Standard };
        let place = towards * 9.0;
        let (far, half_width) = if is_parallel { (Some(20.0), Some(5.0)) } else { (Some(30.0), None) };
        let (near, far) = planes.map_or((1.0, far), |(near, own)| (near, if is_parallel { own.or(far) } else { own }));
        let sun = Eye { place, forward: -towards, near, is_relative: true, depth, far, half_width };
        let mut camera = sun.camera();
        let turned = DMat4::from_rotation_z(turn) * Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        camera.view_projection = turned.as_mat4().to_cols_array_2d();
        let sun = Sun { at: if is_parallel { towards } else { place }, is_parallel, camera };
        let place = DVec3::new(between(-5.0, 5.0), between(0.6, 5.0), between(-5.0, 5.0));
        let forward = DVec3::new(between(-1.0, 1.0), between(0.0, 1.5), between(-1.0, 1.0)) - place;
        let near = if between(0.0, 1.0) < 0.3 { 1.0 } else { 0.1 };
        let depth = DepthDirection::Reversed;
        let eye = Eye { place, forward, near, is_relative: false, depth, far: None, half_width: None }.camera();
        let eye_rays = Rays::new(&eye, SIDE);
        let mut near = (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
        if near.any(|place| world.is_inside(eye_rays.at(place).0)) {
            return None;
        }
        let light_rays = Rays::new(&sun.camera, side);
        let light_seen = seen(world, &light_rays, [side; 2]);
        let eye_seen = seen(world, &eye_rays, [SIDE; 2]);
        Some(Self { world, sun, side, light_rays, light_seen, eye, eye_seen })
    }

    /// Depths of the map and of the eye's depth buffer.
    pub(crate) fn depths(&self) -> [Vec<f32>; 2] {
        [depths(&self.sun.camera, &self.light_seen), depths(&self.eye, &self.eye_seen)]
    }

    /// Distances in place of the map's depths.
    pub(crate) fn distances(&self, metric: DepthMetric) -> Vec<f32> {
        let measured = Measured::new(&self.sun.camera);
        let distance = |(place, _): (DVec3, DVec3)| measured.distance(metric, place) as f32;
        self.light_seen.iter().map(|seen| seen.map_or(f32::INFINITY, distance)).collect()
    }

    /// Surfaces front-facing to the light that the eye sees: index of the pixel, point and normal.
    pub(crate) fn receivers(&self) -> impl Iterator<Item = (usize, (DVec3, DVec3))> {
        let seen = self.eye_seen.iter().enumerate().filter_map(|(pixel, seen)| Some((pixel, (*seen)?)));
        seen.filter(|&(_, (point, normal))| !self.sun.is_averted(point, normal))
    }

    /// Whether light reaches a place.
    pub(crate) fn is_lit(&self, (point, normal): (DVec3, DVec3)) -> bool {
        self.sun.is_lit(self.world, point, normal)
    }

    /// Kind of shadow boundary within some texels of a point, seen from the light.
    pub(crate) fn near(&self, seen: (DVec3, DVec3), within: f64) -> Near {
        what_is_near((self.world, &self.sun), (&self.light_rays, self.side), within, seen)
    }
}
