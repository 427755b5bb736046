//! Many twisted polygons.
//!
//! It tests the stage `piece_crossings`, too.

use glam::DVec3;
use rimline::gpu::{Capacities, PositionBuffer, SceneOptions};
use rimline::mesh::Weld;
use rimline::{Counting, Light, Mesh};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Body, Eye, Frame};
use rimline_testkit::goldens::golden;
use rimline_testkit::on_gpu::{shadow_statistics, text};
use rimline_testkit::polygons::PolygonSet;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::Shape;
use rimline_testkit::{OneCaster, made_anew, same};

use crate::polygons::{Compared, Rig, Truth};
use crate::render::Renderer;
use crate::trials::Test;

pub(crate) const TESTS: &[Test] =
    &[("a_thousand_that_are_twisted_overlap", thousand), ("twisted_polygons_tell_their_pieces_without_room", room)];

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

/// With room for all pieces the shadows are right, and statistics tell how many have none, also of a scene that is given
/// other room.
fn room() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 79_500;
    println!("seed {seed}");
    let set = bow_ties(&mut Random::new(seed), 100);
    let light = Light::directional([0.05, 1.0, 0.02]);
    let (mesh, frame) = in_room(&set, light)?;
    let rig = Rig::new(&frame, 0)?;
    for counting in [Counting::Auto, Counting::ZFail] {
        let mut all = None;
        for (pieces, lost) in [(None, 0), (Some(600), 0), (Some(599), 1), (Some(300), 300), (Some(0), 599)] {
            let options = with_pieces(pieces);
            let counted = Renderer { options, ..Renderer::new(gpu) }.count(&frame, counting)?;
            let what = format!("{counting:?}, room for {pieces:?}");
            let statistics = counted.statistics[0];
            same(&what, &[statistics.lost_pieces, statistics.most_pieces], &[lost, 600])?;
            let stencil = &counted.stencils[0];
            let wrong = if lost == 0 { rig.wrong(stencil, Compared::Counts) } else { Vec::new() };
            let all = &*all.get_or_insert_with(|| stencil.clone());
            let changed = stencil.iter().zip(all).filter(|(count, all)| count != all).count();
            // Hairlines are everywhere, and explain any value. So nearly all counts must be exactly those of the rays.
            let agree = |(truth, count): &(&Truth, &u8)| **truth == Truth::Odd(u32::from(**count));
            let agree = rig.truths.iter().zip(stencil).filter(agree).count();
            let is_exact = agree * 1000 >= rig.truths.len() * 999;
            let is_right = if lost == 0 { wrong.is_empty() && changed == 0 && is_exact } else { changed > 100 };
            if !is_right {
                return Err(format!("{what}: {} pixels are wrong, {changed} changed, {agree} agree", wrong.len()));
            }
        }
    }
    let mut caster = OneCaster::new(&gpu.pipelines, &gpu.queue, &mesh, with_pieces(Some(7))).map_err(text)?;
    let buffer = gpu.storage(&set.positions);
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let camera = frame.eye.camera();
    for (pieces, lost) in [(Some(7), 593), (Some(599), 1), (Some(600), 0), (Some(u32::MAX), 0), (Some(1), 599)] {
        caster.scene.set_capacities(Capacities { pieces, ..Capacities::default() });
        let frame =
            gpu.submit(|encoder| caster.encode(encoder, positions, &[light], Some(&camera), None).map_err(text))?;
        let statistics = shadow_statistics(gpu, &frame)?;
        same(&format!("{pieces:?}"), &[statistics.lost_pieces, statistics.most_pieces], &[lost, 600])?;
    }
    Ok(())
}

fn with_pieces(pieces: Option<u32>) -> SceneOptions {
    let capacities = Capacities { pieces, ..Capacities::default() };
    SceneOptions { capacities, ..made_anew(32, Counting::Auto) }
}

/// Each counts once, modulo 256, and the bound tells that counts wrap.
fn thousand() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 79_000;
    println!("seed {seed}");
    let set = bow_ties(&mut Random::new(seed), 1000);
    for light in [Light::directional([0.05, 1.0, 0.02]), Light::point([0.2, 3.5, 0.3])] {
        let (_, frame) = in_room(&set, light)?;
        let rig = Rig::new(&frame, 0)?;
        let most = rig.most();
        println!("{light:?}: up to {most} between");
        for counting in [Counting::Auto, Counting::ZFail] {
            let mut renderer = Renderer::new(gpu);
            renderer.options.stencil.bound_counts = true;
            let counted = renderer.count(&frame, counting)?;
            let wrong = rig.wrong(&counted.stencils[0], Compared::Counts);
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
