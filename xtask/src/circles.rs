//! `cargo xtask circles`: modules of a crate that import one another in a circle.
//!
//! This reads text, it does not compile. It follows `use` of paths that begin with `crate`, `super` or `self`, and
//! paths in code that begin with `crate::`. It does not follow:
//!
//! - paths that begin with the name of a child, because a parent may use its own children;
//! - `pub use` in `mod.rs`, `lib.rs` and `main.rs`, because a parent that shows what its children have does not depend
//!   on them;
//! - items in the root of a crate, and unit tests inside a file: they may use anything.

use std::collections::{BTreeMap, BTreeSet};

use crate::process;

/// Imports of each module. A module is named by its full path, for example `crate::gltf::pose`.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// Prints a line for each crate; the error has every circle.
pub(crate) fn run() -> Result<(), String> {
    // The text of each file, by its path from the folder of its crate's sources.
    let mut crates: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    for (name, text) in process::files(&["src/*.rs", "crates/*/src/*.rs"])? {
        let from = name.find("src/").unwrap_or(0) + 4;
        crates.entry(name[..from - 1].to_owned()).or_default().insert(name[from..].to_owned(), text);
    }
    let mut errors = Vec::new();
    for (name, files) in crates {
        let imports = imports(&files);
        let circles = circles(&imports);
        println!("{name}: {} modules, {} circles", imports.len(), circles.len());
        errors.extend(circles.iter().map(|circle| describe(&name, circle, &imports)));
    }
    if errors.is_empty() { Ok(()) } else { Err(errors.join("\n")) }
}

/// The imports of each module, from the text of each file.
fn imports(files: &BTreeMap<String, String>) -> Imports {
    let modules: BTreeSet<String> = files.keys().map(|file| module(file)).collect();
    let imports = files.iter().map(|(file, text)| {
        let module = module(file);
        let paths = paths(&code(text), is_parent(file));
        let mut found: BTreeSet<_> = paths.iter().filter_map(|path| resolve(&module, path, &modules)).collect();
        found.remove(&module);
        (module, found)
    });
    imports.collect()
}

/// The module that a file holds: `crate::gltf` for `gltf/mod.rs` and for `gltf.rs`.
fn module(file: &str) -> String {
    let path = if is_parent(file) { file.rsplit_once('/').map_or("", |(folder, _)| folder) } else { file };
    let names = path.trim_end_matches(".rs").split('/').filter(|name| !name.is_empty());
    std::iter::once("crate").chain(names).collect::<Vec<_>>().join("::")
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
    for root in ["crate::", "super::", "self::"] {
        for (start, _) in code.match_indices(root) {
            let before = &code[..start];
            let used = before.strip_suffix("use ").filter(|before| !before.ends_with(is_part_of_name));
            let length = if let Some(before) = used {
                if is_parent && ends_with_pub(before) {
                    continue;
                }
                code[start..].find(';')
            } else if root == "crate::" && !before.ends_with(|c| c == ':' || is_part_of_name(c)) {
                code[start..].find(|c| c != ':' && !is_part_of_name(c))
            } else {
                continue;
            };
            expand("", &code[start..length.map_or(code.len(), |length| start + length)], &mut paths);
        }
    }
    paths
}

fn is_part_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether code ends with `pub`, or with the likes of `pub(crate)`.
fn ends_with_pub(code: &str) -> bool {
    let word = code.trim_end().rsplit([' ', '\n']).next().unwrap_or_default();
    word == "pub" || word.starts_with("pub(")
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
    use super::{circles, describe, paths};

    fn imports(files: &[(&str, &str)]) -> super::Imports {
        super::imports(&files.iter().map(|(file, text)| ((*file).into(), (*text).into())).collect())
    }

    /// Imports of one module.
    fn imports_of(module: &str, files: &[(&str, &str)]) -> Vec<String> {
        imports(files).remove(module).into_iter().flatten().collect()
    }

    #[test]
    fn circles_are_found_and_described() {
        let (lib, c) = (("lib.rs", "mod a;\nmod b;\nmod c;"), ("c.rs", "use super::a::A;"));
        let two = imports(&[lib, ("a.rs", "use crate::b::B;"), ("b.rs", "fn f() { crate::a::f(); }"), c]);
        let found = circles(&two);
        assert_eq!(found.len(), 1);
        let expected = "src: 2 modules import one another in a circle\n  \
                        crate::a imports crate::b\n  crate::b imports crate::a";
        assert_eq!(describe("src", &found[0], &two), expected);
        let three = imports(&[lib, ("a.rs", "use crate::b;"), ("b.rs", "use crate::c::C;"), c]);
        assert_eq!(circles(&three).iter().map(std::collections::BTreeSet::len).collect::<Vec<_>>(), [3]);
        assert!(circles(&imports(&[("a.rs", "use crate::b;"), ("b.rs", "use crate::c::C;"), ("c.rs", "")])).is_empty());
    }

    #[test]
    fn groups_are_taken_apart() {
        let uses = "use super::{\n    a::{A, B},\n    b::{self, c::C as Other},\n    d,\n};";
        let others = [("m/mod.rs", ""), ("m/a.rs", ""), ("m/b/mod.rs", ""), ("m/b/c.rs", ""), ("m/d.rs", "")];
        let texts = [&others[..], &[("m/user.rs", uses)]].concat();
        let expected = ["crate::m::a", "crate::m::b", "crate::m::b::c", "crate::m::d"];
        assert_eq!(imports_of("crate::m::user", &texts), expected);
    }

    #[test]
    fn comments_unit_tests_and_other_crates_are_ignored() {
        let text = "// use crate::b::B;\n#[cfg(test)]\nmod tests {\n    use crate::b::B;\n}\n";
        assert!(imports_of("crate::a", &[("a.rs", text), ("b.rs", "")]).is_empty());
        let code = "use std::fs;\nuse crates::x;\nfn f() { reuse crate_::y; crate::z::f::<u8>() }";
        assert_eq!(paths(code, false), ["crate::z::f::"]);
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
}
