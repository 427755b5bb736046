//! Every level of skipping alone, all and none: the picture stays the same, and is what rays tell.

use glam::{DVec3, Vec3};
use rimline::Counting;
use rimline::gpu::{Capacities, Measuring, SceneOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::frames::{Body, Eye};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, made_anew, must_fail, same, shapes};

use crate::culled::behind_walls;
use crate::range::in_range;
use crate::rays::Truth;
use crate::render::{Counted, Levels, Placing, Renderer};
use crate::trials::{Test, Traced, every};

pub(crate) const TESTS: &[Test] =
    &[("levels_of_skipping_change_no_picture", levels), ("occluded_casters_change_no_picture", occluded)];

const EACH: [Measuring; 6] = [
    Measuring::CULLED_BY_RANGE,
    Measuring::CULLED_BY_VIEW,
    Measuring::CACHED_BITS,
    Measuring::CACHED_LISTS,
    Measuring::CULLED_BY_RECEIVERS,
    Measuring::CULLED_BY_OCCLUDERS,
];

/// None, all, then each alone: names, and what they switch on.
const CHOICES: [(&str, Levels); 8] = [
    ("none", (&[], false)),
    ("all", (&EACH, true)),
    ("light reach", (&[Measuring::CULLED_BY_RANGE], false)),
    ("shadow reach", (&[Measuring::CULLED_BY_VIEW], false)),
    ("bits", (&[Measuring::CACHED_BITS], false)),
    ("bits and lists", (&[Measuring::CACHED_BITS, Measuring::CACHED_LISTS], false)),
    ("hidden receivers", (&[Measuring::CULLED_BY_RECEIVERS], false)),
    ("clusters", (&[], true)),
];

/// The counts where the eye sees a surface that the light reaches.
fn seen(traced: &Traced, counted: &Counted) -> Vec<u8> {
    let pixels = counted.stencils[0].iter().zip(&traced.truths);
    pixels.map(|(&count, truths)| if truths[0] == Truth::Background { 0 } else { count }).collect()
}

/// Counters that show the effect of each level.
fn counters(counted: &Counted) -> Result<[u32; 6], String> {
    let scene = counted.scene.ok_or("no scene")?;
    let shadows = counted.statistics[0];
    let unseen = shadows.skipped - shadows.culled_by_receivers - shadows.culled_by_range;
    Ok([
        scene.pairs_culled_by_range + shadows.culled_by_range,
        unseen,
        scene.cached_pairs,
        shadows.cached_lists,
        shadows.culled_by_receivers,
        scene.untested_faces,
    ])
}

fn levels() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let (mut pictures, mut shadowed, mut counts) = (0, 0, [[0; 6]; CHOICES.len()]);
    for (index, class) in CLASSES.iter().enumerate() {
        // Two of five numbers, others for the next class.
        let few = vec![400 + index as u64 % 5, 400 + (index as u64 + 1) % 5];
        for number in if is_long() { (400..420).collect() } else { few } {
            let (traced, range) = if class.name == "directional lights" {
                (Traced::new(class, number), f32::INFINITY)
            } else {
                let (mut traced, _, range) = in_range(class, number);
                // A caster behind the eye that the light does not reach.
                let Eye { position, forward, .. } = traced.frame.eye;
                let [x, y, z] = traced.frame.lights[0].xyz.map(|c| f64::from(c / traced.frame.lights[0].w));
                let away = 4.0 * f64::from(range) + 2.0 * position.distance(DVec3::new(x, y, z));
                let at = (position - away * forward.normalize()).as_vec3().to_array();
                traced.frame.bodies.push(Body::caster(shapes::cube()).scaled(0.2 * range).moved(at));
                (traced, range)
            };
            let counting = [Counting::Auto, Counting::ZpPlus, Counting::ZFail][number as usize % 3];
            // Volumes that never end, lists of few entries, and rigid casters, each in some.
            let end_at_range = number % 4 == 0 && counting != Counting::ZpPlus;
            let capacities = Capacities { lists: (number % 2 == 1).then_some(2), ..Capacities::default() };
            let options = SceneOptions { end_at_range, capacities, ..made_anew(32, Counting::Auto) };
            let placing = if number % 2 == 0 { Placing::Moved(traced.seed) } else { Placing::Busy(traced.seed) };
            let of = |levels| Renderer {
                options,
                range,
                placing,
                levels: Some(levels),
                receivers: Some(false),
                ..Renderer::new(gpu)
            };
            let mut expected = None;
            for (choice, (name, levels)) in CHOICES.into_iter().enumerate() {
                let what = |error| format!("{}, {number}, {counting:?}, range {range}, {name}: {error}", class.name);
                // Where all are moved far away, hairlines are elsewhere; tests/shadow/in_scene.rs compares those.
                let counted = match placing {
                    Placing::Moved(_) => of(levels).count(&traced.frame, counting),
                    _ => traced.check(&of(levels), counting, false).map(|(_, counted)| counted),
                };
                let counted = counted.map_err(what)?;
                let found = seen(&traced, &counted);
                let (expected, every) = expected.get_or_insert_with(|| (found.clone(), every(&counted, 0)));
                let alike = |found: &[u8]| traced.compared().alike("counts", found, expected, every);
                alike(&found).map_err(what)?;
                let mut wrong = found;
                let middle = wrong.len() / 2;
                wrong[middle] ^= 64;
                must_fail("one count", &alike(&wrong))?;
                let of_choice = counters(&counted)?;
                counts[choice] = std::array::from_fn(|counter| counts[choice][counter] + of_choice[counter]);
                pictures += 1;
            }
            shadowed += traced.shadowed();
        }
    }
    println!("{pictures} pictures, {shadowed} pixels in shadow");
    for ((name, _), counts) in CHOICES.iter().zip(&counts) {
        println!("{name}: {counts:?}");
    }
    let [none, all, alone @ ..] = counts;
    // Each level alone changes its own counter.
    let acts = alone.iter().zip([0, 1, 2, 3, 4, 5]).all(|(counts, of)| counts[of] != none[of]);
    let acts_with_all = (0..6).all(|counter| all[counter] != none[counter]);
    if acts && acts_with_all && shadowed > 0 { Ok(()) } else { Err("not as meant".to_owned()) }
}

/// Walls whose faces are declared as occluders, and bodies before and behind them.
fn occluded() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let (mut culled, mut shadowed) = (0, 0);
    for number in 0..if is_long() { 400 } else { 40 } {
        let seed = 7300 + number;
        let mut random = Random::new(seed);
        let mut frame = behind_walls(&mut random);
        // Plates, and small bodies on both sides of them.
        for body in &mut frame.bodies {
            body.casts = true;
        }
        for _ in 0..6 {
            let at = [random.between(-5.0, 5.0), random.between(-1.5, 3.0), random.between(-9.0, -3.0)];
            frame.bodies.push(Body::caster(shapes::sphere(2)).scaled(random.between(0.02, 0.15)).moved(at));
        }
        let counting = [Counting::Auto, Counting::ZpPlus, Counting::ZFail][number as usize % 3];
        // Mirrored bodies have a matrix. All stay near, where proofs succeed.
        for (body, flip) in frame.bodies.iter_mut().zip([1.0, -1.0].into_iter().cycle()) {
            body.mirror = Some(Vec3::new(flip, 1.0, 1.0));
        }
        let of = |levels| Renderer { placing: Placing::Scene, levels: Some(levels), ..Renderer::new(gpu) };
        let without = of((&[], false)).count(&frame, counting)?;
        let with = of((&EACH, true)).count(&frame, counting)?;
        let is_dark = |counted: &Counted| counted.stencils[0].iter().map(|count| *count != 0).collect::<Vec<_>>();
        let expected = is_dark(&without);
        same(&format!("seed {seed}, {counting:?}: dark pixels"), &is_dark(&with), &expected)?;
        culled += with.scene.ok_or("no scene")?.pairs_culled_by_occluders;
        shadowed += expected.iter().filter(|dark| **dark).count();
    }
    println!("{culled} pairs culled, {shadowed} dark pixels");
    if culled < 40 || shadowed == 0 { Err("too few".to_owned()) } else { Ok(()) }
}
