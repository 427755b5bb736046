//! Volumes that end at the range of their light.

use glam::DVec3;
use rimline::gpu::SceneOptions;
use rimline::{Counting, Light};

use crate::rays::{self, Truth};
use crate::render::Renderer;
use crate::trials::{Test, Traced};
use rimline_testkit::device::Gpu;
use rimline_testkit::frame_classes::{CLASSES, Class};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, made_anew, must_fail};

pub(crate) const TESTS: &[Test] = &[("volumes_end_at_the_range", ended)];

fn light_position(light: Light) -> DVec3 {
    DVec3::from(light.xyz.map(f64::from)) / f64::from(light.w)
}

/// A frame, of which rays see nothing out of the light's range; and what they see there.
pub(crate) fn in_range(class: &Class, number: u64) -> (Traced, Vec<Vec<Truth>>, f32) {
    let mut traced = Traced::new(class, number);
    let light = light_position(traced.frame.lights[0]);
    let casters = traced.frame.bodies.iter().filter(|body| body.casts);
    let corners = casters
        .flat_map(|body| body.finite_faces().into_iter().flatten().map(|vertex| body.shape.positions[vertex as usize]));
    let distances: Vec<f64> = corners.map(|p| DVec3::from(p.map(f64::from)).distance(light)).collect();
    let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
    let farthest = distances.iter().copied().fold(0.0, f64::max);
    // From some of the casters to a good way behind them.
    let range = (nearest + (farthest - nearest) * f64::from(Random::new(traced.seed).between(0.3, 3.0))) as f32;
    let mut beyond = traced.truths.clone();
    for ((truth, beyond), point) in traced.truths.iter_mut().zip(&mut beyond).zip(rays::points(&traced.frame)) {
        let is_in = point.is_some_and(|point| point.distance(light) <= f64::from(range));
        let outside = if is_in { beyond } else { truth };
        outside[0] = Truth::Background;
    }
    (traced, beyond, range)
}

/// Within the range all is as ever, by every method; out of it shadows are gone. A range that is said to be smaller than it
/// is leaves shadows out that the rays see.
fn ended() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let options = SceneOptions { end_at_range: true, ..made_anew(32, Counting::Auto) };
    let methods = [Counting::Auto, Counting::ZFail, Counting::ZPass, Counting::ZpPlus, Counting::ZpPlus2005];
    let (mut volumes, mut shadowed, mut gone) = ([0; 5], 0, [0; 5]);
    for class in CLASSES.iter().filter(|class| class.name != "directional lights") {
        for number in 50..if is_long() { 70 } else { 51 } {
            let (traced, beyond, range) = in_range(class, number);
            let renderer = Renderer { options, range, ..Renderer::new(&gpu) };
            shadowed += traced.shadowed();
            // Volumes of ZP+ never end, and z-pass and the published method are not right everywhere.
            let is_outside = class.name == "camera outside the shadow";
            for (method, &counting) in methods[..if is_outside { 5 } else { 2 }].iter().enumerate() {
                let what = |error| format!("{}, range {range}: {error}", class.name);
                let (_, counted) = traced.check(&renderer, counting, !class.touches).map_err(what)?;
                volumes[method] += counted.statistics.iter().map(|statistics| statistics.ended).sum::<u32>();
                let pixels = counted.stencils[0].iter().zip(&beyond);
                gone[method] += pixels.filter(|(count, truth)| **count == 0 && truth[0].is_shadowed()).count();
                if is_outside && method < 3 {
                    let whole = Traced::new(class, number);
                    let range = light_position(whole.frame.lights[0]).length() as f32;
                    must_fail("a range too small", &whole.check(&Renderer { range, ..renderer }, counting, false))?;
                }
            }
        }
    }
    println!("{shadowed} pixels in shadow; by {methods:?}:");
    println!("{volumes:?} volumes ended, {gone:?} pixels out of range not in shadow any more");
    let is_right = volumes[..3].iter().all(|&ended| ended > 0) && volumes[3..] == [0, 0];
    if is_right && shadowed > 0 && gone[0].min(gone[1]) > 0 {
        return Ok(());
    }
    Err("volumes ended where they should not, or did not where they should".to_owned())
}
