//! Soft shadows of the command: the penumbra is as smooth as a light's whole area makes it, and far shadows are there.

use glam::{DVec2, DVec3};

use super::outlines::box_model;
use super::pictures::Image;
use super::run::folder;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] =
    &[("soft::the_penumbra_shows_no_steps", penumbra), ("soft::a_low_sun_throws_far_shadows", low_sun)];

const SIZE: [usize; 2] = [480, 360];

/// Where a picture is taken from: eye, target, vertical field of view in degrees.
type View = (DVec3, DVec3, f64);

/// The shadow's far corner, from near enough that steps are wider than blocks.
const CORNER: View = (DVec3::new(1.5, 3.0, 6.5), DVec3::new(1.5, 0.0, 0.4), 12.0);
const WIDE: View = (DVec3::new(6.0, 4.0, 9.0), DVec3::new(6.0, 0.0, 0.0), 30.0);
/// A box on posts of air: its shadow is all on the ground and in the picture.
const LOW: DVec3 = DVec3::new(-0.5, 0.6, -0.4);
const HIGH: DVec3 = DVec3::new(0.4, 1.1, 0.5);
const LIGHT: DVec3 = DVec3::new(-4.0, 5.0, -0.5);
const RADIUS: f64 = 0.8;

/// Right, up and forward, the last as long as the picture's half height is wide.
fn axes((eye, target, fov): View) -> [DVec3; 3] {
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    [right, right.cross(forward), forward / (0.5 * fov.to_radians()).tan()]
}

/// The ground, at height 0, at a pixel's centre.
fn ground(view: View, x: usize, y: usize) -> Option<DVec3> {
    let ([right, up, forward], eye) = (axes(view), view.0);
    let half = 0.5 * SIZE[1] as f64;
    let [across, down] = [(x as f64 + 0.5 - 0.5 * SIZE[0] as f64) / half, (y as f64 + 0.5) / half - 1.0];
    let ray = forward + across * right - down * up;
    (ray.y < 0.0).then(|| eye - ray * (eye.y / ray.y))
}

/// The way from one point to the other leads through the box.
fn meets_box(from: DVec3, to: DVec3) -> bool {
    let inverse = (to - from).recip();
    let (a, b) = ((LOW - from) * inverse, (HIGH - from) * inverse);
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    enter.max(0.0) < leave.min(1.0)
}

fn draw((eye, target, fov): View, options: &str) -> Result<Image, String> {
    let folder = folder();
    folder.write("box.npz", box_model([LOW.to_array(), HIGH.to_array()]))?;
    let view = format!("--size {}x{} --eye {} --target {} --fov {fov}", SIZE[0], SIZE[1], list(eye), list(target));
    folder.run(&format!("shadow @box.npz --out @p.png --ground 0 {view} {options}")).expect(0, &[])?;
    folder.image("p.png")
}

fn list(v: DVec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}

/// Colour of the ground in so much light of strength 1, by the formulas of `scene.wgsl`, `ground.wgsl` and `picture.wgsl`.
fn shade(light: f64) -> [f64; 3] {
    let (albedo, around) = ([0.80, 0.79, 0.77], [0.86, 0.95, 1.08]);
    std::array::from_fn(|c| {
        let x: f64 = 1.12 / 1.27 * albedo[c] * (0.27 * around[c] + light);
        let over = (x - 0.7).max(0.0) / 0.3;
        let pressed: f64 = x.min(0.7) + 0.3 * over / (1.0 + over);
        255.0 * if pressed > 0.003_130_8 { 1.055 * pressed.powf(1.0 / 2.4) - 0.055 } else { 12.92 * pressed }
    })
}

/// Light of the disc that reaches each pixel of the ground, and the share of the disc that is visible from there.
/// `None` for a pixel that shows no ground.
fn expected() -> Vec<Option<(f64, f64)>> {
    let normal = (0.5 * (LOW + HIGH) - LIGHT).normalize();
    let (right, up) = normal.any_orthonormal_pair();
    let steps = 22;
    let at = |n: i32| (2.0 * f64::from(n) + 1.0) / f64::from(steps) - 1.0;
    let lamps: Vec<DVec3> = (0..steps * steps)
        .map(|n| DVec2::new(at(n % steps), at(n / steps)))
        .filter(|p| p.length() < 1.0)
        .map(|p| RADIUS * DVec2::from_angle(0.37).rotate(p))
        .map(|p| LIGHT + p.x * right + p.y * up)
        .collect();
    let pixels = (0..SIZE[0] * SIZE[1]).map(|n| [n % SIZE[0], n / SIZE[0]]);
    let light = |[x, y]: [usize; 2]| {
        let point = ground(CORNER, x, y).filter(|&point| !meets_box(CORNER.0, point))?;
        let open: Vec<f64> =
            lamps.iter().filter(|&&lamp| !meets_box(point, lamp)).map(|&lamp| (lamp - point).normalize().y).collect();
        let count = lamps.len() as f64;
        Some((open.iter().sum::<f64>() / count, open.len() as f64 / count))
    };
    pixels.map(light).collect()
}

/// The worst difference between a step from block to block and the step that it should be; and how many were compared.
fn worst_step(picture: &Image, expected: &[Option<(f64, f64)>]) -> (f64, usize) {
    let [columns, rows] = SIZE.map(|pixels| pixels / 8);
    let block = |column: usize, row: usize| {
        let pixels: Vec<usize> = (0..64).map(|n| (8 * row + n / 8) * SIZE[0] + 8 * column + n % 8).collect();
        let light: Option<Vec<(f64, f64)>> = pixels.iter().map(|&pixel| expected[pixel]).collect();
        let light = light.filter(|light| light.iter().all(|&(_, share)| share > 0.0 && share < 1.0))?;
        let mean = |of: &dyn Fn(usize) -> f64| (0..64).map(of).sum::<f64>() / 64.0;
        let errors: [f64; 3] = std::array::from_fn(|c| {
            mean(&|n| f64::from(picture.pixels()[pixels[n]][c])) - mean(&|n| shade(light[n].0)[c])
        });
        Some(errors)
    };
    let (mut worst, mut pairs) = (0.0_f64, 0);
    for (row, column) in (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| (row, column))) {
        let Some(here) = block(column, row) else { continue };
        for there in [block(column + 1, row), block(column, row + 1)].into_iter().flatten() {
            pairs += 1;
            worst = (0..3).fold(worst, |worst, c| worst.max((here[c] - there[c]).abs()));
        }
    }
    (worst, pairs)
}

fn penumbra() -> Outcome {
    let lamp = format!("--light point:{} --area disc:{RADIUS}", list(LIGHT));
    let expected = expected();
    let (worst, pairs) = worst_step(&draw(CORNER, &lamp)?, &expected);
    ensure!(pairs > 60, "only {pairs} pairs of blocks lie in the penumbra");
    ensure!(worst <= 2.0, "means of 8x8 pixels step by {worst} too much or too little, of {pairs} pairs");
    // The same samples everywhere are seen as steps: the comparison can fail.
    let (worst, _) = worst_step(&draw(CORNER, &format!("{lamp} --one-pattern"))?, &expected);
    ensure!(worst > 4.0, "one pattern steps by {worst} only");
    Ok(())
}

/// The shadow's far end, ten times as far away as the box is large, is as dark as its near one.
fn low_sun() -> Outcome {
    let sun = DVec3::new(-1.0, 0.1, 0.0);
    let picture = draw(WIDE, &format!("--light dir:{}", list(sun)))?;
    let is_dark = |point: DVec3| meets_box(point, point + 40.0 * sun);
    let contrast = |from: f64, to: f64| {
        let (mut dark, mut lit) = (Vec::new(), Vec::new());
        for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
            let Some(point) = ground(WIDE, x, y) else { continue };
            if meets_box(WIDE.0, point) || point.x < from || point.x > to || point.z.abs() > 1.0 {
                continue;
            }
            let to = if is_dark(point) { &mut dark } else { &mut lit };
            to.push(f64::from(picture.pixels()[y * SIZE[0] + x][1]));
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        if dark.len() > 50 && lit.len() > 50 { Ok(mean(&lit) - mean(&dark)) } else { Err("nothing is seen there") }
    };
    let (near, far) = (contrast(6.2, 7.5)?, contrast(9.0, 10.5)?);
    ensure!(near > 8.0, "the shadow is not there at all: {near}");
    ensure!(far > 0.9 * near, "the far shadow is fainter: {far} against {near}");
    Ok(())
}
