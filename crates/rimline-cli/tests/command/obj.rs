//! Every way to write an OBJ file reads alike.

use super::run::folder;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("obj::every_way_to_write_it_reads_alike", ways)];

/// Extracts from an OBJ file of these bytes.
fn extract(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let folder = folder();
    folder.write("model.obj", bytes)?;
    let line = "extract --device cpu --light point:2,3,4 --light dir:-1,-2e-1,.5 @model.obj --out @out";
    folder.run(line).expect(0, &[])?;
    folder.read("out")
}

/// A cube of quadrilaterals.
const CUBE: &str = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn ways() -> Outcome {
    let expected = extract(CUBE.as_bytes())?;
    ensure!(!expected.is_empty(), "no result");
    let vertices = CUBE.lines().filter(|line| line.starts_with('v'));
    let faces = || CUBE.lines().filter(|line| line.starts_with('f'));
    let corners = |to: fn(i32) -> String| -> String {
        let line =
            |line: &str| line[2..].split(' ').map(|word| to(word.parse().unwrap_or(0))).collect::<Vec<_>>().join(" ");
        faces().map(|face| format!("f {}\n", line(face))).collect::<Vec<_>>().concat()
    };
    let head: String = vertices.clone().map(|line| format!("{line}\n")).collect::<Vec<_>>().concat();
    let weighted: String = vertices.clone().map(|line| format!("{line} 2.5\n")).collect::<Vec<_>>().concat();
    let coloured: String = vertices
        .clone()
        .enumerate()
        .map(|(i, line)| format!("{line}{}\n", [" 1 0 .5", ""][i % 2]))
        .collect::<Vec<_>>()
        .concat();
    let mut latin = b"# caf\xe9 C:\\models\\\no \xfc # x\n".to_vec();
    latin.extend(CUBE.bytes());
    let cases: [(&str, Vec<u8>); 18] = [
        ("CRLF", CUBE.replace('\n', "\r\n").into()),
        ("CR", CUBE.replace('\n', "\r").into()),
        ("CR CR LF, continued", CUBE.replace("4 3 2", "4 \\\n3 2").replace('\n', "\r\r\n").into()),
        ("CR, continued, and all ends mixed", CUBE.replace("4 3 2", "4 \\\r3 2").replacen('\n', "\r", 5).into()),
        ("a mark of the byte order", format!("\u{feff}{CUBE}").into()),
        ("no last line end", CUBE.trim_end().into()),
        ("tabs and spaces", CUBE.replace(' ', " \t ").replace('f', "  f").into()),
        ("continued lines", CUBE.replace("4 3 2", "4 \\\n3\\\r\n 2").into()),
        ("comments", CUBE.replace('\n', " # v 1 2\n").into()),
        ("Latin-1", latin),
        ("texture coordinates", format!("{head}vt 0 0\n{}", corners(|v| format!("{v}/1"))).into()),
        ("normals", format!("{head}vn 0 0 1\n{}", corners(|v| format!("{v}//1"))).into()),
        ("both, backwards", format!("{head}{}", corners(|v| format!("{}/-1/-1", v - 9))).into()),
        ("faces first", format!("{}{head}", corners(|v| v.to_string())).into()),
        ("weights", format!("{weighted}{}", corners(|v| v.to_string())).into()),
        ("colours of some", format!("{coloured}{}", corners(|v| v.to_string())).into()),
        ("groups and materials", CUBE.replace("f ", "mtllib a.mtl\ng a b\ns off\nusemtl\no\nf ").into()),
        ("lines and points", format!("{CUBE}l 1 2 3 4\np 1 2\nl 99 98\nvp 1\n").into()),
    ];
    for (name, model) in cases {
        let found = extract(&model).map_err(|error| format!("{name}: {error}"))?;
        ensure!(found == expected, "{name}: another archive");
    }
    // A position or a face that differs is seen.
    for other in [CUBE.replace("v 1 1 1", "v 1 1 1.5"), CUBE.replace("f 4 1 5 8", "f 4 1 5")] {
        ensure!(extract(other.as_bytes())? != expected, "the same archive");
    }
    Ok(())
}
