//! Every bad file of the catalogue gives a typed error, or a warning, that names the JSON path.

use std::path::Path;

use libtest_mimic::Trial;
use rimline::MeshError;
use rimline::gltf::{Asset, SkippedPrimitives};
use rimline::mesh::Weld;
use rimline_models::catalogue::{BAD, Fate};
use rimline_testkit::files;
use rimline_testkit::harness::{on_both, on_made};
use rimline_testkit::refusals::{self, refusal};

use crate::{Outcome, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        on_both("bad::no_position", ["no_position.glb", "bad/primitive_no_position.gltf"], no_position),
        test("bad::control", control),
    ];
    tests.extend(on_made("bad::", BAD.iter().map(|bad| bad.name), |path| {
        let bad = BAD.iter().find(|bad| path.ends_with(bad.name)).ok_or("no row")?;
        if bad.fate == Fate::Refused { refused(path, bad.says) } else { warned(path, bad.says) }
    }));
    tests
}

fn refused(path: &Path, says: &[&str]) -> Outcome {
    Ok(refusals::refused([refusal(path.display(), Asset::open(path, Weld::Data), refusals::says(says))])?)
}

fn warned(path: &Path, says: &[&str]) -> Outcome {
    let asset = Asset::open(path, Weld::Data)?;
    crate::check::asset(&asset, 0, false)?;
    let warnings = crate::check::said(&asset);
    let one = warnings.iter().any(|warning| says.iter().all(|part| warning.contains(part)));
    ensure(one, || format!("{warnings:?} do not say {says:?}"))
}

fn no_position(path: &Path) -> Outcome {
    let asset = Asset::open(path, Weld::Data)?;
    let skipped = SkippedPrimitives { without_position: 1, ..SkippedPrimitives::default() };
    same(&asset.skipped(), &skipped, "skipped")?;
    same(&asset.model().mesh(&asset.pose(None, 0.0)?), &Err(MeshError::NoFaces.into()), "the mesh")
}

fn control() -> Outcome {
    let is_refused = |name: &str, says: &[&str]| Ok::<_, String>(refused(&files::made(name)?.path, says).is_ok());
    ensure(!is_refused("cube.glb", &[])?, || "a good file passed as bad".to_owned())?;
    ensure(!is_refused(BAD[1].name, &["meshes[7]"])?, || "a wrong path passed".to_owned())?;
    ensure(is_refused(BAD[1].name, &["meshes[0]"])?, || "the right one did not".to_owned())
}
