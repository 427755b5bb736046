//! Models that a GPU cannot take, and pictures.

use super::archive::write_zip;
use super::makers::{npz_mesh, rows, tetrahedron};
use super::run::{folder, is_long};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("fallback::auto_takes_the_cpu_for_a_large_model", model),
    ("fallback::a_picture_that_does_not_fit_has_advice", picture),
];

/// More than four bindings of 128 MiB hold; adapters with larger ones take it. Smaller ones are cases.
fn model() -> Outcome {
    if !is_long() {
        return Ok(());
    }
    let folder = folder();
    let positions: Vec<[f32; 3]> = (0..60_000_000).map(|v| [(v / 2) as f32, (v % 2) as f32, 0.0]).collect();
    let faces: Vec<[u32; 3]> = (0..64).map(|f| [f, f + 1, f + 2]).collect();
    folder.write("model.npz", npz_mesh(&positions, &faces))?;
    let points = write_zip(&[rows("points", &[[0.0; 3]])]);
    folder.write("points.npz", points)?;
    for command in ["extract", "query --points @points.npz"] {
        for device in ["cpu", "auto"] {
            let line = format!("{command} @model.npz --no-weld --light point:1,2,3 --device {device} --out @{device}");
            folder.run(&line).expect(0, &[])?;
        }
        ensure!(folder.read("cpu")? == folder.read("auto")?, "other bytes than the CPU's");
    }
    Ok(())
}

fn picture() -> Outcome {
    let folder = folder();
    folder.write("model.npz", tetrahedron())?;
    for command in ["draw", "shadow"] {
        let run = folder.run(&format!("{command} @model.npz --size 16384x16384 --out @out.png"));
        if run.code == 0 {
            // A large device.
            continue;
        }
        run.expect(2, &["--size 16384x16384", "try --size "])?;
        let (_, advice) = run.stderr.rsplit_once("try --size ").ok_or("no advice")?;
        let sides: Vec<u32> = advice.trim().split('x').filter_map(|side| side.parse().ok()).collect();
        ensure!(matches!(sides[..], [w, h] if w == h && (1..=8192).contains(&w)), "{command}: {}", run.stderr);
        ensure!(!folder.path().join("out.png").exists(), "there is a picture");
    }
    Ok(())
}
