//! Edges against their CPU reference, and all that comes after them against whole numbers.
//!
//! It tests the stages `compact` and `arguments`.

use bytemuck::Zeroable;
use rimline::gpu::{EdgeTopology, ExtractorOptions, ListOptions};
use rimline::internals::Method;
use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::DrawArguments;

use rimline_testkit::band::check_facing;
use rimline_testkit::cases::{case, hard_positions, random_soup, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::extract;
use rimline_testkit::oracle::{check_masks, listed};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, lights, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("masks_and_lists_follow_from_facing_bits", masks_and_lists),
    ("masks_close_and_agree_with_faces_alone", closes),
    ("per_edge_keeps_to_its_lights", per_edge),
    ("overflowing_lists_are_counted_and_drawn_whole", overflow),
];

const LIGHT_COUNTS: [usize; 6] = [1, 12, 31, 32, 33, 100];

fn list_options(capacity: Option<u32>, ordered: bool) -> ListOptions {
    ListOptions { capacity, ordered, topology: EdgeTopology::TriangleList }
}

/// Masks and lists against those that follow from the facing bits of the GPU, for all counts of lights. Facing is checked
/// against its error band; all later stages are integers. Lists are made with masks and without, in order and in any order.
fn masks_and_lists() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(1);
    let [ordered, unordered] = [(None, true), (Some(u32::MAX), false)].map(|of| Some(list_options(of.0, of.1)));
    for (name, positions, mesh) in topologies() {
        for count in LIGHT_COUNTS {
            let lights = lights(&mut random, count);
            for (masks, lists) in [(true, None), (false, ordered), (true, ordered), (false, unordered)] {
                let options = ExtractorOptions { max_lights: count, masks, lists, ..Default::default() };
                let mut found = extract(gpu, &positions, &mesh, &lights, options)?;
                let what = format!("{name}, {count} lights, masks {masks}, {lists:?}");
                let expected = cpu::edges(mesh.edges(), &found.facing, mesh.faces().len(), count, Threads::all());
                if lists.is_none() {
                    check_facing(&what, &found.facing, &positions, mesh.faces(), &lights)?;
                }
                if masks {
                    same(&format!("{what}, masks"), &found.masks, &expected)?;
                    found.masks[random.below(expected.len())].winding ^= 1;
                    must_fail("a flipped winding bit", &same(&what, &found.masks, &expected))?;
                }
                for (light, list) in found.lists.iter_mut().enumerate() {
                    let plane = &expected[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
                    let expected = listed(plane, light as u32 % 32);
                    if lists.is_some_and(|lists| !lists.ordered) {
                        list.sort_by_key(|entry| entry & !cpu::WINDING);
                    }
                    same(&format!("{what}, list {light}"), list, &expected)?;
                    let draws = [found.counts[light], found.draws[light].instance_count];
                    same(&format!("{what}, draw {light}"), &draws, &[expected.len() as u32; 2])?;
                }
                let live = |word: usize| 1_u64.checked_shl((count - 32 * word) as u32).map_or(u64::MAX, |bit| bit - 1);
                for (at, masks) in expected.iter().enumerate() {
                    if u64::from(masks.silhouette | masks.winding) & !live(at / mesh.edges().len()) != 0 {
                        return Err(format!("{what}: record {at} has bits past the lights"));
                    }
                }
            }
        }
    }
    Ok(())
}

fn overflow() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4);
    let lights = lights(&mut random, 40);
    for (name, positions, mesh) in topologies() {
        let whole =
            ExtractorOptions { max_lights: 40, lists: Some(list_options(Some(u32::MAX), true)), ..Default::default() };
        let whole = extract(gpu, &positions, &mesh, &lights, whole)?;
        for ordered in [false, true] {
            let options =
                ExtractorOptions { max_lights: 40, lists: Some(list_options(Some(20), ordered)), ..Default::default() };
            let found = extract(gpu, &positions, &mesh, &lights, options)?;
            same(&format!("{name}, counts"), &found.counts, &whole.counts)?;
            // A list that overflowed is drawn from all edges.
            let instances = |&count: &u32| if count > 20 { mesh.edges().len() as u32 } else { count };
            let draw =
                |count| DrawArguments { vertex_count: 6, instance_count: instances(count), ..Zeroable::zeroed() };
            let draws: Vec<_> = whole.counts.iter().map(draw).collect();
            same(&format!("{name}, draws"), &found.draws, &draws)?;
            let overflowed = whole.counts.iter().filter(|&&count| count > 20).count() as u32;
            same(&format!("{name}, overflowed"), &[found.statistics.overflowed_lists], &[overflowed])?;
            for (list, whole) in found.lists.iter().zip(&whole.lists) {
                if ordered {
                    same(&format!("{name}, list"), list, &whole[..whole.len().min(20)])?;
                } else if !list.iter().all(|entry| whole.contains(entry)) {
                    return Err(format!("{name}: a list holds what is no silhouette"));
                }
            }
        }
    }
    Ok(())
}

/// Masks of the 2003 method have no bits past the lights, and its lists hold what its masks say.
fn per_edge() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(6);
    for (name, positions, mesh) in topologies() {
        for (count, max_lights) in [(1, 1), (5, 5), (33, 33), (5, 100)] {
            let lights = lights(&mut random, count);
            let options = ExtractorOptions {
                max_lights,
                method: Method::PerEdge,
                masks: true,
                lists: Some(list_options(Some(u32::MAX), false)),
                ..Default::default()
            };
            let found = extract(gpu, &positions, &mesh, &lights, options)?;
            let what = format!("{name}, {count} lights of {max_lights}");
            for light in 0..max_lights {
                let plane = &found.masks[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
                let expected = if light < count { listed(plane, light as u32 % 32) } else { Vec::new() };
                let mut list = found.lists[light].clone();
                list.sort_by_key(|entry| entry & !cpu::WINDING);
                same(&format!("{what}, list {light}"), &list, &expected)?;
                same(&format!("{what}, draw {light}"), &[found.draws[light].instance_count], &[expected.len() as u32])?;
            }
            for (word, plane) in found.masks.chunks(mesh.edges().len()).take(count.div_ceil(32)).enumerate() {
                let lights = (count - 32 * word).min(32) as u32;
                let past = u32::MAX.checked_shl(lights).unwrap_or(0);
                if plane.iter().any(|masks| (masks.silhouette | masks.winding) & past != 0) {
                    return Err(format!("{what}: bits past the lights"));
                }
            }
        }
    }
    Ok(())
}

/// Masks against the faces alone, and closed at every vertex.
fn closes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(33);
    let soups = 0..if is_long() { 400 } else { 12 };
    let soups: Vec<_> = soups.map(|index| case(format!("soup {index}"), random_soup(&mut random))).collect();
    let ordinary = topologies().into_iter().chain(soups).map(|case| (case, lights(&mut random, 100)));
    let hard = hard_positions(&mut Random::new(31)).into_iter().map(|(_, case, lights)| (case, lights));
    for ((name, positions, mesh), lights) in ordinary.chain(hard) {
        let options = ExtractorOptions { max_lights: lights.len(), masks: true, lists: None, ..Default::default() };
        let found = extract(gpu, &positions, &mesh, &lights, options)?;
        check_masks(&name, &mesh, &found.facing, &found.masks, lights.len())?;
    }
    Ok(())
}
