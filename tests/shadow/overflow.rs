//! Lists that overflow.

use rimline::Counting;
use rimline::gpu::Capacities;
use rimline::internals::shadow::CAST_EVERY;
use rimline_testkit::device::Gpu;
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::{must_fail, same};

use crate::render::{Placing, Renderer};
use crate::trials::{Test, Traced, rotated};

pub(crate) const TESTS: &[Test] = &[("lists_that_overflow_count_alike", short_lists)];

/// Lists of sides and of cap faces that overflow give the same counts, by each method, of casters alone and in one scene.
fn short_lists() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let methods = [Counting::Auto, Counting::ZpPlus, Counting::ZFail, Counting::ZPass, Counting::ZpPlus2005];
    let capacities = [(Some(1), None), (Some(100), None), (Some(40), Some(3)), (None, Some(1))];
    let (mut compared, mut overflowed, mut doubled, mut shadowed) = (0, [[0; 2]; 4], 0, 0);
    for (index, class) in CLASSES.iter().enumerate() {
        let traced = Traced::new(class, 110);
        let frame = &traced.frame;
        let placing = [Placing::Alone, Placing::Scene][index % 2];
        for counting in [rotated(&methods[..3], index / 2), rotated(&methods[3..], index / 2)].concat() {
            let whole = Renderer { placing, ..Renderer::new(&gpu) }.count(frame, counting)?;
            for ((lists, caps), overflowed) in capacities.into_iter().zip(&mut overflowed) {
                let what = format!("{}, seed {}, {counting:?}, {lists:?}, {caps:?}", class.name, traced.seed);
                let mut renderer = Renderer { placing, ..Renderer::new(&gpu) };
                renderer.options.capacities = Capacities { lists, caps, ..Capacities::default() };
                let mut counted = renderer.count(frame, counting)?;
                // The published method sees all edges where a list overflowed, and leaves more to z-fail.
                let is_alike = counted.chosen == whole.chosen;
                if !is_alike && counting != Counting::ZpPlus2005 {
                    return Err(format!("{what}: other choices"));
                }
                for (statistics, lights) in counted.statistics.iter().zip(&counted.chosen) {
                    overflowed[0] += statistics.overflowed_sides;
                    overflowed[1] += statistics.overflowed_caps;
                    doubled += u32::from(statistics.overflowed_sides > 0 && lights[0].casting == CAST_EVERY);
                }
                if is_alike {
                    same(&what, &counted.stencils, &whole.stencils)?;
                    counted.stencils[0][7] ^= 1;
                    must_fail("another count", &same(&what, &counted.stencils, &whole.stencils))?;
                    compared += 1;
                }
            }
        }
        let mut renderer = Renderer { placing, ..Renderer::new(&gpu) };
        renderer.options.capacities.lists = Some(1);
        traced.check(&renderer, Counting::Auto, !class.touches)?;
        shadowed += traced.shadowed();
    }
    println!(
        "{compared} pictures, {shadowed} pixels in shadow; overflowed lists of sides and caps: {overflowed:?}, {doubled} doubled"
    );
    let [one, hundred, both, caps] = overflowed;
    let fewest = [one[0], hundred[0], both[0], both[1], caps[1], doubled].into_iter().min();
    if fewest == Some(0) || shadowed == 0 { Err("no list of a kind overflowed".to_owned()) } else { Ok(()) }
}
