//! Masks of some views and lights of a frame.

use rimline::gpu::{MaskInputs, SceneOptions, ShadowMasks};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{must_fail, same};
use wgpu::TextureFormat::{Depth24Plus, R8Uint, R32Uint};

use crate::drawn::Picture;
use crate::world::{SIZE, World, encode};

pub(crate) const TESTS: &[Test] =
    &[("masks_of_two_views_in_one_encoder", views), ("lights_in_any_order_and_none", order)];

const PICTURE: Picture = Picture { size: SIZE, depth: Depth24Plus, samples: 1, target: R8Uint };

/// The masks of a world by something new.
fn by_new_masks(gpu: &Gpu, world: &World, picture: &Picture) -> Result<Vec<Vec<u8>>, String> {
    let mut masks = ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let [found, _] = picture.both(gpu, world, &SceneOptions::default(), &mut masks)?;
    Ok(found)
}

fn views() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let picture = &PICTURE;
    let world = World::new(7, 0, 3);
    let others = [8, 9].map(|seed| World { camera: World::new(seed, 0, 3).camera, ..World::new(7, 0, 3) });
    let targets = [(); 2].map(|()| picture.target(gpu, 3));
    gpu.submit(|encoder| {
        let mut encoded = world.encode(gpu, encoder, SceneOptions::default())?;
        let frame = encode(&mut encoded.scene, encoder, &others.each_ref().map(|other| other.camera))?;
        for ((view, other), target) in others.iter().enumerate().zip(&targets) {
            let depth = &picture.depth(gpu, encoder, other)?;
            let inputs = MaskInputs { depth, view, lights: &encoded.lights, target };
            frame.write_masks(encoder, masks, &inputs).map_err(text)?;
        }
        Ok(())
    })?;
    let mut expected = others.iter().map(|other| by_new_masks(gpu, other, picture)).collect::<Result<Vec<_>, _>>()?;
    let found = targets.iter().map(|target| picture.masks(gpu, target, 3)).collect::<Result<Vec<_>, _>>()?;
    same("views", &found, &expected)?;
    expected.reverse();
    must_fail("the other view", &same("views", &found, &expected))
}

/// Bits are in the order of the lights given, twice if they are given twice; the bits of others are 0, not what was there.
fn order() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let world = World::new(11, 0, 12);
    let picture = &Picture { target: R32Uint, ..PICTURE };
    let all = by_new_masks(gpu, &world, picture)?;
    let target = picture.target(gpu, 12);
    let lists: [&[usize]; 4] = [&[11, 3, 3, 5], &[], &[0, 1, 2, 3, 4, 5, 6, 7, 8, 11], &[7]];
    for list in lists {
        gpu.submit(|encoder| {
            let depth = &picture.depth(gpu, encoder, &world)?;
            let encoded = world.encode(gpu, encoder, SceneOptions::default())?;
            let lights: Vec<_> = list.iter().map(|&light| encoded.lights[light]).collect();
            let inputs = MaskInputs { depth, view: 0, lights: &lights, target: &target };
            encoded.frame.write_masks(encoder, masks, &inputs).map_err(text)
        })?;
        let nothing = vec![0; all[0].len()];
        let expected = (0..12).map(|bit| list.get(bit).map_or(&nothing, |&light| &all[light]).clone());
        let found = picture.masks(gpu, &target, 12)?;
        same(&format!("{list:?}"), &found, &expected.collect::<Vec<_>>())?;
        must_fail("another order", &same("masks", &found, &all))?;
    }
    Ok(())
}
