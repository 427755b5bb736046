//! Words: comments begin with their subject, and names are of standard terms.

use std::fs;

use crate::process;

/// Words that no comment opens with.
const OPENERS: [&str; 5] = ["As", "That", "Those", "What", "Of"];

/// Parts of names that stand for too many things, and the words to take instead.
const BANNED: [(&str, &str); 11] = [
    ("place", "index, offset, slot, position, path"),
    ("places", "indices, offsets, crossings"),
    ("own", "what it is: local, planned, stored"),
    ("told", "decided, found, refused"),
    ("averted", "back_facing"),
    ("unneeded", "culled"),
    ("unreached", "culled_by_range"),
    ("figure", "deforming caster, skinned mesh"),
    ("figures", "deforming casters"),
    ("fresh", "dirty, new"),
    ("matter", "active, relevant"),
];

/// Folders whose names are checked. The command, the benches and the tests still have other words.
const CHECKED: [&str; 2] = ["src/", "wgsl/"];

/// Names that may stay, and why.
const ALLOWED: [(&str, &str); 0] = [];

/// Looks at the comments of all Rust and WGSL files, and at the names of the library.
pub(crate) fn run() -> Result<(), String> {
    let mut git = std::process::Command::new("git");
    let names = process::output(git.args(["ls-files", "-z", "*.rs", "*.wgsl"]).current_dir(process::root()))?;
    let (mut found, mut banned) = (Vec::new(), Vec::new());
    for name in names.split('\0').filter(|name| !name.is_empty()) {
        // A file that is removed but not committed.
        let text = fs::read_to_string(process::root().join(name)).unwrap_or_default();
        found.extend(openers(&text).into_iter().map(|line| format!("{name}:{line}")));
        if CHECKED.iter().any(|folder| name.starts_with(folder)) {
            banned.extend(banned_names(&text).into_iter().map(|what| format!("{name}:{what}")));
        }
    }
    if !found.is_empty() {
        return Err(format!("these comments open with one of {OPENERS:?}; name the subject: {}", found.join(", ")));
    }
    if !banned.is_empty() {
        return Err(format!("these names have words that mean too many things: {}", banned.join(", ")));
    }
    Ok(())
}

/// The line, from 1, the name and the words to take, of each name with a banned part. Comments and strings have no names.
fn banned_names(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    for (line, code) in (1..).zip(text.lines()) {
        let code = code.split("//").next().unwrap_or_default();
        // Every other part between quotes is a string. Strings of several lines are read as code.
        let outside = code.split('"').step_by(2);
        for name in outside.flat_map(|code| code.split(|c: char| c != '_' && !c.is_alphanumeric())) {
            let has = |word: &str| name.split('_').any(|part| part.eq_ignore_ascii_case(word));
            let allowed = ALLOWED.iter().any(|(allowed, _)| *allowed == name);
            if let Some((_, instead)) = BANNED.iter().find(|(word, _)| has(word)).filter(|_| !allowed) {
                all.push(format!("{line} `{name}` ({instead})"));
            }
        }
    }
    all
}

/// The lines, from 1, where a comment opens with one of the words.
fn openers(text: &str) -> Vec<usize> {
    let opens = |line: &str| {
        let prose = line.trim_start().strip_prefix("//")?.trim_start_matches(['/', '!']).trim_start();
        let word = prose.trim_start_matches("* ").split(|c: char| !c.is_alphanumeric()).next()?;
        OPENERS.contains(&word).then_some(())
    };
    (1..).zip(text.lines()).filter(|(_, line)| opens(line).is_some()).map(|(number, _)| number).collect()
}

#[cfg(test)]
mod tests {
    use super::{banned_names, openers};

    #[test]
    fn comments_without_a_subject_are_found() {
        let text = "/// What it is.\nfn a() {}\n  // As before.\n//! * Of all.\n/// Ask it.\nlet s = \"// That\";\n";
        assert_eq!(openers(text), [1, 3, 4]);
    }

    #[test]
    fn names_of_banned_words_are_found() {
        let text = "let place = 1; // place\nlet placement = \"a place\";\nfn at_place(own: u32) {}\nconst AVERTED: u32 = 1;\n";
        let found = banned_names(text);
        let lines: Vec<_> = found.iter().filter_map(|what| what.split(' ').next()).collect();
        assert_eq!(lines, ["1", "3", "3", "4"], "{found:?}");
    }

    #[test]
    fn the_tree_has_none() {
        super::run().expect("words are those of ARCHITECTURE.md");
    }
}
