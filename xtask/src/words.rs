//! Comments begin with their subject: none opens with a word that only stands for one.

use std::fs;

use crate::process;

/// Words that no comment opens with.
const OPENERS: [&str; 5] = ["As", "That", "Those", "What", "Of"];

/// Looks at the comments of all Rust and WGSL files.
pub(crate) fn run() -> Result<(), String> {
    let mut git = std::process::Command::new("git");
    let names = process::output(git.args(["ls-files", "-z", "*.rs", "*.wgsl"]).current_dir(process::root()))?;
    let mut found = Vec::new();
    for name in names.split('\0').filter(|name| !name.is_empty()) {
        // A file that is removed but not committed.
        let text = fs::read_to_string(process::root().join(name)).unwrap_or_default();
        found.extend(openers(&text).into_iter().map(|line| format!("{name}:{line}")));
    }
    if found.is_empty() {
        return Ok(());
    }
    Err(format!("these comments open with one of {OPENERS:?}; name the subject: {}", found.join(", ")))
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
    use super::openers;

    #[test]
    fn comments_without_a_subject_are_found() {
        let text = "/// What it is.\nfn a() {}\n  // As before.\n//! * Of all.\n/// Ask it.\nlet s = \"// That\";\n";
        assert_eq!(openers(text), [1, 3, 4]);
    }
}
