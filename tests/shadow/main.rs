//! Shadows against rays. Without an adapter these tests fail; they are never passed over.

mod classes;
#[path = "../common/mod.rs"]
mod common;
mod rays;
mod render;
mod scene;

use libtest_mimic::{Arguments, Failed, Trial};
use rimline::Counting;

use crate::classes::CLASSES;
use crate::common::device::Gpu;
use crate::common::random::Random;
use crate::rays::Truth;
use crate::render::Renderer;
use crate::scene::Frame;

fn main() {
    let name = Gpu::shared().map_or_else(|error| error, |gpu| gpu.name.clone());
    println!("adapter: {name}");
    let mut trials = Vec::new();
    for &(name, class) in CLASSES {
        for (method, counting) in [("auto", Counting::Auto), ("z-fail", Counting::ZFail), ("zp+", Counting::ZpPlus)] {
            let run = move || right(name, class, counting).map_err(Failed::from);
            trials.push(Trial::test(format!("{method}: {name}"), run).with_kind("gpu"));
        }
    }
    println!("gpu tests: {}", trials.len());
    let conclusion = libtest_mimic::run(&Arguments::from_args(), trials);
    Gpu::close();
    conclusion.exit();
}

/// Pixels that the GPU shows lit or shadowed and the rays otherwise, farther than a pixel from a shadow's edge.
pub(crate) fn wrong_pixels(frame: &Frame, truths: &[Vec<Truth>], light: usize, stencil: &[u8]) -> Vec<(u32, u32)> {
    let size = frame.size as i64;
    let truth = |x: i64, y: i64| truths[(y * size + x) as usize][light];
    let pixels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
    let is_wrong = |&(x, y): &(i64, i64)| {
        let true_one = truth(x, y);
        if matches!(true_one, Truth::Background | Truth::Averted) {
            return false;
        }
        let lit = stencil[(y * size + x) as usize] == 0;
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        let mut near = around.filter(|&(x, y)| (0..size).contains(&x) && (0..size).contains(&y));
        lit != true_one.is_lit() && !near.any(|(x, y)| truth(x, y).is_lit() == lit)
    };
    pixels.filter(is_wrong).map(|(x, y)| (x as u32, y as u32)).collect()
}

fn right(name: &str, class: fn(&mut Random) -> Frame, counting: Counting) -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let renderer = Renderer::new(&gpu);
    let frames =
        std::env::var("FRAMES").ok().and_then(|n| n.parse().ok()).unwrap_or(if common::is_long() { 40 } else { 3 });
    let mut report = String::new();
    let mut wrong_in_all = 0;
    for number in 0..frames {
        let seed = 1000 + number;
        let frame = class(&mut Random::new(seed));
        let counted = renderer.count(&frame, counting)?;
        let truths = rays::trace(&frame);
        let wrong = wrong_pixels(&frame, &truths, 0, &counted.stencils[0]);
        let shadowed = truths.iter().filter(|truth| matches!(truth[0], Truth::Shadowed(_))).count();
        let lit = truths.iter().filter(|truth| truth[0].is_lit()).count();
        let chosen: Vec<_> = counted.chosen.iter().map(|lights| (lights[0].casting, lights[0].counting)).collect();
        let capped: u32 = counted.statistics.iter().map(|statistics| statistics.capped).sum();
        wrong_in_all += wrong.len();
        if !wrong.is_empty() || std::env::var_os("SHOW").is_some() {
            report += &format!(
                "\nseed {seed}: {} wrong, {shadowed} shadowed, {lit} lit, chosen {chosen:?}, capped {capped}; {:?}",
                wrong.len(),
                wrong
                    .iter()
                    .take(4)
                    .map(|&(x, y)| (
                        x,
                        y,
                        truths[(y * frame.size + x) as usize][0],
                        counted.stencils[0][(y * frame.size + x) as usize]
                    ))
                    .collect::<Vec<_>>()
            );
        }
    }
    if std::env::var_os("SHOW").is_some() {
        println!("{name}: {report}");
    }
    if wrong_in_all == 0 {
        Ok(())
    } else {
        Err(format!("{name}: {wrong_in_all} wrong pixels in {frames} frames{report}"))
    }
}
