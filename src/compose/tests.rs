//! The composer against small files.

use std::collections::{BTreeMap, BTreeSet};

use super::*;
use crate::stages::{DRAWN, FILES, STAGES};

const SMALL: [(&str, &str); 6] = [
    (
        "main",
        "// Head.\n\n#import one\n#import other\n\n// Adds.\n@compute @workgroup_size(64)\nfn main() {\n  let b = a() + S(1u).left;\n}\n",
    ),
    (
        "one",
        "// One.\n#import other\n\nfn a() -> u32 {\n  return LIMIT;\n}\n\nfn left() {\n  unused();\n}\n\nstruct S {\n  left: u32,\n}\n",
    ),
    (
        "other",
        "#import one\n#if WIDE\nconst LIMIT: u32 = 2u;\n#else\nconst LIMIT: u32 = 1u;\n#endif\n\n@group(0) @binding(1) var<storage, read_write> words: array<u32>;\nvar<private> state: u32;\n\n@compute @workgroup_size(1)\nfn elsewhere() {\n  words[0] = state;\n}\n",
    ),
    ("twice", "#import one\n@vertex\nfn a() {\n}\n"),
    ("open", "@vertex\nfn a() {\n"),
    ("odd", "#include one\n"),
];

fn read(name: &str) -> Option<&'static str> {
    SMALL.iter().find(|(file, _)| *file == name).map(|&(_, text)| text)
}

fn composed(file: &'static str, flags: &[&str], further: &str) -> Result<String, String> {
    compose(file, flags, &["main", "x"], further, &read).map(|composed| composed.wgsl)
}

#[test]
fn a_module_has_what_is_reached_and_no_more() {
    let entry = "// Adds.\n@compute @workgroup_size(64)\nfn main() {\n  let b = a() + S(1u).left;\n}\n";
    let of_one = "fn a() -> u32 {\n  return LIMIT;\n}\nstruct S {\n  left: u32,\n}\n";
    // `left` is a member here, and no call. The entry point of another file is none of this module.
    assert_eq!(composed("main", &[], "").as_deref(), Ok(&*format!("const LIMIT: u32 = 1u;\n{of_one}{entry}")));
    assert_eq!(composed("main", &["WIDE"], "").as_deref(), Ok(&*format!("const LIMIT: u32 = 2u;\n{of_one}{entry}")));
}

/// A file may have several stages.
#[test]
fn a_module_has_the_compute_entry_points_of_its_stage() {
    let text = "@compute @workgroup_size(1)\nfn x() {}\n@compute @workgroup_size(1)\nfn y() {}\n@fragment\nfn z() {}\n";
    let found =
        |entry_points: &[&str]| compose("x", &[], entry_points, "", &|_: &str| Some(text)).map(|found| found.wgsl);
    assert_eq!(found(&["y"]).as_deref(), Ok("@compute @workgroup_size(1)\nfn y() {}\n@fragment\nfn z() {}\n"));
    assert_eq!(found(&["x", "y"]).as_deref(), Ok(text));
}

#[test]
fn what_a_caller_names_is_kept() {
    let wgsl = composed("main", &[], "fn more() { words[state]; }").expect("valid files");
    assert!(wgsl.contains("@group(0) @binding(1) var<storage, read_write> words"), "{wgsl}");
    assert!(wgsl.contains("var<private> state") && !wgsl.contains("elsewhere"), "{wgsl}");
}

/// A device refuses a constant that a module does not have, and so a name that is spelt wrong.
#[test]
fn constants_that_a_pipeline_may_set_are_kept() {
    let text = "const MOST: u32 = 2u;\noverride LEAST: u32 = MOST;\noverride WIDE: bool = false;\nconst FEW = 1;\n@vertex\nfn x() {}\n";
    let found = compose("x", &[], &["x"], "", &|_: &str| Some(text)).expect("valid text");
    assert_eq!(found.wgsl, text.replace("const FEW = 1;\n", ""));
}

#[test]
fn lines_are_found_by_file() {
    let module = compose("main", &["WIDE"], &["main"], "", &read).expect("valid files");
    let line = 1 + module.wgsl.lines().position(|line| line.contains("return LIMIT")).expect("it is reached");
    assert_eq!(module.located(line, "no"), "wgsl/one.wgsl:5: no");
    assert_eq!(module.located(1, "no"), "wgsl/other.wgsl:3: no");
    assert_eq!(module.located(0, "no"), "no");
    assert_eq!(module.located(1000, "no"), "no");
    assert_eq!(module.origins.len(), module.wgsl.lines().count());
}

#[test]
fn wrong_files_are_named() {
    for (file, message) in [
        ("none", "wgsl/none.wgsl: there is no such file"),
        ("twice", "wgsl/twice.wgsl: a is declared in one too"),
        ("open", "wgsl/open.wgsl: the end of a is missing"),
        ("odd", "wgsl/odd.wgsl:1: no such directive: #include one"),
    ] {
        assert_eq!(composed(file, &[], ""), Err(message.to_owned()));
    }
    for (text, message) in [
        ("#else", "wgsl/x.wgsl:1: no #if before: #else"),
        ("const A = 1;\n#endif", "wgsl/x.wgsl:2: no #if before: #endif"),
        ("#if A", "wgsl/x.wgsl: the end of #if is missing"),
    ] {
        let found = compose("x", &[], &["x"], "", &|_: &str| Some(text));
        assert_eq!(found, Err(message.to_owned()));
    }
}

#[test]
fn conditions_may_lie_in_each_other() {
    let text = "#if A\n#if B\nconst X = 1;\n#else\nconst X = 2;\n#endif\n#else\nconst X = 3;\n#endif\n@vertex\nfn x() { X; }\n";
    for (flags, value) in [(&["A", "B"][..], 1), (&["A"], 2), (&["B"], 3), (&[], 3)] {
        let found = compose("x", flags, &["x"], "", &|_: &str| Some(text)).expect("valid text");
        assert!(found.wgsl.starts_with(&format!("const X = {value};\n")), "{flags:?}: {}", found.wgsl);
    }
}

#[test]
fn every_stage_composes() {
    for stage in STAGES.iter().chain(DRAWN) {
        let module = stage.composed().unwrap_or_else(|message| panic!("{message}"));
        for entry_point in stage.entry_points {
            assert!(module.wgsl.contains(&format!("fn {entry_point}(")), "{}: {entry_point}", stage.module);
        }
    }
}

#[test]
fn every_compute_entry_point_is_of_a_stage() {
    for &(file, text) in FILES {
        let is_of_stage = |name| STAGES.iter().any(|stage| stage.file == file && stage.entry_points.contains(&name));
        for item in whole(file, text).1.iter().filter(|item| item.entry == Some("compute")) {
            assert!(is_of_stage(item.name), "{file}: {}", item.name);
        }
    }
}

/// The items and imports of a file, with both sides of each `#if`.
fn whole(file: &'static str, text: &str) -> (Vec<&'static str>, Vec<Item>) {
    let lines = text.lines().filter(|line| !["#if", "#else", "#endif"].iter().any(|start| line.starts_with(start)));
    parse(file, lines.collect::<Vec<_>>().join("\n").leak(), &[]).unwrap_or_else(|message| panic!("{message}"))
}

/// The names that an item of a file takes from others: what it uses, but for its parameters and variables.
fn taken_from_others(item: &Item) -> BTreeSet<&str> {
    let text: Vec<_> = item.lines.iter().map(|(_, line)| line.split("//").next().unwrap_or_default()).collect();
    let text = text.join("\n");
    let found = words(&text);
    let is_local = |pair: &[Word<'_>]| matches!(pair[0].text, "let" | "var" | "const");
    let signature = text.split('{').next().unwrap_or_default();
    let local: BTreeSet<_> = found.windows(2).filter(|pair| is_local(pair)).map(|pair| pair[1].text).collect();
    let parameters: BTreeSet<_> =
        words(signature).into_iter().filter(|word| word.after == ':').map(|word| word.text).collect();
    let uses = item.uses.iter().copied();
    uses.filter(|name| *name != item.name && !local.contains(name) && !parameters.contains(name)).collect()
}

/// The names that a file has from importing `file`.
fn given<'a>(
    file: &str,
    declared: &BTreeMap<&str, BTreeSet<&'a str>>,
    imports: &BTreeMap<&str, Vec<&str>>,
) -> BTreeSet<&'a str> {
    let mut names = declared.get(file).cloned().unwrap_or_default();
    if file.starts_with("interface/") {
        names.extend(imports[file].iter().flat_map(|import| given(import, declared, imports)));
    }
    names
}

/// The names in the paragraph `Expects:` of a file's head, which is what the importing file declares.
fn expected(text: &str) -> BTreeSet<&str> {
    let head =
        text.lines().take_while(|line| line.starts_with("//")).skip_while(|line| !line.starts_with("// Expects:"));
    let names = head.flat_map(|line| line.split('`').skip(1).step_by(2));
    names.filter_map(|name| name.split('(').next()).collect()
}

/// A file can be read alone: each name that it does not declare comes from a file that it imports itself, or is named in its
/// head. It imports nothing that it does not use.
#[test]
fn files_import_what_they_use() {
    let parsed: Vec<_> = FILES.iter().map(|&(file, text)| (file, text, whole(file, text))).collect();
    let declared: BTreeMap<_, BTreeSet<_>> =
        parsed.iter().map(|(file, _, (_, items))| (*file, items.iter().map(|item| item.name).collect())).collect();
    let imports: BTreeMap<_, _> = parsed.iter().map(|(file, _, (imports, _))| (*file, imports.clone())).collect();
    let everything: BTreeSet<_> = declared.values().flatten().copied().collect();
    let mut wrong = Vec::new();
    for (file, text, (file_imports, items)) in &parsed {
        let used: BTreeSet<_> =
            items.iter().flat_map(taken_from_others).filter(|name| everything.contains(name)).collect();
        let declared_here = &declared[file];
        let mut missing: BTreeSet<_> = used.difference(declared_here).copied().collect();
        for import in file_imports {
            let given = given(import, &declared, &imports);
            let takes_nothing =
                used.is_disjoint(&given) && !file.starts_with("interface/") && *import != "deform/displace";
            if takes_nothing {
                wrong.push(format!("{file} uses nothing of {import}"));
            }
            missing.retain(|name| !given.contains(name));
        }
        let expected = expected(text);
        if missing != expected {
            wrong.push(format!("{file} takes {missing:?} from nowhere, and expects {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
