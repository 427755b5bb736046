//! Each class of frames, by every method that claims to be right there; and what must be wrong.
//!
//! The stages `caps` and `list_sides` have no other test against an oracle, but for the most turns of their loops.

use rimline::Counting;
use rimline::gpu::Measuring;
use rimline::internals::layout::ShadowLight;

use crate::compare::{Compared, Wrong};
use crate::rays::{self, Truth};
use crate::render::{Counted, Placing, Renderer};
use rimline_testkit::device::Gpu;
use rimline_testkit::frame_classes::{CLASSES, Class};
use rimline_testkit::frames::{CENTRE, Frame, SAMPLES};
pub(crate) use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};

pub(crate) const TESTS: &[Test] = &[
    ("z_pass_is_wrong_in_shadow", z_pass),
    ("wrong_pixels_are_noticed", perturbed),
    ("every_face_casts_alike", every_face),
    ("volumes_that_are_trimmed_are_right", trimmed),
    ("another_depth_pass_does_no_harm", reordered),
];

pub(crate) fn seed(class: &Class, number: u64) -> u64 {
    class.name.bytes().fold(number, |seed, byte| seed.wrapping_mul(31).wrapping_add(u64::from(byte)))
}

/// For each caster, whether every face casts, as the GPU chose for a light.
pub(crate) fn every(counted: &Counted, light: usize) -> Vec<bool> {
    counted.chosen.iter().map(|lights: &Vec<ShadowLight>| lights[light].casting == 2).collect()
}

/// One frame by several methods; the rays are traced once.
pub(crate) struct Traced {
    pub(crate) frame: Frame,
    pub(crate) truths: Vec<Vec<Truth>>,
    pub(crate) seed: u64,
    /// Which of four samples a pixel the rays go through; through its centre, if none.
    pub(crate) sample: Option<usize>,
}

impl Traced {
    pub(crate) fn new(class: &Class, number: u64) -> Self {
        let seed = seed(class, number);
        Self::of((class.frame)(&mut Random::new(seed)), seed)
    }

    pub(crate) fn of(frame: Frame, seed: u64) -> Self {
        let truths = rays::trace(&frame, CENTRE);
        Self { frame, truths, seed, sample: None }
    }

    /// The same frame by rays through a sample.
    pub(crate) fn through(&self, sample: usize) -> Self {
        let truths = rays::trace(&self.frame, SAMPLES[sample]);
        Self { frame: self.frame.clone(), truths, sample: Some(sample), ..*self }
    }

    /// Pixels in the shadow of the first light.
    pub(crate) fn shadowed(&self) -> usize {
        self.truths.iter().filter(|truths| truths[0].is_shadowed()).count()
    }

    pub(crate) fn compared(&self) -> Compared<'_> {
        let within_pixel = self.sample.map_or(CENTRE, |sample| SAMPLES[sample]);
        Compared { frame: &self.frame, truths: &self.truths, within_pixel, light: 0, explains: true }
    }

    /// Counts of the GPU at the samples that the rays go through.
    pub(crate) fn stencil<'a>(&self, counted: &'a Counted) -> &'a [u8] {
        &counted.stencils[self.sample.unwrap_or(0)]
    }

    /// Fails where the GPU is wrong; returns the pixels compared.
    pub(crate) fn check(
        &self,
        renderer: &Renderer<'_>,
        counting: Counting,
        counts: bool,
    ) -> Result<(Wrong, Counted), String> {
        let counted = renderer.count(&self.frame, counting)?;
        let every = every(&counted, 0);
        let mut wrong = self.compared().lit(&counted.stencils[0], &every);
        if counts {
            wrong.add(&self.compared().counts(&counted.stencils[0], &every));
        }
        match wrong.pixels.first() {
            None => Ok((wrong, counted)),
            Some(&(x, y)) => {
                let at = (y * self.frame.size + x) as usize;
                Err(format!(
                    "{counting:?}, seed {}: {} wrong pixels, first ({x}, {y}): stencil {}, truth {:?}, lights {:?}",
                    self.seed,
                    wrong.pixels.len(),
                    counted.stencils[0][at],
                    self.truths[at][0],
                    counted.chosen,
                ))
            }
        }
    }
}

/// The part of `all` that a class is tried with: one, another for the next class. In a long run all.
pub(crate) fn rotated<T: Copy>(all: &[T], class: usize) -> Vec<T> {
    if is_long() { all.to_vec() } else { vec![all[class % all.len()]] }
}

/// Pixels in shadow over frames, pixels that are off and explained, and failures.
#[derive(Default)]
pub(crate) struct Tally {
    shadowed: usize,
    explained: usize,
    failures: Vec<String>,
}

impl Tally {
    pub(crate) fn add(&mut self, traced: &Traced, renderer: &Renderer<'_>, methods: &[Counting], counts: bool) {
        self.shadowed += traced.shadowed();
        for &counting in methods {
            match traced.check(renderer, counting, counts) {
                Ok((wrong, _)) => self.explained += wrong.hairlines.len() + wrong.slivers.len(),
                Err(error) => self.failures.push(error),
            }
        }
    }

    /// Fails where a pixel was wrong.
    pub(crate) fn result(&self, name: &str) -> Result<(), String> {
        let Self { shadowed, explained, failures } = self;
        println!("{name}: {shadowed} pixels in shadow; by all methods {explained} pixels off and explained");
        match (shadowed, failures.is_empty()) {
            (0, _) => Err(format!("{name}: nothing was ever in shadow")),
            (_, true) => Ok(()),
            (_, false) => Err(failures.join("\n")),
        }
    }
}

/// Methods that are right everywhere.
pub(crate) const RIGHT: [Counting; 3] = [Counting::Auto, Counting::ZpPlus, Counting::ZFail];

/// No wrong pixel, of casters by themselves and in one scene, counted at once and in batches.
pub(crate) fn right(class: &'static Class) -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut tally = Tally::default();
    // Some 180 frames of all classes, or 2,400 in a long run.
    for number in 0..if is_long() { 105 } else { 8 } {
        let traced = Traced::new(class, number);
        let placing = [Placing::Alone, Placing::Scene, Placing::Busy(traced.seed)][number as usize % 3];
        let renderer = Renderer { placing, ..Renderer::new(&gpu) };
        tally.add(&traced, &renderer, &RIGHT, !class.touches);
        // The highest bit tells that an earlier batch darkens.
        if number % 8 == 1 {
            tally.add(&traced, &Renderer { count_batches: 2, ..renderer }, &RIGHT, false);
        }
    }
    tally.result(class.name)
}

pub(crate) fn class(name: &str) -> Result<&'static Class, String> {
    CLASSES.iter().find(|class| class.name == name).ok_or_else(|| format!("no class {name}"))
}

/// The negative control of it all: the method that needs caps and has none.
fn z_pass() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let traced = Traced::new(class("near rectangle in shadow, light behind")?, 0);
    must_fail("z-pass within a shadow", &traced.check(&Renderer::new(&gpu), Counting::ZPass, false))?;
    let outside = Traced::new(class("camera outside the shadow")?, 0);
    outside.check(&Renderer::new(&gpu), Counting::ZPass, true).map(|_| ())
}

/// One pixel, changed.
fn perturbed() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let traced = Traced::new(class("random cameras")?, 0);
    let (_, counted) = traced.check(&Renderer::new(&gpu), Counting::Auto, true)?;
    let mut stencil = counted.stencils[0].clone();
    let size = traced.frame.size as usize;
    let lit_around = |at: &usize| {
        let near =
            [*at, at - 1, at + 1, at - size, at + size, at - size - 1, at - size + 1, at + size - 1, at + size + 1];
        near.iter().all(|&at| traced.truths[at][0].is_lit())
    };
    let at = (size + 1..size * (size - 1) - 1).find(lit_around).ok_or("no lit surface")?;
    stencil[at] = 1;
    let every = every(&counted, 0);
    let lit = traced.compared().lit(&stencil, &every).pixels.len();
    let counts = traced.compared().counts(&stencil, &every).pixels.len();
    if (lit, counts) == (1, 1) { Ok(()) } else { Err(format!("one pixel changed, {lit} and {counts} noticed")) }
}

/// Closed casters of which every face casts.
fn every_face() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut renderer = Renderer::new(&gpu);
    renderer.options.measuring.set(Measuring::EVERY_FACE, true);
    each_class(&renderer, &[Counting::Auto, Counting::ZFail], |class| !class.name.contains("shadow, light"))
}

/// A frame of some classes, of which the rays are traced once for all tests.
fn each_class(renderer: &Renderer<'_>, methods: &[Counting], takes: impl Fn(&Class) -> bool) -> Result<(), String> {
    for class in CLASSES.iter().filter(|class| takes(class)) {
        let traced = renderer.gpu.kept(class.name, || Ok(Traced::new(class, 7)))?;
        for &counting in methods {
            traced.check(renderer, counting, !class.touches).map_err(|error| format!("{}: {error}", class.name))?;
        }
    }
    Ok(())
}

/// Volumes that are cut at the frustum in the vertex shader, against rays.
fn trimmed() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let renderer = Renderer { trim: true, ..Renderer::new(&gpu) };
    for (index, class) in CLASSES.iter().enumerate() {
        each_class(&renderer, &rotated(&RIGHT, index), |other| other.name == class.name)?;
    }
    Ok(())
}

/// A depth pass that rounds differently: z-pass and ZP+ compare with surfaces only where volumes cut them, and z-fail
/// from back-facing faces leaves lit surfaces alone. Where every face casts, z-fail needs equal bits.
fn reordered() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let renderer = Renderer { is_reordered: true, ..Renderer::new(&gpu) };
    each_class(&renderer, &[Counting::Auto], |class| !class.touches)?;
    let z_fail = |class: &Class| class.name == "camera outside the shadow" || class.name == "random cameras";
    each_class(&renderer, &[Counting::ZFail], z_fail)
}
