//! Which casters of a scene are drawn into a map, and what is refused.

use glam::DVec3;
use rimline::gpu::depth_map::{DepthMapError, SceneDepth, SceneDepthCasters, SceneDepthCounts};
use rimline::gpu::{Caster, LightMask, ShadowError};
use rimline::{CameraError, DepthDirection, Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::mesh_depth::SIDE;
use crate::scene::Eye;
use crate::scene_depth::{Casters, FORMATS, Placed, UNMOVED, bits, light, map};

pub(crate) const TESTS: &[Test] = &[
    ("casters_of_a_scene_are_chosen_for_its_depth", chosen),
    ("casters_that_the_light_does_not_see_are_left_out", outside),
    ("depths_of_scenes_that_are_refused", refused),
];

fn chosen() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(1713);
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (16, 2.0))?;
    let light = light(&mut random, 1);
    let of_scene = casters.scene.add_light(Light::point([0.0, 9.0, 0.0])).map_err(text)?;
    let is_listed = |number: usize| number % 3 == 1;
    let listed: Vec<_> =
        (0..).zip(&casters.placed).filter(|(number, _)| is_listed(*number)).map(|(_, caster)| caster.handle).collect();
    for &caster in &listed {
        casters.scene.set_lights(caster, LightMask::ALL.without(of_scene)).map_err(text)?;
    }
    let twice = [&listed[..], &listed[..]].concat();
    let draw = |which| Ok::<_, String>(casters.drawn(&gpu, FORMATS[0], &light, which)?.0);
    let own = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, is_listed)?);
    let others = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |number| !is_listed(number))?);
    let all = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |_| true)?);
    same("only", &bits(&draw(SceneDepthCasters::Only(&listed))?), &own)?;
    same("only, twice", &bits(&draw(SceneDepthCasters::Only(&twice))?), &own)?;
    same("except", &bits(&draw(SceneDepthCasters::Except(&listed))?), &others)?;
    same("without volumes", &bits(&draw(SceneDepthCasters::NotCastingFor(of_scene))?), &own)?;
    same("except none", &bits(&draw(SceneDepthCasters::Except(&[]))?), &all)?;
    let none = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |_| false)?);
    same("none", &bits(&draw(SceneDepthCasters::Only(&[]))?), &none)?;
    must_fail("all", &same("only", &all, &own))?;
    must_fail("others", &same("only", &others, &own))?;
    must_fail("nothing", &same("only", &none, &own))?;
    // A scene without casters, and one whose casters have no place.
    let mut empty = Casters::new(&gpu)?;
    let (found, counts) = empty.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    same("no casters", &bits(&found), &none)?;
    same("no draws", &[counts], &[SceneDepthCounts::default()])?;
    let mesh = empty.meshes()?[0];
    let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]];
    let not_finite = [[f32::NAN, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    for rows in [flat, not_finite] {
        let handle = empty.scene.insert(Caster::rigid(mesh, rows)).map_err(text)?;
        empty.placed.push(Placed { shape: 0, rows, buffer: None, handle });
    }
    let (found, counts) = empty.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    same("singular", &bits(&found), &none)?;
    same("singular: no draws", &[counts], &[SceneDepthCounts::default()])?;
    let each = empty.one_by_one(&gpu, FORMATS[0], &light, |_| true)?;
    same("singular, one by one", &bits(&each), &none)?;
    // Negative control: with a place, it is drawn.
    empty.scene.set_transform(empty.placed[0].handle, UNMOVED).map_err(text)?;
    let (found, _) = empty.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    must_fail("a place", &same("singular", &bits(&found), &none))
}

/// Leaving casters out changes no bit. Boxes of buffers are stated.
fn outside() -> Result<(), String> {
    const SEED: u64 = 1714;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut left_out, mut all) = (0, 0);
    for number in 0..if is_long() { 48 } else { 12 } {
        let mut casters = Casters::new(&gpu)?;
        casters.fill(&gpu, &mut random, (24, 8.0))?;
        for at in 0..casters.placed.len() {
            let caster = &casters.placed[at];
            let Some((buffer, offset, stride)) = &caster.buffer else { continue };
            let words: Vec<f32> = gpu.read(buffer, (buffer.size() / 4) as usize)?;
            let vertices = casters.shapes[caster.shape].0.positions.len();
            let word = |vertex: usize, axis: usize| words[(offset + stride * vertex as u64) as usize / 4 + axis];
            let bound = |pick: fn(f32, f32) -> f32| {
                std::array::from_fn(|axis| (0..vertices).map(|vertex| word(vertex, axis)).reduce(pick).unwrap_or(0.0))
            };
            let bounds = [bound(f32::min), bound(f32::max)];
            casters.scene.set_bounds(caster.handle, Some(bounds)).map_err(text)?;
        }
        let (light, format) = (light(&mut random, number), FORMATS[number % 3]);
        let (found, counts) = casters.drawn(&gpu, format, &light, SceneDepthCasters::All)?;
        let truth = casters.one_by_one(&gpu, format, &light, |_| true)?;
        same(&format!("view {number}"), &bits(&found), &bits(&truth))?;
        // Each that was left out has no texel of its own.
        let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
        for at in 0..casters.placed.len() {
            let only = [casters.placed[at].handle];
            let (_, one) = casters.drawn(&gpu, format, &light, SceneDepthCasters::Only(&only))?;
            let alone = casters.one_by_one(&gpu, format, &light, |number| number == at)?;
            let is_seen = alone.iter().any(|&depth| depth != far);
            if is_seen && one.drawn != 1 {
                return Err(format!("view {number}: caster {at} is seen and left out"));
            }
        }
        left_out += counts.outside;
        all += counts.outside + counts.drawn;
    }
    println!("{left_out} of {all} left out");
    // A box that is not finite in one corner, or not stated, tells nothing; a box elsewhere does, whatever is in the buffer.
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (8, 0.1))?;
    let light = light(&mut random, 0);
    let (_, counts) = casters.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    same("in the middle", &[counts.outside], &[0])?;
    let in_buffer = casters.placed.iter().rfind(|caster| caster.buffer.is_some()).map(|caster| caster.handle);
    let in_buffer = in_buffer.ok_or("a caster has a buffer")?;
    casters.scene.set_bounds(in_buffer, Some([[900.0; 3], [901.0; 3]])).map_err(text)?;
    let (_, counts) = casters.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    same("stated elsewhere", &[counts.outside], &[1])?;
    if left_out * 4 > all && left_out * 10 < all * 9 { Ok(()) } else { Err(format!("{left_out} of {all} left out")) }
}

fn refused() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(1717);
    let [mut casters, mut other] = [Casters::new(&gpu)?, Casters::new(&gpu)?];
    casters.fill(&gpu, &mut random, (4, 1.0))?;
    other.fill(&gpu, &mut random, (4, 1.0))?;
    let of_other = [other.placed[0].handle];
    let gone = casters.placed.swap_remove(1);
    casters.scene.remove(gone.handle).map_err(text)?;
    let dangling = [casters.placed[0].handle, gone.handle];
    let lights = [&mut casters.scene, &mut other.scene].map(|scene| scene.add_light(Light::point([1.0; 3])));
    let [old, foreign] = lights;
    let (old, foreign) = (old.map_err(text)?, foreign.map_err(text)?);
    casters.scene.remove_light(old).map_err(text)?;
    let light = crate::stages::camera(DepthDirection::Reversed);
    let standard = crate::stages::camera(DepthDirection::Standard);
    let singular = ShadowCamera { view_projection: [[0.0; 4]; 4], ..light };
    let draws = SceneDepth::new(&gpu.pipelines, FORMATS[0], light.depth).map_err(text)?;
    let mut found = Vec::new();
    let depths = map(&gpu, FORMATS[0], &light, |pass| {
        let mut draw = |which, light| draws.draw(pass, &casters.scene, which, light).err();
        found = vec![
            draw(SceneDepthCasters::Only(&dangling), &light),
            draw(SceneDepthCasters::Except(&dangling), &light),
            draw(SceneDepthCasters::Only(&of_other), &light),
            draw(SceneDepthCasters::NotCastingFor(old), &light),
            draw(SceneDepthCasters::NotCastingFor(foreign), &light),
            draw(SceneDepthCasters::All, &standard),
            draw(SceneDepthCasters::All, &singular),
        ];
        Ok(())
    })?;
    let of_scene = |error| Some(DepthMapError::Shadow(error));
    let truth = [
        of_scene(ShadowError::Removed { what: "caster" }),
        of_scene(ShadowError::Removed { what: "caster" }),
        of_scene(ShadowError::OtherScene { what: "caster" }),
        of_scene(ShadowError::Removed { what: "light" }),
        of_scene(ShadowError::OtherScene { what: "light" }),
        Some(DepthMapError::Depth {
            what: "the light",
            given: DepthDirection::Standard,
            made: DepthDirection::Reversed,
        }),
        Some(DepthMapError::Light(CameraError::Singular)),
    ];
    same("refused", &found, &truth)?;
    same("nothing is drawn", &depths, &[0.0; (SIDE * SIDE) as usize])?;
    let color = SceneDepth::new(&gpu.pipelines, TextureFormat::R32Float, light.depth).err();
    same("format", &[color], &[Some(DepthMapError::NoDepth(TextureFormat::R32Float))])?;
    // A scene of another device.
    let another = gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let mut of_another = Casters::new(&another)?;
    of_another.fill(&another, &mut random, (4, 0.1))?;
    let straight = Eye {
        place: DVec3::new(0.0, 0.0, 5.0),
        forward: DVec3::NEG_Z,
        near: 0.1,
        is_relative: true,
        depth: DepthDirection::Reversed,
        far: None,
        half_width: None,
    };
    let mut outcome = None;
    map(&gpu, FORMATS[0], &light, |pass| {
        outcome = draws.draw(pass, &of_another.scene, SceneDepthCasters::All, &straight.camera()).err();
        Ok(())
    })?;
    match outcome {
        Some(DepthMapError::Refused { .. }) => Ok(()),
        other => Err(format!("another device: {other:?}")),
    }
}
