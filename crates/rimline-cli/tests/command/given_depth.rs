//! `--depth`: shadows of a map that some program made, which `--save-depth` is one of.

use glam::{DMat4, DVec3};
use rimline_testkit::shapes;

use super::archive::{Entry, array, data, read_zip, words, write_zip};
use super::makers::npz_model;
use super::pictures::apart;
use super::run::{Folder, folder};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("given_depth::a_saved_map_has_the_same_mask", round_trip),
    ("given_depth::other_types_and_orders_are_the_same_map", types),
    ("given_depth::a_map_casts_and_the_models_do_not", casts_alone),
    ("given_depth::objects_bound_shadows", objects),
    ("given_depth::walls_without_room_are_told_and_shown_as_every_cell", overflow),
    ("given_depth::distances_are_the_same_map", distances),
];

const VIEW: &str = "--ground 0 --eye 4,9,14 --target 0,1,0 --size 160x120";
const LIGHT: &str = "point:6,12,3";

/// A folder with a ball and a ring around it.
fn models() -> Result<Folder, String> {
    let folder = folder();
    folder.write("ball.npz", npz_model(&shapes::sphere(8), 1.0, [0.0, 2.0, 0.0]))?;
    folder.write("ring.npz", npz_model(&shapes::torus(24, 12, 2.0, 0.5), 1.0, [0.0, 2.0, 0.5]))?;
    Ok(folder)
}

/// Saves the map of a light that sees both models, and a mask made with it.
fn save(folder: &Folder, light: &str, side: u32) -> Result<(serde_json::Value, Vec<u8>), String> {
    let line = format!(
        "shadow @ball.npz @ring.npz {VIEW} --light {light} --from-depth {side} --detector every --mask @own --save-depth @map --json"
    );
    Ok((folder.run(&line).json()?, mask(folder, "own")?))
}

fn mask(folder: &Folder, name: &str) -> Result<Vec<u8>, String> {
    Ok(folder.mask(format!("{name}.0.png"))?.bytes)
}

/// The mask of a map, and what is said about it.
fn of_map(folder: &Folder, map: &str, options: &str) -> Result<(serde_json::Value, Vec<u8>), String> {
    let line = format!("shadow @ball.npz @ring.npz {VIEW} --depth @{map}.npz {options} --mask @given --json");
    Ok((folder.run(&line).json()?, mask(folder, "given")?))
}

/// The entries of a saved map: depth, matrix, origin, direction.
fn entries(folder: &Folder) -> Result<Vec<Entry>, String> {
    read_zip(&folder.read("map.0.npz")?)
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    words(bytes).into_iter().map(f32::from_bits).collect()
}

fn round_trip() -> Outcome {
    let folder = models()?;
    let mut masks = Vec::new();
    // Among the models there are six maps.
    for (light, maps) in [(LIGHT, 1), ("point:1.2,2.4,0.9", 6), ("dir:-1,2,0.5", 1)] {
        let (said, rendered) = save(&folder, light, 128)?;
        let dark: usize = rendered.iter().map(|value| usize::from(*value == 0)).sum();
        ensure!(dark > 1000, "{light}: {dark} are dark");
        let (again, given) = of_map(&folder, "map.0", &format!("--light {light}"))?;
        ensure!(rendered == given, "{light}: {} pixels differ", apart([&rendered, &given], 1, 0)?);
        let of_light = &again["lights"][0];
        ensure!(of_light == &said["lights"][0] && again["method"] == "parity", "{light}: {said:#} {again:#}");
        ensure!(of_light["depth_map"]["maps"] == maps, "{again:#}");
        ensure!(of_light["depth_map"]["size"] == serde_json::json!([128, 128]), "{again:#}");
        // The light's place follows from the matrix, but for rounding.
        let (_, derived) = of_map(&folder, "map.0", "")?;
        ensure!(
            apart([&rendered, &derived], 1, 0)? < 20,
            "{light}: {} pixels differ without --light",
            apart([&rendered, &derived], 1, 0)?
        );
        masks.push(rendered);
    }
    // Negative controls: other lights, and a map that is moved.
    ensure!(
        apart([&masks[0], &masks[1]], 1, 0)? > 1000 && apart([&masks[0], &masks[2]], 1, 0)? > 1000,
        "all lights have the same mask"
    );
    let mut moved = entries(&folder)?;
    let origin: Vec<u8> = [0.5_f32, 2.0, 0.25].iter().flat_map(|c| c.to_le_bytes()).collect();
    moved[2] = array("origin", "<f4", "False", "(3,)", &origin);
    folder.write("moved.npz", write_zip(&moved))?;
    let (_, given) = of_map(&folder, "moved", "")?;
    ensure!(apart([&masks[2], &given], 1, 0)? > 300, "a map that is moved has the same mask");
    Ok(())
}

fn types() -> Outcome {
    const SIDE: usize = 128;
    let folder = models()?;
    let (_, rendered) = save(&folder, LIGHT, SIDE as u32)?;
    let saved = entries(&folder)?;
    let names: Vec<_> = saved.iter().map(|entry| entry.name.as_str()).collect();
    ensure!(names == ["depth.npy", "view_projection.npy", "origin.npy", "reversed.npy"], "{names:?}");
    let depths = floats(data(&saved[0], "<f4", &format!("({SIDE}, {SIDE})"))?);
    let matrix = floats(data(&saved[1], "<f4", "(4, 4)")?);
    let square = format!("({SIDE}, {SIDE})");
    let same = |name: &str, depth: Entry, matrix: Entry, reversed: Entry, most: usize| {
        folder.write("other.npz", write_zip(&[reversed, saved[2].clone(), matrix, depth]))?;
        let (_, given) = of_map(&folder, "other", &format!("--light {LIGHT}"))?;
        let differing = apart([&rendered, &given], 1, 0)?;
        ensure!(differing <= most, "{name}: {differing} pixels differ");
        Ok(())
    };
    // Other ways to say the same numbers.
    let packed = Entry { method: 8, ..saved[0].clone() };
    same("deflated", packed, saved[1].clone(), array("reversed", "|u1", "False", "(1,)", &[1]), 0)?;
    let turned = |values: &[f32], side: usize| -> Vec<u8> {
        let texels = (0..side * side).map(|at| at % side * side + at / side);
        texels.flat_map(|at| values[at].to_be_bytes()).collect()
    };
    let columns = array("depth", ">f4", "True", &square, &turned(&depths, SIDE));
    let doubles: Vec<u8> = matrix.iter().flat_map(|&value| f64::from(value).to_le_bytes()).collect();
    let doubles = array("view_projection", "<f8", "False", "(4, 4)", &doubles);
    same("columns, doubles", columns, doubles, array("reversed", "<i8", "False", "()", &1_u64.to_le_bytes()), 0)?;
    // Depth the other way round: 1 less it, and rows of the matrix likewise. It is coarser.
    let standard: Vec<u8> = depths.iter().flat_map(|depth| (1.0 - depth).to_le_bytes()).collect();
    let mut rows = matrix.clone();
    for column in 0..4 {
        rows[8 + column] = matrix[12 + column] - matrix[8 + column];
    }
    let rows: Vec<u8> = rows.iter().flat_map(|value| value.to_le_bytes()).collect();
    let standard = array("depth", "<f4", "False", &square, &standard);
    let rows = array("view_projection", "<f4", "False", "(4, 4)", &rows);
    same("standard", standard, rows, array("reversed", "|b1", "False", "()", &[0]), 10)?;
    // 16 bits.
    let steps: Vec<u8> = depths.iter().flat_map(|depth| ((depth * 65535.0).round() as u16).to_le_bytes()).collect();
    let steps = array("depth", "<u2", "False", &square, &steps);
    same("16 bits", steps, saved[1].clone(), saved[3].clone(), 40)?;
    // Negative control: rows and columns exchanged.
    let exchanged = array("depth", ">f4", "False", &square, &turned(&depths, SIDE));
    let failed = same("exchanged", exchanged, saved[1].clone(), saved[3].clone(), 40);
    ensure!(failed.is_err(), "a map with rows for columns has the same mask");
    Ok(())
}

/// A ball to the left casts by its map, and a cube to the right does not. The eye is far above.
fn casts_alone() -> Outcome {
    let folder = folder();
    folder.write("ball.npz", npz_model(&shapes::sphere(8), 1.0, [-4.0, 2.0, 0.0]))?;
    folder.write("cube.npz", npz_model(&shapes::cube(), 1.0, [4.0, 2.0, 0.0]))?;
    let view = "--ground 0 --eye 0,60,0.01 --target 0,0,0 --fov 15 --size 160x120 --light dir:0,1,1";
    let dark = |files: &str, options: &str| {
        folder.run(&format!("shadow {files} {view} {options} --mask @m --json")).json()?;
        let mask = folder.mask("m.0.png")?;
        let half = |columns: std::ops::Range<usize>| {
            columns.flat_map(|x| (0..120).map(move |y| (x, y))).filter(|&(x, y)| mask.at(x, y) == 0).count()
        };
        Ok::<_, String>([half(0..80), half(80..160)])
    };
    let [ball, cube] = dark("@ball.npz @cube.npz", "")?;
    ensure!(ball > 150 && cube > 150, "{ball} and {cube} pixels are dark by the meshes");
    dark("@ball.npz", "--from-depth 512 --save-depth @map")?;
    let [of_map, none] = dark("@cube.npz", "--depth @map.0.npz")?;
    // The ball itself is dark in part, and hides a part of its shadow from the eye.
    ensure!(
        (ball / 2..2 * ball).contains(&of_map) && none < 60,
        "{of_map} and {none}, and {ball} and {cube} by the meshes"
    );
    Ok(())
}

/// A convex body casts no shadow onto itself, so its outline is enough.
fn objects() -> Outcome {
    let folder = folder();
    folder.write("ball.npz", npz_model(&shapes::sphere(8), 1.0, [0.0, 2.0, 0.0]))?;
    let draw = |options: &str, name: &str| {
        let line = format!("shadow @ball.npz {VIEW} --light {LIGHT} {options} --mask @{name} --json");
        Ok::<_, String>((folder.run(&line).json()?, mask(&folder, name)?))
    };
    let (every, rendered) = draw("--from-depth 128 --detector every --save-depth @map", "own")?;
    let saved = entries(&folder)?;
    let with_objects = |number: fn(usize) -> u16| {
        let objects: Vec<u8> = (0..128 * 128).flat_map(|texel| number(texel).to_le_bytes()).collect();
        let mut entries = saved.clone();
        entries.push(array("objects", "<u2", "False", "(128, 128)", &objects));
        folder.write("objects.npz", write_zip(&entries))
    };
    with_objects(|_| 7)?;
    let (found, given) = draw("--depth @objects.npz --detector differences=1", "given")?;
    let cells = |json: &serde_json::Value| json["lights"][0]["depth_map"]["cells"].as_u64().unwrap_or(0);
    ensure!(apart([&rendered, &given], 1, 0)? < 30, "{} pixels differ", apart([&rendered, &given], 1, 0)?);
    ensure!(cells(&found) > 100 && 10 * cells(&found) < cells(&every), "{} and {}", cells(&found), cells(&every));
    // Halves of the ball are two objects: more edges, the same shadow.
    with_objects(|texel| u16::from(texel % 128 < 64))?;
    let (halves, given) = draw("--depth @objects.npz --detector differences=1", "given")?;
    ensure!(apart([&rendered, &given], 1, 0)? < 30 && cells(&halves) > cells(&found) + 20, "{} cells", cells(&halves));
    // Beside a threshold they are taken, too; with every edge there is nothing to add.
    let (both, _) = draw("--depth @objects.npz --detector differences=0.01", "given")?;
    let (steps, _) = draw("--depth @map.0.npz --detector differences=0.01", "given")?;
    ensure!(cells(&both) > cells(&steps) + 20, "{} and {}", cells(&both), cells(&steps));
    let (all, given) = draw("--depth @objects.npz", "given")?;
    ensure!(given == rendered && cells(&all) == cells(&every), "with every edge objects make a difference");
    Ok(())
}

/// A map of lone texels has more walls than their list has room for. Every cell is drawn then, and shown.
fn overflow() -> Outcome {
    const SIDE: usize = 64;
    let folder = models()?;
    save(&folder, LIGHT, SIDE as u32)?;
    let mut entries = entries(&folder)?;
    let depths = floats(data(&entries[0], "<f4", &format!("({SIDE}, {SIDE})"))?);
    let middle = depths.iter().copied().fold(0.0, f32::max);
    let lone = |at: usize| if (at % SIDE + at / SIDE).is_multiple_of(2) { middle } else { 0.0 };
    let lone: Vec<u8> = (0..SIDE * SIDE).flat_map(|at| lone(at).to_le_bytes()).collect();
    entries[0] = array("depth", "<f4", "False", &format!("({SIDE}, {SIDE})"), &lone);
    folder.write("lone.npz", write_zip(&entries))?;
    let draw = |map: &str, options: &str| {
        let options = format!("--depth @{map}.npz --detector {options}");
        let line = format!("shadow @ball.npz @ring.npz {VIEW} {options} --volumes --out @p.png");
        let drawn = folder.run(&line);
        drawn.expect(0, &[])?;
        Ok::<_, String>((drawn.stdout, folder.image("p.png")?.bytes))
    };
    let map_of = |json: &str| {
        let json: serde_json::Value = serde_json::from_str(json).map_err(|error| error.to_string())?;
        Ok::<_, String>(json["lights"][0]["depth_map"].clone())
    };
    let (text, shown) = draw("lone", "contours=0.01")?;
    ensure!(text.contains("their list has room for 1056, so every cell is drawn"), "{text}");
    let walls = map_of(&draw("lone", "contours=0.01 --json")?.0)?;
    ensure!(walls["overflowed"] == true, "{walls:#}");
    ensure!(walls["walls"].as_u64().is_some_and(|walls| walls > 4225 / 4), "{walls:#}");
    let (json, expected) = draw("lone", "differences=0.01 --json")?;
    ensure!(map_of(&json)?["overflowed"] == false, "{json}");
    ensure!(shown == expected, "{} bytes differ from every cell's", apart([&shown, &expected], 1, 0)?);
    // Negative control: a list that has room is shown as walls.
    let (json, shown) = draw("map.0", "contours=0.01 --json")?;
    ensure!(map_of(&json)?["overflowed"] == false, "{json}");
    let (text, expected) = draw("map.0", "differences=0.01")?;
    ensure!(!text.contains("has room for"), "{text}");
    ensure!(apart([&shown, &expected], 1, 0)? > 500, "walls are shown as cells");
    Ok(())
}

/// A saved map with distances in the place of its depths, in the order of `metric`: along the axis, and along rays.
fn as_distances(
    saved: &[Entry],
    (side, maps): (usize, usize),
    light: Option<DVec3>,
) -> Result<[Vec<Entry>; 2], String> {
    let of = |shape: &[usize]| {
        let shape = if maps == 1 { shape.to_vec() } else { [&[maps], shape].concat() };
        format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
    };
    let shape = of(&[side, side]);
    let depths = floats(data(&saved[0], "<f4", &shape)?);
    let matrices = floats(data(&saved[1], "<f4", &of(&[4, 4]))?);
    let origin = floats(data(&saved[2], "<f4", "(3,)")?);
    let origin = DVec3::new(origin[0].into(), origin[1].into(), origin[2].into());
    let mut found = [Vec::new(), Vec::new()];
    for (depths, matrix) in depths.chunks(side * side).zip(matrices.chunks(16)) {
        let rows: [f64; 16] = std::array::from_fn(|at| f64::from(matrix[at]));
        let matrix = DMat4::from_cols_array(&rows).transpose();
        let inverse = matrix.inverse();
        for (texel, &depth) in depths.iter().enumerate() {
            let [column, row] = [texel % side, texel / side].map(|at| (at as f64 + 0.5) / side as f64);
            let point_at = |depth: f64| inverse.project_point3(DVec3::new(2.0 * column - 1.0, 1.0 - 2.0 * row, depth));
            let at = point_at(depth.into());
            // From the light, or from the near plane of a light at infinity, whose rays are at right angles to it.
            let [axis, ray] = match light {
                Some(light) => {
                    let w = matrix.row(3);
                    [w.dot(at.extend(1.0)) / w.truncate().length(), (at + origin - light).length()]
                }
                None => [(at - point_at(1.0)).length(); 2],
            };
            for (found, distance) in found.iter_mut().zip([axis, ray]) {
                let distance = if depth == 0.0 { f32::INFINITY } else { distance as f32 };
                found.extend(distance.to_le_bytes());
            }
        }
    }
    let archive = |(metric, bytes): (u8, &Vec<u8>)| {
        let mut entries = saved.to_vec();
        entries[0] = array("depth", "<f4", "False", &shape, bytes);
        entries.push(array("metric", "|u1", "False", "()", &[metric]));
        entries
    };
    Ok([archive((1, &found[0])), archive((2, &found[1]))])
}

fn distances() -> Outcome {
    const SIDE: usize = 128;
    let folder = models()?;
    for (light, light_position, maps) in [
        (LIGHT, Some(DVec3::new(6.0, 12.0, 3.0)), 1),
        ("dir:-1,2,0.5", None, 1),
        ("point:1.2,2.4,0.9", Some(DVec3::new(1.2_f32.into(), 2.4_f32.into(), 0.9_f32.into())), 6),
    ] {
        let (_, rendered) = save(&folder, light, SIDE as u32)?;
        let archives = as_distances(&entries(&folder)?, (SIDE, maps), light_position)?;
        for (archive, metric) in archives.iter().zip(1..) {
            folder.write("distances.npz", write_zip(archive))?;
            let (said, given) = of_map(&folder, "distances", &format!("--light {light}"))?;
            ensure!(said["lights"][0]["depth_map"]["maps"] == maps, "{light}: {said:#}");
            let differing = apart([&rendered, &given], 1, 0)?;
            ensure!(differing < 30, "{light}, metric {metric}: {differing} pixels differ");
        }
        // Negative controls: distances are taken for depths, and those along the axis for the longer ones along rays.
        // (The other way round surfaces move away from the light, and most of the mask stays.) At infinity both are the
        // same.
        let wrongs = [(1, 2), (2, 0)];
        for (metric, wrong) in wrongs.into_iter().skip(usize::from(light_position.is_none())) {
            let mut other = archives[metric - 1].clone();
            other.pop();
            other.push(array("metric", "|u1", "False", "()", &[wrong]));
            folder.write("wrong.npz", write_zip(&other))?;
            let (_, given) = of_map(&folder, "wrong", &format!("--light {light}"))?;
            let differing = apart([&rendered, &given], 1, 0)?;
            ensure!(differing >= 30, "{light}, {metric} as {wrong}: {differing} pixels differ");
        }
    }
    Ok(())
}
