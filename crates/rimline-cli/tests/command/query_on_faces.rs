//! `rimline query` about points on the surface: they name their face, or are lifted.

use std::ffi::OsStr;
use std::path::Path;

use rimline_testkit::shadow_cases::centre;
use rimline_testkit::shapes::{self, Shape};

use super::archive::{Entry, array, data, read_zip, words, write_zip};
use super::makers::{npz_model, rows};
use super::run::{Run, folder, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] =
    &[("query_on_faces::half_of_a_sphere_is_lit", sphere), ("query_on_faces::lifted_points_are_other_points", lifted)];

/// The centres of all faces, in `f32`.
fn centres(shape: &Shape) -> Vec<[f32; 3]> {
    let corners = |face: &[u32; 3]| face.map(|vertex| shape.positions[vertex as usize]);
    shape.faces.iter().map(|face| centre(corners(face))).collect()
}

fn faces(kind: &str, faces: &[i64]) -> Entry {
    let size = kind[2..].parse().unwrap_or(8);
    let bytes: Vec<u8> = faces.iter().flat_map(|face| face.to_le_bytes()[..size].to_vec()).collect();
    array("on_face", kind, "False", &format!("({},)", faces.len()), &bytes)
}

/// Queries a model; the run, and the bytes of the result if there is one.
fn query(folder: &Path, shape: &Shape, points: &[Entry], options: &str) -> Result<(Run, Option<Vec<u8>>), String> {
    let [from, file, out] = ["model.npz", "points.npz", "out.npz"].map(|name| folder.join(name));
    write_file(&from, npz_model(shape, 1.0, [0.0; 3]))?;
    write_file(&file, write_zip(points))?;
    let mut line = vec![OsStr::new("query"), from.as_os_str(), OsStr::new("--points"), file.as_os_str()];
    line.extend([OsStr::new("--out"), out.as_os_str()]);
    line.extend(options.split_whitespace().map(OsStr::new));
    let run = rimline(line);
    let result = std::fs::read(&out).ok();
    if result.is_some() {
        std::fs::remove_file(&out).map_err(|error| error.to_string())?;
    }
    Ok((run, result))
}

/// The depths of a result, one light after the other for each point.
fn depths(result: Option<Vec<u8>>, shape: &str) -> Result<Vec<i32>, String> {
    let entries = read_zip(&result.ok_or("nothing was written")?)?;
    Ok(words(data(&entries[2], "<i4", shape)?).into_iter().map(u32::cast_signed).collect())
}

fn sphere() -> Outcome {
    let folder = folder();
    let shape = shapes::globe(48, 24);
    let points = rows("points", &centres(&shape));
    let named_faces: Vec<i64> = (0..2208).collect();
    let none = |kind: &str| vec![if kind == "<u4" { i64::from(u32::MAX) } else { -1 }; 2208];
    let mut outputs = Vec::new();
    for device in ["cpu", "gpu"] {
        let options = format!("--light dir:0,0,1 --device {device} --json");
        let in_shadow = |arrays: &[Entry], more: &str| -> Result<_, String> {
            let (run, result) = query(folder.path(), &shape, arrays, &format!("{options} {more}"))?;
            let json = run.json()?;
            let depths = depths(result.clone(), "(2208, 1)")?;
            let dark = depths.iter().filter(|&&depth| depth > 0).count();
            ensure!(json["points_in_shadow"] == serde_json::json!([dark]), "{json}");
            Ok((dark, json["points_on_faces"].as_u64(), result))
        };
        let (plain, named, result) = in_shadow(std::slice::from_ref(&points), "")?;
        ensure!(plain > 1300 && named == Some(0), "{device}: {plain} in shadow without faces");
        outputs.push(result);
        for kind in ["<i2", "<i4", "<u4", "<i8"] {
            let (dark, named, result) = in_shadow(&[points.clone(), faces(kind, &named_faces)], "")?;
            ensure!(dark == 1104 && named == Some(2208), "{device}, {kind}: {dark} in shadow");
            outputs.push(result);
            let (dark, named, _) = in_shadow(&[points.clone(), faces(kind, &none(kind))], "")?;
            ensure!(dark == plain && named == Some(0), "{device}, {kind}: {dark} in shadow, no face named");
        }
        let (dark, _, result) = in_shadow(std::slice::from_ref(&points), "--lift 1e-4")?;
        ensure!(dark == 1104, "{device}: {dark} of the lifted points in shadow");
        outputs.push(result);
    }
    let (cpu, gpu) = outputs.split_at(outputs.len() / 2);
    ensure!(cpu == gpu, "devices differ");
    ensure!(cpu[1..5].iter().all(|result| *result == cpu[1]), "types differ");
    let (run, _) =
        query(folder.path(), &shape, &[points, faces("<i4", &named_faces)], "--light dir:0,0,1 --device cpu")?;
    run.expect(0, &[])?;
    ensure!(run.stdout.contains("2208 name their face"), "{}", run.stdout);
    Ok(())
}

/// Depths of lifted points are those of points that were moved before, light by light.
fn lifted() -> Outcome {
    let folder = folder();
    let shape = shapes::torus(20, 12, 1.0, 0.4);
    let points = centres(&shape);
    let lights = [rimline::Light::point([0.3, 3.0, 0.2]), rimline::Light::directional([0.2, 1.0, -0.4])];
    let written = ["--light point:0.3,3,0.2", "--light dir:0.2,1,-0.4"];
    let all = written.join(" ");
    for device in ["cpu", "gpu"] {
        let options = format!("{all} --lift 0.25 --device {device}");
        let (run, result) = query(folder.path(), &shape, &[rows("points", &points)], &options)?;
        run.expect(0, &[])?;
        ensure!(run.stderr.is_empty(), "a warning: {}", run.stderr);
        let entries = read_zip(&result.clone().ok_or("nothing was written")?)?;
        let given: Vec<u32> = points.iter().flatten().map(|c| c.to_bits()).collect();
        ensure!(words(data(&entries[0], "<f4", "(480, 3)")?) == given, "the points changed");
        let found = depths(result, "(480, 2)")?;
        for (at, light) in lights.iter().enumerate() {
            let moved: Vec<_> = points.iter().map(|&point| light.lift(point, 0.25)).collect();
            let options = format!("{} --device cpu", written[at]);
            let (_, result) = query(folder.path(), &shape, &[rows("points", &moved)], &options)?;
            let right = depths(result, "(480, 1)")?;
            ensure!(found.iter().skip(at).step_by(2).eq(&right), "{device}, light {at}: other depths");
            let (_, result) = query(folder.path(), &shape, &[rows("points", &points)], &options)?;
            ensure!(depths(result, "(480, 1)")? != right, "negative control: the lift changes nothing");
        }
    }
    Ok(())
}
