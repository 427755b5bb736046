//! Shaders are compiled apart from the work for `--json` alone, with lights as the models have them.

use super::archive::{array, write_zip};
use super::run::Run;
use super::shadow::with_cube;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] =
    &[("warm_up::only_json_waits_for_it", only_json), ("warm_up::it_sees_lights_as_the_models_do", lights)];

/// Whether the text lists compiling among the stages.
fn has_compiled(run: &Run) -> bool {
    run.stdout.lines().any(|line| line.starts_with("by stage") && line.contains("compile"))
}

fn only_json() -> Outcome {
    let folder = with_cube()?;
    let points = write_zip(&[array("points", "<f4", "False", "(1, 3)", &[0; 12])]);
    folder.write("points.npz", points)?;
    for line in [
        "extract @cube.npz --light dir:1,2,1 --device gpu --out @bits.npz",
        "query @cube.npz --points @points.npz --light dir:1,2,1 --device gpu --out @depths.npz",
        "shadow @cube.npz --size 64x48 --out @shadow.png",
        "shadow @cube.npz --size 64x48 --from-depth 16 --mask @depth",
    ] {
        let text = folder.run(line);
        text.expect(0, &[])?;
        ensure!(text.stdout.contains("by stage"), "{line}: no stages in {}", text.stdout);
        ensure!(!has_compiled(&text), "{line}: the work ran twice: {}", text.stdout);
        let json = folder.run(&format!("{line} --json")).json()?;
        let compiled = json["milliseconds"]["compile"].as_f64();
        ensure!(compiled.is_some_and(|time| time > 0.0), "{line}: compiled in {compiled:?}");
    }
    Ok(())
}

/// The light is outside of a small cube, which has one map. It is among what is larger, which would have six.
fn lights() -> Outcome {
    let folder = with_cube()?;
    let small = super::shadow::model(&rimline_testkit::shapes::cube(), 0.05, [0.0; 3]);
    folder.write("small.npz", small)?;
    let line = "shadow @small.npz --size 64x48 --light point:0.3,0.4,0.2 --from-depth 64 \
        --detector contours=0.01 --mask @m";
    let json = folder.run(&format!("{line} --json")).json()?;
    ensure!(json["lights"][0]["depth_map"]["maps"] == 1, "{}", json["lights"]);
    // Negative control: a light in the cube has six maps, and that is said.
    let among = line.replace("0.3,0.4,0.2", "0.01,0,0");
    folder.run(&among).expect(2, &["--detector every or automatic"])
}
