//! Facts of cases: what a command line wrote, and how it compares.
//!
//! | fact | holds if |
//! |---|---|
//! | `files NAMES` | these files are new, and no others |
//! | `has NAMES`, `lacks NAMES` | the files are there; the files, or arrays `FILE:NAME`, are not |
//! | `says TEXT`, `hides TEXT` | standard output has the text, has it not |
//! | `json POINTER VALUE` | the value of standard output there is this, or `< N`, `> N`, `none` |
//! | `entries FILE NAMES` | an archive has these arrays in this order, stored and without a date |
//! | `array FILE NAME TYPE SHAPE NUMBERS` | the array of an archive is this; `...` at the end stands for more numbers |
//! | `same A B`, `other A B` | the files, or arrays `FILE:NAME`, have the same bytes, or not |
//! | `apart A B OP N [by M] [pixels]` | so many values or pixels of the pictures differ by more than M; without it, of masks |
//! | `count FILE WHAT OP N` | so many pixels of a mask have this value, or of a picture are `ink`, `orange`, `blue` or `red` |
//! | `values FILE VALUES` | the values of a grey picture are these |
//! | `pixel FILE X,Y VALUE ...` | the pixels have these values |
//! | `size FILE N` | so many bytes, or `WIDTHxHEIGHT` pixels |
//!
//! A string of JSON has `\u003b` for `;`, which parts facts.

use std::collections::BTreeSet;

use serde_json::Value;

use super::archive::{Entry, FIRST_DAY, entry, read_zip};
use super::pictures::{apart, is_ink, is_orange};
use super::run::Folder;
use super::{Outcome, ensure};

/// Whether a fact is about a run's output: it holds for each command line. Others hold after the last.
pub(crate) fn is_of_output(fact: &str) -> bool {
    ["files", "says", "hides", "json"].contains(&fact.split(' ').next().unwrap_or(""))
}

/// Checks a fact after a run, which wrote to standard output and made these files.
pub(crate) fn check(folder: &Folder, stdout: &str, new: &[&str], fact: &str) -> Outcome {
    let (kind, rest) = fact.split_once(' ').unwrap_or((fact, ""));
    let words: Vec<&str> = rest.split_whitespace().collect();
    let word = |at: usize| words.get(at).copied().ok_or("a word is missing");
    let is_there = |name: &str| folder.path().join(name).symlink_metadata().is_ok();
    match kind {
        "files" => ensure!(new == words, "{new:?}"),
        "has" => ensure!(words.iter().all(|name| is_there(name)), "a file is missing"),
        "lacks" => {
            for name in words {
                let is_in = match name.split_once(':') {
                    Some((file, name)) => names(folder, file)?.iter().any(|there| there == name),
                    None => is_there(name),
                };
                ensure!(!is_in, "{name} is there");
            }
        }
        "says" => ensure!(stdout.contains(rest), "it is not said"),
        "hides" => ensure!(!stdout.contains(rest), "it is said"),
        "json" => {
            let json: Value = serde_json::from_str(stdout).map_err(|error| error.to_string())?;
            let (pointer, expected) = rest.split_once(' ').ok_or("no value")?;
            let found = json.pointer(pointer).unwrap_or(&Value::Null);
            ensure!(is_value(found, expected)?, "it is {found}");
        }
        "entries" => {
            let names = names(folder, word(0)?)?;
            ensure!(names == words[1..], "they are {names:?}");
            let is_plain = |entry: &Entry| entry.method == 0 && entry.time == FIRST_DAY && entry.flags & 9 == 0;
            ensure!(
                read_zip(&folder.read(word(0)?)?)?.iter().all(is_plain),
                "not stored, dated, encrypted or sized afterwards"
            );
        }
        "array" => array(folder, &words)?,
        "same" | "other" => {
            let is_same = bytes(folder, word(0)?)? == bytes(folder, word(1)?)?;
            ensure!(is_same == (kind == "same"), "is it the same: {is_same}");
        }
        "apart" => {
            let by = words.iter().position(|word| *word == "by").and_then(|at| words.get(at + 1)?.parse().ok());
            let channels = if words.contains(&"pixels") { 3 } else { 1 };
            let read = |name: &str| if by.is_some() { folder.image(name) } else { folder.mask(name) };
            let [one, other] = [read(word(0)?)?, read(word(1)?)?];
            ensure!(one.size == other.size, "pictures of {:?} and {:?} pixels", one.size, other.size);
            let count = apart([&one.bytes, &other.bytes], channels, by.unwrap_or(0))?;
            ensure!(is_number(count as f64, [word(2)?, word(3)?])?, "{count}");
        }
        "count" => {
            let image = || folder.image(word(0)?);
            let count = match word(1)? {
                "ink" => image()?.count_pixels(is_ink)?,
                "blue" => image()?.count_pixels(|[red, _, blue]| blue > red)?,
                "red" => image()?.count_pixels(|[red, green, blue]| red > 90 && green < 40 && blue < 40)?,
                "orange" => image()?.count_pixels(is_orange)?,
                value => folder.mask(word(0)?)?.count(value.parse().map_err(|_| "no value")?),
            };
            ensure!(is_number(count as f64, [word(2)?, word(3)?])?, "{count}");
        }
        "values" => {
            let found: BTreeSet<u8> = folder.image(word(0)?)?.bytes.into_iter().collect();
            ensure!(found.iter().map(u8::to_string).eq(words[1..].iter().copied()), "{found:?}");
        }
        "pixel" => {
            let image = folder.mask(word(0)?)?;
            for pair in words[1..].chunks_exact(2) {
                let at: Vec<usize> = pair[0].split(',').filter_map(|number| number.parse().ok()).collect();
                let [x, y] = at[..] else { return Err("no place".into()) };
                ensure!(image.at(x, y).to_string() == pair[1], "{}: {}", pair[0], image.at(x, y));
            }
        }
        "size" => {
            let size = match word(1)?.split_once('x') {
                Some(_) => folder.image(word(0)?)?.size.map(|side| side.to_string()).join("x"),
                None => folder.read(word(0)?)?.len().to_string(),
            };
            ensure!(size == word(1)?, "{size}");
        }
        _ => return Err("there is no such fact".into()),
    }
    Ok(())
}

fn is_number(found: f64, [relation, number]: [&str; 2]) -> Result<bool, String> {
    let number: f64 = number.parse().map_err(|error| format!("{number}: {error}"))?;
    Ok(match relation {
        "=" => found == number,
        "<" => found < number,
        ">" => found > number,
        _ => return Err(format!("no relation {relation}")),
    })
}

fn is_value(found: &Value, expected: &str) -> Result<bool, String> {
    if let Some(number) = expected.strip_prefix(['<', '>']) {
        return found.as_f64().map_or(Ok(false), |found| is_number(found, [&expected[..1], number.trim()]));
    }
    let expected: Value = if expected == "none" { Value::Null } else { json(expected)? };
    let is_equal = found.as_f64().is_some_and(|number| expected.as_f64() == Some(number));
    Ok(is_equal || *found == expected)
}

pub(crate) fn json(text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| format!("{text}: {error}"))
}

/// The arrays of an archive.
fn names(folder: &Folder, file: &str) -> Result<Vec<String>, String> {
    let entries = read_zip(&folder.read(file)?)?;
    Ok(entries.iter().map(|entry| entry.name.trim_end_matches(".npy").to_owned()).collect())
}

/// The bytes of a file, or of one of its arrays.
fn bytes(folder: &Folder, name: &str) -> Result<Vec<u8>, String> {
    if let Some((file, name)) = name.split_once(':') {
        return Ok(entry(&folder.read(file)?, name)?.bytes);
    }
    let bytes = folder.read(name)?;
    Ok(if bytes.starts_with(b"\x89PNG") { without_text(&bytes) } else { bytes })
}

/// A PNG without its texts, which name a film.
fn without_text(png: &[u8]) -> Vec<u8> {
    let (head, mut rest) = png.split_at(png.len().min(8));
    let mut kept = head.to_vec();
    while let Some((&[a, b, c, d], after)) = rest.split_first_chunk::<4>() {
        let size = rest.len().min(u32::from_be_bytes([a, b, c, d]) as usize + 12);
        if !after.starts_with(b"tEXt") {
            kept.extend(&rest[..size]);
        }
        rest = &rest[size..];
    }
    kept
}

fn array(folder: &Folder, words: &[&str]) -> Outcome {
    let [file, name, kind, rest @ ..] = words else { return Err("words are missing".into()) };
    let bytes = entry(&folder.read(file)?, name)?.bytes;
    let end = rest.iter().position(|word| word.ends_with(')')).ok_or("no shape")? + 1;
    let (shape, expected) = (rest[..end].join(" "), rest[end..].to_vec());
    let head = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let found = String::from_utf8_lossy(&bytes[10..128]).trim().to_owned();
    ensure!(found == head, "it is {found}");
    let numbers: Vec<String> = match *kind {
        "<u4" => bytes[128..].as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes).to_string()).collect(),
        "<i4" => bytes[128..].as_chunks().0.iter().map(|bytes| i32::from_le_bytes(*bytes).to_string()).collect(),
        "<f4" => bytes[128..].as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes).to_string()).collect(),
        "<f8" => bytes[128..].as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes).to_string()).collect(),
        _ => bytes[128..].iter().map(u8::to_string).collect(),
    };
    let is_right = match expected.iter().position(|word| *word == "...") {
        Some(count) => numbers.len() >= count && numbers[..count] == expected[..count],
        None => numbers == expected,
    };
    ensure!(is_right, "it is {}", numbers.join(" "));
    Ok(())
}
