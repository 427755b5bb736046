//! The documents: links lead to files and headings that are there, and paths that the text names exist. So do
//! references in the code to the numerics.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders that a path begins with, from the root of the repository.
const FOLDERS: [&str; 9] = ["src/", "wgsl/", "tests/", "crates/", "docs/", "examples/", "benches/", "xtask/", ".ci/"];

#[test]
fn links_and_paths_lead_somewhere() {
    no_faults(&documents(), |document, text| {
        let links = links(text).into_iter().map(|link| broken_link(&link, document));
        let missing =
            |path: String| (!root().join(&path).exists()).then(|| format!("`{path}` is not in the repository"));
        links.chain(paths(text).into_iter().map(missing)).chain(commands(text)).collect()
    });
}

/// Negative controls: what is broken is noticed, and what is no link is none.
#[test]
fn broken_links_are_noticed() {
    let readme = root().join("README.md");
    for good in ["ARCHITECTURE.md", "docs/", "#rimline", "docs/numerics/facing.md#tie-rule"] {
        assert_eq!(broken_link(good, &readme), None, "{good}");
    }
    for bad in ["ARCHITECTURE.txt", "#rimlines", "docs/numerics/facing.md#tie-rules", "docs/nothing.png"] {
        assert!(broken_link(bad, &readme).is_some(), "{bad}");
    }
    let text = "[a](x.md) `src/lib.rs` ![b](docs/b.png)\n```text\n[c](y.md) `src/c.rs`\n```\n\
                [d](https://d.example) `wgsl/SUBJECT/NAME.wgsl` `src/lib.rs::item` <img src=\"docs/e.png\">";
    assert_eq!(links(text), ["x.md", "docs/b.png", "docs/e.png"]);
    assert_eq!(paths(text), ["src/lib.rs"]);
    let text = "`cargo test --test docs`, `cargo xtask test --long doc\n  all`, `--long` or `cargo xtask web --test`";
    assert_eq!(commands(text), [None, Some("there is no target `doc`".to_owned())]);
    assert!(commands("`RIMLINE_LONG=1 cargo test --test docs`")[0].is_some());
}

/// Paths in comments of the code, from the root or from the folder of the crate, exist.
#[test]
fn paths_in_comments_lead_somewhere() {
    no_faults(&sources(), |file, text| {
        let in_crates = file.strip_prefix(root().join("crates")).ok().and_then(|rest| rest.iter().next());
        let of_crate = in_crates.map_or(root().to_owned(), |name| root().join("crates").join(name));
        let exists = |path: &str| root().join(path).exists() || of_crate.join(path).exists();
        let paths = commented_paths(text).into_iter();
        paths.map(|path| (!exists(&path)).then(|| format!("{path} is not there"))).collect()
    });
    let (first, second) = ("src/b.rs", "wgsl/c.wgsl");
    let comments =
        format!("let a = \"src/a.rs\"; // Of {first}.\n//! `{second}`, wgsl/SUBJECT/NAME.wgsl, notes/src/d.rs");
    assert_eq!(commented_paths(&comments), [first, second]);
}

/// References, such as `docs/numerics/facing.md, "Filter"`, lead to files and headings, also where a comment goes on in the next
/// line.
#[test]
fn references_to_numerics_lead_somewhere() {
    no_faults(&[documents(), sources()].concat(), |_, text| broken_references(text));
    let folder = "docs/numerics";
    let text = format!("// See {folder}/facing.md, \"Error\n/// band\" and \"Filters\"; {folder}/none.md, \"None\".");
    let wrong: Vec<String> = broken_references(&text).into_iter().flatten().collect();
    assert!(wrong.len() == 2 && wrong[0].contains("Filters") && wrong[1].contains("none"), "{wrong:?}");
}

/// Fails with all faults of the files. `check` gives one entry for each thing that it looks at.
fn no_faults(files: &[PathBuf], check: impl Fn(&Path, &str) -> Vec<Option<String>>) {
    let (mut checked, mut wrong) = (0, Vec::new());
    for file in files {
        let found = check(file, &read(file));
        checked += found.len();
        let shown = file.strip_prefix(root()).unwrap_or(file).display();
        wrong.extend(found.into_iter().flatten().map(|fault| format!("{shown}: {fault}")));
    }
    assert!(checked > 100 && files.len() >= 5, "only {checked} found in {} files", files.len());
    assert!(wrong.is_empty(), "{} of {checked}:\n{}", wrong.len(), wrong.join("\n"));
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(file: &Path) -> String {
    fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// The Markdown files at the root, in `docs` and of each crate.
fn documents() -> Vec<PathBuf> {
    let mut folders = vec![root().to_owned(), root().join("docs"), root().join("docs").join("numerics")];
    folders.extend(entries(&root().join("crates")));
    let mut documents: Vec<_> = folders.iter().flat_map(|folder| entries(folder)).collect();
    documents.retain(|file| file.extension().is_some_and(|extension| extension == "md"));
    documents
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<_> = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    entries.sort();
    entries
}

/// The Rust and WGSL files of the repository.
fn sources() -> Vec<PathBuf> {
    let mut left: Vec<_> = FOLDERS.iter().map(|folder| root().join(folder)).collect();
    let mut files = Vec::new();
    while let Some(path) = left.pop() {
        left.extend(entries(&path));
        if path.extension().is_some_and(|extension| extension == "rs" || extension == "wgsl") {
            files.push(path);
        }
    }
    files
}

/// An entry for each file of the numerics that a text names, and for each title that follows.
fn broken_references(text: &str) -> Vec<Option<String>> {
    let lines = text.lines().map(|line| line.trim().trim_start_matches(['/', '!']).trim());
    let text = lines.collect::<Vec<_>>().join(" ");
    let mut found = Vec::new();
    for rest in text.split("docs/numerics/").skip(1) {
        let Some((name, mut rest)) = rest.split_once(".md") else { continue };
        if !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-') {
            continue;
        }
        let file = root().join("docs").join("numerics").join(format!("{name}.md"));
        if !file.exists() {
            found.push(Some(format!("{name}.md is not there")));
            continue;
        }
        found.push(None);
        let headings = headings(&read(&file));
        let marks = [", \"", " and \"", ", and \""];
        while let Some(quoted) = marks.into_iter().find_map(|mark| rest.strip_prefix(mark)) {
            let Some((title, after)) = quoted.split_once('"') else { break };
            let is_there = headings.contains(&anchor(title));
            found.push((!is_there).then(|| format!("{name}.md has no heading \"{title}\"")));
            rest = after;
        }
    }
    found
}

/// The text without its fenced blocks.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// Targets of links and pictures, but for those in the web.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let marked = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let tagged = prose.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let is_local = |link: &&str| !link.contains("://") && !link.starts_with("mailto:");
    marked.chain(tagged).filter(is_local).map(str::to_owned).collect()
}

/// Whether it begins with a folder; those with a placeholder in capitals are none.
fn is_path(text: &str) -> bool {
    let is_placeholder = |part: &str| part.len() > 1 && part.chars().all(|c| c.is_ascii_uppercase());
    FOLDERS.iter().any(|folder| text.starts_with(folder)) && !text.split(['/', '.']).any(is_placeholder)
}

fn is_plain(c: char) -> bool {
    c.is_ascii_alphanumeric() || "_./-".contains(c)
}

/// Paths in backticks.
fn paths(text: &str) -> Vec<String> {
    let prose = prose(text);
    let quoted = prose.split('`').skip(1).step_by(2);
    quoted.filter(|code| code.chars().all(is_plain) && is_path(code)).map(str::to_owned).collect()
}

/// An entry for each target that a command of a text names, and for each command that has a better one.
fn commands(text: &str) -> Vec<Option<String>> {
    let folders = [vec![root().to_owned()], entries(&root().join("crates")), entries(&root().join("benches"))].concat();
    let manifests = folders.iter().map(|folder| folder.join("Cargo.toml")).filter(|file| file.exists());
    let manifests: Vec<String> = manifests.map(|file| read(&file)).collect();
    let is_there = |target: &str| manifests.iter().any(|text| text.contains(&format!("\nname = \"{target}\"\n")));
    let words: Vec<&str> = text.split(|c: char| c.is_whitespace() || "`,;)".contains(c)).collect();
    let mut found = Vec::new();
    for pair in words.windows(2).filter(|pair| ["--test", "--bench", "--long"].contains(&pair[0])) {
        let target = pair[1];
        if !target.is_empty() && !target.chars().all(|c| c.is_ascii_uppercase()) {
            found.push((!is_there(target)).then(|| format!("there is no target `{target}`")));
        }
    }
    let by_hand =
        text.matches("RIMLINE_LONG=").map(|_| Some("long trials run by `cargo xtask test --long`".to_owned()));
    by_hand.chain(found).collect()
}

/// Paths of files in the comments of a source.
fn commented_paths(text: &str) -> Vec<String> {
    let comments = text.lines().filter_map(|line| Some(line.split_once("//")?.1));
    let words = comments.flat_map(|comment| comment.split(|c: char| !is_plain(c)));
    let words = words.map(|word| word.trim_end_matches('.'));
    let is_file = |word: &&str| [".rs", ".wgsl", ".md", ".txt", ".toml"].iter().any(|end| word.ends_with(end));
    words.filter(|word| is_file(word) && is_path(word)).map(str::to_owned).collect()
}

/// The fault of a link in a document, if it has one.
fn broken_link(link: &str, document: &Path) -> Option<String> {
    let (file, heading) = link.split_once('#').map_or((link, None), |(file, heading)| (file, Some(heading)));
    let target = if file.is_empty() { document.to_owned() } else { document.with_file_name(file) };
    if !target.exists() {
        return Some(format!("the link `{link}` leads to no file"));
    }
    let is_missing = heading.is_some_and(|heading| !headings(&read(&target)).contains(heading));
    is_missing.then(|| format!("the link `{link}` leads to no heading"))
}

/// The names that GitHub and others give to headings.
fn headings(text: &str) -> BTreeSet<String> {
    let prose = prose(text);
    let titles = prose.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    titles.map(anchor).collect()
}

/// The name of a heading.
fn anchor(title: &str) -> String {
    let kept = title.to_lowercase();
    kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>().replace(' ', "-")
}
