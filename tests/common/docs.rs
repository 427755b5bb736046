//! The documents: links lead to files and headings that are there, and paths that the text names exist. So do
//! references in the code to the numerics.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders that a path in backticks begins with, from the root of the repository.
const FOLDERS: [&str; 9] = ["src/", "wgsl/", "tests/", "crates/", "docs/", "examples/", "benches/", "xtask/", ".ci/"];

/// Folders of code that refers to the numerics.
const SOURCES: [&str; 7] = ["src", "wgsl", "tests", "crates", "examples", "benches", "xtask"];

#[test]
fn links_and_paths_lead_somewhere() {
    let (root, documents) = (root(), documents());
    assert!(documents.len() >= 5, "only {} documents found: {documents:?}", documents.len());
    let mut wrong = Vec::new();
    let mut checked = 0;
    for document in &documents {
        let text = read(document);
        let folder = document.parent().expect("a file lies in a folder");
        let (links, paths) = (links(&text), paths(&text));
        checked += links.len() + paths.len();
        wrong.extend(links.iter().filter_map(|link| broken_link(link, document, folder).err()));
        wrong.extend(
            paths
                .iter()
                .filter(|path| !root.join(path).exists())
                .map(|path| format!("{}: `{path}` is not in the repository", shown(document))),
        );
    }
    assert!(checked > 100, "only {checked} links and paths found");
    assert!(wrong.is_empty(), "{} of {checked}:\n{}", wrong.len(), wrong.join("\n"));
}

/// Negative controls: what is broken is noticed, and what is no link is none.
#[test]
fn broken_links_are_noticed() {
    let readme = root().join("README.md");
    let check = |link: &str| broken_link(link, &readme, root());
    for good in ["ARCHITECTURE.md", "docs/", "#rimline", "docs/numerics/facing.md#tie-rule"] {
        assert_eq!(check(good), Ok(()), "{good}");
    }
    for bad in ["ARCHITECTURE.txt", "#rimlines", "docs/numerics/facing.md#tie-rules", "docs/nothing.png"] {
        assert!(check(bad).is_err(), "{bad}");
    }
    let text = "[a](x.md) `src/lib.rs` ![b](docs/b.png)\n```text\n[c](y.md) `src/c.rs`\n```\n\
                [d](https://d.example) `wgsl/SUBJECT/NAME.wgsl` `src/lib.rs::item` <img src=\"docs/e.png\">";
    assert_eq!(links(text), ["x.md", "docs/b.png", "docs/e.png"]);
    assert_eq!(paths(text).into_iter().collect::<Vec<_>>(), ["src/lib.rs"]);
}

/// Paths in comments of the code, from the root or from the folder of the crate, exist.
#[test]
fn paths_in_comments_lead_somewhere() {
    let mut files = Vec::new();
    for folder in SOURCES {
        add_sources(&root().join(folder), &mut files);
    }
    let mut wrong = Vec::new();
    let mut checked = 0;
    for file in &files {
        let mut crate_folder = root().to_owned();
        if let Ok(rest) = file.strip_prefix(root().join("crates")) {
            crate_folder.extend(Path::new("crates").join(rest).iter().take(2));
        }
        let paths = commented_paths(&read(file));
        checked += paths.len();
        let is_missing = |path: &&String| !root().join(path).exists() && !crate_folder.join(path).exists();
        wrong.extend(paths.iter().filter(is_missing).map(|path| format!("{}: {path}", shown(file))));
    }
    assert!(checked > 100, "only {checked} paths found");
    assert!(wrong.is_empty(), "{} of {checked}:\n{}", wrong.len(), wrong.join("\n"));
    let (first, second) = ("src/b.rs", "wgsl/c.wgsl");
    let comments =
        format!("let a = \"src/a.rs\"; // Of {first}.\n//! `{second}`, wgsl/SUBJECT/NAME.wgsl, notes/src/d.rs");
    assert_eq!(commented_paths(&comments).into_iter().collect::<Vec<_>>(), [first, second]);
}

/// References in comments, such as `docs/numerics/facing.md, "Filter"`, lead to files and headings.
#[test]
fn references_to_numerics_lead_somewhere() {
    let mut files = documents();
    for folder in SOURCES {
        add_sources(&root().join(folder), &mut files);
    }
    let mut wrong = Vec::new();
    let mut checked = 0;
    for file in &files {
        for (name, titles) in references(&unwrapped(&read(file))) {
            checked += 1;
            wrong.extend(broken_reference(&name, &titles).map(|what| format!("{}: {what}", shown(file))));
        }
    }
    assert!(checked > 100, "only {checked} references found");
    assert!(wrong.is_empty(), "{} of {checked}:\n{}", wrong.len(), wrong.join("\n"));
}

/// Negative controls: files and titles that are not there are noticed, also where a comment goes on in the next line.
#[test]
fn broken_references_are_noticed() {
    let folder = "docs/numerics";
    let text = format!("// See {folder}/facing.md, \"Error\n/// band\" and \"Filters\"; {folder}/none.md, \"None\".");
    let found = references(&unwrapped(&text));
    let wrong: Vec<String> = found.iter().filter_map(|(name, titles)| broken_reference(name, titles)).collect();
    assert!(wrong.len() == 2 && wrong[0].contains("Filters") && wrong[1].contains("none"), "{wrong:?}");
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A document by its path in the repository.
fn shown(document: &Path) -> std::path::Display<'_> {
    document.strip_prefix(root()).unwrap_or(document).display()
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

/// Adds the Rust and WGSL files of a folder and of all folders in it.
fn add_sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in entries(folder) {
        if entry.is_dir() {
            add_sources(&entry, files);
        } else if entry.extension().is_some_and(|extension| extension == "rs" || extension == "wgsl") {
            files.push(entry);
        }
    }
}

/// The text in one line, without the marks of comments.
fn unwrapped(text: &str) -> String {
    let lines = text.lines().map(|line| line.trim().trim_start_matches(['/', '!']).trim());
    lines.collect::<Vec<_>>().join(" ")
}

/// The files of the numerics that a text names, each with the titles that follow it.
fn references(text: &str) -> Vec<(String, Vec<String>)> {
    let found = text.split("docs/numerics/").skip(1).filter_map(|rest| {
        let (name, mut rest) = rest.split_once(".md")?;
        if !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-') {
            return None;
        }
        let mut titles = Vec::new();
        let marks = [", \"", " and \"", ", and \""];
        while let Some(quoted) = marks.into_iter().find_map(|mark| rest.strip_prefix(mark)) {
            let (title, after) = quoted.split_once('"')?;
            titles.push(title.to_owned());
            rest = after;
        }
        Some((name.to_owned(), titles))
    });
    found.collect()
}

/// The fault of a reference, if it has one.
fn broken_reference(name: &str, titles: &[String]) -> Option<String> {
    let file = root().join("docs").join("numerics").join(format!("{name}.md"));
    if !file.exists() {
        return Some(format!("{name}.md is not there"));
    }
    let headings = headings(&read(&file));
    let missing = titles.iter().find(|title| !headings.contains(&anchor(title)))?;
    Some(format!("{name}.md has no heading \"{missing}\""))
}

/// The text without its fenced blocks.
fn prose(text: &str) -> String {
    let mut is_code = false;
    let lines = text.lines().filter(|line| {
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Targets of links and pictures, but for those in the web.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let marked = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let tagged = prose.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let is_local = |link: &&str| !link.contains("://") && !link.starts_with("mailto:");
    marked.chain(tagged).filter(is_local).map(str::to_owned).collect()
}

/// Paths in backticks; those with a placeholder in capitals are none.
fn paths(text: &str) -> BTreeSet<String> {
    let prose = prose(text);
    let is_path = |code: &&str| {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "_./-".contains(c);
        FOLDERS.iter().any(|folder| code.starts_with(folder)) && code.chars().all(is_plain) && !has_placeholder(code)
    };
    prose.split('`').skip(1).step_by(2).filter(is_path).map(str::to_owned).collect()
}

/// Paths of files in the comments of a source; those with a placeholder in capitals are none.
fn commented_paths(text: &str) -> BTreeSet<String> {
    let comments = text.lines().filter_map(|line| Some(line.split_once("//")?.1));
    let words = comments.flat_map(|comment| comment.split(|c: char| !c.is_ascii_alphanumeric() && !"_./-".contains(c)));
    let words = words.map(|word| word.trim_end_matches('.'));
    let is_file = |word: &&str| {
        let ends = [".rs", ".wgsl", ".md", ".txt", ".toml"];
        ends.iter().any(|end| word.ends_with(end)) && FOLDERS.iter().any(|folder| word.starts_with(folder))
    };
    words.filter(is_file).filter(|word| !has_placeholder(word)).map(str::to_owned).collect()
}

fn has_placeholder(path: &str) -> bool {
    path.split(['/', '.']).any(|part| part.len() > 1 && part.chars().all(|c| c.is_ascii_uppercase()))
}

fn broken_link(link: &str, document: &Path, folder: &Path) -> Result<(), String> {
    let (file, heading) = link.split_once('#').map_or((link, None), |(file, heading)| (file, Some(heading)));
    let target = if file.is_empty() { document.to_owned() } else { folder.join(file) };
    if !target.exists() {
        return Err(format!("{}: the link `{link}` leads to no file", shown(document)));
    }
    match heading {
        Some(heading) if !headings(&read(&target)).contains(heading) => {
            Err(format!("{}: the link `{link}` leads to no heading", shown(document)))
        }
        _ => Ok(()),
    }
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
