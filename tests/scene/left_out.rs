//! Lights that a view leaves out: no volumes are prepared for them, and those of other lights stay.

use rimline::ShadowCamera;
use rimline::gpu::{FrameInputs, LightMask, SceneFrame, View};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{must_fail, same};

use crate::histories::{VolumeBuffers, camera};
use crate::random_scene::RandomScene;
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[("lights_that_a_view_leaves_out_take_no_shadow_stages", left_out)];

/// The work for a light in a frame's only view: its sides by groups, in order, and the instances of its draws.
type Work = (Vec<Vec<u32>>, [u32; 6]);

fn work(gpu: &Gpu, frame: &SceneFrame, light: u32) -> Result<Work, String> {
    let mut sides = Vec::new();
    for group in frame.results().map_err(text)?.groups.iter().filter(|group| group.batch == light as usize / 32) {
        let (words, bit): (Vec<u32>, _) = (gpu.read(group.sides[0], usize::MAX)?, light as usize % 32);
        let range = &words[64 + bit * group.side_capacity as usize..][..group.side_capacity as usize];
        let [plain, clipped] = [0, 1].map(|kind| words[2 * bit + kind] as usize);
        let mut listed = [&range[..plain], &range[range.len() - clipped..]].concat();
        listed.sort_unstable();
        sides.push(listed);
    }
    Ok((sides, VolumeBuffers::new(frame, 1)?.read(gpu, &[light])?.instances[0]))
}

fn left_out() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut listed, mut emptied) = (0, 0);
    for seed in 3301..3311 {
        let mut scene = RandomScene::filled(gpu, seed, roomy(40), [6, 35])?;
        let camera: ShadowCamera = camera(&mut scene.random);
        let lights: Vec<_> = scene.content.lights.iter().map(|(handle, _)| *handle).collect();
        let kept = LightMask::only(lights.iter().copied().filter(|_| scene.random.below(3) > 0));
        let mut all: Vec<Option<Work>> = vec![None; lights.len()];
        // Lists of lights that are left out are empty, also where there were some, and come back.
        for (step, mask) in [kept, LightMask::ALL, kept, kept, LightMask::ALL].into_iter().enumerate() {
            let view = View { lights: mask, ..View::new(camera) };
            let frame = gpu.submit(|encoder| scene.scene.encode(encoder, FrameInputs::new(&[view])).map_err(text))?;
            for (light, all) in lights.iter().zip(&mut all) {
                let found = work(gpu, &frame, light.bit())?;
                let none = (vec![Vec::new(); found.0.len()], [0; 6]);
                let what = format!("seed {seed}, step {step}, light {}", light.bit());
                if mask.contains(*light) {
                    listed += found.0.iter().map(Vec::len).sum::<usize>();
                    same(&what, &[&found], &[&*all.get_or_insert_with(|| found.clone())])?;
                } else {
                    same(&what, &[&found], &[&none])?;
                    if let Some(before) = all.as_ref().filter(|before| **before != none) {
                        must_fail("volumes of a light that is left out", &same(&what, &[before], &[&none]))?;
                        emptied += 1;
                    }
                }
            }
        }
    }
    println!("{listed} sides of lights in views, {emptied} lights that lost theirs");
    if listed > 1000 && emptied > 10 { Ok(()) } else { Err("too little is compared".to_owned()) }
}
