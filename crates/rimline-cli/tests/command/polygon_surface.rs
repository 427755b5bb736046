//! Polygons of a modelling tool: outlines and masks are those of the triangles that are drawn, by rays in `f64`.

use std::path::Path;

use glam::DVec3;
use rimline_testkit::rays::Tracer;

use super::archive::words_of;
use super::models_of_code::bar;
use super::pictures::is_ink;
use super::run::{Folder, folder, read_file, run};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("polygon_surface::the_outline_is_that_of_the_surface", outline),
    ("polygon_surface::masks_are_those_of_the_surface", masks),
];

const EYE: DVec3 = DVec3::new(2.5, 3.2, 4.0);
const TARGET: DVec3 = DVec3::new(0.0, 1.2, 0.0);
const SIZE: [usize; 2] = [200, 150];
const VIEW: &str = "--eye 2.5,3.2,4 --target 0,1.2,0 --fov 40 --size 200x150";
const LIGHT: DVec3 = DVec3::new(0.6, 1.0, 0.5);

/// The model's triangles, as `extract` writes them.
fn surface(folder: &Path) -> Result<Tracer<()>, String> {
    run(folder, "extract @bar.obj --device cpu --light dir:.6,1,.5 --out @bar.npz").expect(0, &[])?;
    let archive = read_file(folder.join("bar.npz"))?;
    let (positions, faces) = (words_of(&archive, "positions")?, words_of(&archive, "faces")?);
    let corner =
        |&v: &u32| DVec3::from(std::array::from_fn(|c| f64::from(f32::from_bits(positions[3 * v as usize + c]))));
    Ok(Tracer::build(faces.as_chunks::<3>().0.iter().map(|face| (face.each_ref().map(corner), ()))))
}

fn with_bar() -> Result<(Folder, Tracer<()>), String> {
    let folder = folder();
    folder.write("bar.obj", bar(false, false))?;
    let surface = surface(folder.path())?;
    Ok((folder, surface))
}

/// The ray through each pixel's middle.
fn rays() -> impl Iterator<Item = DVec3> {
    let forward = (TARGET - EYE).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let [width, height] = SIZE.map(|pixels| pixels as f64);
    let half = 20.0_f64.to_radians().tan();
    (0..SIZE[0] * SIZE[1]).map(move |pixel| {
        let [x, y] = [pixel % SIZE[0], pixel / SIZE[0]].map(|at| at as f64 + 0.5);
        let (x, y) = (half * (2.0 * x - width) / height, half * (1.0 - 2.0 * y / height));
        forward + x * right + y * up
    })
}

/// The pixel and those around it.
fn around(pixel: usize, reach: usize) -> impl Iterator<Item = usize> {
    let [width, height] = SIZE;
    let (x, y) = (pixel % width, pixel / width);
    let [xs, ys] = [(x, width), (y, height)].map(|(at, end)| at.saturating_sub(reach)..(at + reach + 1).min(end));
    ys.flat_map(move |y| xs.clone().map(move |x| y * width + x))
}

fn outline() -> Outcome {
    let (folder, surface) = with_bar()?;
    let covered: Vec<bool> = rays().map(|ray| surface.first((EYE, ray)).is_some()).collect();
    let on_contour = |&pixel: &usize| covered[pixel] && around(pixel, 1).any(|other| !covered[other]);
    let contour: Vec<usize> = (0..covered.len()).filter(on_contour).collect();
    let bare = |options: &str| -> Result<usize, String> {
        folder.run(&format!("draw @bar.obj {VIEW} {options} --out @bar.png")).expect(0, &[])?;
        let picture = folder.image("bar.png")?;
        let has_line = |&&pixel: &&usize| around(pixel, 2).any(|near| is_ink(picture.pixels()[near]));
        Ok(contour.len() - contour.iter().filter(has_line).count())
    };
    let (found, by_loop) = (bare("")?, bare("--polygons")?);
    ensure!(found == 0, "{found} of {} pixels of the contour have no line", contour.len());
    ensure!(by_loop > contour.len() / 50, "by the loop rule {by_loop} of {} have none", contour.len());
    Ok(())
}

/// Light on the surface that a ray meets: 255, 0, or 128 for no surface. The ground is at 0, the bar's lowest point.
fn seen(surface: &Tracer<()>, ray: DVec3) -> u8 {
    let on_surface = surface.first((EYE, ray)).map(|(at, triangle)| {
        let [a, b, c] = triangle.corners;
        (at, (b - a).cross(c - a))
    });
    let on_ground = (ray.y < 0.0).then(|| (EYE - ray * (EYE.y / ray.y), DVec3::Y));
    let nearest = on_surface
        .into_iter()
        .chain(on_ground)
        .min_by(|one, other| one.0.distance_squared(EYE).total_cmp(&other.0.distance_squared(EYE)));
    let Some((at, normal)) = nearest else { return 128 };
    let is_turned_to_both = (normal.dot(LIGHT) > 0.0) == (normal.dot(ray) < 0.0);
    if is_turned_to_both && surface.first((at + 1e-5 * LIGHT, LIGHT)).is_none() { 255 } else { 0 }
}

fn masks() -> Outcome {
    let (folder, surface) = with_bar()?;
    let truth: Vec<u8> = rays().map(|ray| seen(&surface, ray)).collect();
    let is_even = |&pixel: &usize| around(pixel, 1).all(|near| truth[near] == truth[pixel]);
    let even: Vec<usize> = (0..truth.len()).filter(is_even).collect();
    let wrong = |options: &str| -> Result<usize, String> {
        let line = format!("shadow @bar.obj {VIEW} --light dir:.6,1,.5 {options} --mask @m");
        folder.run(&line).expect(0, &[])?;
        let mask = folder.mask("m.0.png")?;
        Ok(even.iter().filter(|&&pixel| mask.bytes[pixel] != truth[pixel]).count())
    };
    for method in ["auto", "z-fail"] {
        let found = wrong(&format!("--method {method}"))?;
        // Where two faces are nearly in one plane with the light, rays in `f64` start on a rounded place.
        ensure!(found <= 2, "{method}: {found} of {} pixels are wrong", even.len());
    }
    let by_loop = wrong("--polygons")?;
    ensure!(by_loop > 20, "by the loop rule {by_loop} of {} are wrong", even.len());
    Ok(())
}
