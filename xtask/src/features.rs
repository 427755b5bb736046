//! What a user of the library alone compiles.

use crate::process;

/// Dependencies that only the command may have.
const OF_THE_COMMAND: [&str; 8] =
    ["clap", "epaint_default_fonts", "indicatif", "num-bigint", "png", "resvg", "rimline-measure", "zip"];

pub(crate) fn library_alone() -> Result<(), String> {
    process::run(&mut process::cargo(["check", "--package", "rimline", "--lib", "--no-default-features"]))
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
    let found = forbidden(&tree);
    if found.is_empty() { Ok(()) } else { Err(format!("it depends on {}", found.join(", "))) }
}

/// The command's dependencies in a list of packages, one `NAME VERSION` a line.
fn forbidden(tree: &str) -> Vec<&'static str> {
    let names: Vec<_> = tree.lines().filter_map(|line| line.split_whitespace().next()).collect();
    OF_THE_COMMAND.into_iter().filter(|name| names.contains(name)).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn dependencies_are_found_by_their_whole_name() {
        assert_eq!(super::forbidden("rimline v0.1.0 (here)\nwgpu v30.0.1\nclap_lex v1.0.0 (*)\n"), [""; 0]);
        assert_eq!(super::forbidden("wgpu v30.0.1\npng v0.18.0\nclap v4.5.0 (*)\n"), ["clap", "png"]);
    }
}
