//! Shadows of distance fields and meshes against rays to the light: a wrong pixel is at most a texel of the map away from
//! the border of a shadow.

use glam::{DVec2, DVec3};
use rimline::gpu::{DepthEdges, DepthMapOptions};
use rimline::{DepthDirection, ShadowCamera};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::random::Random;
use rimline_measure::shapes;
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::parity::device_depth;
use crate::picture::Picture;
use crate::scene::{Eye, Rays};
use crate::textures::{objects, texture};
use crate::worlds::World;

pub(crate) const TESTS: &[Test] = &[
    ("shadows_are_right_but_for_a_texel", every_cell),
    ("shadows_of_marked_cells_are_right_but_for_a_texel", marked),
    ("shadows_of_edges_of_objects_are_right_but_for_a_texel", of_objects),
    ("a_map_that_is_off_by_three_texels_is_noticed", off),
    ("borders_of_more_bits_are_nearer_to_the_truth", of_bits),
];

const SIDE: u32 = 96;
/// The distance between what casts and what is next to it as the light sees it, to tell a border from a fold.
const APART: f64 = 0.15;
/// The distance that shadow rays begin over a surface.
const OVER: f64 = 1e-6;

struct Sun {
    /// A place, or a direction.
    at: DVec3,
    is_parallel: bool,
    camera: ShadowCamera,
}

impl Sun {
    fn is_lit(&self, world: &World, point: DVec3, normal: DVec3) -> bool {
        let from = point + OVER * normal;
        let way = if self.is_parallel { self.at } else { self.at - from };
        let length = if self.is_parallel { f64::INFINITY } else { way.length() };
        world.first(from, way.normalize()).is_none_or(|(t, _)| t >= length)
    }

    fn is_averted(&self, point: DVec3, normal: DVec3) -> bool {
        let way = if self.is_parallel { self.at } else { self.at - point };
        way.dot(normal) <= 0.0
    }
}

fn worlds(random: &mut Random) -> Vec<World> {
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

/// What is seen through a pixel: the place and its normal.
type Seen = Option<(DVec3, DVec3)>;

fn seen(world: &World, rays: &Rays, size: [u32; 2]) -> Vec<Seen> {
    let place = |texel: u32| DVec2::new(f64::from(texel % size[0]) + 0.5, f64::from(texel / size[0]) + 0.5);
    let hit = |texel| {
        let (from, direction) = rays.at(place(texel));
        world.first(from, direction).map(|(t, normal)| (from + t * direction, normal))
    };
    (0..size[0] * size[1]).map(hit).collect()
}

fn depths(camera: &ShadowCamera, seen: &[Seen]) -> Vec<f32> {
    let far = if camera.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    seen.iter().map(|seen| seen.map_or(far, |(place, _)| device_depth(camera, place))).collect()
}

/// What is near to a place, as the light sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Near {
    Nothing,
    /// The surface bends towards the light, so the boundary is before it.
    Fold,
    /// A border of a shadow, on the plane of the surface or where the surface ends.
    Border,
}

/// What is within some texels of a place.
fn what_is_near(
    world: &World,
    sun: &Sun,
    rays: &Rays,
    (side, within): (u32, f64),
    (point, normal): (DVec3, DVec3),
) -> Near {
    let origin = DVec3::from_array(sun.camera.origin.map(f64::from));
    let matrix = glam::Mat4::from_cols_array_2d(&sun.camera.view_projection).as_dmat4();
    let clip = matrix * (point - origin).extend(1.0);
    let texels = DVec2::new(clip.x / clip.w + 1.0, 1.0 - clip.y / clip.w) * f64::from(side) / 2.0;
    let is_lit = sun.is_lit(world, point, normal);
    let near = (0..121).map(|number| {
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
    });
    near.max().unwrap_or(Near::Nothing)
}

#[derive(Debug, Default)]
struct Tally {
    dark: usize,
    lit: usize,
    at_borders: usize,
    at_folds: usize,
    wrong: usize,
    /// The sum of the squares of what the shares of dark bits are off by.
    squares: f64,
}

fn trial(
    gpu: &Gpu,
    random: &mut Random,
    world: &World,
    format: TextureFormat,
    (options, off): (DepthMapOptions, usize),
    tally: &mut Tally,
) -> Result<(), String> {
    let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
    let towards = DVec3::new(between(-0.7, 0.7), 1.0, between(-0.7, 0.7)).normalize();
    let is_parallel = between(0.0, 1.0) < 0.4;
    let depth = if between(0.0, 1.0) < 0.5 { DepthDirection::Reversed } else { DepthDirection::Standard };
    let place = towards * 9.0;
    let (far, half_width) = if is_parallel { (Some(20.0), Some(5.0)) } else { (Some(30.0), None) };
    let sun = Eye { place, forward: -towards, near: 1.0, is_relative: true, depth, far, half_width };
    let sun = Sun { at: if is_parallel { towards } else { place }, is_parallel, camera: sun.camera() };
    let place = DVec3::new(between(-5.0, 5.0), between(0.6, 5.0), between(-5.0, 5.0));
    let forward = DVec3::new(between(-1.0, 1.0), between(0.0, 1.5), between(-1.0, 1.0)) - place;
    let near = if between(0.0, 1.0) < 0.3 { 1.0 } else { 0.1 };
    let depth = DepthDirection::Reversed;
    let eye = Eye { place, forward, near, is_relative: false, depth, far: None, half_width: None }.camera();
    let eye_rays = Rays::new(&eye, SIDE);
    let corners = (0..81).map(|at| DVec2::new(f64::from(at % 9), f64::from(at / 9)) * f64::from(SIDE) / 8.0);
    if corners.into_iter().any(|corner| world.is_inside(eye_rays.at(corner).0)) {
        // What is seen inside a body is no surface.
        return Ok(());
    }

    let side = 96;
    let light_rays = Rays::new(&sun.camera, side);
    let light_seen = seen(world, &light_rays, [side; 2]);
    let depths_of_light = depths(&sun.camera, &light_seen);
    let is_reversed = sun.camera.depth == DepthDirection::Reversed;
    let mut map = Map { size: [side; 2], is_reversed, depths: depths_of_light };
    map.depths.rotate_right(off);
    let eye_seen = seen(world, &eye_rays, [SIDE; 2]);
    let eye_depths = depths(&eye, &eye_seen);
    let texture = texture(gpu, map.size, format, &map.depths)?;
    // The ground is one object, and what stands on it is another.
    let on_ground = |seen: &Seen| u32::from(seen.is_some_and(|(place, _)| place.y < 1e-7));
    let mut numbers: Vec<_> = light_seen.iter().map(on_ground).collect();
    numbers.rotate_right(off);
    let objects = options.objects.then(|| objects(gpu, map.size, &numbers));
    let (light, side_of_picture) = (sun.camera, SIDE);
    let picture = Picture {
        map: &texture,
        objects: objects.as_ref(),
        light,
        eye,
        depths: &eye_depths,
        side: side_of_picture,
        options,
        bit: 8 - options.bits,
    };
    let stencil = picture.stencil(gpu)?;
    // A texel, and as much as bits move the boundary.
    let within = 1.5 - 0.5 / f64::from(options.bits);
    for (pixel, (seen, value)) in eye_seen.iter().zip(stencil).enumerate() {
        let Some((point, normal)) = *seen else { continue };
        if sun.is_averted(point, normal) {
            continue;
        }
        let is_lit = sun.is_lit(world, point, normal);
        *(if is_lit { &mut tally.lit } else { &mut tally.dark }) += 1;
        let off = f64::from(value.count_ones()) / f64::from(options.bits) - if is_lit { 0.0 } else { 1.0 };
        tally.squares += off * off;
        if off == 0.0 {
            continue;
        }
        let near = what_is_near(world, &sun, &light_rays, (side, within), (point, normal));
        tally.at_borders += usize::from(near == Near::Border);
        tally.at_folds += usize::from(near == Near::Fold);
        if near == Near::Nothing {
            tally.wrong += 1;
            if tally.wrong < 10 {
                println!("pixel {pixel}: {point} {normal}, lit {is_lit}, {format:?} {is_parallel}");
            }
        }
    }
    Ok(())
}

fn trials(seed: u64, rounds: usize, options: DepthMapOptions) -> Result<(), String> {
    println!("seed {seed}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let formats = [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];
    let (mut all_wrong, mut pixels) = (0, 0);
    for format in formats {
        let mut tally = Tally::default();
        for round in 0..rounds {
            let worlds = worlds(&mut random);
            // Objects that cast no shadow onto themselves.
            let is_convex = |world: &World| matches!(world, World::Sphere { .. } | World::Cuboid { .. });
            let taken = worlds.iter().enumerate().filter(|(_, world)| !options.objects || is_convex(world));
            for (number, world) in taken {
                let before = tally.wrong;
                trial(&gpu, &mut random, world, format, (options, 0), &mut tally)?;
                if tally.wrong > before {
                    println!("{format:?}, round {round}, world {number}: {} wrong", tally.wrong - before);
                }
            }
        }
        println!("{format:?}: {tally:?}");
        // The move by the slope is for folds.
        let folds = if options.slope_bias > 0.0 { 10_000 } else { 2_000 };
        if tally.dark < 1000
            || tally.lit < 1000
            || tally.at_borders * 20 > tally.dark + tally.lit
            || tally.at_folds * folds > tally.dark + tally.lit
        {
            return Err(format!("{format:?}: {tally:?}"));
        }
        all_wrong += tally.wrong;
        pixels += tally.dark + tally.lit;
    }
    // A detector may miss an edge.
    let allowed = if options.edges == DepthEdges::EveryCell { 0 } else { pixels / 100_000 };
    if all_wrong > allowed { Err(format!("{all_wrong} of {pixels} are wrong away from borders")) } else { Ok(()) }
}

fn every_cell() -> Result<(), String> {
    trials(1631, 4, DepthMapOptions::default())
}

fn marked() -> Result<(), String> {
    let edges = DepthEdges::Differences { threshold: 0.0005 };
    trials(1632, 4, DepthMapOptions { edges, ..Default::default() })
}

/// Steep sides of the boxes are left out. Moved, they would leave the boxes behind, and rays would miss a crossing there, so they are
/// not moved.
fn of_objects() -> Result<(), String> {
    trials(
        1634,
        4,
        DepthMapOptions { edges: DepthEdges::Outlines, objects: true, slope_bias: 0.0, ..Default::default() },
    )
}

/// The same views with one bit and with more. The error of a pixel is the difference between the share of its bits that are dark and the truth.
fn of_bits() -> Result<(), String> {
    let mut errors = Vec::new();
    let marked = DepthEdges::Differences { threshold: 0.0005 };
    let every = DepthEdges::EveryCell;
    for (bits, edges) in [(1, every), (4, every), (8, every), (4, marked)] {
        println!("seed 1635, {bits} bits, {edges:?}");
        let gpu = Gpu::shared()?;
        let mut random = Random::new(1635);
        let mut tally = Tally::default();
        for world in worlds(&mut random).into_iter().chain(worlds(&mut random)) {
            let options = DepthMapOptions { bits, edges, ..Default::default() };
            trial(&gpu, &mut random, &world, TextureFormat::Depth32Float, (options, 0), &mut tally)?;
        }
        println!("{tally:?}");
        if tally.wrong > 0 {
            return Err(format!("{bits} bits, {edges:?}: {tally:?}"));
        }
        errors.push(tally.squares);
    }
    println!("mean squares are {:.2} and {:.2} of those of one bit", errors[1] / errors[0], errors[2] / errors[0]);
    // Bits that are all alike would have the error of one.
    if errors[1] < 0.8 * errors[0] && errors[2] < errors[1] { Ok(()) } else { Err(format!("{errors:?}")) }
}

/// Negative control: the map's columns are moved.
fn off() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(1633);
    let mut tally = Tally::default();
    for world in worlds(&mut random) {
        trial(&gpu, &mut random, &world, TextureFormat::Depth32Float, (DepthMapOptions::default(), 3), &mut tally)?;
    }
    if tally.wrong > 100 { Ok(()) } else { Err(format!("negative control: {tally:?}")) }
}
