//! All that a scene of one caster records, from extraction to draws.

use rimline::gpu::{PositionBuffer, ShadowFormat, ShadowPipelines};
use rimline::internals::layout::{DrawArguments, ShadowDraws, ShadowLight};
use rimline::internals::shadow::{CAST_EVERY, CAST_NOTHING, COUNT_Z_FAIL};
use rimline::{Counting, Light};

use crate::stages::{LAYOUTS, instances, position_buffer};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::goldens::golden;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{chosen, draws, one_caster, shadow_statistics, text};
use rimline_testkit::random::Random;
use rimline_testkit::same;
use rimline_testkit::scenes::scene;

pub(crate) const TESTS: &[Test] = &[("shadow_volumes_from_extraction_to_draws", chain)];

const METHODS: [Counting; 5] =
    [Counting::Auto, Counting::ZpPlus, Counting::ZpPlus2005, Counting::ZFail, Counting::ZPass];

const LIGHTS: usize = 40;

/// The draws with so many instances of each list: quadrilaterals, pentagons where they are clipped, and triangles. The
/// published ZP+ clips nothing. Light caps, which casters that are not in the depth buffer alone have, are drawn from
/// the lists of far caps.
fn shaped(instances: [u32; 6], counting: Counting, in_depth: bool) -> ShadowDraws {
    let draw = |vertices: u32, instances: u32| DrawArguments {
        vertex_count: if instances == 0 { 0 } else { vertices },
        instance_count: instances,
        first_vertex: 0,
        first_instance: 0,
    };
    let [clipped, near] = if counting == Counting::ZpPlus2005 { [4, 3] } else { [5, 5] };
    let light = |far: u32| draw(4, if in_depth { 0 } else { far });
    ShadowDraws {
        plain: draw(4, instances[0]),
        clipped: draw(clipped, instances[1]),
        near_front: draw(near, instances[2]),
        near_back: draw(near, instances[3]),
        far_front: draw(3, instances[4]),
        far_back: draw(3, instances[5]),
        light_front: light(instances[4]),
        light_back: light(instances[5]),
    }
}

/// In each counting method, with lists that fit or overflow.
fn chain() -> Result<(), String> {
    // z-fail needs depth to be unclipped where the camera has a far plane.
    let gpu = &*Gpu::shared_with_depth_features()?;
    let seed = 104;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut overflowed, mut doubled, mut switched, mut ended, mut bounded, mut excluded, mut overflowed_sides) =
        (0, 0, 0, 0, 0, 0, 0);
    for counting in METHODS {
        for number in 0..6 {
            let mut scene = scene(&mut random, number, LIGHTS);
            // Lights on vertices of the caster, so in planes of its faces.
            for light in &mut scene.lights[..4] {
                *light = Light::point(scene.caster.1[random.below(scene.caster.1.len())]);
            }
            let (name, (_, positions, mesh)) = (&scene.name, &scene.caster);
            let (depth, has_far_plane) = (scene.camera.depth, scene.camera.has_far_plane());
            let format = ShadowFormat { depth, has_far_plane, ..ShadowFormat::default() };
            let pipelines = ShadowPipelines::new(&gpu.pipelines, &format, counting).map_err(text)?;
            let capacity = [None, Some(30)][number % 2];
            let options = OneCasterOptions {
                // Ten more than are used.
                max_lights: LIGHTS + 10,
                list_capacity: capacity,
                every_face: number == 3,
                in_depth: !matches!(number, 1 | 5),
                cap_capacity: [None, Some(9)][number / 2 % 2],
                cull_by_view: number != 4,
                end_at_range: number % 3 == 2,
                bound_counts: number % 2 == 1 || number == 0,
                ..OneCasterOptions::default()
            };
            let mut caster = one_caster(gpu, &pipelines, mesh, options).map_err(text)?;
            let layout = LAYOUTS[number % 3];
            let buffer = position_buffer(gpu, positions, layout);
            let bound =
                PositionBuffer { buffer: &buffer, offset: 4 * u64::from(layout.0), stride: 4 * u64::from(layout.1) };
            let frame = gpu.submit(|encoder| {
                caster.encode(encoder, bound, &scene.lights, Some(&scene.camera), None).map_err(text)
            })?;
            let lights = chosen(gpu, &frame, LIGHTS)?;
            let draws = draws(gpu, &frame, LIGHTS + 10)?;
            let what = format!("{counting:?}, {name}");
            same(&format!("{what}, lights not in use"), &draws[LIGHTS..], &[bytemuck::Zeroable::zeroed(); 10])?;
            let shaped = |draw: &ShadowDraws| shaped(instances(draw), counting, options.in_depth);
            let expected: Vec<ShadowDraws> = draws[..LIGHTS].iter().map(shaped).collect();
            same(&format!("{what}, draws"), &draws[..LIGHTS], &expected)?;
            let statistics = shadow_statistics(gpu, &frame)?;
            // Distances come from a division and a square root, which WGSL lets be off by some units of the last place.
            let mut words: Vec<u32> =
                lights.iter().flat_map(|light| [light.casting, light.counting, light.excludes]).collect();
            words.extend(draws[..LIGHTS].iter().flat_map(instances));
            words.extend_from_slice(bytemuck::cast_slice(&[statistics]));
            golden("shadow", &format!("shadow_volumes {counting:?} {number}"), &words)?;
            overflowed += statistics.overflowed_caps;
            overflowed_sides += statistics.overflowed_sides;
            ended += statistics.ended;
            bounded += u32::from(statistics.count_bound > 0);
            let counted = |is: fn(&ShadowLight) -> bool| lights.iter().filter(|light| is(light)).count();
            if counting == Counting::ZpPlus2005 {
                switched += counted(|light| light.casting != CAST_NOTHING && light.counting == COUNT_Z_FAIL);
            }
            excluded += counted(|light| light.excludes != 0);
            doubled += counted(|light| light.casting == CAST_EVERY);
        }
    }
    println!(
        "{overflowed} lights with lists that overflow, {doubled} with every face, {switched} switched, {ended} ended, \
         {bounded} scenes with a bound, {excluded} lights that exclude faces, {overflowed_sides} with lists of sides that overflow"
    );
    if overflowed.min(ended).min(bounded).min(overflowed_sides) == 0 || doubled.min(switched).min(excluded) == 0 {
        return Err("too few of a kind".to_owned());
    }
    Ok(())
}
