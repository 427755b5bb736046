//! Mutations of bytes, text, JSON and glTF files, for the fuzzer and for tests.

use rimline_models::maker;
use serde_json::{Value, json};

use crate::random::Random;

/// A glTF file of these parts: a GLB, or the JSON alone. Once in a while its text or its bytes are changed.
pub fn gltf(json: &Value, binary: &[u8], is_glb: bool, random: &mut Random) -> Vec<u8> {
    let mut text = json.to_string();
    if random.below(3) == 0 {
        self::text(&mut text, &["{", "}", "[", "]", ",", "\"", "null", "\\u0000", "true", "1e"], random);
    }
    let mut file = if is_glb { maker::glb(text.as_bytes(), binary) } else { text.into_bytes() };
    if random.below(10) == 0 {
        bytes(&mut file, random);
    }
    file
}

/// JSON and binary chunk of a glTF file.
pub fn split_gltf(file: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|byte| file[at + byte])) as usize;
    let end = if file.starts_with(b"glTF") { 20 + word(12) } else { file.len() };
    let json = &file[if file.starts_with(b"glTF") { 20 } else { 0 }..end];
    (serde_json::from_slice(json).unwrap_or_default(), file.get(end + 8..).unwrap_or_default().to_vec())
}

/// Flips bits, sets bytes, cuts, repeats and moves pieces.
pub fn bytes(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    let piece = at..(at + 1 + random.below(16)).min(bytes.len());
    match random.below(8) {
        0 | 1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5)],
        3 => bytes[at] = random.next_u64() as u8,
        4 => bytes.truncate(at),
        5 => {
            let copy = bytes[piece].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, copy);
        }
        6 => drop(bytes.drain(piece)),
        _ => {
            // A number in binary, of one of the usual widths.
            let number = extreme(random).to_le_bytes();
            let width = [1, 2, 4, 8][random.below(4)];
            let end = (at + width).min(bytes.len());
            let length = end - at;
            bytes[at..end].copy_from_slice(&number[..length]);
        }
    }
}

/// A number at the edge of something.
pub fn extreme(random: &mut Random) -> u64 {
    let edges = [0, 1, 2, 0x7f, 0xff, 0x7fff, 0xffff, 0x00ff_ffff, 0x7fff_ffff, 0xffff_ffff, 1 << 53, u64::MAX >> 1];
    let edge: u64 = edges[random.below(edges.len())];
    match random.below(4) {
        0 => edge.wrapping_add(1),
        1 => edge.wrapping_sub(1),
        2 => random.next_u64() >> random.below(64),
        _ => edge,
    }
}

/// A number as text.
pub fn number(random: &mut Random) -> String {
    match random.below(14) {
        0 => "-1".to_owned(),
        1 => "1e30".to_owned(),
        2 => "1e-45".to_owned(),
        3 => "-0.0".to_owned(),
        4 => "1e400".to_owned(),
        5 => "NaN".to_owned(),
        6 => "inf".to_owned(),
        7 => "0x7f".to_owned(),
        8 => "99999999999999999999".to_owned(),
        9 => format!("{}", f32::from_bits(random.next_u64() as u32)),
        10..=12 => random.below(12).to_string(),
        _ => extreme(random).to_string(),
    }
}

/// Changes words of a text: numbers, pieces, repetitions, words of a dictionary.
pub fn text(text: &mut String, dictionary: &[&str], random: &mut Random) {
    let mut words = words(text);
    if words.is_empty() {
        return;
    }
    let at = random.below(words.len());
    match random.below(10) {
        0..=2 => {
            let numbers: Vec<_> =
                words.iter().enumerate().filter(|(_, word)| word.starts_with(|c: char| c.is_ascii_digit())).collect();
            if !numbers.is_empty() {
                let (at, _) = numbers[random.below(numbers.len())];
                words[at] = number(random);
            }
        }
        3 => dictionary[random.below(dictionary.len())].clone_into(&mut words[at]),
        4 => words.insert(at, dictionary[random.below(dictionary.len())].to_owned()),
        5 => drop(words.remove(at)),
        6 => {
            let other = random.below(words.len());
            words.swap(at, other);
        }
        7 => {
            // Once in a while so often that recursion would be deep.
            let end = (at + 1 + random.below(12)).min(words.len());
            let times = if random.below(4) == 0 { 1 << random.below(14) } else { 1 + random.below(4) };
            let piece = words[at..end].to_vec();
            let times = times.min((1 << 18) / piece.iter().map(String::len).sum::<usize>().max(1));
            let copies: Vec<String> = (0..times).flat_map(|_| piece.clone()).collect();
            words.splice(at..at, copies);
        }
        8 => {
            let from = random.below(words.len());
            let end = (from + 1 + random.below(12)).min(words.len());
            let piece = words[from..end].to_vec();
            words.splice(at..at, piece);
        }
        _ => words.truncate(at),
    }
    *text = words.concat();
}

/// Words, white space and single characters, which together are the text.
fn words(text: &str) -> Vec<String> {
    let kind = |c: char| if c.is_alphanumeric() || c == '_' || c == '.' { 0 } else { 1 + u8::from(c.is_whitespace()) };
    let mut words: Vec<String> = Vec::new();
    let mut last = u8::MAX;
    for c in text.chars() {
        let this = kind(c);
        match words.last_mut() {
            Some(word) if this == last && this != 1 => word.push(c),
            _ => words.push(c.into()),
        }
        last = this;
    }
    words
}

/// Replaces, removes, repeats or nests one of the values.
pub fn value(root: &mut Value, random: &mut Random) {
    let count = count(root);
    let other = pick(root, &mut random.below(count)).cloned().unwrap_or(Value::Null);
    let Some(node) = pick(root, &mut random.below(count)) else { return };
    match random.below(12) {
        0 => *node = Value::Null,
        1 => *node = json!([node.clone()]),
        2 => *node = json!({ "extras": node.clone() }),
        3 => *node = other,
        4 => *node = json!(-1),
        5 => *node = json!(1e30),
        6 => *node = json!(extreme(random)),
        7 => {
            for _ in 0..1 << random.below(11) {
                *node = json!([node.take()]);
            }
        }
        8 => match node {
            Value::Array(list) if !list.is_empty() => {
                let at = random.below(list.len());
                if random.below(2) == 0 {
                    list.remove(at);
                } else {
                    let copies = vec![list[at].clone(); 1 << random.below(8)];
                    list.splice(at..at, copies);
                }
            }
            Value::Object(map) => {
                let key = map.keys().nth(random.below(map.len())).cloned();
                key.and_then(|key| map.remove(&key));
            }
            _ => *node = json!("x"),
        },
        _ if node.is_number() => *node = json!(random.below(12)),
        _ => {}
    }
}

fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(list) => list.iter().map(count).sum(),
        Value::Object(map) => map.values().map(count).sum(),
        _ => 0,
    }
}

/// The value of this number in depth-first order.
fn pick<'a>(value: &'a mut Value, number: &mut usize) -> Option<&'a mut Value> {
    if *number == 0 {
        return Some(value);
    }
    *number -= 1;
    match value {
        Value::Array(list) => list.iter_mut().find_map(|value| pick(value, number)),
        Value::Object(map) => map.values_mut().find_map(|value| pick(value, number)),
        _ => None,
    }
}
