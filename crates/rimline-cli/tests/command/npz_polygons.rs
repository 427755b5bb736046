//! Archives with polygons.

use super::archive::{Entry, array, read_zip, write_zip};
use super::npz_input::extract;
use super::run::folder;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("npz_polygons::extract_writes_masks_of_polygons", extracted),
    ("npz_polygons::what_was_written_is_a_model", again),
    ("npz_polygons::bad_polygons_are_named", bad),
    ("npz_polygons::other_subcommands_take_them", others),
];

/// A square with a square hole, and beside it a quadrilateral that is a bow tie from above. The first corner is there
/// twice, so welding does something.
const POSITIONS: [[f32; 3]; 13] = [
    [-2.0, -2.0, 0.0],
    [2.0, -2.0, 0.0],
    [2.0, 2.0, 0.0],
    [-2.0, 2.0, 0.0],
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [5.0, 0.0, 0.0],
    [7.0, 2.0, 0.5],
    [7.0, 0.0, 0.0],
    [5.0, 2.0, -0.5],
    [-2.0, -2.0, 0.0],
];
const LOOPS: [u8; 2] = [2, 1];
const SIZES: [u8; 3] = [4, 4, 4];
const CORNERS: [u8; 12] = [12, 1, 2, 3, 7, 6, 5, 4, 8, 9, 10, 11];

fn positions() -> Entry {
    let data: Vec<u8> = POSITIONS.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    array("positions", "<f4", "False", "(13, 3)", &data)
}

fn polygons(loops: &[u8], sizes: &[u8], corners: &[u8]) -> Vec<u8> {
    let row = |name, values: &[u8]| array(name, "|u1", "False", &format!("({},)", values.len()), values);
    write_zip(&[positions(), row("polygon_loops", loops), row("loop_sizes", sizes), row("loop_corners", corners)])
}

pub(crate) fn words(archive: &[u8], name: &str) -> Result<Vec<u32>, String> {
    let entries = read_zip(archive)?;
    let entry = entries.iter().find(|entry| entry.name == format!("{name}.npy")).ok_or_else(|| format!("no {name}"))?;
    Ok(entry.bytes[128..].as_chunks::<4>().0.iter().map(|bytes| u32::from_ne_bytes(*bytes)).collect())
}

fn extracted() -> Outcome {
    let (run, out) = extract(&polygons(&LOOPS, &SIZES, &CORNERS))?;
    run.expect(0, &[])?;
    for line in ["faces              2\n", "twisted polygons   1, ", "unclosed vertices  0, 0\n"] {
        ensure!(run.stdout.contains(line), "the output lacks `{line}`: {}", run.stdout);
    }
    ensure!(words(&out, "polygon_loops")? == [2, 1] && words(&out, "loop_sizes")? == [4, 4, 4], "loops");
    ensure!(words(&out, "loop_corners")? == [0, 1, 2, 3, 7, 6, 5, 4, 8, 9, 10, 11], "welded corners");
    ensure!(words(&out, "triangle_polygons")? == [0, 0, 0, 0, 0, 0, 0, 0, 1, 1], "triangles");
    ensure!(words(&out, "edges")?.len() == 2 * 12, "edge records of outlines only");
    let (facing, twisted) = (words(&out, "facing")?, words(&out, "twisted")?);
    ensure!(facing.len() == 2 && twisted.len() == 2, "a row a polygon");
    ensure!(facing[0] == 0b11 && twisted[0] == 0 && twisted[1] & 1 == 1 && facing[1] & 1 == 0, "the bits");
    let silhouette = words(&out, "silhouette")?;
    ensure!(silhouette[..8] == [0b11; 8] && silhouette[8..].iter().all(|bits| bits & 1 == 0), "silhouettes");
    Ok(())
}

fn again() -> Outcome {
    let (_, out) = extract(&polygons(&LOOPS, &SIZES, &CORNERS))?;
    let (run, same) = extract(&out)?;
    run.expect(0, &[])?;
    ensure!(out == same, "the same bytes");
    Ok(())
}

/// Loops of each polygon, sizes of the loops, their corners, and what the message names.
type Bad<'a> = (&'a [u8], &'a [u8], &'a [u8], &'a str);

fn bad() -> Outcome {
    let cases: [Bad<'_>; 6] = [
        (&[], &[], &[], "no faces"),
        (&[2, 1], &[4, 2, 4], &CORNERS, "loop 1 of polygon 0 has 2 corners"),
        (&[2, 0, 1], &SIZES, &CORNERS, "polygon 1 has no loops"),
        (&[2, 2], &SIZES, &CORNERS, "loop 1 of polygon 1 has no size"),
        (&LOOPS, &[4, 4, 3], &CORNERS, "1 corners are left over"),
        (&LOOPS, &SIZES, &[0, 1, 2, 3, 7, 6, 5, 13, 8, 9, 10, 11], "corner 3 of loop 1 of polygon 0 names vertex 13"),
    ];
    for (loops, sizes, corners, message) in cases {
        let (run, _) = extract(&polygons(loops, sizes, corners))?;
        run.expect(1, &["model.npz", message]).map_err(|error| format!("{message}: {error}"))?;
    }
    let square = array("polygon_loops", "|u1", "False", "(2, 1)", &LOOPS);
    let (run, _) = extract(&write_zip(&[positions(), square]))?;
    run.expect(1, &["`polygon_loops`", "(2, 1)", "(P,)"])?;
    let missing = array("polygon_loops", "|u1", "False", "(2,)", &LOOPS);
    let (run, _) = extract(&write_zip(&[positions(), missing]))?;
    run.expect(1, &["`loop_sizes`"])
}

fn others() -> Outcome {
    let folder = folder();
    folder.write("model.npz", polygons(&LOOPS, &SIZES, &CORNERS))?;
    // Under the rim, under the hole, and beside.
    let data: Vec<u8> = [[1.5_f32, 0.0, -1.0], [0.0, 0.0, -1.0], [4.0, 0.0, -1.0]]
        .iter()
        .flatten()
        .flat_map(|c| c.to_le_bytes())
        .collect();
    folder.write("points.npz", write_zip(&[array("points", "<f4", "False", "(3, 3)", &data)]))?;
    let line = "query @model.npz --points @points.npz --device cpu --light dir:0,0,1 --out @out.npz";
    folder.run(line).expect(0, &[])?;
    ensure!(words(&folder.read("out.npz")?, "depth")? == [1, 0, 0], "depths");
    Ok(())
}
