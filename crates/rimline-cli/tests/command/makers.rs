//! Input files of cases, made by steps. The indented lines after a step are its own.
//!
//! | step | makes |
//! |---|---|
//! | `text FILE TEXT` | a file of this text, or of the lines after it; `escaped` says how bytes are written |
//! | `npz FILE [from FILE]` | an archive of the arrays in the lines after it: `archive` |
//! | `gltf FILE [BODY]` | a glTF, and the files that it names, with changes: `POINTER JSON`; `/-` adds to a list |
//! | `make FILE SHAPE NUMBERS [* SCALE] [@ X,Y,Z]` | a model of code, as .npz or .obj |
//! | `folder NAME` | a folder |
//! | `copy FILE NAMES` | copies |
//! | `cut FILE N` | keeps the first N bytes of a file; half of them (`/2`), all but the last (`-1`) |
//! | `flip FILE TEXT N MASK` | flips bits of the byte that is N after the text's first occurrence |
//! | `claim FILE OLD NEW` | writes one 32-bit number for another, wherever it stands |

use std::fmt::Write as _;

use rimline_testkit::shapes::{self, Shape};

use super::archive::{Entry, array, read_zip, write_zip};
use super::facts::json;
use super::run::Folder;
use super::{Outcome, ensure, models_of_code, small_gltf};

const STEPS: [&str; 9] = ["text", "npz", "gltf", "make", "folder", "copy", "cut", "flip", "claim"];

pub(crate) fn is_one(line: &str) -> bool {
    line.split_once(' ').is_some_and(|(word, _)| STEPS.contains(&word))
}

/// Makes what the first of these lines says; those that follow belong to it if they are indented.
pub(crate) fn step(folder: &Folder, lines: &[String]) -> Outcome {
    let indented: Vec<&str> = lines[1..].iter().map_while(|line| line.strip_prefix("  ")).collect();
    let Some((step, rest)) = lines[0].split_once(' ').filter(|(step, _)| STEPS.contains(step)) else { return Ok(()) };
    let (file, rest) = rest.split_once(' ').unwrap_or((rest, ""));
    let words: Vec<&str> = rest.split_whitespace().collect();
    let failed = |error: String| format!("{}: {error}", lines[0]);
    let number = |at: usize| words.get(at).and_then(|word| word.parse::<usize>().ok()).ok_or("a number is missing");
    match step {
        "text" if indented.is_empty() => folder.write(file, escaped(rest)),
        "text" => folder.write(file, escaped(&indented.join("\\n"))),
        "npz" => archive(folder, file, rest.strip_prefix("from "), &indented).map_err(failed),
        "gltf" => gltf(folder, file, rest, &indented).map_err(failed),
        "make" => shape(folder, file, rest).map_err(failed),
        "folder" => folder.inner(file).map(drop),
        "copy" => {
            let bytes = folder.read(file)?;
            words.iter().try_for_each(|name| folder.write(name, &bytes))
        }
        "cut" => {
            let bytes = folder.read(file)?;
            let count = match words[..] {
                ["/2"] => bytes.len() / 2,
                ["-1"] => bytes.len() - 1,
                _ => number(0)?,
            };
            folder.write(file, &bytes[..count])
        }
        "flip" => {
            let mut bytes = folder.read(file)?;
            let text = escaped(words[0]);
            let at = bytes.windows(text.len()).position(|part| part == text).ok_or("the text is not there")?;
            bytes[at + number(1)?] ^= number(2)? as u8;
            folder.write(file, bytes)
        }
        _ => {
            let mut bytes = folder.read(file)?;
            let [old, new] = [number(0)?, number(1)?].map(|number| (number as u32).to_le_bytes());
            let offsets: Vec<usize> = (0..bytes.len() - 4).filter(|&at| bytes[at..at + 4] == old).collect();
            ensure!(offsets.len() == 2, "the number stands at {offsets:?}");
            for at in offsets {
                bytes[at..at + 4].copy_from_slice(&new);
            }
            folder.write(file, bytes)
        }
    }
}

/// Bytes of a text: `\n`, `\r`, `\t`, `\\`, `\xFF` for a byte, `\u{202e}` for a character, `\{TEXT*N}` for many times.
pub(crate) fn escaped(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text;
    while let Some((plain, escape)) = rest.split_once('\\') {
        bytes.extend(plain.bytes());
        let inner = |open: usize| escape[open..].split_once('}').unwrap_or((&escape[open..], ""));
        let (more, after): (Vec<u8>, &str) = match escape.as_bytes().first() {
            Some(b'n') => (b"\n".to_vec(), &escape[1..]),
            Some(b'r') => (b"\r".to_vec(), &escape[1..]),
            Some(b't') => (b"\t".to_vec(), &escape[1..]),
            Some(b'x') => (vec![u8::from_str_radix(&escape[1..3], 16).unwrap_or(0)], &escape[3..]),
            Some(b'u') => {
                let (code, after) = inner(2);
                let character = u32::from_str_radix(code, 16).ok().and_then(char::from_u32);
                (character.map(String::from).unwrap_or_default().into_bytes(), after)
            }
            Some(b'{') => {
                let (part, after) = inner(1);
                let (part, count) = part.rsplit_once('*').unwrap_or((part, "1"));
                (escaped(part).repeat(count.parse().unwrap_or(1)), after)
            }
            _ => (b"\\".to_vec(), escape.get(1..).unwrap_or("")),
        };
        bytes.extend(more);
        rest = after;
    }
    bytes.extend(rest.bytes());
    bytes
}

/// Arrays, one a line: `NAME TYPE SHAPE NUMBERS`, where `V*N` is N times V, and `\{NUMBERS*N}` are N times these. Before the name may stand `deflate`,
/// `fortran`, or another word for the order, `cut=N` and `more=N` for other lengths than the shape's. `NAME raw TEXT`
/// is an entry of these bytes, whose name may be `escaped` and have another ending. From another archive, arrays of its
/// names are replaced, `- NAME` takes one out, `NAME flip N MASK` flips bits of the N-th byte of the data, and `NAME
/// put N TYPE NUMBERS` writes numbers there.
fn archive(folder: &Folder, file: &str, source: Option<&str>, lines: &[&str]) -> Outcome {
    let mut entries = source.map_or(Ok(Vec::new()), |source| read_zip(&folder.read(source)?))?;
    for line in lines {
        let mut words = line.split_whitespace().peekable();
        let (mut flags, mut name) = (Vec::new(), words.next().ok_or("an empty line")?);
        while ["deflate", "fortran", "Maybe"].contains(&name) || name.contains('=') {
            flags.push(name);
            name = words.next().ok_or("no name")?;
        }
        let kind = words.next().ok_or("no type")?;
        let at =
            entries.iter().position(|entry| entry.name == format!("{}.npy", if name == "-" { kind } else { name }));
        match (kind, at) {
            (_, Some(at)) if name == "-" => _ = entries.remove(at),
            ("flip", Some(at)) => {
                let [offset, mask] =
                    [words.next(), words.next()].map(|word| word.and_then(|word| word.parse::<usize>().ok()));
                entries[at].bytes[128 + offset.ok_or("no place")?] ^= mask.ok_or("no mask")? as u8;
            }
            ("put", Some(at)) => {
                let offset = 128 + words.next().and_then(|word| word.parse::<usize>().ok()).ok_or("no place")?;
                let data = numbers(words.next().ok_or("no type")?, words)?;
                entries[at].bytes[offset..offset + data.len()].copy_from_slice(&data);
            }
            _ => {
                let made = entry(name, kind, &flags, &words.collect::<Vec<_>>(), line)?;
                match at {
                    Some(at) => entries[at] = made,
                    None => entries.push(made),
                }
            }
        }
    }
    folder.write(file, write_zip(&entries))
}

fn entry(name: &str, kind: &str, flags: &[&str], words: &[&str], line: &str) -> Result<Entry, String> {
    if kind == "raw" {
        let bytes = escaped(line.split_once("raw ").map_or("", |(_, text)| text));
        let name = String::from_utf8_lossy(&escaped(name)).into_owned();
        let named = if name.contains('.') { name } else { format!("{name}.npy") };
        return Ok(Entry { name: named, bytes, ..array("", "|u1", "False", "()", &[]) });
    }
    let end = words.iter().position(|word| word.ends_with(')')).ok_or("no shape")? + 1;
    let shape = words[..end].join(" ");
    let order =
        if flags.contains(&"Maybe") { "Maybe" } else { ["False", "True"][usize::from(flags.contains(&"fortran"))] };
    let shape = String::from_utf8_lossy(&escaped(&shape)).into_owned();
    let kind = String::from_utf8_lossy(&escaped(kind)).into_owned();
    let all = String::from_utf8_lossy(&escaped(&words[end..].join(" "))).into_owned();
    let mut made = array(name, &kind, order, &shape, &numbers(&kind, all.split_whitespace())?);
    for flag in flags {
        match flag.split_once('=').map(|(word, count)| (word, count.parse().unwrap_or(0))) {
            Some(("cut", count)) => made.bytes.truncate(count),
            Some((_, count)) => made.bytes.extend(vec![0; count]),
            None if *flag == "deflate" => made.method = 8,
            None => {}
        }
    }
    Ok(made)
}

fn numbers<'a>(kind: &str, words: impl Iterator<Item = &'a str>) -> Result<Vec<u8>, String> {
    let size: usize = kind.chars().last().and_then(|digit| digit.to_digit(10)).ok_or("no size")? as usize;
    let mut bytes = Vec::new();
    for word in words {
        let (word, count) = word.split_once('*').unwrap_or((word, "1"));
        let number = || word.parse::<f64>().map_err(|error| format!("{word}: {error}"));
        let mut one = match (kind.contains('f'), size) {
            (true, 4) => (number()? as f32).to_le_bytes().to_vec(),
            (true, _) => number()?.to_le_bytes()[..size].to_vec(),
            _ => word.parse::<i128>().map_err(|error| format!("{word}: {error}"))?.to_le_bytes()[..size].to_vec(),
        };
        if kind.starts_with('>') {
            one.reverse();
        }
        bytes.extend(one.repeat(count.parse().map_err(|error| format!("{count}: {error}"))?));
    }
    Ok(bytes)
}

fn gltf(folder: &Folder, file: &str, body: &str, lines: &[&str]) -> Outcome {
    let words: Vec<&str> = body.split_whitespace().collect();
    let mut value = match words[..] {
        [] => small_gltf::value(),
        ["inline"] => small_gltf::inline(),
        ["triangle"] => models_of_code::lit_triangle(),
        ["house", at] => models_of_code::house_gltf(position(at)?),
        _ => return Err("there is no such body".into()),
    };
    for line in lines {
        let (pointer, text) = line.split_once(' ').ok_or("no value")?;
        let mut at = &mut value;
        let (mut parts, mut is_added) = (pointer.split('/').skip(1), false);
        while let Some(part) = parts.next().filter(|_| !is_added) {
            is_added = part == "-";
            at = match part.parse::<usize>() {
                _ if is_added => at,
                Ok(index) => &mut at[index],
                Err(_) => &mut at[part],
            };
        }
        let new = json(&String::from_utf8_lossy(&escaped(text)))?;
        match at.as_array_mut().filter(|_| is_added) {
            Some(list) => list.push(new),
            None => *at = new,
        }
    }
    small_gltf::write(folder, file, &value)
}

fn position(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.parse().ok()).collect();
    numbers.try_into().map_err(|_| format!("{text}: no place"))
}

fn shape(folder: &Folder, file: &str, text: &str) -> Outcome {
    let (text, at) = text.split_once(" @ ").unwrap_or((text, "0,0,0"));
    let (text, scale) = text.split_once(" * ").unwrap_or((text, "1"));
    let (name, words) = text.split_once(' ').unwrap_or((text, ""));
    let whole: Vec<u32> = words.split(' ').filter_map(|word| word.parse().ok()).collect();
    let real: Vec<f32> = words.split(' ').filter_map(|word| word.parse().ok()).collect();
    let shape = match (name, &whole[..]) {
        ("cube", []) => shapes::cube(),
        ("sphere", &[n]) => shapes::sphere(n),
        ("torus", &[rings, segments, ..]) => shapes::torus(rings, segments, real[2], real[3]),
        ("plane", &[n, m]) => shapes::plane_grid(n, m),
        _ => match models_of_code::of(name, &whole, words, position(at)?)? {
            models_of_code::Made::Shape(shape) => shape,
            models_of_code::Made::File(bytes) => return folder.write(file, bytes),
        },
    };
    let at = position(at)?.map(|c| c as f32);
    folder.write(file, npz_model(&shape, scale.parse().map_err(|_| "no scale")?, at))
}

/// A shape, scaled and moved, as an .npz.
pub(crate) fn npz_model(shape: &Shape, scale: f32, [x, y, z]: [f32; 3]) -> Vec<u8> {
    let transform = |p: &[f32; 3]| [scale * p[0] + x, scale * p[1] + y, scale * p[2] + z];
    npz_mesh(&shape.positions.iter().map(transform).collect::<Vec<_>>(), &shape.faces)
}

/// Triangles as an .npz.
pub(crate) fn npz_mesh(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<u8> {
    let faces_bytes: Vec<u8> = faces.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    write_zip(&[
        rows("positions", positions),
        array("faces", "<u4", "False", &format!("({}, 3)", faces.len()), &faces_bytes),
    ])
}

/// Points as an array of `f32`.
pub(crate) fn rows(name: &str, points: &[[f32; 3]]) -> Entry {
    let bytes: Vec<u8> = points.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    array(name, "<f4", "False", &format!("({}, 3)", points.len()), &bytes)
}

/// A tetrahedron at the origin, as an archive.
pub(crate) fn tetrahedron() -> Vec<u8> {
    npz_mesh(&small_gltf::CORNERS, &small_gltf::FACES)
}

/// An OBJ of these vertices and faces.
pub(crate) fn obj(vertices: impl IntoIterator<Item = [f64; 3]>, faces: impl IntoIterator<Item = Vec<usize>>) -> String {
    let mut text = String::new();
    for [x, y, z] in vertices {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for face in faces {
        let corners: Vec<String> = face.iter().map(ToString::to_string).collect();
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text
}
