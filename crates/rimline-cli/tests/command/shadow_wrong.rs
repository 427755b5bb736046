//! `rimline shadow` and `film`: what is refused, and that nothing is left then.

use rimline_testkit::shapes;

use super::npz_input::tetrahedron;
use super::run::{folder, is_empty, rimline};
use super::shadow::{model, with_cube};
use super::{Outcome, Test, ensure};
use crate::archive::{array, write_zip};

pub(crate) const TESTS: &[Test] = &[
    ("shadow::wrong_options_end_with_2", wrong_options),
    ("shadow::options_without_effect_end_with_2", idle_options),
    ("shadow::result_names_that_clash_end_with_2", clash),
    ("shadow::bad_input_leaves_nothing", bad_input),
    ("shadow::unwritable_places_end_with_4", unwritable),
    ("shadow::help_offers_no_cpu_where_pictures_are_drawn", help),
];

fn wrong_options() -> Outcome {
    let folder = with_cube()?;
    let results = folder.inner("results")?;
    let cases = [
        ("", "--out"),
        ("--out @results/p.png --method best", "best"),
        ("--out @results/p.png --mode dark", "dark"),
        ("--out @results/p.png --light sun:1,2,3", "sun"),
        ("--out @results/p.png --light point:1,2,3,range=0", "range"),
        ("--out @results/p.png --light point:1,2,3,colour=1,1,1", "colour"),
        ("--out @results/p.png --light point:1,2,3,color=1,1", "3 numbers"),
        ("--out @results/p.png --light point:1,2,3,intensity=-1", "intensity"),
        ("--out @results/p.png --light hom:1,2,3,-1", "negative w"),
        ("--out @results/p.png --light file:all", "no lights"),
        ("--out @results/p.png --area tube", "tube"),
        ("--out @results/p.png --area disc:0", "more than 0"),
        ("--out @results/p.png --area disc --samples 33", "32"),
        ("--out @results/p.png --area disc --mode black", "black"),
        ("--out @results/p.png --near 0", "near"),
        ("--out @results/p.png --near 1e-35", "normal range"),
        ("--out @results/p.png --near 1e-36", "normal range"),
        ("--out @results/p.png --near 1e-38", "normal range"),
        ("--out @results/p.png --ground high", "high"),
        ("--out @results/p.png --size 0x4", "pixel"),
        ("--out @results/p.png --size 4000000000x4", "4000000000x4"),
        ("--out @results/p.png --eye 0,0,0 --target 0,0,0", "--target"),
        ("--out @results/p.png --device cpu", "GPU"),
        ("--out @results/p.png --animation Run", "Run"),
    ];
    for (options, part) in cases {
        folder
            .run(&format!("shadow @cube.npz {options}"))
            .expect(2, &[part])
            .map_err(|error| format!("{options}: {error}"))?;
        is_empty(&results).map_err(|error| format!("{options}: {error}"))?;
    }
    let film = [
        ("", "--frames"),
        ("--frames 0", "0"),
        ("--fps 0", "0.001 to 100000"),
        ("--seconds 1e9", "100000"),
        ("--frames 2 --seconds 1", "--seconds"),
    ];
    for (options, part) in film {
        folder
            .run(&format!("film @cube.npz --out @results/ {options}"))
            .expect(2, &[part])
            .map_err(|error| format!("{options}: {error}"))?;
        is_empty(&results).map_err(|error| format!("{options}: {error}"))?;
    }
    folder.run("shadow --out @results/p.png").expect(2, &["FILE"])?;
    let many = "--light dir:0,1,0 ".repeat(33);
    let line = format!("shadow @cube.npz {many} --area disc --samples 32 --out @results/p.png");
    folder.run(&line).expect(2, &["1056", "1024"])
}

fn idle_options() -> Outcome {
    let folder = with_cube()?;
    for (options, part) in [
        ("--samples 4", "--area"),
        ("--light point:1,2,3,begin=1", "range"),
        ("--light point:1,2,3,exponent=2", "range"),
        ("--light dir:1,2,3,range=4", "infinity"),
        ("--light point:1,2,3,begin=4,range=3", "begin=4"),
    ] {
        folder
            .run(&format!("shadow @cube.npz --size 16x16 --out @p.png {options}"))
            .expect(2, &[part])
            .map_err(|error| format!("{options}: {error}"))?;
        ensure!(!folder.path().join("p.png").exists(), "{options}: a picture");
    }
    Ok(())
}

fn bad_input() -> Outcome {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| folder.write(name, bytes);
    write("good.npz", &tetrahedron())?;
    write("nan.npz", &model(&shapes::cube(), f32::NAN, [0.0; 3]))?;
    let positions = array("positions", "<f4", "False", "(1, 3)", &[0; 12]);
    write("empty.npz", &write_zip(&[positions, array("faces", "<u4", "False", "(0, 3)", &[])]))?;
    write("noise.glb", &[7; 100])?;
    let results = folder.inner("results")?;
    for (files, part) in [
        ("@nan.npz", "finite"),
        ("@empty.npz", "no faces"),
        ("@good.npz @empty.npz", "empty.npz"),
        ("@noise.glb", "noise.glb"),
        ("@missing.npz", "missing.npz"),
    ] {
        for command in ["shadow", "film --frames 1"] {
            folder
                .run(&format!("{command} {files} --size 16x16 --out @results/p"))
                .expect(1, &[part])
                .map_err(|error| format!("{command} {files}: {error}"))?;
            is_empty(&results).map_err(|error| format!("{command} {files}: {error}"))?;
        }
    }
    // A file without anything finite beside a good one casts nothing, and is no reason to stop.
    folder.run("shadow @good.npz @nan.npz --size 16x16 --out @results/p.png").expect(0, &[])
}

fn unwritable() -> Outcome {
    let folder = with_cube()?;
    for line in [
        "shadow @cube.npz --size 16x16 --out @no/such.png",
        "shadow @cube.npz --size 16x16 --out @p.png --mask @no/such",
        "film @cube.npz --frames 2 --size 16x16 --out @no/such/",
    ] {
        folder.run(line).expect(4, &["cannot be written"]).map_err(|error| format!("{line}: {error}"))?;
    }
    ensure!(!folder.path().join("p.png").exists(), "a picture in spite of its masks' failure");
    Ok(())
}

fn clash() -> Outcome {
    let folder = with_cube()?;
    let clash = folder.run("shadow @cube.npz --size 16x16 --out @a.0.png --mask @a");
    clash.expect(2, &["--out", "--mask", "a.0.png"])?;
    folder.run("shadow @cube.npz --size 16x16 --out @./b.0.png --mask @b").expect(2, &["--mask"])?;
    for name in ["a.0.png", "b.0.png"] {
        ensure!(!folder.path().join(name).exists(), "there is a {name}");
    }
    // There is only one light.
    folder.run("shadow @cube.npz --size 16x16 --out @a.1.png --mask @a").expect(0, &[])
}

fn help() -> Outcome {
    for command in ["shadow", "film", "draw"] {
        let run = rimline([command, "--help"]);
        run.expect(0, &[])?;
        ensure!(run.stdout.contains("--device <auto|gpu|NAME>"), "{}", run.stdout);
        ensure!(!run.stdout.contains("cpu") && !run.stdout.contains("the CPU"), "{}", run.stdout);
    }
    // The folder in the example of the help works as it is shown.
    let folder = with_cube()?;
    let example = rimline(["film", "--help"]).stdout;
    let (_, out) = example.rsplit_once("--out ").ok_or("no example")?;
    let out = out.lines().next().unwrap_or_default().trim();
    folder.run(&format!("film @cube.npz --frames 1 --size 16x16 --out @{out}")).expect(0, &[])?;
    ensure!(folder.path().join(out).join("0000.png").is_file(), "no frame in {out}");
    Ok(())
}
