//! `cargo xtask demo`.

use std::process::Command;

use crate::{process, vulkan};

/// Models made by code: the file, and the program of `rimline-models` with the arguments that writes it.
const MODELS: [(&str, &str, &[&str]); 2] = [(WALKER, "walking_figure", &[]), ("blob.glb", "shape", &["blob"])];

/// Pictures: the file, the command that draws it, the model, and how it is shown, words apart by spaces. The figure
/// faces +Z, is 1.76 m tall, and takes 1.1 s for two steps. `docs/walking_figure.png` is `walk_from_the_front.png` with
/// `--size 640x800`, `docs/walking_shadows.png` is `walk_with_shadows.png` with that size, and `docs/walking_lines.png`
/// is `walk_as_lines.svg` as a PNG with `--page 160x200 --dpi 102`.
const PICTURES: [[&str; 4]; 6] = [
    ["walk_from_the_front.png", "draw", WALKER, "--time 0.02 --eye 1.7,1.5,3.6 --target 0,0.88,0 --fov 30"],
    [
        "walk_with_shadows.png",
        "shadow",
        WALKER,
        "--time 0.02 --eye 1.9,2.7,5.4 --target 0.12,0.72,-0.2 --fov 27 \
         --light point:-2.1,5.2,2.2,color=1,.2,.1 --light point:2.3,5.4,2.2,color=.1,.8,.18 \
         --light point:0.6,5,3.6,color=.12,.25,1",
    ],
    ["walk_from_the_side.png", "draw", WALKER, "--time 0.5 --eye 3.9,1.1,0.7 --target 0,0.88,0 --fov 30"],
    ["walk_from_behind.png", "draw", WALKER, "--time 0.75 --eye -2.2,1.9,-3.1 --target 0,0.88,0 --fov 30"],
    ["walk_as_lines.svg", "lines", WALKER, "--time 0.02 --view 25,12"],
    ["blob.png", "draw", "blob.glb", "--eye 3.2,2.4,5.2 --target 0,0,0 --fov 36"],
];
const WALKER: &str = "walking_figure.glb";

/// Makes the models, draws the pictures, and names them at the end.
pub(crate) fn run() -> Result<(), String> {
    vulkan::ensure()?;
    let mut build = process::cargo(["build", "--release", "--package", "rimline-cli", "--package", "rimline-models"]);
    // Pictures need no measurements and no charts.
    build.arg("--no-default-features");
    // Whoever only looks at pictures debugs nothing, and the profile's debug information takes time and space.
    process::run(build.env("CARGO_PROFILE_RELEASE_DEBUG", "0"))?;
    let demo = process::root().join("demo");
    std::fs::create_dir_all(&demo).map_err(|error| format!("cannot make {}: {error}", demo.display()))?;
    for (file, model, arguments) in MODELS {
        process::run(program(model).args(arguments).arg(demo.join(file)))?;
    }
    let mut written = Vec::new();
    for [file, command, model, view] in PICTURES {
        let out = demo.join(file);
        // So that a picture that is named has been drawn now.
        if out.exists() {
            std::fs::remove_file(&out).map_err(|error| format!("cannot replace {}: {error}", out.display()))?;
        }
        let animation: &[&str] = if model == WALKER { &["--animation", "0"] } else { &[] };
        let size: &[&str] = if command == "lines" { &[] } else { &["--size", "960x1200"] };
        let mut draw = program("rimline");
        draw.arg(command).arg(demo.join(model)).args(view.split(' ')).args(animation).args(size);
        process::run(draw.arg("--out").arg(&out))?;
        if !out.is_file() {
            return Err(format!("`rimline {command}` succeeded, but there is no {}", out.display()));
        }
        written.push(out.display().to_string());
    }
    println!("\n{}", written.join("\n"));
    Ok(())
}

/// A program from the release build.
fn program(name: &str) -> Command {
    Command::new(process::target().join("release").join(format!("{name}{}", std::env::consts::EXE_SUFFIX)))
}
