//! All that extractions leave, against the CPU: facing, masks, lists, counts, draws.
//!
//! It tests the stages `compact` and `arguments`.

use bytemuck::Zeroable;
use rimline::Predicate;
use rimline::gpu::{EdgeTopology, Extractor, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::internals::Method;
use rimline::internals::cpu::{self, Extraction, Threads};
use rimline::internals::layout::{DrawArguments, EdgeMasks};

use rimline_testkit::cases::{case, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{Found, extract, read, text};
use rimline_testkit::oracle::listed;
use rimline_testkit::random::Random;
use rimline_testkit::{lights, must_fail, same, shapes};

pub(crate) const TESTS: &[Test] = &[
    ("results_are_those_of_the_cpu", results),
    ("per_edge_keeps_to_its_lights", per_edge),
    ("any_number_of_a_thousand_lights_has_its_lists", thousand),
    ("encodes_in_one_encoder_see_their_own_lights", several_encodes),
];

/// Fails unless an extraction left what `twin` has, for this number of lights, and no edge for the lights after them.
pub(crate) fn check(
    what: &str,
    found: &Found,
    twin: &Extraction,
    lights: usize,
    options: &ExtractorOptions,
) -> Result<(), String> {
    same(&format!("{what}, facing"), &found.facing[..twin.facing.len()], &twin.facing)?;
    if options.masks {
        same(&format!("{what}, masks"), &found.masks[..twin.masks.len()], &twin.masks)?;
    }
    options.lists.map_or(Ok(()), |lists| check_lists(what, found, &twin.masks, lights, lists))
}

fn check_lists(
    what: &str,
    found: &Found,
    masks: &[EdgeMasks],
    lights: usize,
    lists: ListOptions,
) -> Result<(), String> {
    let edges = masks.len() / lights.div_ceil(32);
    let room = lists.capacity.map_or(edges, |room| (room as usize).clamp(1, edges));
    let mut overflowed = 0;
    for (light, (list, draw)) in found.lists.iter().zip(&found.draws).enumerate() {
        let what = format!("{what}, light {light}");
        let plane = masks.chunks(edges).nth(light / 32).filter(|_| light < lights).unwrap_or_default();
        let (mut list, mut expected) = (list.clone(), listed(plane, light as u32 % 32));
        let (count, overflows) = (expected.len() as u32, expected.len() > room);
        overflowed += u32::from(overflows);
        // A list that overflowed is drawn from all edges.
        let instance_count = if overflows { edges as u32 } else { count };
        let vertex_count = lists.topology.vertices();
        let expected_draw = DrawArguments { vertex_count, instance_count, ..Zeroable::zeroed() };
        same(&what, &[found.counts[light]], &[count])?;
        same(&what, &[*draw], &[expected_draw])?;
        if lists.ordered {
            expected.truncate(room);
        } else {
            // Which entries it keeps then is chance.
            expected.retain(|entry| !overflows || list.contains(entry));
            list.sort_by_key(|entry| entry & !cpu::WINDING);
        }
        same(&what, &list, &expected)?;
    }
    same(&format!("{what}, overflowed"), &[found.statistics.overflowed_lists], &[overflowed])
}

/// Masks are kept or not; lists have an order or not, and room for all, a few or none.
fn results() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(1);
    for (name, positions, mesh) in topologies() {
        for (count, masks, lists, undecided_capacity) in [
            (1, true, Some((None, true)), None),
            (12, false, Some((None, true)), Some(0)),
            (31, false, Some((Some(u32::MAX), false)), None),
            (32, true, None, None),
            (33, true, Some((Some(20), true)), None),
            (100, true, Some((Some(20), false)), None),
            (33, false, Some((Some(0), false)), None),
        ] {
            let topology = [EdgeTopology::TriangleStrip, EdgeTopology::TriangleList, EdgeTopology::LineList][count % 3];
            let lists = lists.map(|(capacity, ordered)| ListOptions { capacity, ordered, topology });
            let options =
                ExtractorOptions { max_lights: count, masks, lists, undecided_capacity, ..Default::default() };
            let lights = lights(&mut random, count);
            let twin = cpu::extract(&positions, &mesh, &lights, Predicate::Exact, Threads::all()).map_err(text)?;
            let mut found = extract(gpu, &positions, &mesh, &lights, options)?;
            let what = format!("{name}, {count} lights, masks {masks}, {lists:?}");
            check(&what, &found, &twin, count, &options)?;
            if let Some(of_last) = found.masks.last_mut() {
                of_last.winding ^= 1;
            } else if let Some(list) = found.lists.iter_mut().find(|list| !list.is_empty()) {
                list[0] ^= cpu::WINDING;
            }
            must_fail("a flipped winding bit", &check(&what, &found, &twin, count, &options))?;
        }
    }
    Ok(())
}

/// Masks of the 2003 method have no bits past the lights, and its lists hold what its masks say.
fn per_edge() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(6);
    let lists = ListOptions { capacity: Some(u32::MAX), ..ListOptions::default() };
    for (name, positions, mesh) in topologies() {
        for (count, max_lights) in [(1, 1), (33, 33), (5, 100)] {
            let lights = lights(&mut random, count);
            let method = Method::PerEdge;
            let options =
                ExtractorOptions { max_lights, method, masks: true, lists: Some(lists), ..Default::default() };
            let found = extract(gpu, &positions, &mesh, &lights, options)?;
            let what = format!("{name}, {count} lights of {max_lights}");
            let masks = &found.masks[..count.div_ceil(32) * mesh.edges().len()];
            check_lists(&what, &found, masks, count, lists)?;
            let past = u32::MAX << (count % 32);
            if masks.iter().rev().take(mesh.edges().len()).any(|of| (of.silhouette | of.winding) & past != 0) {
                return Err(format!("{what}: bits past the lights"));
            }
        }
    }
    Ok(())
}

fn thousand() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(41);
    let (_, positions, mesh) = case("blob", shapes::blob(2, 0.4, 3));
    let buffer = gpu.storage(&positions);
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    for ordered in [false, true] {
        let lists = Some(ListOptions { capacity: Some(u32::MAX), ordered, ..ListOptions::default() });
        let options = ExtractorOptions { max_lights: 1024, masks: true, lists, ..Default::default() };
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
        // First all of them, so that something could be left over.
        for count in [1024, 1, 31, 32, 33, 99] {
            let lights = lights(&mut random, count);
            gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
            let found = read(gpu, &extractor, &mesh, 1024)?;
            let twin = cpu::extract(&positions, &mesh, &lights, Predicate::Exact, Threads::all()).map_err(text)?;
            check(&format!("{count} of 1024 lights, ordered {ordered}"), &found, &twin, count, &options)?;
        }
    }
    Ok(())
}

/// Results are copied out between encodes; a later encode must not reach back.
fn several_encodes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(42);
    let (_, positions, mesh) = case("torus", shapes::torus(24, 16, 1.0, 0.4));
    let moved = positions.iter().map(|[x, y, z]| [x * 0.5, y + 0.3, *z]).collect();
    for ordered in [false, true] {
        let lists = Some(ListOptions { ordered, ..ListOptions::default() });
        let options = ExtractorOptions { max_lights: 40, masks: true, lists, ..Default::default() };
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
        let runs = [(&positions, 40), (&moved, 7), (&positions, 33)];
        let runs = runs.map(|(positions, count)| (positions, gpu.storage(positions), lights(&mut random, count)));
        let zeros = vec![0_u8; mesh.edges().len() * size_of::<EdgeMasks>()];
        let copies = runs.each_ref().map(|_| [gpu.storage(&zeros), gpu.storage(&[0_u32; 40])]);
        gpu.submit(|encoder| {
            for ((_, buffer, lights), [masks, counts]) in runs.iter().zip(&copies) {
                let positions = PositionBuffer { buffer, offset: 0, stride: 12 };
                extractor.encode(encoder, positions, lights).map_err(text)?;
                let results = extractor.results();
                encoder.copy_buffer_to_buffer(&results.masks[0], 0, masks, 0, masks.size());
                encoder.copy_buffer_to_buffer(results.counts, 0, counts, 0, counts.size());
            }
            Ok(())
        })?;
        for (number, ((positions, _, lights), [masks, counts])) in runs.iter().zip(&copies).enumerate() {
            let twin = cpu::extract(positions, &mesh, lights, Predicate::Exact, Threads::all()).map_err(text)?;
            let masks: Vec<EdgeMasks> = gpu.read(masks, mesh.edges().len())?;
            same(&format!("encode {number}, masks"), &masks, &twin.masks[..masks.len()])?;
            let planes = twin.masks.chunks(mesh.edges().len());
            let of_lights = |at: usize| listed(planes.clone().nth(at / 32).unwrap_or_default(), at as u32 % 32).len();
            let expected: Vec<u32> = (0..lights.len()).map(|light| of_lights(light) as u32).collect();
            same(&format!("encode {number}, counts"), &gpu.read::<u32>(counts, lights.len())?, &expected)?;
        }
    }
    Ok(())
}
