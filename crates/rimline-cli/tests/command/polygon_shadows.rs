//! Shadows of polygons: masks of the ground, against what `query` counts.

use std::fmt::Write as _;
use std::path::Path;

use rimline_testkit::random::Random;

use super::archive::{words_of, write_zip};
use super::makers::rows;
use super::pictures::Image;
use super::run::{folder, is_long, read_file, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("polygon_shadows::the_ground_is_dark_where_query_counts_polygons", ground),
    ("polygon_shadows::more_pieces_than_there_is_room_for", many_pieces),
];

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

/// Rows of small quadrilaterals above the eye that cross themselves as seen from above: six pieces each.
fn bow_ties(rows: std::ops::Range<usize>) -> String {
    let (mut text, mut vertex) = (String::new(), 1);
    for (row, column) in rows.flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        let [x, z] = [column, row].map(|at| 3.0 * ((at as f32 + 0.5) / COLUMNS as f32 - 0.5));
        for [dx, dz] in [[-1.0, -1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]] {
            let _ = writeln!(text, "v {} {} {}", x + 0.015 * dx, 3.0 + 0.001 * dx, z + 0.015 * dz);
        }
        let _ = writeln!(text, "f {vertex} {} {} {}", vertex + 1, vertex + 2, vertex + 3);
        vertex += 4;
    }
    text
}

const COLUMNS: usize = 84;

/// A scene has room for 1,048,576 pieces of 32 lights and one for each sixteenth edge: 34,532 a light. There are
/// 42,336. In two files there is room.
fn many_pieces() -> Outcome {
    let folder = folder();
    folder.write("all.obj", bow_ties(0..COLUMNS))?;
    folder.write("one.obj", bow_ties(0..COLUMNS / 2))?;
    folder.write("other.obj", bow_ties(COLUMNS / 2..COLUMNS))?;
    let mut lights = String::new();
    for x in -16..16 {
        let _ = write!(lights, " --light dir:{x},64,-5");
    }
    let masks = |models: &str, name: &str| -> Result<Vec<Image>, String> {
        let run = folder.run(&format!("shadow {models} --polygons {VIEW}{lights} --method z-fail --mask @{name}"));
        run.expect(0, &[])?;
        ensure!(!run.stderr.contains("warning"), "{}", run.stderr);
        (0..32).map(|light| Image::mask(&folder.path().join(format!("{name}.{light}.png")))).collect()
    };
    let (whole, cut) = (masks("@all.obj", "whole")?, masks("@one.obj @other.obj", "cut")?);
    for (light, (whole, cut)) in whole.iter().zip(&cut).enumerate() {
        let dark = [whole, cut].map(|mask| mask.count(0));
        ensure!(whole.bytes == cut.bytes, "light {light}: {dark:?} dark pixels");
        ensure!(dark[0] > 500, "light {light}: {} dark pixels", dark[0]);
    }
    Ok(())
}
