//! Words: comments begin with their subject, and names are of standard terms.

use crate::process;

/// Words that no comment opens with.
const OPENERS: [&str; 5] = ["As", "That", "Those", "What", "Of"];

/// Parts of names that stand for too many things, and the words to take instead.
const BANNED: [(&str, &str); 13] = [
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
    ("covered", "occluded, blocked, behind"),
    ("hidden", "occluded, culled"),
];

/// Folders whose names are checked.
const CHECKED: [&str; 7] = ["benches/", "crates/", "examples/", "src/", "tests/", "wgsl/", "xtask/"];

/// Reasons for names that may stay.
const WALKER: &str = "the walking figure, a model of rimline-models";
const LINES: &str = "lines that faces hide, the term of drawings";
const NODES: &str = "nodes that a glTF file hides";

/// Names that may stay in a folder or a file, and why.
const ALLOWED: [(&str, &[&str], &str); 19] = [
    ("crates/rimline-bench/", &["Figure", "figure", "figures"], "a chart and its table in a report"),
    ("crates/rimline-cli/src/draw/", &["is_hidden"], LINES),
    ("crates/rimline-cli/src/info.rs", &["hidden_nodes"], NODES),
    ("crates/rimline-cli/src/lines", &["Hidden", "has_hidden", "hidden", "is_hidden"], LINES),
    ("crates/rimline-cli/src/output.rs", &["hidden", "is_hidden"], "functions of indicatif"),
    ("crates/rimline-cli/src/shadow", &["hide_covered"], "the option --hide-covered"),
    ("crates/rimline-cli/tests/", &["Figure", "figure"], WALKER),
    ("crates/rimline-cli/tests/command/drawings/", &["hidden"], LINES),
    ("crates/rimline-cli/tests/command/outlines.rs", &["Hidden", "hidden"], LINES),
    ("crates/rimline-fuzz/", &["hidden"], NODES),
    ("crates/rimline-lines/", &["hidden", "is_hidden", "is_hidden_drawn"], LINES),
    ("crates/rimline-models/", &["Figure", "figure"], WALKER),
    ("crates/rimline-view/", &["Figure", "figure", "walking_figure"], WALKER),
    ("examples/", &["Figure", "figure"], WALKER),
    ("src/gltf/", &["hidden_nodes", "is_hidden"], NODES),
    ("tests/examples/", &["FIGURE", "Figure", "figure"], WALKER),
    ("tests/gltf/", &["hidden", "hidden_nodes"], NODES),
    ("tests/outline/", &["hidden"], LINES),
    ("wgsl/outline/", &["is_hidden"], LINES),
];

/// Looks at the comments of all Rust and WGSL files, and at the names in [`CHECKED`].
pub(crate) fn run() -> Result<(), String> {
    let (mut found, mut banned) = (Vec::new(), Vec::new());
    for (name, text) in process::files(&["*.rs", "*.wgsl"])? {
        found.extend(openers(&text).into_iter().map(|line| format!("{name}:{line}")));
        if CHECKED.iter().any(|folder| name.starts_with(folder)) {
            let allowed = ALLOWED.iter().filter(|(folder, ..)| name.starts_with(folder));
            let allowed: Vec<_> = allowed.flat_map(|(_, names, _)| *names).copied().collect();
            banned.extend(banned_names(&text, &allowed).into_iter().map(|what| format!("{name}:{what}")));
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

/// The line, from 1, the name and the words to take, of each name with a banned part. Comments, strings and `doc(hidden)`
/// have no names.
fn banned_names(text: &str, allowed: &[&str]) -> Vec<String> {
    let mut all = Vec::new();
    for (line, code) in (1..).zip(code_of(text).replace("doc(hidden)", "doc").lines()) {
        for name in code.split(|c: char| c != '_' && !c.is_alphanumeric()) {
            let parted = parted(name);
            let has = |word: &str| parted.split('_').any(|part| part.eq_ignore_ascii_case(word));
            if let Some((_, instead)) = BANNED.iter().find(|(word, _)| has(word)).filter(|_| !allowed.contains(&name)) {
                all.push(format!("{line} `{name}` ({instead})"));
            }
        }
    }
    all
}

/// The name with `_` between all its words: `CoveredFaces` has two.
fn parted(name: &str) -> String {
    let mut parted = String::new();
    for c in name.chars() {
        if c.is_uppercase() && parted.ends_with(|before: char| before.is_lowercase() || before.is_numeric()) {
            parted.push('_');
        }
        parted.push(c);
    }
    parted
}

/// The text without its comments and strings, with the same lines.
fn code_of(text: &str) -> String {
    let (mut code, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(['"', '/', '\'']) {
        code += &rest[..at];
        rest = &rest[at..];
        let left_out = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with('"') {
            string_length(&code, rest)
        } else {
            // The character of a quote begins no string.
            if rest.starts_with("'\"'") { 3 } else { 1 }
        };
        code.extend(rest[..left_out].chars().map(|c| if c == '\n' { c } else { ' ' }));
        rest = &rest[left_out..];
    }
    code + rest
}

/// The bytes of the string that `rest` begins with, its quotes included. `before` ends in `r`, `r#` and so on at a raw
/// string.
fn string_length(before: &str, rest: &str) -> usize {
    let without_hashes = before.trim_end_matches('#');
    if without_hashes.ends_with('r') {
        let end = format!("\"{}", &before[without_hashes.len()..]);
        return rest[1..].find(&end).map_or(rest.len(), |at| 1 + at + end.len());
    }
    let mut is_escaped = false;
    let end = rest[1..].find(|c| {
        let is_end = c == '"' && !is_escaped;
        is_escaped = c == '\\' && !is_escaped;
        is_end
    });
    end.map_or(rest.len(), |at| at + 2)
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
        let lines = |text, allowed: &[&str]| -> Vec<String> {
            banned_names(text, allowed).iter().filter_map(|what| Some(what.split(' ').next()?.to_owned())).collect()
        };
        assert_eq!(lines(text, &[]), ["1", "3", "3", "4"]);
        assert_eq!(lines(text, &["own", "place"]), ["3", "4"]);
        let types = "struct CoveredFaces;\nstruct Displaced;\n#[doc(hidden)]\nstruct Near2Own;\nfn hidden() {}\n";
        assert_eq!(lines(types, &[]), ["1", "4", "5"]);
        assert_eq!(lines(types, &["CoveredFaces"]), ["4", "5"]);
    }

    #[test]
    fn strings_and_comments_have_no_names() {
        let text = r##"let a = "own \" own
            own"; let own = '"'; // own "
            let b = r#"own " own"#; let place = "//"; let own = 1;"##;
        let found = banned_names(text, &[]);
        let lines: Vec<_> = found.iter().filter_map(|what| what.split(' ').next()).collect();
        assert_eq!(lines, ["2", "3", "3"], "{found:?}");
    }

    #[test]
    fn the_tree_has_none() {
        super::run().expect("words are those of ARCHITECTURE.md");
    }
}
