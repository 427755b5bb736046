//! Checks of the library alone: builds with each set of features, and dependencies.

use crate::process;
use crate::summary::Summary;
use crate::web::{self, WASM};

/// Dependencies that only the command may have.
const OF_THE_COMMAND: [&str; 8] =
    ["clap", "epaint_default_fonts", "indicatif", "num-bigint", "png", "resvg", "rimline-bench", "zip"];
/// Dependencies of the command's charts and windows.
const OF_CHARTS: [&str; 4] = ["resvg", "epaint_default_fonts", "egui", "winit"];

/// Choices of the library's features.
const FEATURES: [&str; 6] = ["", "gltf", "gpu", "gltf,gpu", "depth-map", "default"];

pub(crate) fn add(summary: &mut Summary) {
    let of_library = |arguments: &[&str]| tree("rimline", arguments);
    let cpu_alone = of_library(&["--no-default-features", "--features", "gltf"]);
    summary.check("the library builds with any of its features", library_alone());
    summary.check("the library without `gpu` has no GPU library", has_none(&["wgpu", "naga"], cpu_alone));
    summary.check("the library compiles for wasm32", library_for_wasm());
    summary.check("the command builds without `bench`, and without its charts", command_without_bench());
    summary.check("the library has none of the command's dependencies", has_none(&OF_THE_COMMAND, of_library(&[])));
}

/// The library builds with each of them, without a warning: no code is dead.
fn library_alone() -> Result<(), String> {
    FEATURES.iter().try_for_each(|features| {
        let mut check = process::cargo(["rustc", "--profile", "check", "--package", "rimline", "--lib"]);
        process::run(check.args(["--no-default-features", "--features", features, "--", "--deny", "warnings"]))
    })
}

/// The library compiles for browsers. Where the target is not installed, only its features are looked at.
fn library_for_wasm() -> Result<(), String> {
    if web::has_target()? {
        return process::run(&mut process::cargo(["check", "--package", "rimline", "--lib", "--target", WASM]));
    }
    naga_has_back_end(&tree("rimline", &["--target", WASM, "--no-default-features", "--features", "gpu"])?)
}

/// naga leaves out `process_overrides`, which the library needs, unless it has a back end. On wasm32 wgpu asks for none.
fn naga_has_back_end(tree: &str) -> Result<(), String> {
    let naga = tree.lines().find(|line| line.starts_with("naga v")).ok_or("the library does not depend on naga")?;
    let features = naga.split_whitespace().nth(2).unwrap_or_default();
    let is_there = features.split(',').any(|feature| ["glsl-out", "hlsl-out", "msl-out", "spv-out"].contains(&feature));
    if is_there { Ok(()) } else { Err(format!("naga has no back end for {WASM}: its features are `{features}`")) }
}

/// The command builds without its measurements, as the demo has it.
fn command_without_bench() -> Result<(), String> {
    let mut check = process::cargo(["check", "--package", "rimline-cli", "--bin", "rimline", "--no-default-features"]);
    process::run(&mut check)?;
    has_none(&OF_CHARTS, tree("rimline-cli", &["--no-default-features"]))
}

/// The dependencies of a package, a line each: name, version, features.
fn tree(package: &str, arguments: &[&str]) -> Result<String, String> {
    let all = ["tree", "--edges", "normal", "--prefix", "none", "--format", "{p} {f}", "--package", package];
    process::output(process::cargo(all).args(arguments))
}

/// None of these packages is among the dependencies.
fn has_none(packages: &[&str], tree: Result<String, String>) -> Result<(), String> {
    let tree = tree?;
    let names: Vec<_> = tree.lines().filter_map(|line| line.split_whitespace().next()).collect();
    if names.is_empty() {
        return Err("`cargo tree` lists no package".to_owned());
    }
    let found: Vec<_> = packages.iter().copied().filter(|name| names.contains(name)).collect();
    if found.is_empty() { Ok(()) } else { Err(format!("it depends on {}", found.join(", "))) }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::{FEATURES, OF_THE_COMMAND, has_none, naga_has_back_end};

    /// Each choice of the library's features that differs from the others in what is compiled.
    #[test]
    fn every_choice_of_features_is_built() {
        let manifest = include_str!("../../Cargo.toml");
        let section = manifest.split("\n[features]\n").nth(1).and_then(|rest| rest.split("\n[").next());
        let lines = section.expect("there are features").lines().filter_map(|line| line.split_once(" = "));
        let names = |list: &'static str| list.split('"').skip(1).step_by(2).filter(|name| !name.starts_with("dep:"));
        let implied: BTreeMap<&str, Vec<&str>> = lines.map(|(name, list)| (name, names(list).collect())).collect();
        let compiled = |mut left: Vec<&'static str>| {
            let mut all = BTreeSet::new();
            while let Some(name) = left.pop() {
                if all.insert(name) {
                    left.extend(&implied[name]);
                }
            }
            all.remove("default");
            all
        };
        let built = FEATURES.map(|features| compiled(features.split(',').filter(|name| !name.is_empty()).collect()));
        for choice in 0..1_u32 << implied.len() {
            let chosen = (0_u32..).zip(implied.keys()).filter(|&(bit, _)| choice >> bit & 1 == 1);
            let chosen = compiled(chosen.map(|(_, name)| *name).collect());
            assert!(built.contains(&chosen), "{chosen:?}");
        }
        assert_eq!(built.iter().collect::<BTreeSet<_>>().len(), built.len(), "a choice is built twice");
    }

    #[test]
    fn a_naga_without_a_back_end_is_found() {
        let tree = |features: &str| format!("glam v0.34.2 std\nnaga v30.0.1 {features}\nnaga-types v30.0.1 glsl-out\n");
        assert!(naga_has_back_end(&tree("default,glsl-out,wgsl-in")).is_ok());
        assert!(naga_has_back_end(&tree("default,wgsl-in,wgsl-out")).is_err());
        assert!(naga_has_back_end("naga-types v30.0.1 glsl-out\n").is_err());
    }

    #[test]
    fn dependencies_are_found_by_their_whole_name() {
        let found = |tree: &str| has_none(&OF_THE_COMMAND, Ok(tree.to_owned()));
        assert_eq!(found("rimline v0.1.0 (here)\nwgpu v30.0.1\nclap_lex v1.0.0 (*)\n"), Ok(()));
        let both = found("wgpu v30.0.1\npng v0.18.0\nclap v4.5.0 (*)\n");
        assert_eq!(both, Err("it depends on clap, png".to_owned()));
        assert!(found("\n").is_err());
    }
}
