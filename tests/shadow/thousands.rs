//! Ten thousand casters, thirty-two lights and three views: what is chosen, how much is drawn, and the bound of counts.

use glam::{DQuat, DVec3};
use rimline::gpu::{Capacities, Caster, FrameInputs, Scene, SceneOptions, StencilCounts};
use rimline::internals::layout::{ShadowDraws, ShadowStatistics, StencilPencil};
use rimline::{Light, Matrix3x4, ShadowCamera};

use crate::scene::Eye;
use crate::stages::instances;
use crate::trials::Test;
use rimline_testkit::device::Gpu;
use rimline_testkit::goldens::golden;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::{same, shapes};

pub(crate) const TESTS: &[Test] = &[("ten_thousand_casters", thousands)];

const CASTERS: usize = 10_000;
const LIGHTS: usize = 32;

fn rows(turn: DQuat, scale: f64, position: [f32; 3]) -> Matrix3x4 {
    let matrix = (glam::DMat3::from_quat(turn) * scale).as_mat3();
    [0, 1, 2].map(|axis| {
        let [x, y, z] = matrix.row(axis).to_array();
        [x, y, z, position[axis]]
    })
}

fn light(random: &mut Random, number: usize) -> Light {
    match number % 4 {
        0 => Light::directional(random.direction()),
        // Among the casters.
        3 => Light::point(random.direction().map(|c| 25.0 * c)),
        _ => Light::point(random.direction().map(|c| 75.0 * c)),
    }
}

fn camera(random: &mut Random) -> ShadowCamera {
    let position = DVec3::from(random.direction().map(|c| f64::from(30.0 * c)));
    let eye = Eye {
        position,
        forward: -position,
        near: 0.1,
        is_relative: true,
        depth: rimline::DepthDirection::Reversed,
        far: None,
        half_width: None,
    };
    eye.camera()
}

fn placement(random: &mut Random) -> Matrix3x4 {
    let [x, y, z] = random.direction().map(f64::from);
    let turn = DQuat::from_axis_angle(DVec3::new(x, y, z).normalize(), f64::from(random.between(0.0, 6.0)));
    let position = [(); 3].map(|()| random.between(-40.0, 40.0));
    rows(turn, f64::from(random.between(0.2, 1.5)), position)
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
    let lights: Vec<Light> = (0..LIGHTS).map(|number| light(&mut random, number)).collect();
    for &light in &lights {
        scene.add_light(light).map_err(text)?;
    }
    let cameras = [(); 3].map(|()| camera(&mut random));
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
    // Half of the weights that a half plane crosses at most, and faces that the axis may meet, but no more than there are.
    let bound = |row: &[u32]| {
        let mut crossed = 0_u32;
        let sums = row[..1024].iter().map(|&change| {
            crossed = crossed.wrapping_add(change);
            crossed
        });
        row[1026].min(sums.max().unwrap_or(0).div_ceil(2) + row[1025])
    };
    let bounds: Vec<u32> = bin_rows.chunks(row).map(bound).collect();
    let of_all = [*bounds.iter().max().unwrap_or(&0), bounds.iter().filter(|&&bound| bound > 255).count() as u32];
    same("bounds of all lights", &[statistics.count_bound, statistics.may_wrap], &of_all)?;
    println!("bounds {bounds:?}");
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
    let of_pencils: Vec<u32> = pencils.iter().zip(bin_rows.chunks(row)).flat_map(of_pencil).collect();
    golden("shadow", "ten_thousand_casters pencils", &of_pencils)?;
    let kinds = [0, 1, 2].map(|kind| pencils.iter().filter(|pencil| pencil.kind == kind).count());
    let near: u32 = draws.iter().map(|draws| draws.near_front.instance_count + draws.near_back.instance_count).sum();
    println!("{near} near caps, {kinds:?} pencils of each kind");
    if kinds.contains(&0) || near == 0 { Err("no pencil of a kind, or no near cap".to_owned()) } else { Ok(()) }
}
