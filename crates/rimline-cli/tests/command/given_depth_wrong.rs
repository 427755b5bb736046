//! Files of `--depth` that are refused: what is wrong, in which array, and nothing is left.

use super::archive::{Entry, array, write_zip};
use super::given_depth::{entries, models, save};
use super::run::Folder;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("given_depth::wrong_arrays_end_with_1", arrays),
    ("given_depth::wrong_projections_end_with_1", projections),
    ("given_depth::wrong_cubes_end_with_1", cubes),
    ("given_depth::damaged_files_end_with_1", damage),
];

/// Draws with this archive, which must be refused with a message that has all of `parts`.
fn refused(folder: &Folder, archive: &[u8], options: &str, parts: &[&str]) -> Outcome {
    let before = names(folder)?;
    folder.write("wrong.npz", archive)?;
    let line =
        format!("shadow @ball.npz @ring.npz --size 32x32 --depth @wrong.npz {options} --mask @no --out @no.png --json");
    let parts: Vec<&str> = [&["wrong.npz"], parts].concat();
    let run = folder.run(&line);
    run.expect(1, &parts)?;
    ensure!(!run.stderr.contains("DepthMap"), "a name of the library: {}", run.stderr);
    std::fs::remove_file(folder.path().join("wrong.npz")).map_err(|error| error.to_string())?;
    ensure!(names(folder)? == before, "something is left: {:?}", names(folder)?);
    Ok(())
}

fn names(folder: &Folder) -> Result<Vec<std::ffi::OsString>, String> {
    let entries = std::fs::read_dir(folder.path()).map_err(|error| error.to_string())?;
    let names: Result<Vec<_>, _> = entries.map(|entry| entry.map(|entry| entry.file_name())).collect();
    let mut names = names.map_err(|error| error.to_string())?;
    names.sort();
    Ok(names)
}

/// A folder with the saved map of a light, and its arrays.
fn saved(light: &str, side: u32) -> Result<(Folder, Vec<Entry>), String> {
    let folder = models()?;
    save(&folder, light, side)?;
    let entries = entries(&folder)?;
    Ok((folder, entries))
}

/// The arrays with this one in the place of that of the same name, or behind.
fn with(entries: &[Entry], changed: Entry) -> Vec<u8> {
    let mut all: Vec<Entry> = entries.iter().filter(|entry| entry.name != changed.name).cloned().collect();
    all.push(changed);
    write_zip(&all)
}

fn arrays() -> Outcome {
    let (folder, map) = saved("point:6,12,3", 16)?;
    for missing in ["depth", "view_projection", "reversed"] {
        let rest: Vec<Entry> = map.iter().filter(|entry| entry.name != format!("{missing}.npy")).cloned().collect();
        refused(&folder, &write_zip(&rest), "", &[&format!("no array `{missing}`"), "it has", "origin.npy"])?;
    }
    let zeros =
        |name: &str, descr: &str, shape: &str, bytes: usize| array(name, descr, "False", shape, &vec![0; bytes]);
    for (changed, parts) in [
        (zeros("depth", "<f8", "(16, 16)", 2048), ["`depth`", "<f8", "float32 or uint16"]),
        (zeros("depth", "<i2", "(16, 16)", 512), ["`depth`", "<i2", "float32 or uint16"]),
        (zeros("depth", "<f4", "(256,)", 1024), ["`depth`", "(256)", "(H, W) or (6, H, W)"]),
        (zeros("depth", "<f4", "(1, 16, 16)", 1024), ["`depth`", "(1, 16, 16)", "(6, H, W)"]),
        (zeros("depth", "<f4", "(0, 16)", 0), ["`depth`", "(0, 16)", "from 1 to 4096"]),
        (zeros("depth", "<f4", "(4097, 16)", 16), ["`depth`", "(4097, 16)", "from 1 to 4096"]),
        (zeros("depth", "<f4", "(4294967296, 4294967296)", 16), ["`depth`", "4294967296", "from 1 to 4096"]),
        (zeros("depth", "<f4", "(16, 16)", 1020), ["`depth`", "takes", "holds"]),
        (zeros("depth", "<f4", "(6, 16, 16)", 6144), ["`view_projection`", "(4, 4)", "(6, 4, 4) for six maps"]),
        (zeros("view_projection", "<f4", "(3, 4)", 48), ["`view_projection`", "(3, 4)", "(4, 4)"]),
        (zeros("view_projection", "<i4", "(4, 4)", 64), ["`view_projection`", "<i4", "float32 or float64"]),
        (zeros("origin", "<f4", "(4,)", 16), ["`origin`", "(4)", "(3,)"]),
        (zeros("reversed", "<f4", "()", 4), ["`reversed`", "<f4", "a bool"]),
        (zeros("reversed", "|b1", "(2,)", 2), ["`reversed`", "(2)", "()"]),
        (array("reversed", "|u1", "False", "()", &[7]), ["`reversed`", "holds 7", "whether near is 1"]),
        (array("reversed", "|i1", "False", "()", &[255]), ["`reversed`", "-1", "from 0"]),
        (array("depth_bits", "|u1", "False", "()", &[20]), ["`depth_bits`", "holds 20", "16, 24 or 32"]),
        (array("metric", "|u1", "False", "()", &[3]), ["`metric`", "holds 3", "0, 1 or 2"]),
        (array("metric", "|i1", "False", "()", &[255]), ["`metric`", "-1", "from 0"]),
        (zeros("metric", "<f4", "()", 4), ["`metric`", "<f4", "along rays"]),
    ] {
        let name = changed.name.clone();
        refused(&folder, &with(&map, changed), "", &parts).map_err(|error| format!("{name}, {parts:?}: {error}"))?;
    }
    // Distances are no steps of a format, and have no bits of a depth buffer.
    let metric = |value: u8| array("metric", "|u1", "False", "()", &[value]);
    let mut steps = map.clone();
    steps[0] = zeros("depth", "<u2", "(16, 16)", 512);
    refused(&folder, &with(&steps, metric(1)), "", &["`depth` is uint16", "`metric`", "float32"])?;
    let mut bits = map.clone();
    bits.push(array("depth_bits", "|u1", "False", "()", &[24]));
    refused(&folder, &with(&bits, metric(2)), "", &["`depth_bits`", "`metric`"])?;
    for (changed, parts) in [
        (zeros("objects", "<u4", "(16, 8)", 512), ["`objects`", "(16, 8)"]),
        (zeros("objects", "<f4", "(16, 16)", 1024), ["`objects`", "integer"]),
        (array("objects", "<i4", "False", "(16, 16)", &[255; 1024]), ["`objects`, row 0", "-1"]),
    ] {
        refused(&folder, &with(&map, changed), "--detector automatic", &parts)?;
    }
    Ok(())
}

fn projections() -> Outcome {
    let (folder, map) = saved("point:6,12,3", 16)?;
    let matrix = super::given_depth::floats(super::archive::data(&map[1], "<f4", "(4, 4)")?);
    let changed = |change: &dyn Fn(&mut [f32])| {
        let mut matrix = matrix.clone();
        change(&mut matrix);
        let bytes: Vec<u8> = matrix.iter().flat_map(|value| value.to_le_bytes()).collect();
        with(&map, array("view_projection", "<f4", "False", "(4, 4)", &bytes))
    };
    let name = "`view_projection` of map 0";
    refused(&folder, &changed(&|matrix| matrix[5] = f32::NAN), "", &[name, "singular or not finite"])?;
    refused(&folder, &changed(&|matrix| matrix.fill(0.0)), "", &[name, "singular or not finite"])?;
    refused(&folder, &changed(&|matrix| matrix[..4].fill(0.0)), "", &[name, "singular or not finite"])?;
    refused(&folder, &changed(&|matrix| matrix[8] += 0.3), "", &[name, "oblique"])?;
    let nowhere = [f32::INFINITY, 0.0, 0.0].iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>();
    let nowhere = array("origin", "<f4", "False", "(3,)", &nowhere);
    refused(&folder, &with(&map, nowhere), "", &[name, "not finite"])?;
    // A y that points down, as Vulkan has it, and a near plane that is next to the light.
    refused(
        &folder,
        &changed(&|matrix| matrix[4..8].iter_mut().for_each(|c| *c = -*c)),
        "",
        &[name, "mirror", "row of x or of y"],
    )?;
    refused(&folder, &changed(&|matrix| matrix.iter_mut().for_each(|c| *c *= 1e-36)), "", &[name, "normal range"])?;
    // The matrix is that of reversed depth.
    let standard = array("reversed", "|b1", "False", "()", &[0]);
    refused(&folder, &with(&map, standard), "", &[name, "`reversed`"])?;
    // Columns in the place of rows.
    let turned = |matrix: &mut [f32]| {
        let old = matrix.to_vec();
        (0..16).for_each(|at| matrix[at] = old[at % 4 * 4 + at / 4]);
    };
    refused(&folder, &changed(&turned), "", &[name, "its rows"])
}

fn cubes() -> Outcome {
    let (folder, map) = saved("point:1.2,2.4,0.9", 16)?;
    let matrices = super::archive::data(&map[1], "<f4", "(6, 4, 4)")?.to_vec();
    let mut exchanged = matrices.clone();
    exchanged.rotate_left(64);
    let exchanged = array("view_projection", "<f4", "False", "(6, 4, 4)", &exchanged);
    refused(&folder, &with(&map, exchanged), "", &["map", "does not meet the others", "docs/formats.md"])?;
    // Options of the command, and nothing of the library.
    refused(&folder, &write_zip(&map), "--detector contours=0.1", &["six maps", "--detector contours takes one"])?;
    let mut broken = matrices.clone();
    broken[3 * 64..3 * 64 + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let broken = array("view_projection", "<f4", "False", "(6, 4, 4)", &broken);
    refused(&folder, &with(&map, broken), "", &["`view_projection` of map 3", "not finite"])?;
    let flat = array("depth", "<f4", "False", "(6, 16, 8)", &[0; 6 * 16 * 8 * 4]);
    refused(&folder, &with(&map, flat), "", &["square", "8×16"])?;
    let small = array("depth", "<f4", "False", "(6, 2, 2)", &[0; 96]);
    refused(&folder, &with(&map, small), "", &["at least 3 texels"])?;
    let objects = array("objects", "|u1", "False", "(16, 16)", &[0; 256]);
    refused(&folder, &with(&map, objects), "--detector automatic", &["`objects`", "six"])
}

fn damage() -> Outcome {
    let (folder, map) = saved("point:6,12,3", 16)?;
    let whole = write_zip(&map);
    for length in [0, 3, 100, whole.len() / 2, whole.len() - 1] {
        let part = if length == 0 { "empty" } else { "not a ZIP archive" };
        refused(&folder, &whole[..length], "", &[part])?;
    }
    let mut flipped = whole.clone();
    flipped[400] ^= 1;
    refused(&folder, &flipped, "", &["`depth`"])?;
    // The directory and the header claim six maps of 4,096², 403 MB, and hold nothing of them.
    let data = vec![0; 64];
    let mut huge = array("depth", "<f4", "False", "(6, 4096, 4096)", &data);
    huge.method = 8;
    let claimed = (huge.bytes.len() - data.len() + 6 * 4096 * 4096 * 4) as u32;
    let truth = (huge.bytes.len() as u32).to_le_bytes();
    let mut bomb = with(&map, huge);
    for at in (0..bomb.len() - 4).filter(|&at| bomb[at..at + 4] == truth).collect::<Vec<_>>() {
        bomb[at..at + 4].copy_from_slice(&claimed.to_le_bytes());
    }
    refused(&folder, &bomb, "", &["`depth`, row 0"])?;
    refused(&folder, &bomb, "--memory-limit 1GiB", &["`depth` with 24576 rows", "--memory-limit"])
}
