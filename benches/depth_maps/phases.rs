//! Table 1 of the paper: the phases of a frame, each submitted by itself, in turn.

use glam::DVec3;
use rimline::ShadowCamera;
use rimline::gpu::{DepthMapMethod, DepthMapOptions, DepthMapVolumes};
use rimline_testkit::on_gpu::text;

use crate::scenes::{PAPER, RADIUS, scene};
use crate::shade::Shade;
use crate::stage::{Bench, Drawn, EYE, MAP, Target, axes, camera, map_of, medians, pass, way};

const PHASES: [&str; 6] = [
    "light view",
    "detection and compaction",
    "eye view",
    "volume, cap left out",
    "cap, if drawn (with outlines)",
    "shade",
];
const SHOWN: [&str; 4] = ["every cell", "automatic", "differences 0.02", "contours 0.005"];

/// Resources of a frame.
struct Frame<'a> {
    bench: &'a Bench,
    drawn: &'a Drawn,
    map: Target,
    target: Target,
    shade: Shade,
    light: ShadowCamera,
    eye: ShadowCamera,
}

impl Frame<'_> {
    /// Milliseconds of each phase. `outlines` finds next to nothing but borders, so its draw is little more than the cap.
    fn times(&self, volumes: &mut DepthMapVolumes, outlines: &mut DepthMapVolumes) -> Result<[f64; 6], String> {
        let Self { bench, drawn, map, target, shade, light, eye } = self;
        let light_view = bench.clock(|encoder| Bench::draw_map(encoder, drawn, map, light))?;
        let (mut frame, mut other) = (None, None);
        bench.clock(|encoder| {
            other = Some(outlines.encode(encoder, &map_of(map, *light), eye, None).map_err(text)?);
            Ok(())
        })?;
        let detection = bench.clock(|encoder| {
            frame = Some(volumes.encode(encoder, &map_of(map, *light), eye, None).map_err(text)?);
            Ok(())
        })?;
        let eye_view = bench.clock(|encoder| Bench::draw_eye(encoder, &[drawn], target, eye))?;
        let draw = |frame: Option<rimline::gpu::DepthMapFrame>| {
            bench.clock(|encoder| {
                let mut pass = pass(encoder, &target.all, None, true);
                frame.map_or(Ok(()), |frame| frame.draw(&mut pass, &bench.pipelines).map_err(text))
            })
        };
        let cap = draw(other)?;
        let volume = draw(frame)?;
        let shade = bench.clock(|encoder| {
            shade.stencil(encoder, target);
            Ok(())
        })?;
        Ok([light_view, detection, eye_view, volume, cap, shade])
    }
}

pub(crate) fn measure(bench: &Bench, rounds: usize, seed: u64) -> Result<(), String> {
    println!(
        "\nPhases of a frame, milliseconds, and times the light view; medians of {rounds} rounds in turn; seed {seed}"
    );
    println!("| picture and map | scene | detector | {} |", PHASES.join(" | "));
    println!("|---|---|---|{}", "---:|".repeat(PHASES.len()));
    let down = DVec3::new(0.4, -1.0, 0.3).normalize();
    let light = camera(axes(down, DVec3::Z), 8.0, f64::from(RADIUS), true);
    let ahead = DVec3::new(-0.3, -0.5, -1.0).normalize();
    let eye = camera(axes(ahead, DVec3::Y), 6.0, f64::from(RADIUS), false);
    for side in [256, 512] {
        for (number, (name, ..)) in PAPER.into_iter().enumerate() {
            let drawn = &bench.drawn(&scene(number, seed))?;
            let (map, target) = (bench.target(side, MAP), bench.target(side, EYE));
            let frame = Frame { bench, drawn, map, target, shade: Shade::new(bench, side), light, eye };
            let mut volumes = Vec::new();
            for name in SHOWN {
                let way = way(name)?;
                let threshold = 1.0;
                let method = match way {
                    DepthMapMethod::Contours { sideways, depth, .. } => {
                        DepthMapMethod::Contours { threshold, sideways, depth }
                    }
                    _ => DepthMapMethod::Differences { threshold, dangling: None },
                };
                let outlines = DepthMapOptions { method, skip_near_caps: false, ..Default::default() };
                let outlines = DepthMapVolumes::new(&bench.pipelines, [side; 2], outlines).map_err(text)?;
                volumes.push((bench.volumes(side, way)?, outlines, Vec::new()));
            }
            // One more, in which shaders are compiled.
            for round in 0..=rounds {
                for (volumes, outlines, times) in &mut volumes {
                    let own = frame.times(volumes, outlines)?;
                    times.extend((round > 0).then_some(own));
                }
            }
            for (detector, (_, _, times)) in SHOWN.iter().zip(&volumes) {
                let medians = medians(times);
                let cells = medians.map(|time| format!("{time:.2} ({:.2})", time / medians[0]));
                println!("| {side}² | {name} | {detector} | {} |", cells.join(" | "));
            }
        }
    }
    Ok(())
}
