//! Twisted polygons in motion, and many of them.
//!
//! It tests the stage `piece_crossings`, too.

use glam::{Affine3A, DVec3, Quat, Vec3};
use rimline::gpu::{Capacities, Deformer, DeformerOptions, Extractor, ExtractorOptions, PositionBuffer};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::Weld;
use rimline::{Counting, Geometry, GeometryOptions, Influences, Instance, InstancePose, Light, Mesh, Model, Pose};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::{read, shadow_statistics, text};
use rimline_testkit::polygons::PolygonSet;
use rimline_testkit::random::Random;
use rimline_testkit::same;
use rimline_testkit::shapes::Shape;
use rimline_testkit::{OneCaster, OneCasterOptions};

use crate::polygons::{Compared, Rig, Truth, compare, frame};
use crate::render::Renderer;
use crate::scene::{Body, Eye, Frame};
use crate::trials::{RIGHT, Test, frames};
use rimline_testkit::goldens::golden;

pub(crate) const TESTS: &[Test] = &[
    ("skinned_quadrilaterals_that_twist", motion),
    ("a_thousand_that_are_twisted_overlap", thousand),
    ("twisted_polygons_tell_their_pieces_without_room", room),
    ("a_scene_gets_room_for_pieces", grow),
];

const RINGS: u32 = 7;
const SIDES: u32 = 5;

/// A bar along x of one joint a ring, and its quadrilaterals.
fn bar() -> Result<(Model, PolygonSet), String> {
    let mut set = PolygonSet::default();
    for ring in 0..RINGS {
        for side in 0..SIDES {
            let (sin, cos) = (side as f32 / SIDES as f32 * std::f32::consts::TAU).sin_cos();
            set.positions.push([2.0 * ring as f32 / (RINGS - 1) as f32 - 1.0, 0.5 * cos, 0.5 * sin]);
        }
    }
    for ring in 0..RINGS - 1 {
        let (here, there) = (ring * SIDES, (ring + 1) * SIDES);
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            set.push(&[vec![here + side, here + next, there + next, there + side]]);
        }
    }
    set.push(&[(0..SIDES).rev().collect()]);
    set.push(&[((RINGS - 1) * SIDES..RINGS * SIDES).collect()]);
    let vertices = RINGS * SIDES;
    let influences = Influences::new(
        (0..=vertices).collect(),
        (0..vertices).map(|vertex| vertex / SIDES).collect(),
        vec![1.0; vertices as usize],
    );
    let options = GeometryOptions { influences: Some(influences.map_err(text)?), ..GeometryOptions::default() };
    let mesh = set.mesh(Weld::Keep).map_err(text)?;
    let geometry = Geometry::new(set.positions.clone(), mesh.faces().to_vec(), options).map_err(text)?;
    Ok((Model::new(vec![geometry], vec![Instance::new(0, None)]).map_err(text)?, set))
}

/// The rings turn against each other, and the bar bends.
fn pose(time: f32) -> Result<Pose, String> {
    let palette = (0..RINGS).map(|ring| {
        let along = ring as f32 / (RINGS - 1) as f32;
        let turn =
            Quat::from_rotation_x(9.0 * time.sin() * along) * Quat::from_rotation_z(0.7 * (3.0 * time + along).cos());
        Affine3A::from_translation(0.2 * Vec3::Y * (time + 4.0 * along).sin()) * Affine3A::from_quat(turn)
    });
    Ok(Pose::new(vec![InstancePose::new(palette, Vec::new()).map_err(text)?]))
}

/// Polygons at the positions that a deformer wrote: masks are those of its twin, and shadows those of the rays.
fn motion() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (model, mut set) = bar()?;
    let mesh = set.mesh(Weld::Keep).map_err(text)?;
    let deformer = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions::default()).map_err(text)?;
    let (mut counts, mut failures) = (Vec::new(), Vec::new());
    for number in 0..frames() {
        let pose = pose(number as f32 * 0.37)?;
        let mut random = Random::new(78_000 + number);
        // The bar is about as large as what the frame is for.
        let mut frame = frame(&mut random, set.clone(), &mesh);
        let light = frame.lights[0];
        gpu.submit(|encoder| {
            deformer.encode(encoder, &pose).map_err(text)?;
            extractor.encode(encoder, deformer.positions(), &[light]).map_err(text)
        })?;
        set.positions = gpu.read(deformer.positions().buffer, model.vertex_count())?;
        let found = read(gpu, &extractor, &mesh, 1)?;
        let polygons = mesh.polygons().ok_or("no polygons")?;
        let (masks, _) = cpu::polygon_facing(&set.positions, polygons, &[light], Threads::ONE);
        let of_triangles = polygons.triangle_polygons();
        let expected: Vec<u32> = of_triangles.iter().map(|&polygon| masks[polygon as usize].twisted).collect();
        same(&format!("frame {number}, twisted"), &found.twisted, &expected)?;
        counts.push(masks.iter().filter(|masks| masks.twisted != 0).count());
        frame.bodies[0].shape.positions.clone_from(&set.positions);
        frame.bodies[0].polygons = Some(set.clone());
        let rig = Rig::new(&frame, &mesh);
        let truths = rig.truths();
        let wrong = compare(gpu, &frame, &rig, &truths, &RIGHT)?;
        failures.extend(wrong.into_iter().map(|error| format!("frame {number}: {error}")));
    }
    println!("twisted polygons, frame after frame: {counts:?}");
    let changes = counts.windows(2).filter(|pair| pair[0] != pair[1]).count();
    if failures.is_empty() && 2 * changes > counts.len() { Ok(()) } else { Err(failures.join("\n")) }
}

/// Bow ties above each other, which cast onto the room's floor.
fn bow_ties(random: &mut Random, count: usize) -> PolygonSet {
    let mut set = PolygonSet::default();
    for number in 0..count {
        let height = 0.9 * number as f32 / count as f32;
        let near = |[x, z]: [f32; 2], random: &mut Random| {
            let [dx, dy, dz] = [0.1, 0.02, 0.1].map(|most: f32| random.between(-most, most));
            [x + dx, height + dy, z + dz]
        };
        let corners = [[-1.0, -1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]].map(|corner| near(corner, random));
        set.push_points(&[corners.to_vec()]);
    }
    set
}

/// Bow ties in a room.
fn in_room(set: &PolygonSet, light: Light) -> Result<(Mesh, Frame), String> {
    let mesh = set.mesh(Weld::Keep).map_err(text)?;
    let shape = Shape { positions: set.positions.clone(), faces: mesh.faces().to_vec() };
    let eye = Eye::new(DVec3::new(0.3, -0.8, 2.4), DVec3::new(-0.1, -1.2, -1.0), 0.1);
    let caster = Body { polygons: Some(set.clone()), ..Body::caster(shape) };
    let bodies = vec![caster, Body::room([0.0; 3], 4.0)];
    Ok((mesh, Frame { bodies, eye, lights: vec![light], size: 64 }))
}

/// With room for all pieces the shadows are right, and statistics tell how many have none.
fn room() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 79_500;
    println!("seed {seed}");
    let set = bow_ties(&mut Random::new(seed), 100);
    let (mesh, frame) = in_room(&set, Light::directional([0.05, 1.0, 0.02]))?;
    let rig = Rig::new(&frame, &mesh);
    let truths = rig.truths();
    for counting in [Counting::Auto, Counting::ZFail] {
        let mut all = None;
        for (capacity, lost) in [(None, 0), (Some(600), 0), (Some(599), 1), (Some(300), 300), (Some(0), 599)] {
            let mut renderer = Renderer::new(gpu);
            renderer.options = OneCasterOptions { piece_capacity: capacity, ..renderer.options };
            let counted = renderer.count(&frame, counting)?;
            let what = format!("{counting:?}, room for {capacity:?}");
            let statistics = counted.statistics[0];
            same(&what, &[statistics.lost_pieces, statistics.most_pieces], &[lost, 600])?;
            let stencil = &counted.stencils[0];
            let mut wrong = Vec::new();
            if lost == 0 {
                wrong = rig.wrong(&truths, stencil, Compared::Counts);
            }
            let all = &*all.get_or_insert_with(|| stencil.clone());
            let changed = stencil.iter().zip(all).filter(|(count, all)| count != all).count();
            let agree =
                truths.iter().zip(stencil).filter(|(truth, count)| **truth == Truth::Odd(u32::from(**count))).count();
            println!("{what}: {changed} pixels changed, {agree} are those of the pixel's ray");
            // Hairlines are everywhere, and explain any value. So nearly all counts must be exactly those of the rays.
            let is_exact = agree * 1000 >= truths.len() * 999;
            let is_right = if lost == 0 { wrong.is_empty() && changed == 0 && is_exact } else { changed > 100 };
            if !is_right {
                return Err(format!("{what}: {} pixels are wrong, {changed} changed", wrong.len()));
            }
        }
    }
    Ok(())
}

/// Room is given to a scene that has lost pieces.
fn grow() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let set = bow_ties(&mut Random::new(79_501), 50);
    let light = Light::directional([0.05, 1.0, 0.02]);
    let (mesh, frame) = in_room(&set, light)?;
    let options = OneCasterOptions { piece_capacity: Some(7), ..OneCasterOptions::default() };
    let mut caster = OneCaster::new(&gpu.pipelines, &gpu.queue, &mesh, &options).map_err(text)?;
    let buffer = gpu.storage(&set.positions);
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let camera = frame.eye.camera();
    for (capacity, lost) in [(None, 293), (Some(299), 1), (Some(300), 0), (Some(u32::MAX), 0), (Some(1), 299)] {
        if let Some(pieces) = capacity {
            caster.scene.set_capacities(Capacities { pieces: Some(pieces), ..Capacities::default() });
        }
        let frame =
            gpu.submit(|encoder| caster.encode(encoder, positions, &[light], Some(&camera), None).map_err(text))?;
        let statistics = shadow_statistics(gpu, &frame)?;
        same(&format!("{capacity:?}"), &[statistics.lost_pieces, statistics.most_pieces], &[lost, 300])?;
    }
    Ok(())
}

/// Each counts once, modulo 256, and the bound tells that counts wrap.
fn thousand() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 79_000;
    println!("seed {seed}");
    let set = bow_ties(&mut Random::new(seed), 1000);
    for light in [Light::directional([0.05, 1.0, 0.02]), Light::point([0.2, 3.5, 0.3])] {
        let (mesh, frame) = in_room(&set, light)?;
        let rig = Rig::new(&frame, &mesh);
        let truths = rig.truths();
        let most = truths.iter().map(|truth| if let Truth::Odd(count) = truth { *count } else { 0 }).max();
        let most = most.ok_or("no truths")?;
        println!("{light:?}: up to {most} between");
        for counting in [Counting::Auto, Counting::ZFail] {
            let mut renderer = Renderer::new(gpu);
            renderer.options = OneCasterOptions { bound_counts: true, ..renderer.options };
            let counted = renderer.count(&frame, counting)?;
            let wrong = rig.wrong(&truths, &counted.stencils[0], Compared::Counts);
            let statistics = counted.statistics[0];
            if !wrong.is_empty() || statistics.lost_pieces > 0 || statistics.may_wrap != 1 || most < 900 {
                return Err(format!("{counting:?}: {} wrong, {statistics:?}, {most} between", wrong.len()));
            }
            golden("shadow", &format!("stencil_bound of bow ties, w {}", light.w), &[statistics.count_bound])?;
            if statistics.count_bound < most {
                return Err(format!("{most} between, and a bound of {}", statistics.count_bound));
            }
        }
    }
    Ok(())
}
