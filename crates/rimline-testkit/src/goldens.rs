//! Goldens: hashes of results that every driver must give bit for bit, one `name hash` a line in
//! `tests/goldens/SUBJECT.txt`. docs/testing.md, "Goldens", says how to write them anew. A line whose case is gone stays
//! until it is removed by hand.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::must_fail;

/// FNV-1a with 64 bits, over the bytes of the words, lowest first. It is written out here so that it never changes.
fn fnv(words: &[u32]) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    words.iter().flat_map(|word| word.to_le_bytes()).fold(0xcbf2_9ce4_8422_2325, step)
}

/// Trials are threads of one process, and a file belongs to one test binary.
static WRITING: Mutex<()> = Mutex::new(());

fn path(subject: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/goldens").join(format!("{subject}.txt"))
}

fn read(path: &Path) -> Result<BTreeMap<String, u64>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let line = |line: &str| {
        let (name, hash) = line.rsplit_once(' ')?;
        Some((name.to_owned(), u64::from_str_radix(hash, 16).ok()?))
    };
    let lines = text.lines().map(|given| line(given).ok_or_else(|| format!("{}: `{given}`", path.display())));
    lines.collect()
}

/// Fails where the words of a case have another hash than the golden of this name. Results are integers or bits; lists
/// whose order is free come sorted.
pub fn golden(subject: &str, name: &str, words: &[u32]) -> Result<(), String> {
    let (path, hash) = (path(subject), fnv(words));
    if let Some(folder) = std::env::var_os("RIMLINE_GOLDENS_SHOW") {
        let name: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
        let lines: Vec<String> = words.iter().map(|word| format!("{word:08x}\n")).collect();
        let shown = Path::new(&folder).join(format!("{subject}.{name}.txt"));
        std::fs::write(&shown, lines.concat()).map_err(|error| format!("{}: {error}", shown.display()))?;
    }
    let writing = WRITING.lock().map_err(|error| error.to_string())?;
    if std::env::var_os("RIMLINE_GOLDENS").is_some_and(|value| value == "write") {
        let mut all = if path.exists() { read(&path)? } else { BTreeMap::new() };
        all.insert(name.to_owned(), hash);
        let mut text = String::new();
        for (name, hash) in &all {
            let _ = writeln!(text, "{name} {hash:016x}");
        }
        return std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()));
    }
    drop(writing);
    let all = read(&path)?;
    let known = *all.get(name).ok_or_else(|| format!("{}: no golden `{name}`", path.display()))?;
    compare(subject, name, words, known)?;
    // Each change of one element is noticed: a step of the hash is a bijection.
    let mut other = words.to_vec();
    let middle = other.len() / 2;
    if let Some(word) = other.get_mut(middle) {
        *word ^= 1;
        must_fail("a changed word", &compare(subject, name, &other, known))?;
    }
    Ok(())
}

fn compare(subject: &str, name: &str, words: &[u32], known: u64) -> Result<(), String> {
    let hash = fnv(words);
    if hash == known {
        return Ok(());
    }
    Err(format!(
        "golden `{name}` of tests/goldens/{subject}.txt: {} words have the hash {hash:016x}, expected {known:016x}. To \
         see the change, run this test before and after it with RIMLINE_GOLDENS_SHOW=FOLDER, and compare the folders",
        words.len()
    ))
}

#[cfg(test)]
mod tests {
    use super::{compare, fnv};
    use crate::{must_fail, same};

    const FOOBARFO: u64 = 0x7396_e6eb_4e20_40df;

    /// The hash is that of others, and sees order, length and each bit.
    #[test]
    fn goldens_notice_each_changed_bit() -> Result<(), String> {
        // "foobarfo" by the reference code of Fowler, Noll and Vo.
        let text = b"foobarfo".chunks(4).map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        let words: Vec<u32> = text.collect();
        same("hashes", &[fnv(&[]), fnv(&words)], &[0xcbf2_9ce4_8422_2325, FOOBARFO])?;
        let others = [vec![words[1], words[0]], vec![words[0]], vec![words[0], words[1], 0]];
        let bits = (0..64).map(|bit| {
            let mut other = words.clone();
            other[bit / 32] ^= 1 << (bit % 32);
            other
        });
        for other in others.into_iter().chain(bits) {
            must_fail("other words", &compare("hash", "foobarfo", &other, FOOBARFO))?;
        }
        Ok(())
    }
}
