//! Near caps that are skipped: pictures do not change, and `depth_near` and `depth_near_walls` decide by the samples
//! around the near rectangle.

use glam::DVec3;
use rimline::ShadowCamera;
use rimline::gpu::depth_map::DepthMapOptions;
use rimline::internals::depth_map::{DepthMapNearCap, near_box};
use rimline::internals::layout::DepthNearBox;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, same};
use wgpu::TextureFormat;

use crate::closed::distance;
use crate::cube::{Cube, cube_of};
use crate::maps::Map;
use crate::parity::{any_eye, light, map, seen, seen_depths};
use crate::picture::{AUTOMATIC, Encoded, Maps, REVERSED, STANDARD, Target, Volumes, by, contours, look, pipelines};
use crate::rules::{cast, rank};
use crate::scene::{Eye, Rays, vector};
use rimline_testkit::textures::read;

pub(crate) const TESTS: &[Test] = &[
    ("skipped_near_caps_change_no_picture", of_maps),
    ("near_caps_beyond_the_far_plane_are_drawn", beyond),
    ("skipped_near_caps_of_cubes_change_no_picture", of_cubes),
];

const SIDE: u32 = 40;
const CUBE_SIDE: u32 = 24;

/// Pictures by their near caps: skipped, skipped by the GPU, drawn by the GPU, drawn. And dark pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    known: [usize; 4],
    dark: usize,
    /// Pictures whose result changes if surfaces are never nearer: the negative control.
    others: usize,
}

impl Tally {
    /// Draws a picture with near caps always and where they may matter. `may_be_before`: whether surfaces before it are
    /// in a box.
    fn add(
        &mut self,
        gpu: &Gpu,
        target: &Target<'_>,
        (maps, options): (&Maps, DepthMapOptions),
        may_be_before: &dyn Fn(&Encoded, &DepthNearBox) -> Result<bool, String>,
    ) -> Result<(), String> {
        let (all, encoded) = target.draw(gpu, maps, DepthMapOptions { skip_near_caps: false, ..options })?;
        same("without the switch", &[encoded.frame.near_cap()], &[&DepthMapNearCap::Drawn])?;
        let (stencil, encoded) = target.draw(gpu, maps, options)?;
        same(&format!("{options:?}"), &stencil, &all)?;
        let has_walls = options.method != AUTOMATIC;
        let near = near_box(&maps.lights, maps.size, (&target.eye, target.format), has_walls);
        let may_be_dark = near.map_or(Ok(false), |near| may_be_before(&encoded, &near))?;
        let other = near.map(|near| DepthNearBox { key: 0, distance: i32::MIN, ..near });
        self.others += usize::from(may_be_dark != other.map_or(Ok(false), |near| may_be_before(&encoded, &near))?);
        let kind = match encoded.frame.near_cap() {
            DepthMapNearCap::Skipped => 0,
            DepthMapNearCap::Indirect(draw) => {
                same("the draw", &gpu.read::<u32>(draw, 4)?, &[if may_be_dark { 3 } else { 0 }, 1, 0, 0])?;
                1 + usize::from(may_be_dark)
            }
            DepthMapNearCap::Drawn => 3,
        };
        self.known[kind] += 1;
        self.dark += stencil.iter().filter(|&&value| value != 0).count();
        Ok(())
    }

    fn check(&self, what: &str, least: [usize; 4]) -> Result<(), String> {
        println!("{what}: {self:?}");
        let is_tried = self.known.iter().zip(least).all(|(&known, least)| known >= least);
        if self.dark > 1000 && is_tried && self.others > 4 { Ok(()) } else { Err(format!("{what}: {self:?}")) }
    }
}

/// The samples of a box.
fn samples(near: &DepthNearBox) -> impl Iterator<Item = [u32; 2]> {
    let ([x, y], [across, down]) = (near.first, near.size);
    (y..y + down).flat_map(move |y| (x..x + across).map(move |x| [x, y]))
}

/// Whether triangles between the samples may be nearer than the near rectangle. Texel 0 comes after a border.
fn may_be_before(map: &Map, border: i64, near: &DepthNearBox) -> bool {
    let depth = |[x, y]: [u32; 2]| cast(map, i64::from(x) - border, i64::from(y) - border);
    samples(near).any(|at| depth(at).is_some_and(|depth| rank(map, Some(depth)) <= i64::from(near.key)))
}

/// Whether surfaces that go on up to contours may be. A sample moves nearer by the largest step to a neighbour that is
/// farther away, in each direction.
fn may_be_before_walls(map: &Map, near: &DepthNearBox) -> bool {
    let nearest = |at: [i32; 2]| {
        let distance_here = distance(map, at)?;
        let nearing = |[x, y]: [i32; 2]| {
            let beside = [[at[0] - x, at[1] - y], [at[0] + x, at[1] + y]];
            beside
                .into_iter()
                .filter_map(|there| distance(map, there))
                .map(|other| (other - distance_here).max(0))
                .max()
        };
        Some(distance_here - nearing([1, 0]).unwrap_or(0) - nearing([0, 1]).unwrap_or(0))
    };
    let mut nearest = samples(near).filter_map(|at| nearest(at.map(|at| at as i32)));
    nearest.any(|distance| distance <= i64::from(near.distance))
}

/// An eye near the scene, and the depths that it sees. Its near plane is near or far away from it.
fn looking(random: &mut Random, position: f64) -> (ShadowCamera, Vec<f32>) {
    let position = position * f64::from(random.between(0.1, 1.0)) * vector(random);
    let near = [[0.01, 0.3], [0.3, 3.0]][random.below(2)];
    let eye = any_eye(random, position, near);
    let rays = Rays::new(&eye, SIDE);
    let seen = seen(random, &rays);
    (eye, seen_depths(&eye, SIDE, &seen))
}

/// Eyes farther away than any depth of the map. Far is no surface, but a map may clamp to it what is behind: all is drawn.
fn beyond() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let map = Map::new([9, 9], false, |_| 0.5);
    let (position, forward) = (DVec3::new(0.5, 1.0, -2.0), DVec3::Z);
    for (depth, half_width) in [(STANDARD, None), (STANDARD, Some(2.0)), (REVERSED, None), (REVERSED, Some(2.0))] {
        let light = Eye { depth, far: Some(2.5), half_width, ..look(position, forward, 0.5) }.camera();
        let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, light)?;
        for along in [0.6, 2.0, 2.6, 4.5, 8.0, 8.9, 1e5] {
            let eye = Eye { depth, ..look(position + along * forward, forward, 1e-3) }.camera();
            let encoded = Encoded::new(&gpu, &*pipelines(&gpu, depth, 0..1)?, &maps, &eye, by(AUTOMATIC))?;
            same(&format!("{depth:?}, {half_width:?}, {along} away"), &[encoded.has_cap()], &[along > 1.0])?;
        }
    }
    Ok(())
}

/// Maps with five texels each way for each of others, into one bit and into two, and with walls.
fn of_maps() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1695)?;
    let mut tallies = [Tally::default(); 3];
    for round in 0..if is_long() { 3000 } else { 300 } {
        let (camera, _) = light(&mut random);
        let small = map(&mut random, &camera);
        let [across, down] = small.size.map(|texels| 5 * texels);
        let texel = |at: u32| small.depths[(at / across / 5 * small.size[0] + at % across / 5) as usize];
        let map = Map::new([across, down], small.is_reversed, texel);
        let (eye, depths) = looking(&mut random, [8.0, 24.0][round % 2]);
        let way = round % 3;
        let options = by([AUTOMATIC, AUTOMATIC, contours([0.005, 0.25, 0.02])][way]);
        let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, camera)?;
        let target = Target { bits: 0..[1, 2, 1][way], ..Target::new(eye, &depths) };
        tallies[way].add(&gpu, &target, (&maps, options), &|_, near| {
            Ok(if way == 2 { may_be_before_walls(&map, near) } else { may_be_before(&map, 1, near) })
        })?;
    }
    tallies.iter().zip(["maps", "bits", "walls"]).try_for_each(|(tally, what)| tally.check(what, [10, 4, 10, 0]))
}

fn of_cubes() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1696)?;
    let mut tally = Tally::default();
    for _ in 0..if is_long() { 1000 } else { 60 } {
        let Cube { light, cameras, maps, .. } = cube_of(&mut random, CUBE_SIDE);
        let (eye, depths) = looking(&mut random, 5.0 + light.length());
        let given = Maps::all(&gpu, (&maps, CUBE_SIDE), TextureFormat::R32Float, &cameras)?;
        tally.add(&gpu, &Target::new(eye, &depths), (&given, by(AUTOMATIC)), &|encoded, near| {
            let Volumes::Cube(volumes) = &encoded.volumes else { return Err("no cube".to_owned()) };
            let depths = read(&gpu, volumes.texture().texture())?;
            // Six maps in one, without a border.
            let size = [3 * CUBE_SIDE, 2 * CUBE_SIDE];
            Ok(may_be_before(&Map { size, is_reversed: cameras[0].depth == REVERSED, depths }, 0, near))
        })?;
    }
    tally.check("cubes", [0, 5, 5, 5])
}
