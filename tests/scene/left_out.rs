//! Lights that a view leaves out: no volumes are prepared for them, and those of other lights stay.

use rimline::ShadowCamera;
use rimline::gpu::{FrameInputs, LightMask, SceneFrame, View};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{must_fail, same};

use crate::found::Found;
use crate::histories::camera;
use crate::random_scene::{RandomScene, TestCaster};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[("lights_that_a_view_leaves_out_take_no_shadow_stages", left_out)];

/// The word of a group's first caster with the lights whose lists are made, as in `wgsl/shadow/choices.wgsl`.
const DIRTY: usize = 7;
/// Words of the draws of a light: eight draws of four words, of which the second is the number of instances.
const DRAW_WORDS: usize = 32;

/// The work for a light in a frame's only view.
#[derive(Clone, Debug, Default, PartialEq)]
struct Work {
    /// Groups that make its lists in this encode.
    dirty: usize,
    /// Casters that cast.
    casting: usize,
    /// Entries of its lists of sides, by groups.
    sides: Vec<Vec<u32>>,
    /// Instances of all its draws.
    instances: u32,
}

fn work(gpu: &Gpu, frame: &SceneFrame, casters: &[TestCaster], light: usize) -> Result<Work, String> {
    let results = frame.results().map_err(text)?;
    let mut first_casters = vec![usize::MAX; frame.groups()];
    for caster in casters {
        let (index, group) = frame.locate(caster.handle).ok_or("the frame lacks a caster")?;
        first_casters[group] = first_casters[group].min(index as usize);
    }
    let casters = casters.len();
    let (batch, bit) = (light / 32, light % 32);
    let words: Vec<u32> = gpu.read(results.choices.ok_or("no view")?, 8 * casters * frame.batches())?;
    let is_set = |caster: usize, word: usize| words[8 * (batch * casters + caster) + word] >> bit & 1 != 0;
    let mut work = Work { casting: (0..casters).filter(|&caster| is_set(caster, 0)).count(), ..Work::default() };
    for group in results.groups.iter().filter(|group| group.batch == batch) {
        work.dirty += usize::from(is_set(first_casters[group.group], DIRTY));
        let sides: Vec<u32> = gpu.read(group.sides[0], usize::MAX)?;
        let range = &sides[64 + bit * group.side_capacity as usize..][..group.side_capacity as usize];
        let [plain, clipped] = [0, 1].map(|kind| sides[2 * bit + kind] as usize);
        let mut listed = [&range[..plain], &range[range.len() - clipped..]].concat();
        listed.sort_unstable();
        work.sides.push(listed);
        let draws: Vec<u32> = gpu.read(&results.shadow_draws[group.group], usize::MAX)?;
        work.instances += draws[DRAW_WORDS * light..][..DRAW_WORDS].iter().skip(1).step_by(4).sum::<u32>();
    }
    Ok(work)
}

fn left_out() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let [mut listed, mut silhouettes] = [0; 2];
    for seed in 3301..3311 {
        let mut scene = RandomScene::filled(gpu, seed, roomy(40), [6, 35])?;
        let camera: ShadowCamera = camera(&mut scene.random);
        let lights: Vec<_> = scene.content.lights.iter().map(|(handle, _)| *handle).collect();
        let out = LightMask::only(lights.iter().copied().filter(|_| scene.random.below(3) == 0));
        let kept = lights.iter().filter(|light| !out.contains(**light)).fold(LightMask::NONE, |mask, &l| mask.with(l));
        let mut all: Vec<Option<Work>> = vec![None; 40];
        // Lists of lights that are left out are empty, also where there were some, and come back.
        for (step, mask) in [kept, LightMask::ALL, kept, kept, LightMask::ALL].into_iter().enumerate() {
            let view = View { lights: mask, ..View::new(camera) };
            let frame = gpu.submit(|encoder| scene.scene.encode(encoder, FrameInputs::new(&[view])).map_err(text))?;
            let found = Found::read(gpu, &frame)?;
            for light in &lights {
                let what = format!("seed {seed}, step {step}, light {}", light.bit());
                let bit = light.bit() as usize;
                let found_work = work(gpu, &frame, &scene.content.casters, bit)?;
                let of_batch = found.groups.iter().filter(|group| group.batch == bit / 32);
                silhouettes +=
                    usize::from(!mask.contains(*light)) * of_batch.map(|of| of.lists[bit % 32].len()).sum::<usize>();
                if mask.contains(*light) {
                    let found_work = Work { dirty: 0, ..found_work };
                    let first = all[bit].get_or_insert_with(|| found_work.clone());
                    listed += found_work.sides.iter().map(Vec::len).sum::<usize>();
                    same(&what, &[&found_work], &[&*first])?;
                } else {
                    let none = Work { sides: vec![Vec::new(); found_work.sides.len()], ..Work::default() };
                    same(&what, &[&found_work], &[&none])?;
                }
            }
        }
        let some = all.iter().flatten().find(|work| work.instances > 0).ok_or("no shadows")?;
        must_fail("volumes of a light that is left out", &same("work", &[some], &[&Work::default()]))?;
    }
    println!("{listed} sides of lights in views, {silhouettes} silhouettes of others");
    if listed.min(silhouettes) > 1000 { Ok(()) } else { Err("too little is compared".to_owned()) }
}
