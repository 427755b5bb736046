//! Base colours of models in pictures.

use super::facts::without_text;
use super::run::folder;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("colors::pictures_have_base_colors_unless_plain", pictures)];

/// A cube whose front is red, with the file of its materials or without.
fn cube(materials: &str) -> String {
    let corners: Vec<_> = (0..8).map(|n: u32| format!("v {} {} {}\n", n & 1, n >> 1 & 1, n >> 2)).collect();
    let corners = corners.concat();
    format!("{materials}{corners}f 1 3 4 2\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\nusemtl red\nf 5 6 8 7\n")
}

fn pictures() -> Outcome {
    let folder = folder();
    folder.write("red.mtl", "newmtl red\nKd 1 0 0\n")?;
    folder.write("colored.obj", cube("mtllib red.mtl\n"))?;
    folder.write("clay.obj", cube(""))?;
    let is_red = |pixel: [u8; 3]| pixel[0] > 90 && pixel[1] < 40 && pixel[2] < 40;
    for (command, out) in [
        ("shadow", "p.png"),
        ("shadow --mode black", "p.png"),
        ("shadow --area disc", "p.png"),
        ("draw", "p.png"),
        ("film --frames 1 --orbit 90", "f/0000.png"),
    ] {
        let picture = |file: &str, options: &str| {
            let out = if out == "p.png" { "p.png" } else { "f" };
            let run = folder.run(&format!("{command} @{file} {options} --size 120x90 --out @{out}"));
            run.expect(0, &[]).map(|()| run.stderr)
        };
        let drawn = |file: &str, options: &str| -> Result<(Vec<u8>, usize), String> {
            picture(file, options)?;
            Ok((without_text(&folder.read(out)?), folder.image(out)?.count_pixels(is_red)?))
        };
        let (clay, none) = drawn("clay.obj", "")?;
        ensure!(none == 0, "{command}: {none} pixels of clay are red");
        ensure!(drawn("clay.obj", "--plain")?.0 == clay, "{command}: --plain changes clay");
        ensure!(drawn("colored.obj", "--plain")?.0 == clay, "{command}: --plain is not clay");
        let (_, red) = drawn("colored.obj", "")?;
        ensure!(red > 400, "{command}: {red} pixels are red");
    }
    // A reason why colours are missing is told where they would be shown.
    folder.write("red.mtl", "newmtl blue\n")?;
    for (options, is_warned) in [("", true), ("--plain", false)] {
        let run = folder.run(&format!("shadow @colored.obj {options} --size 40x30 --out @p.png"));
        ensure!(run.stderr.contains("no material is named") == is_warned, "{options}: {}", run.stderr);
    }
    Ok(())
}
