//! All that a scene records, from extraction to draws, by goldens: of ten thousand casters, thirty-two lights and three
//! views; of one caster by each counting method. The last stage is `shadow_arguments`.

use glam::{DQuat, DVec3};
use rimline::gpu::{Capacities, Caster, FrameInputs, Measuring, PositionBuffer, Scene, SceneOptions, StencilCounts};
use rimline::internals::layout::{ShadowDraws, ShadowLight, ShadowStatistics, StencilPencil};
use rimline::internals::shadow::{CAST_EVERY, CAST_NOTHING, COUNT_Z_FAIL};
use rimline::{Counting, Light, Matrix3x4};

use crate::trials::Test;
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::Eye;
use rimline_testkit::goldens::golden;
use rimline_testkit::on_gpu::{chosen, draws, interleaved, shadow_statistics, text, views};
use rimline_testkit::random::Random;
use rimline_testkit::scenes::scene;
use rimline_testkit::{OneCaster, made_anew, shapes};

pub(crate) const TESTS: &[Test] =
    &[("ten_thousand_casters", thousands), ("shadow_volumes_from_extraction_to_draws", chain)];

const CASTERS: usize = 10_000;
const LIGHTS: usize = 32;

fn placement(random: &mut Random) -> Matrix3x4 {
    let [x, y, z] = random.direction().map(f64::from);
    let turn = DQuat::from_axis_angle(DVec3::new(x, y, z).normalize(), f64::from(random.between(0.0, 6.0)));
    let position = [(); 3].map(|()| random.between(-40.0, 40.0));
    let matrix = (glam::DMat3::from_quat(turn) * f64::from(random.between(0.2, 1.5))).as_mat3();
    [0, 1, 2].map(|axis| {
        let [x, y, z] = matrix.row(axis).to_array();
        [x, y, z, position[axis]]
    })
}

fn thousands() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(301)?;
    let models = [shapes::cube(), shapes::plane_grid(2, 2)];
    // Room for every side and cap.
    let capacities = Capacities { lists: Some(1 << 20), caps: Some(1 << 18), ..Capacities::default() };
    let stencil = StencilCounts { bound_counts: true, ..StencilCounts::default() };
    let options = SceneOptions { max_lights: LIGHTS, stencil, capacities, ..SceneOptions::default() };
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let mut meshes = Vec::new();
    for model in &models {
        meshes.push(scene.add_mesh(&model.mesh().map_err(text)?, &model.positions).map_err(text)?);
    }
    for number in 0..CASTERS {
        let rows = placement(&mut random);
        let model = usize::from(number % 5 == 0);
        scene.insert(Caster::rigid(meshes[model], rows)).map_err(text)?;
    }
    for number in 0..LIGHTS {
        // At infinity, around the casters or among them.
        let light = match number % 4 {
            0 => Light::directional(random.direction()),
            3 => Light::point(random.direction().map(|c| 25.0 * c)),
            _ => Light::point(random.direction().map(|c| 75.0 * c)),
        };
        scene.add_light(light).map_err(text)?;
    }
    let cameras = [(); 3].map(|()| {
        let position = DVec3::from(random.direction().map(|c| f64::from(30.0 * c)));
        Eye { is_relative: true, ..Eye::new(position, -position, 0.1) }.camera()
    });
    let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::new(&views(&cameras))).map_err(text))?;
    let results = frame.results().map_err(text)?;
    let draws: Vec<ShadowDraws> = gpu.read(&results.shadow_draws[0], 3 * LIGHTS)?;
    let words: Vec<u32> = gpu.read(results.choices.ok_or("no view")?, usize::MAX)?;
    let statistics: Vec<ShadowStatistics> = gpu.read(frame.shadow_statistics().ok_or("no view")?, 1)?;
    let statistics = statistics[0];
    println!("{statistics:?}, {} bytes", results.bytes);
    if results.groups.len() != 1 || statistics.overflowed_sides + statistics.overflowed_caps > 0 {
        return Err("not as meant".to_owned());
    }
    let [pencils, bin_rows] = results.bound.ok_or("no bound")?;
    let pencils: Vec<StencilPencil> = gpu.read(pencils, usize::MAX)?;
    let bin_rows: Vec<u32> = gpu.read(bin_rows, usize::MAX)?;
    let row = bin_rows.len() / pencils.len();
    // Each view has lights of its own.
    for (number, draws) in draws.chunks(LIGHTS).enumerate() {
        let instances: Vec<u32> = draws.iter().flat_map(instances).collect();
        golden("shadow", &format!("ten_thousand_casters draws of view {number}"), &instances)?;
        let choices: Vec<u32> =
            (0..CASTERS).flat_map(|caster| words[8 * (number * CASTERS + caster)..][..3].iter().copied()).collect();
        golden("shadow", &format!("ten_thousand_casters choices of view {number}"), &choices)?;
    }
    // The kind of each pencil, for those around an axis which it is, and the faces of casters that it may meet, and of all.
    let of_pencil = |(pencil, row): (&StencilPencil, &[u32])| {
        let is_axis = |axis: &usize| pencil.kind == 2 && pencil.forward[*axis] == 0.0 && pencil.aside[*axis] == 0.0;
        [pencil.kind, (0..3).find(is_axis).unwrap_or(3) as u32, row[1025], row[1026]]
    };
    let mut of_pencils: Vec<u32> = pencils.iter().zip(bin_rows.chunks(row)).flat_map(of_pencil).collect();
    of_pencils.extend([statistics.count_bound, statistics.may_wrap]);
    golden("shadow", "ten_thousand_casters pencils", &of_pencils)?;
    let kinds = [0, 1, 2].map(|kind| pencils.iter().filter(|pencil| pencil.kind == kind).count());
    let near: u32 = draws.iter().map(|draws| draws.near_front.instance_count + draws.near_back.instance_count).sum();
    println!("{near} near caps, {kinds:?} pencils of each kind");
    if kinds.contains(&0) || near == 0 { Err("no pencil of a kind, or no near cap".to_owned()) } else { Ok(()) }
}

const METHODS: [Counting; 5] =
    [Counting::Auto, Counting::ZpPlus, Counting::ZpPlus2005, Counting::ZFail, Counting::ZPass];

const CHAIN_LIGHTS: usize = 40;

/// Instances of the draws of a light: of plain and clipped sides, near caps, and far ones.
fn instances(draws: &ShadowDraws) -> [u32; 6] {
    let ShadowDraws { plain, clipped, near_front, near_back, far_front, far_back, .. } = draws;
    [plain, clipped, near_front, near_back, far_front, far_back].map(|draw| draw.instance_count)
}

/// In each counting method, with lists that fit or overflow.
fn chain() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(104)?;
    let mut seen = [0; 7];
    for counting in METHODS {
        for number in 0..6 {
            let mut scene = scene(&mut random, number, CHAIN_LIGHTS);
            // Lights on vertices of the caster, so in planes of its faces.
            for light in &mut scene.lights[..4] {
                *light = Light::point(scene.caster.1[random.below(scene.caster.1.len())]);
            }
            let (_, positions, mesh) = &scene.caster;
            // Ten more lights than are used.
            let mut options = made_anew(CHAIN_LIGHTS + 10, counting);
            options.capacities.lists = [None, Some(30)][number % 2];
            options.capacities.caps = [None, Some(9)][number / 2 % 2];
            options.measuring.set(Measuring::EVERY_FACE, number == 3);
            options.measuring.set(Measuring::CULLED_BY_VIEW, number == 4);
            options.end_at_range = number % 3 == 2;
            options.stencil.bound_counts = number % 2 == 1 || number == 0;
            let mut caster = OneCaster::new(&gpu.pipelines, &gpu.queue, mesh, options).map_err(text)?;
            caster.in_depth = !matches!(number, 1 | 5);
            let (offset, stride) = [(0, 12), (20, 12), (28, 32)][number % 3];
            let buffer = gpu.storage(&interleaved(positions, offset, stride));
            let bound = PositionBuffer { buffer: &buffer, offset, stride };
            let frame = gpu.submit(|encoder| {
                caster.encode(encoder, bound, &scene.lights, Some(&scene.camera), None).map_err(text)
            })?;
            let lights = chosen(&gpu, &frame, CHAIN_LIGHTS)?;
            let draws = draws(&gpu, &frame, CHAIN_LIGHTS + 10)?;
            let statistics = shadow_statistics(&gpu, &frame)?;
            // Distances come from a division and a square root, which WGSL lets be off by some units of the last place.
            let mut words: Vec<u32> =
                lights.iter().flat_map(|light| [light.casting, light.counting, light.excludes]).collect();
            words.extend_from_slice(bytemuck::cast_slice(&draws));
            words.extend_from_slice(bytemuck::cast_slice(&[statistics]));
            golden("shadow", &format!("shadow_volumes {counting:?} {number}"), &words)?;
            let counted = |is: fn(&ShadowLight) -> bool| lights.iter().filter(|light| is(light)).count() as u32;
            // Case D of ZP+ as published (`zp_plus_2005_cases`): excluded faces would leave the caster to z-fail, too.
            let switched =
                counted(|light| light.casting != CAST_NOTHING && light.counting == COUNT_Z_FAIL && light.excludes == 0);
            let found = [
                statistics.overflowed_caps,
                statistics.overflowed_sides,
                statistics.ended,
                statistics.count_bound.min(1),
                if counting == Counting::ZpPlus2005 { switched } else { 0 },
                counted(|light| light.excludes != 0),
                counted(|light| light.casting == CAST_EVERY),
            ];
            seen = std::array::from_fn(|kind| seen[kind] + found[kind]);
        }
    }
    println!(
        "lists of caps and sides that overflow, volumes that end, bounds, switched, excluding, with every face: {seen:?}"
    );
    if seen.contains(&0) { Err("none of a kind".to_owned()) } else { Ok(()) }
}
