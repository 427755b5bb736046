//! The matrix of tests and mutations.

use std::collections::BTreeSet;

use super::mutation::Mutation;

/// A test: its target, and its name there.
pub(super) type Test = (&'static str, String);

/// The tests that fail with a mutation, or why it could not be tried.
pub(super) type Outcome = Result<Vec<Test>, String>;

pub(super) fn outcome(outcome: &Outcome) -> String {
    match outcome.as_deref() {
        Ok([]) => "SURVIVED".into(),
        Ok(failed) => format!("killed by {}", failed.len()),
        Err(why) => format!("NOT TRIED, {why}"),
    }
}

/// The mutations with a number each, then a row for each test, with an `x` below the mutations that it notices.
pub(super) fn shown(tests: &[Test], columns: &[(&Mutation, Outcome)]) -> String {
    let legend = columns.iter().map(|(mutation, result)| format!("{}: {}", mutation.name, outcome(result)));
    let mut lines: Vec<_> = (1..).zip(legend).map(|(number, line)| format!("{number:3}  {line}")).collect();
    lines.push((1..=columns.len()).fold("\n".into(), |line, number| format!("{line}{number:3}")));
    // Tests, and programs that ended early or had to be ended.
    let failed = columns.iter().filter_map(|(_, result)| result.as_ref().ok()).flatten();
    let rows: BTreeSet<_> = tests.iter().chain(failed).collect();
    lines.extend(rows.into_iter().map(|test| {
        let is_noticed = |result: &Outcome| result.as_ref().is_ok_and(|failed| failed.contains(test));
        let marks: String = columns.iter().map(|(_, result)| if is_noticed(result) { "  x" } else { "  ." }).collect();
        format!("{marks}  {} {}", test.0.trim_start_matches("--test "), test.1)
    }));
    lines.join("\n") + "\n"
}

/// The names in the lists of failed tests that test programs print at their ends.
pub(super) fn failed(output: &str) -> Vec<String> {
    let (mut names, mut is_list) = (Vec::new(), false);
    for line in output.lines() {
        match line.strip_prefix("    ") {
            Some(name) if is_list => names.push(name.to_owned()),
            _ => is_list = line == "failures:" || (is_list && line.is_empty()),
        }
    }
    names
}

/// The names that test programs print when they are asked for a list.
pub(super) fn listed(output: &str) -> impl Iterator<Item = String> {
    let names = output.lines().filter_map(|line| line.strip_suffix(": test"));
    names.map(|name| name.split_once("] ").map_or(name, |(_kind, name)| name).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names come from the list at the end, not from what failed tests said before it.
    #[test]
    fn failed_tests_are_read() {
        let output = "test a::b ... FAILED\n\nfailures:\n\n---- a::b ----\nleft:\n    1\n\n\nfailures:\n    a::b\n    c d\n\n\
                      test result: FAILED. 1 passed; 2 failed;\n    x\n";
        assert_eq!(failed(output), ["a::b", "c d"]);
        assert!(failed("test a ... ok\n\ntest result: ok. 1 passed;\n").is_empty());
        let listed: Vec<_> = listed("adapter: x\n[gpu] a: b: test\nc::d: test\n\n2 tests, 0 benchmarks\n").collect();
        assert_eq!(listed, ["a: b", "c::d"]);
    }

    /// A row tells which mutations its test notices.
    #[test]
    fn rows_are_marked() {
        let [a, b] = ["a", "b"].map(|name| ("--lib", name.to_owned()));
        let mutations = super::super::mutation::all().expect("the list is well-formed");
        let outcomes = [vec![b.clone()], Vec::new()].map(Ok);
        let shown = shown(&[a, b], &mutations.iter().zip(outcomes).collect::<Vec<_>>());
        assert!(shown.ends_with(": SURVIVED\n\n  1  2\n  .  .  --lib a\n  x  .  --lib b\n"), "{shown}");
        assert!(shown.contains(": killed by 1\n"), "{shown}");
    }
}
