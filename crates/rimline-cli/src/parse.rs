//! The command line as it is given, before its options check what is theirs.

#[cfg(test)]
mod ranges;

use std::ffi::{OsStr, OsString};

use clap::CommandFactory;

use crate::args::Cli;

/// Joins an option with a value that begins as a negative number does: `--dangling -1,3` becomes `--dangling=-1,3`. clap
/// would look for an option `-1`, and could not say what is wrong with the value. The first argument is the program's name.
pub(crate) fn joined(arguments: Vec<OsString>) -> Vec<OsString> {
    // The definitions of all commands take longer to make than a small model takes.
    if !arguments.iter().any(|argument| is_negative(argument)) {
        return arguments;
    }
    let cli = Cli::command();
    // `-q` may come first.
    let mut names = arguments.iter().skip(1).skip_while(|argument| argument.as_encoded_bytes().starts_with(b"-"));
    let Some(command) = names.next().and_then(|name| cli.find_subcommand(name)) else { return arguments };
    let takes_value = |argument: &OsString| {
        let Some(name) = argument.to_str().and_then(|argument| argument.strip_prefix("--")) else { return false };
        command.get_arguments().any(|option| {
            let names = option.get_long_and_visible_aliases().unwrap_or_default();
            option.get_action().takes_values() && names.contains(&name)
        })
    };
    let mut joined: Vec<OsString> = Vec::with_capacity(arguments.len());
    let mut are_options = true;
    for argument in arguments {
        are_options &= argument != "--";
        match joined.last_mut().filter(|last| are_options && is_negative(&argument) && takes_value(last)) {
            Some(option) => {
                option.push("=");
                option.push(argument);
            }
            None => joined.push(argument),
        }
    }
    joined
}

/// Whether it begins as a negative number does.
fn is_negative(argument: &OsStr) -> bool {
    let Some(number) = argument.as_encoded_bytes().strip_prefix(b"-") else { return false };
    let is_named = |name: &[u8]| number.get(..name.len()).is_some_and(|start| start.eq_ignore_ascii_case(name));
    number.first().is_some_and(|first| first.is_ascii_digit() || *first == b'.') || is_named(b"inf") || is_named(b"nan")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_values_stay_with_their_options() {
        let joined = |line: &str| {
            let arguments = joined(line.split(' ').map(OsString::from).collect());
            arguments.iter().map(|argument| argument.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(joined("rimline shadow a --dangling -1,3 --json"), "rimline shadow a --dangling=-1,3 --json");
        assert_eq!(joined("rimline shadow a --near -.5"), "rimline shadow a --near=-.5");
        assert_eq!(joined("rimline -q bench --scene -1"), "rimline -q bench --scene=-1");
        assert_eq!(joined("rimline shadow a --samples -Inf"), "rimline shadow a --samples=-Inf");
        for line in [
            "rimline",
            "rimline nothing --near -1",
            // A flag, an option that is next, a value that has its option, and no options any more.
            "rimline shadow --json -1",
            "rimline shadow --dangling --json",
            "rimline shadow --near=-1 -2",
            "rimline shadow -- --near -1",
            "rimline shadow --nothing -1",
        ] {
            assert_eq!(joined(line), line);
        }
    }
}
