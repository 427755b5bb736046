//! Shadows of polygons: masks of the ground, against what `query` counts.

use std::fmt::Write as _;
use std::path::Path;

use rimline_testkit::random::Random;

use super::archive::{words_of, write_zip};
use super::makers::rows;
use super::pictures::Image;
use super::run::{folder, is_long, read_file, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("polygon_shadows::the_ground_is_dark_where_query_counts_polygons", ground)];

const SIZE: usize = 96;
/// The eye looks straight down from a height of 2, on 4 by 4 units of the ground.
const VIEW: &str = "--ground 0 --eye 0,2,0 --target 0,0,0 --fov 90 --size 96x96";
const LIGHTS: &str = "--light dir:0.2,1,-0.1 --light point:1,9,-1";

/// Polygons above the eye, most of them twisted as seen from above, and the triangles that they are drawn as.
fn write(file: &Path, seed: u64, are_triangles: bool) -> Outcome {
    let mut random = Random::new(seed);
    let (mut text, mut vertex) = (String::new(), 1);
    for _ in 0..5 {
        let corners = 4 + random.below(4);
        let mut face = "f".to_owned();
        for _ in 0..corners {
            let [x, z] = [random.between(-1.6, 1.6), random.between(-1.6, 1.6)];
            let _ = writeln!(text, "v {x} {} {z}", random.between(3.0, 4.0));
            let _ = write!(face, " {vertex}");
            vertex += 1;
        }
        if are_triangles {
            let first = vertex - corners;
            for at in 1..corners - 1 {
                let _ = writeln!(text, "f {first} {} {}", first + at, first + at + 1);
            }
        } else {
            let _ = writeln!(text, "{face}");
        }
    }
    write_file(file, text)
}

/// The middles of pixels on the ground. Below the eye the picture's right is +X, and its top is −Z.
fn pixels() -> Vec<[f32; 3]> {
    let at = |pixel: usize| 2.0 * ((pixel as f32 + 0.5) * 2.0 / SIZE as f32 - 1.0);
    (0..SIZE * SIZE).map(|pixel| [at(pixel % SIZE), 0.0, at(pixel / SIZE)]).collect()
}

/// Whether the neighbours of a pixel have its depth for a light, too.
fn is_even(depths: &[u32], pixel: usize, light: usize) -> bool {
    let (x, y) = (pixel % SIZE, pixel / SIZE);
    let around = |at: usize| at.saturating_sub(1)..=(at + 1).min(SIZE - 1);
    around(y)
        .flat_map(|y| around(x).map(move |x| y * SIZE + x))
        .all(|other| depths[2 * other + light] == depths[2 * pixel + light])
}

/// Pixels that are wrong, of those that are on no edge.
fn wrong(mask: &Image, depths: &[u32], light: usize) -> [usize; 2] {
    let even: Vec<_> = (0..SIZE * SIZE).filter(|&pixel| is_even(depths, pixel, light)).collect();
    let is_wrong = |&&pixel: &&usize| (mask.bytes[pixel] == 0) != (depths[2 * pixel + light] > 0);
    [even.iter().filter(is_wrong).count(), even.len()]
}

fn ground() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    folder.write("points.npz", write_zip(&[rows("points", &pixels())]))?;
    let depths = |model: &str| -> Result<Vec<u32>, String> {
        let line = format!("query @{model}.obj --polygons {LIGHTS} --points @points.npz --out @depths.npz");
        folder.run(&line).expect(0, &[])?;
        words_of(&read_file(at("depths.npz"))?, "depth")
    };
    let (mut folds, seeds) = (0, if is_long() { 2 } else { 1 });
    for seed in 0..seeds {
        write(&at("polygons.obj"), seed, false)?;
        write(&at("triangles.obj"), seed, true)?;
        let (polygons, triangles) = (depths("polygons")?, depths("triangles")?);
        for method in ["auto", "z-fail", "zp+"] {
            let line = format!("shadow @polygons.obj --polygons {VIEW} {LIGHTS} --method {method} --mask @m");
            folder.run(&line).expect(0, &[])?;
            for light in 0..2 {
                let mask = Image::mask(&at(&format!("m.{light}.png")))?;
                let [found, of] = wrong(&mask, &polygons, light);
                ensure!(found == 0, "seed {seed}, {method}, light {light}: {found} of {of} pixels are wrong");
                ensure!(of > SIZE * SIZE / 2, "{of} pixels are on no edge");
                folds += wrong(&mask, &triangles, light)[0];
            }
        }
    }
    ensure!(folds > 1000, "triangles have the same shadows but for {folds} pixels");
    Ok(())
}
