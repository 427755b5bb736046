//! Planes that the light sees at grazing angles, or in several maps of a cube, where the moved surface passes from map
//! to map: what lies on a plane is lit, and what lies behind it is dark.

use glam::DVec3;
use rimline::gpu::depth_map::{DepthMapCube, DepthMapMethod, DepthMapOptions};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Eye, Rays, vector};
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use wgpu::TextureFormat;

use crate::boundary::sample;
use crate::maps::Map;
use crate::parity::{SIDE, clip, device_depth, either, middle};
use crate::picture::{AUTOMATIC, EVERY_CELL, Maps, REVERSED, Target, by, look};

pub(crate) const TESTS: &[Test] = &[
    ("planes_at_grazing_angles_have_no_specks", grazing),
    ("cubes_have_no_gaps_and_no_specks_where_maps_meet", across_maps),
];

/// A plane by a point on it and its normal, towards the light.
#[derive(Clone, Copy)]
struct Plane(DVec3, DVec3);

impl Plane {
    fn met(&self, (from, ray): (DVec3, DVec3)) -> f64 {
        (self.0 - from).dot(self.1) / ray.dot(self.1)
    }

    /// The map of a camera, which sees the plane up to a distance.
    fn map(&self, camera: &ShadowCamera, side: u32, most: f64) -> Map {
        let (rays, is_reversed) = (Rays::new(camera, side), camera.depth == DepthDirection::Reversed);
        Map::new([side; 2], is_reversed, |texel| {
            let (from, ray) = rays.at(middle(texel, side));
            let t = self.met((from, ray));
            if (0.0..most).contains(&t) { device_depth(camera, from + t * ray) } else { f32::from(!is_reversed) }
        })
    }

    /// Dark pixels of the plane, of those where `is_counted`, and how many these are.
    fn dark(
        &self,
        gpu: &Gpu,
        (maps, options): (&Maps, DepthMapOptions),
        eye: ShadowCamera,
        is_counted: impl Fn(DVec3, f64) -> bool,
    ) -> Result<[usize; 2], String> {
        let rays = Rays::new(&eye, SIDE);
        let point = |pixel| {
            let (from, ray) = rays.at(middle(pixel, SIDE));
            let t = self.met((from, ray));
            let point = from + t * ray;
            is_counted(point, t).then_some(point)
        };
        let points: Vec<_> = (0..SIDE * SIDE).map(point).collect();
        let far = if eye.depth == REVERSED { 0.0 } else { 1.0 };
        let depths: Vec<_> = points.iter().map(|point| point.map_or(far, |point| device_depth(&eye, point))).collect();
        let stencil = Target::new(eye, &depths).stencil(gpu, maps, options)?;
        let counted = points.iter().zip(stencil).filter(|(point, _)| point.is_some());
        Ok(counted.fold([0; 2], |[dark, all], (_, value)| [dark + usize::from(value != 0), all + 1]))
    }
}

/// Pixels on planes and behind them, and wrong ones.
#[derive(Debug, Default)]
struct Tally([[usize; 2]; 2]);

impl Tally {
    fn add(&mut self, is_behind: bool, [dark, all]: [usize; 2]) {
        let [seen, wrong] = &mut self.0[usize::from(is_behind)];
        *seen += all;
        *wrong += if is_behind { all - dark } else { dark };
    }

    fn check(&self, least: usize) -> Result<(), String> {
        println!("{self:?}");
        let is_right = self.0.iter().all(|&[seen, wrong]| seen > least && wrong == 0);
        if is_right { Ok(()) } else { Err(format!("{self:?}")) }
    }
}

/// The light sees a plane at an angle near 90° from its normal. Points on the plane are seen from above, points behind
/// it by more than the bias from below.
fn grazing() -> Result<(), String> {
    const TEXELS: u32 = 64;
    let (gpu, mut random) = Gpu::seeded(16_402)?;
    let mut tally = Tally::default();
    for round in 0..if is_long() { 300 } else { 15 } {
        let angle = f64::to_radians([85.0, 88.0, 89.5, 89.9, 89.99][round % 5]);
        let depth = either(&mut random);
        let forward = vector(&mut random);
        let across = forward.cross(vector(&mut random)).normalize();
        // From the light's direction the normal is turned away by the angle.
        let normal = (-forward * angle.cos() + forward.cross(across) * angle.sin()).normalize();
        let plane = Plane(DVec3::ZERO, normal);
        // So small a map that the plane passes from near to far within 30 texels of 64.
        let texel = 18.0 / (30.0 * angle.tan());
        let half_width = f64::from(TEXELS) / 2.0 * texel;
        let (far, is_relative) = (Some(19.0), random.below(2) == 0);
        let light = look(-10.0 * forward, forward, 1.0);
        let camera = Eye { depth, far, half_width: Some(half_width), is_relative, ..light }.camera();
        let map = plane.map(&camera, TEXELS, 18.0);
        let maps = Maps::of(&gpu, &map, TextureFormat::Depth32Float, camera)?;
        // Along the plane, and away from the light.
        let along = (forward - forward.dot(normal) * normal).normalize();
        let foot = f64::from(random.between(-6.0, 6.0)) * along;
        // The bias is half of a texel's diagonal at most, which along the light is as much times the tangent, and four steps.
        let behind = 0.75 * texel * angle.tan() + 0.01;
        for (is_below, method) in [(false, EVERY_CELL), (false, AUTOMATIC), (true, EVERY_CELL), (true, AUTOMATIC)] {
            let half_width = Some(half_width * f64::from(random.between(0.3, 1.5)));
            // The eye looks at the plane, or from below at what lies behind it.
            let tilt = f64::from(random.between(-0.5, 0.5)) * along;
            let away = (if is_below { -normal } else { normal } + tilt).normalize();
            let target = if is_below { foot + behind * forward } else { foot };
            let eye = look(target + 2.0 * away, -away, if is_below { 0.5 } else { 0.1 });
            let eye = Eye { far: Some(10.0), half_width, ..eye }.camera();
            // In the map, with two texels to spare, and the plane there.
            let is_counted = |position: DVec3, _| {
                let clip = clip(&camera, position);
                let [x, y] =
                    [clip.x, -clip.y].map(|at| (f64::midpoint(at / clip.w, 1.0) * f64::from(TEXELS)).floor() as i64);
                (-2..=2).all(|down| (-2..=2).all(|across| sample(&map, x + across, y + down).is_some()))
            };
            tally.add(is_below, Plane(target, normal).dark(&gpu, (&maps, by(method)), eye, is_counted)?);
        }
    }
    tally.check(10_000)
}

/// The samples of six maps, and an eye on the light's side of the plane, which looks at a position that is not far from
/// the light's foot.
fn across_maps() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1657)?;
    let mut tally = Tally::default();
    for _ in 0..80 {
        let side = 9 + random.below(20) as u32;
        let depth = either(&mut random);
        let light = vector(&mut random).as_vec3();
        let cameras = DepthMapCube::cameras(light.to_array(), 0.2, None, depth, side).map_err(text)?;
        let (light, normal) = (light.as_dvec3(), vector(&mut random));
        let height = f64::from(random.between(1.0, 3.0));
        let foot = light - height * normal;
        let plane = Plane(foot, normal);
        let maps = cameras.map(|camera| Some(plane.map(&camera, side, 1e4)));
        let maps = Maps::all(&gpu, (&maps, side), TextureFormat::R32Float, &cameras)?;
        let aside = vector(&mut random);
        let target = foot + f64::from(random.between(0.0, 1.5)) * height * (aside - aside.dot(normal) * normal);
        let away = vector(&mut random);
        let away = away * away.dot(normal).signum();
        let position = target + f64::from(random.between(0.5, 4.0)) * away + 0.3 * normal;
        let eye = Eye { depth, ..look(position, target - position, 0.05) }.camera();
        // The move takes at most half of what is left to infinity, which is twice the distance. Behind the plane
        // nothing of it is in the eye's depth.
        for (is_behind, behind) in [(false, 0.0), (true, 1.2 * height)] {
            let is_counted = |point: DVec3, t: f64| {
                let way = point - light;
                (0.0..100.0).contains(&t) && -way.dot(normal) > 0.4 * way.length()
            };
            let options = by(DepthMapMethod::EveryCell);
            let found = Plane(foot - behind * normal, normal).dark(&gpu, (&maps, options), eye, is_counted)?;
            tally.add(is_behind, found);
        }
    }
    tally.check(20_000)
}
