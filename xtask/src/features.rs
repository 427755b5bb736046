//! Checks of the library alone: builds with each set of features, and dependencies.

use crate::process;
use crate::web::{self, WASM};

/// Dependencies that only the command may have.
const OF_THE_COMMAND: [&str; 8] =
    ["clap", "epaint_default_fonts", "indicatif", "num-bigint", "png", "resvg", "rimline-bench", "zip"];

/// Choices of the library's features.
const FEATURES: [&str; 5] = ["", "gltf", "gpu", "gltf,gpu", "default"];

/// The library builds with each of them, without a warning: no code is dead.
pub(crate) fn library_alone() -> Result<(), String> {
    FEATURES.iter().try_for_each(|features| {
        let mut check = process::cargo(["rustc", "--profile", "check", "--package", "rimline", "--lib"]);
        process::run(check.args(["--no-default-features", "--features", features, "--", "--deny", "warnings"]))
    })
}

/// Without the feature `gpu` the library brings no GPU library.
pub(crate) fn no_gpu_dependencies() -> Result<(), String> {
    let tree = ["tree", "--package", "rimline", "--edges", "normal", "--prefix", "none", "--format", "{p}"];
    let tree = process::output(process::cargo(tree).args(["--no-default-features", "--features", "gltf"]))?;
    let found = among(&["wgpu", "naga"], &tree);
    if found.is_empty() { Ok(()) } else { Err(format!("it depends on {}", found.join(", "))) }
}

/// The library compiles for browsers. Where the target is not installed, only its features are looked at.
pub(crate) fn library_for_wasm() -> Result<(), String> {
    if web::has_target()? {
        return process::run(&mut process::cargo(["check", "--package", "rimline", "--lib", "--target", WASM]));
    }
    let arguments = ["tree", "--package", "rimline", "--target", WASM, "--edges", "normal", "--prefix", "none"];
    let tree = process::output(process::cargo(arguments).args([
        "--no-default-features",
        "--features",
        "gpu",
        "--format",
        "{p} {f}",
    ]))?;
    naga_has_back_end(&tree)
}

/// naga leaves out `process_overrides`, which the library needs, unless it has a back end. On wasm32 wgpu asks for none.
fn naga_has_back_end(tree: &str) -> Result<(), String> {
    let naga = tree.lines().find(|line| line.starts_with("naga v")).ok_or("the library does not depend on naga")?;
    let features = naga.split_whitespace().nth(2).unwrap_or_default();
    let is_there = features.split(',').any(|feature| ["glsl-out", "hlsl-out", "msl-out", "spv-out"].contains(&feature));
    if is_there { Ok(()) } else { Err(format!("naga has no back end for {WASM}: its features are `{features}`")) }
}

/// The command builds without its measurements, as the demo has it.
pub(crate) fn command_without_bench() -> Result<(), String> {
    process::run(&mut process::cargo([
        "check",
        "--package",
        "rimline-cli",
        "--bin",
        "rimline",
        "--no-default-features",
    ]))?;
    let tree = ["tree", "--package", "rimline-cli", "--edges", "normal", "--prefix", "none", "--format", "{p}"];
    let found = among(
        &["plotters", "resvg", "epaint_default_fonts", "egui", "winit"],
        &process::output(process::cargo(tree).arg("--no-default-features"))?,
    );
    if found.is_empty() { Ok(()) } else { Err(format!("it depends on {}", found.join(", "))) }
}

pub(crate) fn no_command_dependencies() -> Result<(), String> {
    let tree = process::output(&mut process::cargo([
        "tree",
        "--package",
        "rimline",
        "--edges",
        "normal",
        "--prefix",
        "none",
        "--format",
        "{p}",
    ]))?;
    let found = among(&OF_THE_COMMAND, &tree);
    if found.is_empty() { Ok(()) } else { Err(format!("it depends on {}", found.join(", "))) }
}

/// Filters `packages` for names in a list with one `NAME VERSION` a line.
fn among<'a>(packages: &[&'a str], tree: &str) -> Vec<&'a str> {
    let names: Vec<_> = tree.lines().filter_map(|line| line.split_whitespace().next()).collect();
    packages.iter().copied().filter(|name| names.contains(name)).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_naga_without_a_back_end_is_found() {
        let tree = |features: &str| format!("glam v0.34.2 std\nnaga v30.0.1 {features}\nnaga-types v30.0.1 glsl-out\n");
        assert!(super::naga_has_back_end(&tree("default,glsl-out,wgsl-in")).is_ok());
        assert!(super::naga_has_back_end(&tree("default,wgsl-in,wgsl-out")).is_err());
        assert!(super::naga_has_back_end("naga-types v30.0.1 glsl-out\n").is_err());
    }

    #[test]
    fn dependencies_are_found_by_their_whole_name() {
        assert_eq!(
            super::among(&super::OF_THE_COMMAND, "rimline v0.1.0 (here)\nwgpu v30.0.1\nclap_lex v1.0.0 (*)\n"),
            [""; 0]
        );
        assert_eq!(
            super::among(&super::OF_THE_COMMAND, "wgpu v30.0.1\npng v0.18.0\nclap v4.5.0 (*)\n"),
            ["clap", "png"]
        );
    }
}
