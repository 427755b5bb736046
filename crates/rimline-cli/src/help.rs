//! Help texts with lines of their own.

/// A help text with examples and tables as they are. clap breaks the lines of every other text, which would make examples
/// that cannot be pasted.
pub(crate) fn verbatim(examples: &str) -> String {
    format!("{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{{all-args}}\n\n{examples}{{after-help}}")
}
