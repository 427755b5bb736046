//! `rimline film`: numbered pictures in a folder.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_testkit::harness::on_both;

use super::run::{folder, rimline};
use super::shadow::{Image, with_cube};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] =
    &[("shadow::a_film_is_numbered_and_whole", film), ("shadow::a_films_folder_is_made_and_unmade", film_folder)];

pub(crate) fn trials() -> Vec<Trial> {
    let files = ["skinned_without_indices.glb", "Fox.glb"];
    vec![on_both("a_film_plays_the_first_animation", files, first_animation)]
}

fn film() -> Outcome {
    let folder = with_cube()?;
    folder.write(
        "rise.wgsl",
        "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
            return position + vec3<f32>(0.0, time, 0.0);
        }",
    )?;
    let moving = "--displace @rise.wgsl --ground 0 --size 64x48 --fps 2";
    folder.run(&format!("film @cube.npz {moving} --seconds 1.5 --out @frames")).expect(0, &[])?;
    let mut names: Vec<_> = std::fs::read_dir(folder.path().join("frames"))
        .map_err(|error| error.to_string())?
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .collect();
    names.sort();
    ensure!(names == ["0000.png", "0001.png", "0002.png"], "{names:?}");
    let frame = |name: &str| Image::read(&folder.path().join("frames").join(name)).map(|image| image.bytes);
    let frames = [frame("0000.png")?, frame("0001.png")?, frame("0002.png")?];
    ensure!(frames[0] != frames[1] && frames[1] != frames[2], "nothing moves");
    // Into the folder that is there: not a shorter film, whose pictures would stand among these.
    folder.run(&format!("film @cube.npz {moving} --frames 1 --out @frames/")).expect(2, &["0001.png"])?;
    ensure!(frame("0000.png")? == frames[0] && frame("0002.png")? == frames[2], "a film that was refused wrote");
    folder.run(&format!("film @cube.npz {moving} --frames 3 --out @frames/")).expect(0, &[])?;
    ensure!(frame("0001.png")? == frames[1] && frame("0002.png")? == frames[2], "a folder that is there");
    folder.run(&format!("film @cube.npz {moving} --out @more")).expect(2, &["--frames", "--seconds"])
}

fn film_folder() -> Outcome {
    let folder = with_cube()?;
    let exists = |name: &str| folder.path().join(name).exists();
    let film = |options: &str| folder.run(&format!("film @cube.npz --size 16x16 {options}"));
    film("--frames 2 --out @a").expect(0, &[])?;
    film("--frames 2 --out @b/").expect(0, &[])?;
    for name in ["a/0000.png", "a/0001.png", "b/0000.png", "b/0001.png"] {
        ensure!(exists(name), "there is no {name}");
    }
    film("--frames 2 --out @cube.npz").expect(4, &["not a folder"])?;
    film("--out @c").expect(2, &["--frames"])?;
    film("--frames 2 --out @c --light point:1,2,3 --eye 0,0,0 --target 0,0,0").expect(2, &["--target"])?;
    film("--frames 2 --out @c --device nowhere").expect(3, &["nowhere"])?;
    ensure!(!exists("c"), "an empty folder is left");
    Ok(())
}

fn first_animation(file: &Path) -> Outcome {
    let folder = folder();
    let film = |name: &str, options: &[&str]| {
        let mut line = vec!["film".into(), file.as_os_str().to_owned()];
        line.extend(["--size", "64x48", "--fps", "1", "--out"].map(Into::into));
        line.push(folder.path().join(name).into_os_string());
        line.extend(options.iter().map(Into::into));
        rimline(line)
    };
    film("first", &[]).expect(0, &["0 `Survey`", "2 `Run`", "--animation"])?;
    film("named", &["--animation", "Survey"]).expect(0, &[])?;
    for frame in ["0000.png", "0002.png"] {
        let [first, named] = ["first", "named"].map(|name| Image::read(&folder.path().join(name).join(frame)));
        ensure!(first?.bytes == named?.bytes, "{frame} shows something else than the first animation");
    }
    Ok(())
}
