//! Polygons of a modelling tool: outlines, masks and arrays are those of the triangles that are drawn, by rays in `f64`.

use std::fmt::Write as _;
use std::path::Path;

use glam::DVec3;
use rimline_testkit::rays::Tracer;

use super::draw::{is_ink, png};
use super::npz_polygons::words;
use super::run::{Folder, folder, read_file, run, write_file};
use super::shadow::{Image, apart};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("polygon_surface::the_outline_is_that_of_the_surface", outline),
    ("polygon_surface::masks_are_those_of_the_surface", masks),
    ("polygon_surface::arrays_are_those_of_the_triangles", arrays),
    ("polygon_surface::both_sides_of_a_polygon_have_the_same_triangles", both_sides),
    ("polygon_surface::polygons_without_a_surface_are_a_model", without_surface),
    ("polygon_surface::coincident_faces_look_like_one", coincident),
    ("polygon_surface::flat_faces_with_other_diagonals_behind_them_look_like_one", other_diagonals),
    ("polygon_surface::a_sheet_of_two_sides_has_no_lines_between_them", sheet),
    ("polygon_surface::outlines_of_many_corners_take_no_time", many_corners),
];

/// A bar of two by three that is twisted once around as it rises: its quadrilaterals are not planar. Each is also turned over
/// if `is_double`. Written as polygons, or as the triangles of fans.
fn bar(is_double: bool, are_triangles: bool) -> String {
    const LAYERS: usize = 18;
    let mut text = String::new();
    for layer in 0..=LAYERS {
        let part = layer as f64 / LAYERS as f64;
        let (sin, cos) = (5.0 * part).sin_cos();
        for [x, z] in [[-0.6, -0.25], [0.6, -0.25], [0.6, 0.25], [-0.6, 0.25]] {
            let _ = writeln!(text, "v {:.6} {:.6} {:.6}", cos * x + sin * z, 2.6 * part, cos * z - sin * x);
        }
    }
    let mut faces = vec![[1, 2, 3, 4], [3, 2, 1, 0].map(|corner| 4 * LAYERS + corner + 1)];
    for layer in 0..LAYERS {
        for side in 0..4 {
            let next = (side + 1) % 4;
            let [low, high] = [4 * layer + 1, 4 * layer + 5];
            faces.push([low + side, high + side, high + next, low + next]);
        }
    }
    for [a, b, c, d] in faces {
        // The second side begins elsewhere.
        let sides = if are_triangles {
            [format!("f {a} {b} {c}\nf {a} {c} {d}"), format!("f {c} {b} {a}\nf {d} {c} {a}")]
        } else {
            [format!("f {a} {b} {c} {d}"), format!("f {d} {c} {b} {a}")]
        };
        sides.iter().take(1 + usize::from(is_double)).for_each(|side| _ = writeln!(text, "{side}"));
    }
    text
}

const EYE: DVec3 = DVec3::new(2.5, 3.2, 4.0);
const TARGET: DVec3 = DVec3::new(0.0, 1.2, 0.0);
const SIZE: [usize; 2] = [200, 150];
const VIEW: &str = "--eye 2.5,3.2,4 --target 0,1.2,0 --fov 40 --size 200x150";
const LIGHT: DVec3 = DVec3::new(0.6, 1.0, 0.5);

/// The model's triangles, as `extract` writes them.
fn surface(folder: &Path) -> Result<Tracer<()>, String> {
    run(folder, "extract @bar.obj --device cpu --light dir:.6,1,.5 --out @bar.npz").expect(0, &[])?;
    let archive = read_file(folder.join("bar.npz"))?;
    let (positions, faces) = (words(&archive, "positions")?, words(&archive, "faces")?);
    let corner =
        |&v: &u32| DVec3::from(std::array::from_fn(|c| f64::from(f32::from_bits(positions[3 * v as usize + c]))));
    Ok(Tracer::build(faces.as_chunks::<3>().0.iter().map(|face| (face.each_ref().map(corner), ()))))
}

fn with_bar() -> Result<(Folder, Tracer<()>), String> {
    let folder = folder();
    folder.write("bar.obj", bar(false, false))?;
    let surface = surface(folder.path())?;
    Ok((folder, surface))
}

/// The ray through each pixel's middle.
fn rays() -> impl Iterator<Item = DVec3> {
    let forward = (TARGET - EYE).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let [width, height] = SIZE.map(|pixels| pixels as f64);
    let half = 20.0_f64.to_radians().tan();
    (0..SIZE[0] * SIZE[1]).map(move |pixel| {
        let [x, y] = [pixel % SIZE[0], pixel / SIZE[0]].map(|at| at as f64 + 0.5);
        let (x, y) = (half * (2.0 * x - width) / height, half * (1.0 - 2.0 * y / height));
        forward + x * right + y * up
    })
}

/// The pixel and those around it.
fn around(pixel: usize, reach: usize) -> impl Iterator<Item = usize> {
    let [width, height] = SIZE;
    let (x, y) = (pixel % width, pixel / width);
    let [xs, ys] = [(x, width), (y, height)].map(|(at, end)| at.saturating_sub(reach)..(at + reach + 1).min(end));
    ys.flat_map(move |y| xs.clone().map(move |x| y * width + x))
}

fn outline() -> Outcome {
    let (folder, surface) = with_bar()?;
    let covered: Vec<bool> = rays().map(|ray| surface.first((EYE, ray)).is_some()).collect();
    let on_contour = |&pixel: &usize| covered[pixel] && around(pixel, 1).any(|other| !covered[other]);
    let contour: Vec<usize> = (0..covered.len()).filter(on_contour).collect();
    let bare = |options: &str| -> Result<usize, String> {
        folder.run(&format!("draw @bar.obj {VIEW} {options} --out @bar.png")).expect(0, &[])?;
        let picture = png(&folder.path().join("bar.png"))?;
        let has_line = |&&pixel: &&usize| around(pixel, 2).any(|near| is_ink(picture.pixels[near]));
        Ok(contour.len() - contour.iter().filter(has_line).count())
    };
    let (found, by_loop) = (bare("")?, bare("--polygons")?);
    ensure!(found == 0, "{found} of {} pixels of the contour have no line", contour.len());
    ensure!(by_loop > contour.len() / 50, "by the loop rule {by_loop} of {} have none", contour.len());
    Ok(())
}

/// Light on the surface that a ray meets: 255, 0, or 128 for no surface. The ground is at 0, the bar's lowest point.
fn seen(surface: &Tracer<()>, ray: DVec3) -> u8 {
    let on_surface = surface.first((EYE, ray)).map(|(at, triangle)| {
        let [a, b, c] = triangle.corners;
        (at, (b - a).cross(c - a))
    });
    let on_ground = (ray.y < 0.0).then(|| (EYE - ray * (EYE.y / ray.y), DVec3::Y));
    let nearest = on_surface
        .into_iter()
        .chain(on_ground)
        .min_by(|one, other| one.0.distance_squared(EYE).total_cmp(&other.0.distance_squared(EYE)));
    let Some((at, normal)) = nearest else { return 128 };
    let is_turned_to_both = (normal.dot(LIGHT) > 0.0) == (normal.dot(ray) < 0.0);
    if is_turned_to_both && surface.first((at + 1e-5 * LIGHT, LIGHT)).is_none() { 255 } else { 0 }
}

fn masks() -> Outcome {
    let (folder, surface) = with_bar()?;
    let truth: Vec<u8> = rays().map(|ray| seen(&surface, ray)).collect();
    let is_even = |&pixel: &usize| around(pixel, 1).all(|near| truth[near] == truth[pixel]);
    let even: Vec<usize> = (0..truth.len()).filter(is_even).collect();
    let wrong = |options: &str| -> Result<usize, String> {
        let line = format!("shadow @bar.obj {VIEW} --light dir:.6,1,.5 {options} --mask @m");
        folder.run(&line).expect(0, &[])?;
        let mask = folder.mask("m.0.png")?;
        Ok(even.iter().filter(|&&pixel| mask.bytes[pixel] != truth[pixel]).count())
    };
    for method in ["auto", "z-fail"] {
        let found = wrong(&format!("--method {method}"))?;
        // Where two faces are nearly in one plane with the light, rays in `f64` start on a rounded place.
        ensure!(found <= 2, "{method}: {found} of {} pixels are wrong", even.len());
    }
    let by_loop = wrong("--polygons")?;
    ensure!(by_loop > 20, "by the loop rule {by_loop} of {} are wrong", even.len());
    Ok(())
}

/// The archive of the polygons is that of a file with the same triangles, but for the order of the faces.
fn arrays() -> Outcome {
    let folder = folder();
    let mut found = Vec::new();
    for are_triangles in [false, true] {
        folder.write("bar.obj", bar(false, are_triangles))?;
        folder.run("extract @bar.obj --light dir:.6,1,.5 --out @bar.npz").expect(0, &[])?;
        let archive = folder.read("bar.npz")?;
        let faces = words(&archive, "faces")?;
        let turned = |&[a, b, c]: &[u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min();
        let mut faces: Vec<_> = faces.as_chunks::<3>().0.iter().filter_map(turned).collect();
        faces.sort_unstable();
        let bits = |name: &str| -> Result<u32, String> { Ok(words(&archive, name)?.iter().map(|mask| mask & 1).sum()) };
        found.push((faces, words(&archive, "positions")?, bits("facing")?, bits("silhouette")?));
        ensure!(words(&archive, "loop_sizes").is_err(), "there are polygons");
    }
    ensure!(found[0] == found[1], "the polygons have {:?}, the triangles {:?}", found[0], found[1]);
    let line = "verify --make @bits @bar.obj --faces 20";
    folder.run(line).expect(0, &[])?;
    folder.run("verify @bits --device cpu").expect(0, &[])
}

/// Each polygon a second time, turned over and from another corner on.
fn both_sides() -> Outcome {
    let folder = folder();
    folder.write("bar.obj", bar(true, false))?;
    let placed = &folder.run("info @bar.obj --json").json()?["placed"];
    let count = |key: &str| placed[key].as_u64();
    let counts = ["faces", "duplicate_faces", "flipped_faces"].map(count);
    ensure!(counts == [Some(296), Some(148), Some(148)], "{placed}");
    Ok(())
}

/// An edge walked both ways, a hole that is its loop, and both beside a triangle.
fn without_surface() -> Outcome {
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
    let folder = folder();
    for (faces, degenerate, all) in
        [("f 1 2 2 1\nf 1 1 1 1\nf 1 2 2\n", 3, 3), ("f 1 2 3 1 3 2\nf 1 2 4 3\nf 2 3 2 3\n", 2, 4)]
    {
        folder.write("m.obj", format!("{corners}{faces}"))?;
        let placed = &folder.run("info @m.obj --json").json()?["placed"];
        ensure!(placed["faces"] == all && placed["degenerate_faces"] == degenerate, "{faces}: {placed}");
        takes_every_command(folder.path(), "@m.obj", faces)?;
    }
    Ok(())
}

/// Extraction and query on both devices, with triangles and with polygons.
fn takes_every_command(folder: &Path, model: &str, name: &str) -> Outcome {
    use super::archive::{array, write_zip};
    let data: Vec<u8> = [0.25_f32, 0.25, -1.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let points = write_zip(&[array("points", "<f4", "False", "(1, 3)", &data)]);
    write_file(folder.join("points.npz"), points)?;
    for options in ["", "--polygons"] {
        for (command, own) in [("extract", ""), ("query", "--points @points.npz")] {
            let mut results = Vec::new();
            for device in ["cpu", "gpu"] {
                let line = format!(
                    "{command} {model} {options} {own} --light dir:0,0,1 --light point:2,3,4 --device {device}"
                );
                let run = run(folder, &format!("{line} --out @{device}.npz"));
                run.expect(0, &[]).map_err(|error| format!("{name}: {line}: {error}"))?;
                results.push(read_file(folder.join(format!("{device}.npz")))?);
            }
            ensure!(results[0] == results[1], "{name}: {command} {options}: devices differ");
        }
        for (command, result) in [("draw", "--out @p.png"), ("shadow", "--light dir:0,1,1 --mask @m")] {
            // Without a triangle there is nothing to draw, and it says so.
            let run = run(folder, &format!("{command} {model} {options} --size 32x24 {result}"));
            let has_triangles = options.is_empty() || name.contains("f 1 2 4 3");
            let code = i32::from(!has_triangles);
            run.expect(code, &[]).map_err(|error| format!("{name}: {command} {options}: {error}"))?;
        }
    }
    Ok(())
}

/// A bar whose every face is there twice, turned over, looks like the bar: whichever face comes first.
fn coincident() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    for are_triangles in [false, true] {
        let [single, double] = [false, true].map(|is_double| bar(is_double, are_triangles));
        write_file(at("single.obj"), single)?;
        write_file(at("double.obj"), double)?;
        let z_fail = "shadow --light point:3,4,2 --method z-fail";
        for command in ["draw", if are_triangles { z_fail } else { "shadow --light dir:.6,1,.5" }] {
            for body in ["single", "double"] {
                let mask = if command.starts_with("draw") { String::new() } else { format!("--mask @{body}") };
                let line = format!("{command} @{body}.obj {VIEW} --out @{body}.png {mask}");
                folder.run(&line).expect(0, &[])?;
            }
            let [single, double] = ["single.png", "double.png"].map(|name| png(&at(name)));
            let count = apart([single?.pixels.as_flattened(), double?.pixels.as_flattened()], 3, 24)?;
            // Normals next to the contour are smoothed over other faces. Stripes would be on thousands of pixels.
            ensure!(count <= 60, "{command}: {count} pixels differ");
            if command.starts_with("draw") {
                continue;
            }
            let [single, double] = ["single.0.png", "double.0.png"].map(|name| Image::mask(&at(name)));
            let count = apart([&single?.bytes, &double?.bytes], 1, 0)?;
            ensure!(count <= 6, "{command}: {count} pixels of the mask differ");
        }
    }
    Ok(())
}

/// A cube of flat sides, and the same with each side a second time, turned over and cut along the other diagonal.
fn other_diagonals() -> Outcome {
    let folder = folder();
    let mut single = String::new();
    for corner in 0..8 {
        let [x, y, z] = [corner & 1, corner >> 1 & 1, corner >> 2].map(|side| 2.0 * f64::from(side) - 0.9);
        let _ = writeln!(single, "v {x:.3} {y:.3} {z:.3}");
    }
    let mut double = single.clone();
    for [a, b, c, d] in [[1, 5, 7, 3], [2, 4, 8, 6], [1, 2, 6, 5], [3, 7, 8, 4], [1, 3, 4, 2], [5, 6, 8, 7]] {
        let front = format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        single.push_str(&front);
        let _ = writeln!(double, "{front}f {d} {b} {a}\nf {d} {c} {b}");
    }
    for (name, text) in [("single", &single), ("double", &double)] {
        std::fs::write(folder.path().join(format!("{name}.obj")), text).map_err(|error| error.to_string())?;
        for command in ["draw", "shadow --light point:3,5,4 --method z-fail"] {
            let kind = if command == "draw" { "draw" } else { "shadow" };
            let line = format!("{command} @{name}.obj --eye 4,3,5 --size 200x150 --out @{name}.{kind}.png");
            run(folder.path(), &line).expect(0, &[])?;
        }
    }
    for kind in ["draw", "shadow"] {
        let [one, both] = ["single", "double"].map(|name| png(&folder.path().join(format!("{name}.{kind}.png"))));
        let count = apart([one?.pixels.as_flattened(), both?.pixels.as_flattened()], 3, 24)?;
        ensure!(count == 0, "{kind}: {count} pixels differ");
    }
    Ok(())
}

/// A folded sheet, each face followed by its other side: edge records join the sides of one face, but nobody sees a line there.
fn sheet() -> Outcome {
    let folder = folder();
    let mut text = String::new();
    for row in 0..9 {
        for column in 0..9 {
            let _ = writeln!(text, "v {column} {:.3} {row}", 0.05 * f64::from((row * column) % 3));
        }
    }
    for row in 0..8 {
        for column in 1..9 {
            let [a, b, c, d] = [9 * row + column, 9 * row + column + 1, 9 * row + column + 10, 9 * row + column + 9];
            let _ = writeln!(text, "f {a} {d} {c}\nf {c} {d} {a}\nf {a} {c} {b}\nf {b} {c} {a}");
        }
    }
    folder.write("sheet.obj", text)?;
    let line = "draw @sheet.obj --eye 4,12,4.01 --target 4,0,4 --fov 60 --size 160x160 --out @sheet.png";
    folder.run(line).expect(0, &[])?;
    let picture = png(&folder.path().join("sheet.png"))?;
    // Within the sheet, which is 8 of 13.9 units wide.
    let inner = (40..120).flat_map(|y| (40..120).map(move |x| 160 * y + x));
    let ink = inner.filter(|&pixel| is_ink(picture.pixels[pixel])).count();
    ensure!(ink == 0, "{ink} pixels of lines on a sheet that is seen from above");
    let glazed = picture.pixels[160 * 80 + 80];
    ensure!(glazed[2] > glazed[0], "its back is seen: {glazed:?}");
    Ok(())
}

/// A circle that rounding dents, as the CPU and whatever `auto` chooses take it; GPUs refuse it and say what to do.
fn many_corners() -> Outcome {
    const CORNERS: usize = 20_000;
    let folder = folder();
    let (mut text, mut face) = (String::new(), "f".to_owned());
    for corner in 0..CORNERS {
        let (sin, cos) = (corner as f64 / CORNERS as f64 * std::f64::consts::TAU).sin_cos();
        let _ = writeln!(text, "v {} {} 0", cos as f32, sin as f32);
        let _ = write!(face, " {}", corner + 1);
    }
    folder.write("m.obj", format!("{text}{face}\n"))?;
    for device in ["cpu", "auto"] {
        for options in ["", "--polygons"] {
            let line =
                format!("extract @m.obj {options} --light point:.1,.2,3 --light dir:1,0,0 --device {device} --json");
            let json = folder.run(&format!("{line} --out @m.npz")).json()?;
            let edges = &json["silhouette_edges"];
            ensure!(edges == &serde_json::json!([CORNERS, CORNERS]), "{device} {options}: {edges}");
        }
    }
    for command in ["extract @m.obj --light dir:0,0,1 --device gpu --out @m.npz", "draw @m.obj --out @m.png"] {
        folder.run(&format!("{command} --polygons")).expect(3, &["polygon 0", "20000 edges", "--polygons"])?;
    }
    Ok(())
}
