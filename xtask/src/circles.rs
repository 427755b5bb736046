//! `cargo xtask circles`: modules of a crate that import one another in a circle.
//!
//! This reads text, it does not compile. It follows `use` of paths that begin with `crate`, `super` or `self`, and
//! paths in code that begin with `crate::`. It does not follow:
//!
//! - paths that begin with the name of a child, because a parent may use its own children;
//! - `pub use` in `mod.rs`, `lib.rs` and `main.rs`, because a parent that shows what its children have does not depend
//!   on them;
//! - paths in code that begin with `super::` or `self::`;
//! - items in the root of a crate;
//! - unit tests inside a file: they may use anything.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::process;

/// Imports of each module. A module is named by its full path, for example `crate::gltf::pose`.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// Prints a line for each crate; the error has every circle, and every file that cannot be read.
pub(crate) fn run() -> Result<(), String> {
    let root = process::root();
    let mut errors = Vec::new();
    for folder in source_folders(&root)? {
        let name = shown(&folder, &root);
        match read(&folder) {
            Ok(files) => {
                let imports = imports(&files);
                let circles = circles(&imports);
                println!("{name}: {} modules, {} circles", imports.len(), circles.len());
                errors.extend(circles.iter().map(|circle| describe(&name, circle, &imports)));
            }
            Err(error) => errors.push(error),
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors.join("\n")) }
}

/// The library's `src` and the `src` of each folder in `crates`.
fn source_folders(root: &Path) -> Result<Vec<PathBuf>, String> {
    let mut folders = vec![root.join("src")];
    let crates = entries(&root.join("crates"))?;
    folders.extend(crates.into_iter().map(|folder| folder.join("src")).filter(|folder| folder.is_dir()));
    Ok(folders)
}

/// Entries of a folder, in the order of names.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let paths = std::fs::read_dir(folder).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    let mut paths: Vec<PathBuf> = paths.map_err(|error| format!("cannot read {}: {error}", folder.display()))?;
    paths.sort();
    Ok(paths)
}

/// The text of every Rust file in a folder and the folders in it, by the file's path from there, with `/`.
fn read(folder: &Path) -> Result<BTreeMap<String, String>, String> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for path in entries(&next)? {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path);
                let text = text.map_err(|error| format!("cannot read {}: {error}", path.display()))?;
                files.insert(shown(&path, folder), text);
            }
        }
    }
    Ok(files)
}

/// A path from `base`, with `/` on every system.
fn shown(path: &Path, base: &Path) -> String {
    let parts = path.strip_prefix(base).unwrap_or(path).iter();
    parts.map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// The imports of each module, from the text of each file.
fn imports(files: &BTreeMap<String, String>) -> Imports {
    let modules: BTreeSet<String> = files.keys().map(|file| module(file)).collect();
    let mut imports = Imports::new();
    for (file, text) in files {
        let module = module(file);
        let paths = paths(&code(text), is_parent(file));
        let mut found: BTreeSet<_> = paths.iter().filter_map(|path| resolve(&module, path, &modules)).collect();
        found.remove(&module);
        imports.insert(module, found);
    }
    imports
}

/// The module that a file holds: `crate::gltf` for `gltf/mod.rs` and for `gltf.rs`.
fn module(file: &str) -> String {
    let mut parts: Vec<_> = file.trim_end_matches(".rs").split('/').collect();
    if is_parent(file) {
        parts.pop();
    }
    parts.insert(0, "crate");
    parts.join("::")
}

fn is_parent(file: &str) -> bool {
    matches!(file.rsplit('/').next(), Some("mod.rs" | "lib.rs" | "main.rs"))
}

/// A file's text without comments and without the unit tests at its end.
fn code(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim_end());
    lines.take_while(|line| *line != "mod tests {").collect::<Vec<_>>().join("\n")
}

/// Every path that code names, as it is written there but with groups taken apart.
fn paths(code: &str, is_parent: bool) -> Vec<String> {
    let mut paths = Vec::new();
    // Code between the `use` statements.
    let mut rest = String::new();
    let mut end = 0;
    for (start, word) in code.match_indices("use ") {
        let before = &code[..start];
        if start < end || before.ends_with(is_part_of_name) {
            continue;
        }
        let Some(length) = code[start..].find(';') else { continue };
        let tree = &code[start + word.len()..start + length];
        let first = tree.split("::").next().unwrap_or_default().trim();
        if !matches!(first, "crate" | "super" | "self") {
            continue;
        }
        rest.push_str(&code[end..start]);
        end = start + length;
        if !(is_parent && ends_with_pub(before)) {
            expand("", tree, &mut paths);
        }
    }
    rest.push_str(&code[end..]);
    for (start, _) in rest.match_indices("crate::") {
        if !rest[..start].ends_with(is_part_of_name) {
            let path = &rest[start..];
            let end = path.find(|c| c != ':' && !is_part_of_name(c)).unwrap_or(path.len());
            paths.push(path[..end].into());
        }
    }
    paths
}

fn is_part_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether code ends with `pub`, or with the likes of `pub(crate)`.
fn ends_with_pub(code: &str) -> bool {
    let mut code = code.trim_end();
    if let Some(inside) = code.strip_suffix(')') {
        code = inside.rfind('(').map_or("", |open| inside[..open].trim_end());
    }
    code.strip_suffix("pub").is_some_and(|before| !before.ends_with(is_part_of_name))
}

/// Takes the groups of a `use` apart: `a::{b, c::{d, e}}` is `a::b`, `a::c::d` and `a::c::e`.
fn expand(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let tree = tree.trim();
    if let (Some(open), Some(close)) = (tree.find('{'), tree.rfind('}')) {
        let prefix = format!("{prefix}{}", &tree[..open]);
        let mut depth = 0;
        let parts = tree[open + 1..close].split(|c| {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            c == ',' && depth == 0
        });
        for part in parts.filter(|part| !part.trim().is_empty()) {
            expand(&prefix, part, paths);
        }
    } else {
        let name = tree.split_whitespace().next().unwrap_or_default();
        paths.push(format!("{prefix}{name}"));
    }
}

/// The module that a path in `from` leads to or into; nothing where that is the root.
fn resolve(from: &str, path: &str, modules: &BTreeSet<String>) -> Option<String> {
    let mut parts: Vec<&str> = from.split("::").collect();
    for part in path.split("::").filter(|part| !part.is_empty()) {
        match part {
            "crate" => parts.truncate(1),
            "super" => parts.truncate(parts.len().saturating_sub(1)),
            "self" => {}
            name => parts.push(name),
        }
    }
    // The last names of the path may be items, not modules.
    (2..=parts.len()).rev().map(|length| parts[..length].join("::")).find(|path| modules.contains(path))
}

/// Sets of modules that all lead to one another.
fn circles(imports: &Imports) -> Vec<BTreeSet<&str>> {
    let reached: BTreeMap<_, _> = imports.keys().map(|module| (module.as_str(), reach(module, imports))).collect();
    let mut circles: Vec<BTreeSet<&str>> = Vec::new();
    for (module, others) in &reached {
        // No module imports itself, so one that leads to itself does so through others.
        if others.contains(module) && !circles.iter().any(|circle| circle.contains(module)) {
            circles.push(others.iter().copied().filter(|other| reached[other].contains(module)).collect());
        }
    }
    circles
}

/// Every module that a module imports, that those import, and so on.
fn reach<'a>(module: &str, imports: &'a Imports) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut next: Vec<_> = imports.get(module).into_iter().flatten().collect();
    while let Some(module) = next.pop() {
        if reached.insert(module.as_str()) {
            next.extend(imports.get(module).into_iter().flatten());
        }
    }
    reached
}

/// The modules of a circle, each with what it imports from the circle.
fn describe(name: &str, circle: &BTreeSet<&str>, imports: &Imports) -> String {
    let mut lines = vec![format!("{name}: {} modules import one another in a circle", circle.len())];
    for module in circle {
        let others = imports.get(*module).into_iter().flatten().map(String::as_str);
        let others: Vec<_> = others.filter(|other| circle.contains(other)).collect();
        lines.push(format!("  {module} imports {}", others.join(", ")));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::{circles, describe, imports, paths};

    fn files(files: &[(&str, &str)]) -> BTreeMap<String, String> {
        files.iter().map(|(file, text)| ((*file).into(), (*text).into())).collect()
    }

    /// Imports of one module.
    fn imports_of(module: &str, texts: &[(&str, &str)]) -> Vec<String> {
        imports(&files(texts)).remove(module).into_iter().flatten().collect()
    }

    #[test]
    fn a_circle_is_found_and_described() {
        let imports = imports(&files(&[
            ("lib.rs", "mod a;\nmod b;\nmod c;"),
            ("a.rs", "use crate::b::B;"),
            ("b.rs", "fn f() { crate::a::f(); }"),
            ("c.rs", "use super::a::A;"),
        ]));
        let circles = circles(&imports);
        assert_eq!(circles.len(), 1);
        let expected = "src: 2 modules import one another in a circle\n  \
                        crate::a imports crate::b\n  crate::b imports crate::a";
        assert_eq!(describe("src", &circles[0], &imports), expected);
    }

    #[test]
    fn a_circle_of_three_is_one_circle() {
        let long = [("a.rs", "use crate::b;"), ("b.rs", "use crate::c::C;"), ("c.rs", "use crate::a::A;")];
        let long = imports(&files(&long));
        assert_eq!(circles(&long).iter().map(std::collections::BTreeSet::len).collect::<Vec<_>>(), [3]);
    }

    #[test]
    fn a_chain_is_no_circle() {
        let chain = imports(&files(&[("a.rs", "use crate::b;"), ("b.rs", "use crate::c::C;"), ("c.rs", "")]));
        assert!(circles(&chain).is_empty());
    }

    #[test]
    fn groups_are_taken_apart() {
        let texts = [
            ("m/mod.rs", ""),
            ("m/a.rs", ""),
            ("m/b/mod.rs", ""),
            ("m/b/c.rs", ""),
            ("m/d.rs", ""),
            ("m/user.rs", "use super::{\n    a::{A, B},\n    b::{self, c::C as Other},\n    d,\n};"),
        ];
        let expected = ["crate::m::a", "crate::m::b", "crate::m::b::c", "crate::m::d"];
        assert_eq!(imports_of("crate::m::user", &texts), expected);
    }

    #[test]
    fn comments_and_unit_tests_are_ignored() {
        let text = "// use crate::b::B;\n#[cfg(test)]\nmod tests {\n    use crate::b::B;\n}\n";
        assert!(imports_of("crate::a", &[("a.rs", text), ("b.rs", "")]).is_empty());
    }

    #[test]
    fn a_parent_may_show_what_its_children_have() {
        let shows = "pub(crate) use self::b::B;\npub use crate::a::c::C;";
        let children = [("a/b.rs", ""), ("a/c.rs", "")];
        assert!(imports_of("crate::a", &[&[("a/mod.rs", shows)], &children[..]].concat()).is_empty());
        // Without `pub` it is an import.
        let uses = [&[("a/mod.rs", "use self::b::B;")], &children[..]].concat();
        assert_eq!(imports_of("crate::a", &uses), ["crate::a::b"]);
    }

    #[test]
    fn only_paths_of_this_crate_are_taken() {
        let code = "use std::fs;\nuse crates::x;\nfn f() { reuse crate_::y; crate::z::f::<u8>() }";
        assert_eq!(paths(code, false), ["crate::z::f::"]);
    }
}
