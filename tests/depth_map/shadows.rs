//! Shadows of distance fields and meshes against rays to the light: a wrong pixel is at most a texel of the map away from
//! the border of a shadow.

use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod, DepthMapOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use wgpu::TextureFormat;

use crate::picture::{EVERY_CELL, Target, by, contours, differences};
use crate::views::{Tally, View, worlds};

pub(crate) const TESTS: &[Test] =
    &[("shadows_are_right_but_for_a_texel", of_methods), ("borders_of_more_bits_are_nearer_to_the_truth", of_bits)];

/// How a map is made and drawn.
#[derive(Clone, Copy)]
struct Way {
    options: DepthMapOptions,
    /// Texels by which the map is moved: a negative control.
    off: usize,
    bits: u32,
}

impl Way {
    fn new(options: DepthMapOptions) -> Self {
        Self { options, off: 0, bits: 1 }
    }

    /// Draws a view, and compares it with rays.
    fn add(self, gpu: &Gpu, view: &View<'_>, format: TextureFormat, tally: &mut Tally) -> Result<(), String> {
        let Self { options, off, bits } = self;
        let maps = view.moved_maps(gpu, format, off)?;
        let depths = view.eye_depths();
        let target = Target { bits: 8 - bits..8, ..Target::new(view.eye, &depths) };
        tally.add(view, &target.stencil(gpu, &maps, options)?, bits);
        Ok(())
    }
}

/// Each view is drawn with every cell, with cells that detectors mark, and with contours.
fn of_methods() -> Result<(), String> {
    let dangling = Some(DanglingEdges::default());
    let automatic = DepthMapMethod::Automatic { dangling };
    let second = DepthMapMethod::SecondDifferences { low: 0.0005, high: 0.05, dangling };
    let methods = [EVERY_CELL, differences(0.0005), contours([0.0005, 0.25, 0.002]), automatic, second];
    let ways = methods.map(|method| Way::new(by(method)));
    let (gpu, mut random) = Gpu::seeded(1631)?;
    let mut all = ways.map(|_| Tally::default());
    // Negative control: the columns of the map are moved.
    let mut off = Tally::default();
    for format in [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm] {
        let mut tallies = ways.map(|_| Tally::default());
        for round in 0..if is_long() { 12 } else { 4 } {
            for world in &worlds(&mut random) {
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
            let is_tried = tally.dark > 1000 && tally.lit > 1000;
            let pixels = tally.pixels();
            if !is_tried || tally.at_borders * 20 > pixels || tally.at_folds * 10_000 > pixels {
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
