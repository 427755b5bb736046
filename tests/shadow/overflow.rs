//! Counts that 8 bits do not hold, and the bound that tells of them; lists that overflow.

use rimline::{Counting, Light};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::shapes::{self, Shape};

use crate::classes::CLASSES;
use crate::compare::Compared;
use crate::rays::{self, Truth};
use crate::render::{Counted, Renderer};
use crate::scene::{Body, CENTRE, Frame};
use crate::trials::{Test, Traced, every, rotated, seed};
use rimline_testkit::device::Gpu;
use rimline_testkit::goldens::golden;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};

pub(crate) const TESTS: &[Test] = &[
    ("counts_that_are_multiples_of_256_are_warned_of", multiples),
    ("stencil_bound_holds", bound),
    ("ordinary_models_do_not_warn", ordinary),
    ("silhouette_lists_that_overflow", silhouettes),
    ("lists_of_cap_faces_that_a_small_device_shortens", shortened),
];

fn renderer(gpu: &Gpu) -> Renderer<'_> {
    let options = OneCasterOptions { bound_counts: true, ..OneCasterOptions::default() };
    Renderer { options, ..Renderer::new(gpu) }
}

/// `count` sheets above each other, in one mesh, with the eye and a receiver below them all and the light above.
fn stack(count: u32) -> Frame {
    let mut shape = Shape::default();
    for sheet in 0..count {
        let one = shapes::plane_grid(2, 2);
        let first = shape.positions.len() as u32;
        let height = 0.5 + sheet as f32 / count as f32;
        shape.positions.extend(one.positions.iter().map(|[x, _, z]| [*x, height, *z]));
        shape.faces.extend(one.faces.iter().map(|face| face.map(|vertex| vertex + first)));
    }
    let mut frame = (CLASSES[0].frame)(&mut Random::new(1));
    frame.bodies = vec![Body::caster(shape), Body::room([0.0; 3], 3.0)];
    frame.lights = vec![Light::point([0.1, 2.5, 0.2])];
    frame.eye.place = glam::DVec3::new(2.0, -1.0, 2.2);
    frame.eye.forward = glam::DVec3::new(-2.0, -1.5, -2.2);
    frame.eye.near = 0.1;
    frame
}

/// Counts wrap without an error, so 256 sheets cast no shadow. 300 sheets cast one, except on the fringe where 256 of them
/// are in the way. The bound warns of both.
fn multiples() -> Result<(), String> {
    let gpu = Gpu::shared()?;
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
        let compared = Compared { frame: &frame, truths: &truths, place: CENTRE, light: 0, explains: true };
        for counting in [Counting::Auto, Counting::ZFail] {
            let counted = renderer(&gpu).count(&frame, counting)?;
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
            let is_multiple = |&(x, y): &(u32, u32)| match truths[(y * frame.size + x) as usize][0] {
                Truth::Surface(between) => between.count(&[true]) == 256,
                _ => false,
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

/// Never below a count that a ray finds.
fn holds(bounds: &[u32], truths: &[Vec<Truth>], counted: &Counted) -> Result<(), String> {
    for truth in truths {
        let Truth::Surface(between) = truth[0] else { continue };
        for (caster, (&bound, lights)) in bounds.iter().zip(&counted.chosen).enumerate() {
            let [back_facing, facing] = between.0[caster];
            let count = match lights[0].casting {
                0 => 0,
                1 => back_facing,
                _ => back_facing + facing,
            };
            if u32::from(count) > bound {
                return Err(format!("caster {caster}: a count of {count}, the bound is {bound}"));
            }
        }
    }
    Ok(())
}

fn bound() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut tight = 0;
    for class in CLASSES {
        for number in 80..if is_long() { 100 } else { 81 } {
            let seed = seed(class, number);
            let frame = (class.frame)(&mut Random::new(seed));
            let counted = renderer(&gpu).count(&frame, Counting::ZFail)?;
            let got: Vec<u32> = counted.statistics.iter().map(|statistics| statistics.count_bound).collect();
            if number == 80 {
                golden("shadow", &format!("stencil_bound {}", class.name), &got)?;
            }
            let truths = rays::trace(&frame, CENTRE);
            holds(&got, &truths, &counted).map_err(|error| format!("{}, seed {seed}: {error}", class.name))?;
            let lower: Vec<u32> = got.iter().map(|_| 0).collect();
            if truths.iter().any(|truth| truth[0].is_shadowed()) {
                must_fail("a bound of nothing", &holds(&lower, &truths, &counted))?;
                tight += 1;
            }
        }
    }
    if tight > 0 { Ok(()) } else { Err("no frame had a shadow".to_owned()) }
}

/// Shapes of some thousands of faces, from lights around them.
fn ordinary() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let models = [
        ("torus", shapes::torus(48, 24, 1.0, 0.35)),
        ("blob", shapes::blob(48, 0.4, 3)),
        ("plane", shapes::plane_grid(64, 64)),
        ("moebius", shapes::moebius(96, 8)),
        ("sheets", shapes::three_sheets(24)),
    ];
    let mut random = Random::new(11);
    for (name, shape) in models {
        let mut frame = (CLASSES[0].frame)(&mut Random::new(1));
        frame.bodies = vec![Body::caster(shape), Body::room([0.0; 3], 8.0)];
        frame.lights = (0..8).map(|_| Light::point(random.direction().map(|c| c * 5.0))).collect();
        frame.lights.push(Light::directional(random.direction()));
        frame.size = 16;
        let options = OneCasterOptions { cull_by_view: false, bound_counts: true, ..OneCasterOptions::default() };
        let counted = Renderer { options, ..Renderer::new(&gpu) }.count(&frame, Counting::Auto)?;
        let statistics = counted.statistics[0];
        println!("{name}: bound {}", statistics.count_bound);
        if statistics.may_wrap != 0 || statistics.count_bound == 0 {
            return Err(format!("{name}: {statistics:?}"));
        }
    }
    Ok(())
}

/// Lists of silhouette edges with room for some, or for one: the same counts by each method, and right ones.
fn silhouettes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let methods = [Counting::Auto, Counting::ZpPlus, Counting::ZFail, Counting::ZPass, Counting::ZpPlus2005];
    let (mut compared, mut overflowed, mut doubled, mut shadowed) = (0, [0; 2], 0, 0);
    for (index, class) in CLASSES.iter().enumerate() {
        let traced = Traced::new(class, 110);
        let frame = &traced.frame;
        let casters = frame.bodies.iter().filter(|body| body.casts);
        let edges: Vec<u32> = casters
            .map(|body| body.shape.mesh().map(|mesh| mesh.edges().len() as u32).map_err(|error| error.to_string()))
            .collect::<Result<_, _>>()?;
        for counting in [rotated(&methods[..3], index), rotated(&methods[3..], index)].concat() {
            let whole = Renderer::new(&gpu).count(frame, counting)?;
            for capacity in [1, 100] {
                let what = format!("{}, seed {}, {counting:?}, room for {capacity}", class.name, traced.seed);
                let renderer = Renderer { list_capacity: Some(capacity), ..Renderer::new(&gpu) };
                let counted = renderer.count(frame, counting)?;
                // The published method sees all edges where a list overflowed, and leaves more to z-fail.
                let is_alike = counted.chosen == whole.chosen;
                let is_meant = is_alike || counting == Counting::ZpPlus2005;
                if !is_meant || (is_alike && counted.stencils != whole.stencils) {
                    return Err(format!("{what}: another picture"));
                }
                for ((draws, edges), lights) in counted.draws.iter().zip(&edges).zip(&counted.chosen) {
                    let instances = [draws[0].plain, draws[0].clipped].map(|draw| draw.instance_count);
                    let times = if lights[0].casting == 2 { 2 } else { 1 };
                    let all = [2 * edges, 6 * edges];
                    let is_all = instances.iter().any(|instances| all.contains(instances));
                    overflowed[usize::from(capacity > 1)] += usize::from(is_all);
                    doubled += usize::from(is_all && times == 2);
                }
                compared += usize::from(is_alike);
            }
        }
        let renderer = Renderer { list_capacity: Some(1), ..Renderer::new(&gpu) };
        let (_, counted) = traced.check(&renderer, Counting::Auto, !class.touches)?;
        let is_shadowed = traced.truths.iter().filter(|truths| truths[0].is_shadowed()).count();
        shadowed += is_shadowed;
        if is_shadowed > 100 {
            let lit = vec![0; counted.stencils[0].len()];
            let wrong = traced.compared().lit(&lit, &every(&counted, 0));
            must_fail("light for shadow", &wrong.pixels.first().map_or(Ok(()), |pixel| Err(format!("{pixel:?}"))))?;
        }
    }
    println!(
        "{compared} pictures, {shadowed} pixels in shadow; lists of 1 and of 100 that overflowed: {overflowed:?}, {doubled} drawn twice"
    );
    if overflowed.contains(&0) || doubled == 0 || shadowed == 0 {
        return Err("no list of a kind overflowed".to_owned());
    }
    Ok(())
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
