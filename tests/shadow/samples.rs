//! Several samples a pixel, each against the ray through its position.

use rimline::Counting;

use crate::compare::Compared;
use crate::rays::Truth;
use crate::render::Renderer;
use crate::trials::{Test, Traced, every};
use rimline_testkit::device::Gpu;
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::frames::SAMPLES;
use rimline_testkit::is_long;

pub(crate) const TESTS: &[Test] = &[("four_samples_a_pixel", four)];

/// Samples with another count than the ray has.
fn differing(traced: &Traced, stencil: &[u8], every: &[bool]) -> usize {
    let differs = |&(truths, &value): &(&Vec<Truth>, &u8)| match truths[0] {
        Truth::Surface(between) => between.count(every) % 256 != u16::from(value),
        _ => false,
    };
    traced.truths.iter().zip(stencil).filter(differs).count()
}

fn four() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let renderer = Renderer { samples: SAMPLES.len() as u32, ..Renderer::new(&gpu) };
    let [mut mixed, mut compared, mut explained, mut unequal, mut unequal_to_next] = [0; 5];
    for class in CLASSES.iter().filter(|class| is_long() || class.name.contains("near rectangle")) {
        for number in 70..if is_long() { 75 } else { 71 } {
            let centres = Traced::new(class, number);
            let samples = [0, 1, 2, 3].map(|sample| centres.through(sample));
            for counting in [Counting::Auto, Counting::ZFail] {
                let counted = renderer.count(&centres.frame, counting)?;
                let every = every(&counted, 0);
                for (sample, traced) in samples.iter().enumerate() {
                    let what = format!("{}, seed {}, {counting:?}, sample {sample}", class.name, traced.seed);
                    let stencil = traced.stencil(&counted);
                    let wrong = traced.compared().each(stencil, &every, !class.touches);
                    if let Some(pixel) = wrong.pixels.first() {
                        return Err(format!("{what}: {pixel:?} is wrong"));
                    }
                    compared += wrong.compared;
                    explained += wrong.hairlines.len() + wrong.slivers.len();
                    let turned: Vec<u8> = stencil.iter().map(|&value| u8::from(value == 0)).collect();
                    let turned = Compared { explains: false, ..traced.compared() }.lit(&turned, &every);
                    if turned.compared > 0 && turned.pixels.is_empty() {
                        return Err(format!("negative control: {what}, shadow for light went unnoticed"));
                    }
                    if !class.touches {
                        unequal += differing(traced, stencil, &every);
                        unequal_to_next += differing(&samples[(sample + 1) % samples.len()], stencil, &every);
                    }
                }
                let lit = |at: usize| counted.stencils.iter().filter(|stencil| stencil[at] == 0).count();
                mixed += (0..centres.truths.len()).filter(|&at| (1..samples.len()).contains(&lit(at))).count();
            }
        }
    }
    println!(
        "{compared} samples compared, {explained} off and explained; {mixed} pixels in part in shadow; {unequal} samples \
         have another count than their ray, {unequal_to_next} than the next sample's"
    );
    match (mixed, unequal_to_next > 20 * unequal) {
        (0, _) => Err("no pixel was in part in shadow".to_owned()),
        (_, false) => Err("negative control: rays through other samples do as well".to_owned()),
        (_, true) => Ok(()),
    }
}
