//! Every numeric option of every subcommand refuses numbers that it is not meant for. The options are those of clap's own
//! definitions, so that a new one has to be listed here.

use std::any::TypeId;
use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Arg, CommandFactory, Parser as _};

use super::*;

/// A number of an option's value: the option, how the value is written with `{}` for the number, numbers that are valid, and
/// numbers that are refused. Numbers that every option refuses are not listed.
type Number = (&'static str, &'static str, &'static [&'static str], &'static [&'static str]);

/// No option takes these.
const NEVER: [&str; 9] =
    ["nan", "NaN", "inf", "-inf", "1e39", "-1e39", "x", "0x10", "99999999999999999999999999999999999999999"];

const ANY: &[&str] = &["0", "-1", "1e30", "-2.5"];
const POSITIVE: &[&str] = &["1", "0.5"];
const NOT_POSITIVE: &[&str] = &["0", "-1", "-0.5"];

const NUMBERS: &[Number] = &[
    ("weld-distance", "{}", &["0", "1e-6"], &["-1"]),
    ("light", "point:{},1,1", ANY, &[]),
    ("light", "dir:1,{},1", ANY, &[]),
    ("light", "hom:1,1,1,{}", &["0", "1", "0.5"], &[]),
    ("shadow light", "point:1,1,1,range={}", POSITIVE, NOT_POSITIVE),
    ("shadow light", "point:1,1,1,range=2,begin={}", &["0", "1"], &["-1", "3"]),
    ("shadow light", "point:1,1,1,range=2,exponent={}", &["0", "9"], &["-1", "1e30"]),
    ("shadow light", "point:1,1,1,intensity={}", &["0", "9"], &["-1", "1e30"]),
    ("shadow light", "point:1,1,1,color=1,{},1", &["0", "9"], &["-1", "1e30"]),
    ("shadow light", "point:1,1,1,radius={}", POSITIVE, &["0", "-1", "3e38"]),
    ("shadow light", "point:1,1,1,cone={},40", &["0", "40", "0.5"], &["-1", "41"]),
    ("shadow light", "point:1,1,1,cone=0,{}", &["90", "0.5"], &["0", "-1", "91"]),
    ("shadow light", "point:1,1,1,cone=1,2,target=1,{},1", ANY, &[]),
    ("eye", "{},2,3", ANY, &[]),
    ("target", "1,2,{}", ANY, &[]),
    ("fov", "{}", &["1", "179"], &["0", "-1", "180", "1e30"]),
    ("view", "{},0", &["0", "-360", "359.5"], &["361", "1e30"]),
    ("view", "0,{}", &["0", "-90", "89.5"], &["91", "1e30"]),
    ("crease", "{}", &["0", "180", "0.5"], &["-1", "181", "1e30"]),
    ("page", "{}x9", &["1", "20000", "0.5e1"], &["0", "-1", "20001"]),
    ("page", "9x{}", &["1", "20000"], &["0", "-1", "20001"]),
    ("page", "A{}", &["0", "5"], &["-1", "6", "4.5", "+4", "04"]),
    ("scale", "{}:1", &["1", "1e9", "0.01"], &["0", "-1", "1e10"]),
    ("scale", "1:{}", &["50", "1e9"], &["0", "-1", "1e10"]),
    ("dpi", "{}", &["10", "2400"], &["9", "-1", "2401", "1.5"]),
    ("size", "{}x4", &["1", "65536"], &["0", "-1", "65537", "4294967296"]),
    ("size", "4x{}", &["1", "65536"], &["0", "-1", "65537", "4294967296"]),
    ("orbit", "{}", &["0", "-360", "90.5", "3600"], &["3601", "1e30"]),
    ("near", "{}", POSITIVE, NOT_POSITIVE),
    ("lift", "{}", &["1e-6", "1", "1e30"], &["0", "-1", "2e30"]),
    ("ground", "{}", ANY, &[]),
    ("area", "rect:{},1", POSITIVE, &["0", "-1", "3e38"]),
    ("area", "rect:1,{}", POSITIVE, &["0", "-1", "3e38"]),
    ("area", "disc:{}", POSITIVE, &["0", "-1", "3e38"]),
    ("area", "sphere:{}", POSITIVE, &["0", "-1", "3e38"]),
    ("samples", "{}", &["1", "32"], &["0", "-1", "33", "1.5"]),
    ("from-depth", "{}", &["3", "4096"], &["0", "2", "-3", "4097", "1.5"]),
    ("detector", "differences={}", &["0", "1"], &["-0.1", "1.1"]),
    ("detector", "second={},1", &["0", "1"], &["-0.1", "1.1"]),
    ("detector", "second=0,{}", &["0", "1"], &["-0.1", "1.1"]),
    ("detector", "contours={}", &["0", "1"], &["-0.1", "1.1"]),
    ("dangling", "{},3", &["0", "1"], &["-1", "1.1"]),
    ("dangling", "0.5,{}", &["1", "64"], &["0", "-1", "65", "1.5"]),
    ("time", "{}", &["0", "-2", "1e9"], &["1e10", "-1e10"]),
    ("fps", "{}", &["0.001", "100000"], &["0", "-1", "1e6", "1e-40"]),
    ("turn", "{}", &["0", "-360", "36000"], &["36001", "-36001", "1e30"]),
    ("lines frames", "{}", &["1", "100000"], &["0", "-1", "100001", "1.5"]),
    ("film frames", "{}", &["1", "100000"], &["0", "-1", "100001", "1.5"]),
    ("shard", "{}/3", &["1", "3"], &["0", "-1", "4", "1.5"]),
    ("shard", "3/{}", &["3", "4294967295"], &["0", "-1", "2", "4294967296"]),
    ("seconds", "{}", &["0.5", "1e9"], &["0", "-1", "1e10", "1e-40"]),
    ("memory-limit", "{}", &["1", "18446744073709551615"], &["0", "-1", "1.5", "18446744073709551616"]),
    ("memory-limit", "{}GiB", &["1", "4"], &["0", "-1", "1.5", "17179869184"]),
    ("faces", "{}", &["1", "4194304"], &["0", "-1", "4194305", "99999999999", "1.5"]),
    ("meshes", "{},5", &["1", "16777216", "none"], &["0", "-1", "16777217", "1.5"]),
    ("casters", "{}", &["1", "100000", "none"], &["0", "-1", "100001", "1.5"]),
    ("scene-faces", "{}", &["1", "4194304"], &["0", "-1", "4194305", "1.5"]),
    ("lights", "8,{}", &["1", "1024"], &["0", "-1", "1025", "1.5"]),
    ("rounds", "{}", &["1", "1000"], &["0", "-1", "1001", "1.5"]),
    ("bench frames", "{}", &["0", "1000"], &["-1", "1001", "1.5"]),
];

/// Options whose values are words, though they may be digits.
const WORDS: [&str; 4] = ["animation", "classes", "device", "scenes"];

/// The error of clap for an option's value, or `None` if clap takes it. Tries the value once with `=` and once as an
/// argument of its own.
fn refused(command: &str, option: &str, value: &str) -> Option<ErrorKind> {
    let refusal = |arguments: &[String]| {
        let error = Cli::try_parse_from(joined(arguments.iter().map(OsString::from).collect())).err()?;
        matches!(error.kind(), ErrorKind::ValueValidation | ErrorKind::InvalidValue).then(|| error.kind())
    };
    let head = ["rimline".to_owned(), command.to_owned()];
    let [joined, apart] = [vec![format!("--{option}={value}")], vec![format!("--{option}"), value.to_owned()]];
    let [joined, apart] = [joined, apart].map(|tail| refusal(&[&head[..], &tail].concat()));
    assert_eq!(joined, apart, "{command} --{option} {value}");
    joined
}

/// Whether the option's values may be numbers: they are neither text, files nor one of a list.
fn is_numeric(option: &Arg) -> bool {
    let parser = option.get_value_parser();
    let is_text = [TypeId::of::<String>(), TypeId::of::<OsString>(), TypeId::of::<PathBuf>()]
        .iter()
        .any(|text| parser.type_id() == *text);
    option.get_action().takes_values() && !is_text && parser.possible_values().is_none()
}

#[test]
fn each_numeric_option_refuses_what_it_is_not_meant_for() {
    let cli = Cli::command();
    let mut tried = 0;
    for command in cli.get_subcommands() {
        for option in command.get_arguments().filter(|option| is_numeric(option)) {
            let (command, long) = (command.get_name(), option.get_long().expect("numbers have options"));
            if WORDS.contains(&long) {
                continue;
            }
            let is_of = |&&(option, ..): &&Number| match option.split_once(' ') {
                // Lights of shadows have more than those of other commands, and a film is one of shadows.
                Some(("shadow", option)) => option == long && ["shadow", "film"].contains(&command),
                Some((of, option)) => option == long && of == command,
                None => option == long,
            };
            let numbers: Vec<&Number> = NUMBERS.iter().filter(is_of).collect();
            assert!(!numbers.is_empty(), "{command} --{long}: say in this test which numbers it takes");
            for (_, written, good, bad) in numbers {
                for number in *good {
                    let value = written.replace("{}", number);
                    assert_eq!(refused(command, long, &value), None, "{command} --{long} {value} is refused");
                }
                for number in bad.iter().chain(&NEVER) {
                    let value = written.replace("{}", number);
                    assert!(refused(command, long, &value).is_some(), "{command} --{long} {value} is taken");
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 500, "only {tried} values were tried");
}
