//! Shadows of distance fields and meshes against rays to the light: a wrong pixel is at most a texel of the map away from
//! the border of a shadow.

use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod, DepthMapOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::picture::{EVERY_CELL, Target, by, contours, differences};
use crate::views::{Seen, Tally, View, worlds};
use crate::worlds::World;
use rimline_testkit::textures::objects;

pub(crate) const TESTS: &[Test] = &[
    ("shadows_are_right_but_for_a_texel", of_methods),
    ("shadows_of_edges_of_objects_are_right_but_for_a_texel", of_objects),
    ("borders_of_more_bits_are_nearer_to_the_truth", of_bits),
];

/// How a map is made and drawn.
#[derive(Clone, Copy)]
struct Way {
    options: DepthMapOptions,
    /// Texels by which the map is moved: a negative control.
    off: usize,
    /// Whether there are objects.
    has_objects: bool,
    bits: u32,
}

impl Way {
    fn new(options: DepthMapOptions) -> Self {
        Self { options, off: 0, has_objects: false, bits: 1 }
    }

    /// Draws a view, and compares it with rays.
    fn add(self, gpu: &Gpu, view: &View<'_>, format: TextureFormat, tally: &mut Tally) -> Result<(), String> {
        let Self { options, off, has_objects, bits } = self;
        let mut maps = view.moved_maps(gpu, format, off)?;
        if has_objects {
            // The ground is one object, and what stands on it is another.
            let on_ground = |seen: &Seen| u32::from(seen.is_some_and(|(position, _)| position.y < 1e-7));
            let numbers: Vec<_> = view.light_seen().iter().map(on_ground).collect();
            maps.objects = vec![Some(objects(gpu, maps.size, &numbers))];
        }
        let depths = view.eye_depths();
        let target = Target { bits: 8 - bits..8, ..Target::new(view.eye, &depths) };
        tally.add(view, &target.stencil(gpu, &maps, options)?, bits);
        Ok(())
    }
}

/// Draws each view in each way, of worlds that are chosen.
fn trials<const N: usize>(seed: u64, ways: [Way; N], is_chosen: fn(&World) -> bool) -> Result<(), String> {
    println!("seed {seed}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let mut all = ways.map(|_| Tally::default());
    // Negative control: the columns of the map are moved.
    let mut off = Tally::default();
    for format in [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm] {
        let mut tallies = ways.map(|_| Tally::default());
        for round in 0..if is_long() { 12 } else { 4 } {
            for world in worlds(&mut random).iter().filter(|world| is_chosen(world)) {
                let Some(view) = View::random(&mut random, world) else { continue };
                for (tally, way) in tallies.iter_mut().zip(ways) {
                    way.add(&gpu, &view, format, tally)?;
                }
                if round == 0 && format == TextureFormat::Depth32Float {
                    Way { off: 3, ..Way::new(by(EVERY_CELL)) }.add(&gpu, &view, format, &mut off)?;
                }
            }
        }
        for ((all, tally), way) in all.iter_mut().zip(tallies).zip(ways) {
            println!("{format:?} {:?}: {tally:?}", way.options.method);
            // The move by the slope is for folds.
            let folds = if way.options.slope_bias > 0.0 { 10_000 } else { 2_000 };
            let is_tried = tally.dark > 1000 && tally.lit > 1000;
            let pixels = tally.pixels();
            if !is_tried || tally.at_borders * 20 > pixels || tally.at_folds * folds > pixels {
                return Err(format!("{format:?} {:?}: {tally:?}", way.options.method));
            }
            all.sum(tally);
        }
    }
    let of_cells = all[0].at_borders;
    for (tally, way) in all.into_iter().zip(ways) {
        // A detector may miss an edge. Walls miss more, at rims that are steeper than the texels show.
        let pixels = tally.pixels();
        let allowed = match way.options.method {
            DepthMapMethod::EveryCell => 0,
            DepthMapMethod::Contours { .. } => pixels / 10_000,
            DepthMapMethod::SecondDifferences { .. } => 1 + pixels / 100_000,
            _ => pixels / 100_000,
        };
        // Contours lie between samples, so borders are smoother than those of every cell, the first way.
        let is_smooth =
            !matches!(way.options.method, DepthMapMethod::Contours { .. }) || 2 * tally.at_borders < of_cells;
        if tally.wrong > allowed || !is_smooth {
            return Err(format!("{:?}: {tally:?}", way.options.method));
        }
    }
    if off.wrong > 50 { Ok(()) } else { Err(format!("negative control: {off:?}")) }
}

/// Each view is drawn with every cell, with cells that detectors mark, and with contours.
fn of_methods() -> Result<(), String> {
    let dangling = Some(DanglingEdges::default());
    let automatic = DepthMapMethod::Automatic { dangling };
    let second = DepthMapMethod::SecondDifferences { low: 0.0005, high: 0.05, dangling };
    let methods = [EVERY_CELL, differences(0.0005), contours([0.0005, 0.25, 0.002]), automatic, second];
    trials(1631, methods.map(|method| Way::new(by(method))), |_| true)
}

/// Objects that cast no shadow onto themselves. Steep sides of the boxes are omitted. Moved, they would leave the boxes
/// behind, and rays would miss a crossing there, so they are not moved.
fn of_objects() -> Result<(), String> {
    let options = DepthMapOptions { slope_bias: 0.0, ..by(differences(1.0)) };
    let way = Way { has_objects: true, ..Way::new(options) };
    trials(1634, [way], |world| matches!(world, World::Sphere { .. } | World::Cuboid { .. }))
}

/// The same views with one bit and with more. The error of a pixel is the difference between the share of its bits that
/// are dark and the truth.
fn of_bits() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1635)?;
    let ways = [(1, EVERY_CELL), (4, EVERY_CELL), (8, EVERY_CELL), (4, differences(0.0005))];
    let mut tallies = ways.map(|_| Tally::default());
    for world in worlds(&mut random).into_iter().chain(worlds(&mut random)) {
        let Some(view) = View::random(&mut random, &world) else { continue };
        for (tally, (bits, method)) in tallies.iter_mut().zip(ways) {
            Way { bits, ..Way::new(by(method)) }.add(&gpu, &view, TextureFormat::Depth32Float, tally)?;
        }
    }
    let errors = tallies.map(|tally| tally.squares);
    println!("mean squares are {:.2} and {:.2} of those of one bit", errors[1] / errors[0], errors[2] / errors[0]);
    // Equal bits would have the error of one bit.
    let is_right = tallies.iter().all(|tally| tally.wrong == 0);
    if is_right && errors[1] < 0.8 * errors[0] && errors[2] < errors[1] { Ok(()) } else { Err(format!("{tallies:?}")) }
}
