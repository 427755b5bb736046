//! Several samples a pixel.

use rimline::Counting;

use crate::classes::CLASSES;
use crate::common::device::Gpu;
use crate::common::is_long;
use crate::compare::{Compared, Wrong};
use crate::hairlines::Hairlines;
use crate::rays::Truth;
use crate::render::Renderer;
use crate::trials::{Test, Traced, every};

pub(crate) const TESTS: &[Test] = &[("four_samples_a_pixel", four)];

/// No sample is shadowed where all is lit within a pixel, nor lit where all is in shadow.
fn wrong(traced: &Traced, uncounted: &[u8], every: &[bool]) -> Wrong {
    let mut wrong = Wrong::default();
    for is_counted in [|share| share == 0, |share| share < 255] {
        let stencil: Vec<u8> = uncounted.iter().map(|&share| u8::from(is_counted(share))).collect();
        let mut found = Compared { explains: false, ..traced.compared() }.lit(&stencil, every);
        // Samples are not at the centre, so they see slivers that rays through centres miss, and surfaces averted from the
        // light, whose count means nothing.
        if found.pixels.len() < 30 {
            let hairlines = Hairlines::new(&traced.frame, 0);
            found.pixels.retain(|&(x, y)| {
                let is_lit = stencil[(y * traced.frame.size + x) as usize] == 0;
                !hairlines.is_near((x, y), |truth| truth.is_lit() == is_lit || !matches!(truth, Truth::Surface(_)))
            });
        }
        wrong.add(&found);
    }
    wrong
}

fn four() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let renderer = Renderer { samples: 4, ..Renderer::new(&gpu) };
    let (mut mixed, mut compared) = (0, 0);
    for class in CLASSES.iter().filter(|class| is_long() || class.name.contains("near rectangle")) {
        for number in 70..if is_long() { 75 } else { 71 } {
            let traced = Traced::new(class, number);
            for counting in [Counting::Auto, Counting::ZFail] {
                let counted = renderer.count(&traced.frame, counting)?;
                let (uncounted, every) = (&counted.stencils[0], every(&counted, 0));
                let found = wrong(&traced, uncounted, &every);
                if let Some(pixel) = found.pixels.first() {
                    return Err(format!("{}, seed {}, {counting:?}: {pixel:?} is wrong", class.name, traced.seed));
                }
                mixed += uncounted.iter().filter(|&&share| share > 0 && share < 255).count();
                compared += found.compared / 2;
                let turned: Vec<u8> = uncounted.iter().map(|share| 255 - share).collect();
                if found.compared > 0 && wrong(&traced, &turned, &every).pixels.is_empty() {
                    return Err(format!("negative control: {}, shadow for light went unnoticed", class.name));
                }
            }
        }
    }
    println!("{compared} pixels of four samples, {mixed} of them in part in shadow");
    if mixed > 0 { Ok(()) } else { Err("no pixel was in part in shadow".to_owned()) }
}
