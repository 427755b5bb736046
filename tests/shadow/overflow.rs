//! Counts that 8 bits do not hold, and the bound that tells of them; lists that overflow.

use glam::DVec3;
use rimline::internals::shadow::CAST_EVERY;
use rimline::{Counting, Light};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::shapes::{self, Shape};

use crate::classes::CLASSES;
use crate::compare::Compared;
use crate::rays::{self, Truth};
use crate::render::{Placing, Renderer};
use crate::scene::{Body, CENTRE, Eye, Frame};
use crate::trials::{Test, Traced, rotated, seed};
use rimline_testkit::device::Gpu;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("counts_that_are_multiples_of_256_are_warned_of", multiples),
    ("lists_that_overflow_count_alike", short_lists),
    ("lists_of_cap_faces_that_a_small_device_shortens", shortened),
];

/// `count` sheets above each other, in one mesh, with the eye and a receiver below them all and the light above.
fn stack(count: u32) -> Frame {
    let sheet = |number: u32| shapes::plane_grid(2, 2).placed(|[x, _, z]| [x, 0.5 + number as f32 / count as f32, z]);
    let shape = Shape::joined(&(0..count).map(sheet).collect::<Vec<_>>());
    let mut frame = (CLASSES[0].frame)(&mut Random::new(1));
    frame.bodies = vec![Body::caster(shape), Body::room([0.0; 3], 3.0)];
    frame.lights = vec![Light::point([0.1, 2.5, 0.2])];
    frame.eye = Eye::new(DVec3::new(2.0, -1.0, 2.2), DVec3::new(-2.0, -1.5, -2.2), 0.1);
    frame
}

/// Counts wrap without an error, so 256 sheets cast no shadow. 300 sheets cast one, except on the fringe where 256 of them
/// are in the way. The bound warns of both.
fn multiples() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let options = OneCasterOptions { bound_counts: true, ..OneCasterOptions::default() };
    let renderer = Renderer { options, ..Renderer::new(&gpu) };
    for (sheets, aliases, warns) in [(100, false, false), (256, true, true), (300, false, true)] {
        let frame = stack(sheets);
        let truths = rays::trace(&frame, CENTRE);
        let deepest = truths.iter().map(|truths| match truths[0] {
            Truth::Surface(between) => between.count(&[true]),
            _ => 0,
        });
        if deepest.max() != Some(sheets as u16) {
            return Err(format!("no point is below all of {sheets} sheets"));
        }
        let compared = Compared { frame: &frame, truths: &truths, within_pixel: CENTRE, light: 0, explains: true };
        for counting in [Counting::Auto, Counting::ZFail] {
            let counted = renderer.count(&frame, counting)?;
            let stencil = &counted.stencils[0];
            let wrap = compared.counts(stencil, &[true]);
            if !wrap.pixels.is_empty() || wrap.compared == 0 {
                return Err(format!("{sheets} sheets, {counting:?}: counts are not exact modulo 256"));
            }
            let lit = compared.lit(stencil, &[true]);
            let statistics = counted.statistics[0];
            let bound = statistics.count_bound;
            println!(
                "{sheets} sheets, {counting:?}: {} of {} pixels wrong, bound {bound}",
                lit.pixels.len(),
                lit.compared
            );
            // 256 of them begin within a pixel.
            let is_multiple = |&(x, y): &(u32, u32)| {
                let around = compared.around((i64::from(x), i64::from(y))).filter_map(|truth| match truth {
                    Truth::Surface(between) => Some(between.count(&[true])),
                    _ => None,
                });
                let (least, most) =
                    around.fold((u16::MAX, 0), |(least, most), count| (least.min(count), most.max(count)));
                (least..=most).contains(&256)
            };
            if !lit.pixels.iter().all(is_multiple) || (lit.pixels.len() > 100) != aliases {
                return Err(format!("{sheets} sheets, {counting:?}: {} wrong pixels", lit.pixels.len()));
            }
            if bound < sheets || (statistics.may_wrap == 1) != warns {
                return Err(format!("{sheets} sheets, {counting:?}: {statistics:?}"));
            }
        }
    }
    Ok(())
}

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
            for ((list_capacity, cap_capacity), overflowed) in capacities.into_iter().zip(&mut overflowed) {
                let what =
                    format!("{}, seed {}, {counting:?}, {list_capacity:?}, {cap_capacity:?}", class.name, traced.seed);
                let options = OneCasterOptions { cap_capacity, ..OneCasterOptions::default() };
                let renderer = Renderer { options, list_capacity, placing, ..Renderer::new(&gpu) };
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
        let renderer = Renderer { list_capacity: Some(1), placing, ..Renderer::new(&gpu) };
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

/// Where lists of all cap faces do not fit a binding they are shorter by default, and the counts are the same.
fn shortened() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let small = Gpu::with_limits(wgpu::Limits {
        max_storage_buffer_binding_size: 64 << 10,
        max_buffer_size: 4 << 20,
        ..wgpu::Limits::default()
    })?;
    let mut random = Random::new(12);
    let mut overflowed = [0; 2];
    for class in
        CLASSES.iter().filter(|class| class.name != "directional lights").step_by(if is_long() { 1 } else { 4 })
    {
        let seed = seed(class, 111);
        let mut frame = (class.frame)(&mut Random::new(seed));
        let [x, y, z] = frame.lights[0].xyz;
        let about = |_| {
            let [a, b, c] = random.direction();
            Light::point([x + a, y + b, z + c])
        };
        frame.lights.extend((1..32).map(about));
        frame.size = 48;
        for (counting, end_at_range) in [(Counting::ZFail, false), (Counting::ZFail, true), (Counting::Auto, true)] {
            let options = OneCasterOptions { end_at_range, ..OneCasterOptions::default() };
            let count = |gpu| Renderer { options, range: 12.0, ..Renderer::new(gpu) }.count(&frame, counting);
            let (whole, short) = (count(&gpu)?, count(&small)?);
            let what = format!("{}, seed {seed}, {counting:?}, {end_at_range}", class.name);
            if whole.stencils != short.stencils || whole.chosen != short.chosen {
                return Err(format!("{what}: another picture"));
            }
            for (overflowed, counted) in overflowed.iter_mut().zip([&whole, &short]) {
                *overflowed += counted.statistics.iter().map(|statistics| statistics.overflowed_caps).sum::<u32>();
            }
        }
    }
    println!("lists that overflowed: {overflowed:?}");
    if overflowed[0] == 0 && overflowed[1] > 0 { Ok(()) } else { Err("not as meant".to_owned()) }
}
