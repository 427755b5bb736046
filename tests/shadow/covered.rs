//! Shadows of static casters without the faces that other faces hide: the same as with them.

use std::ops::ControlFlow;

use rimline::Mesh;
use rimline::cpu::{OccludedFaces, OcclusionCaster, OcclusionOptions};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same};

use crate::classes::CLASSES;
use crate::render::{Counted, Placing, Renderer};
use crate::scene::{Body, Frame};
use crate::trials::{RIGHT, Test, rotated, seed};

pub(crate) const TESTS: &[Test] = &[("shadows_without_faces_that_others_hide", alike)];

/// The frame without the faces that others hide from its first light, and how many these are.
fn without_occluded(frame: &Frame, leave_out_all: bool) -> Result<(Frame, usize), String> {
    let mut less = frame.clone();
    let casters: Vec<&mut Body> = less.bodies.iter_mut().filter(|body| body.casts).collect();
    let mesh = |body: &Body| Mesh::from_faces(body.shape.positions.len(), body.shape.faces.clone()).map_err(text);
    let meshes = casters.iter().map(|body| mesh(body)).collect::<Result<Vec<_>, _>>()?;
    let all: Vec<OcclusionCaster<'_>> = casters
        .iter()
        .zip(&meshes)
        .map(|(body, mesh)| OcclusionCaster { mesh, positions: &body.shape.positions, version: None })
        .collect();
    let options = OcclusionOptions { leave_out_all, ..OcclusionOptions::default() };
    let found = OccludedFaces::find(frame.lights[0], &all, options, |_, _| ControlFlow::Continue(()));
    let found = found.map_err(text)?;
    drop(all);
    for (number, body) in casters.into_iter().enumerate() {
        body.left_out = found.faces(number).to_vec();
    }
    Ok((less, found.statistics().left_out))
}

fn alike() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut changed, mut occluded, mut different, mut failures) = (0, 0, 0, Vec::new());
    for (index, class) in CLASSES.iter().enumerate() {
        for number in rotated(&[240, 241, 242], index / 3) {
            let seed = seed(class, number);
            let mut random = Random::new(seed);
            let mut frame = (class.frame)(&mut random);
            frame.size = 64;
            frame.lights.truncate(1);
            for body in &mut frame.bodies {
                body.mirror = None;
            }
            // Each caster once more: farther away, or at the same position.
            let again: Vec<Body> = frame.bodies.iter().filter(|body| body.casts).take(2).cloned().collect();
            let by = [0.0, 0.25, 0.5][random.below(3)];
            frame.bodies.extend(again.into_iter().map(|body| body.moved([by, -by, 0.5 * by])));
            let (less, count) = without_occluded(&frame, number > 240)?;
            occluded += count;
            for counting in rotated(&RIGHT, index) {
                for every_face in [false, true] {
                    let options = OneCasterOptions { every_face, ..OneCasterOptions::default() };
                    let draw = |frame: &Frame| {
                        Renderer { placing: Placing::Scene, options, ..Renderer::new(gpu) }.count(frame, counting)
                    };
                    let (with, without) = (draw(&frame)?, draw(&less)?);
                    let dark = |counted: &Counted| counted.stencils[0].iter().map(|n| *n != 0).collect::<Vec<_>>();
                    let (with_dark, without_dark) = (dark(&with), dark(&without));
                    changed += usize::from(with.stencils[0] != without.stencils[0]);
                    let off: Vec<usize> =
                        (0..with_dark.len()).filter(|&at| with_dark[at] != without_dark[at]).collect();
                    different += off.len();
                    if !off.is_empty() {
                        let what = format!("{}, seed {seed}, {counting:?}, every face {every_face}", class.name);
                        failures.push(format!("{what}: pixels {off:?}"));
                    }
                    let mut wrong = with_dark.clone();
                    wrong[0] = !wrong[0];
                    must_fail("a pixel of the other kind", &same("dark", &wrong, &with_dark))?;
                }
            }
        }
    }
    println!("{occluded} occluded faces, {changed} pictures with other counts, {different} pixels differ");
    for failure in &failures {
        println!("{failure}");
    }
    if occluded < 100 || changed < 20 {
        return Err("too few of a kind".to_owned());
    }
    if failures.is_empty() { Ok(()) } else { Err(format!("{} pictures differ", failures.len())) }
}
