//! Animations of model files.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_testkit::harness::on_both;

use super::run::folder;
use super::{Outcome, ensure};

pub(crate) fn trials() -> Vec<Trial> {
    let animated = ["skinned_without_indices.glb", "Fox.glb"];
    vec![on_both("models::a_film_plays_the_first_animation", animated, first_animation)]
}

fn first_animation(file: &Path) -> Outcome {
    let folder = folder();
    let model = folder.path().join(file.file_name().ok_or("no name")?);
    std::fs::copy(file, &model).map_err(|error| error.to_string())?;
    let name = model.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let film = |out: &str| folder.run(&format!("film @{name} --size 64x48 --fps 1 --out @{out}"));
    film("first").expect(0, &["0 `Survey`", "2 `Run`", "--animation"])?;
    film("named --animation Survey").expect(0, &[])?;
    for frame in ["0000.png", "0002.png"] {
        let [first, named] = ["first", "named"].map(|film| folder.image(format!("{film}/{frame}")));
        ensure!(first?.bytes == named?.bytes, "{frame} shows something else than the first animation");
    }
    Ok(())
}
