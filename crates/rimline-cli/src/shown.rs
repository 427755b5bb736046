//! Text that may hold names from files, made fit for a terminal: what would steer it is shown as an escape instead.

use std::fmt::{self, Display, Formatter, Write};

use rimline::gltf::{AnimationInfo, Asset};

/// One line, whatever the text holds.
pub(crate) struct Line<T>(pub(crate) T);

/// Text whose line breaks are meant.
pub(crate) struct Text<T>(pub(crate) T);

impl<T: Display> Display for Line<T> {
    fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
        write!(Escaper { to, keeps_lines: false }, "{}", self.0)
    }
}

impl<T: Display> Display for Text<T> {
    fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
        write!(Escaper { to, keeps_lines: true }, "{}", self.0)
    }
}

struct Escaper<'a, 'b> {
    to: &'a mut Formatter<'b>,
    keeps_lines: bool,
}

impl Write for Escaper<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let is_escaped = |c: char| steers(c) && !(self.keeps_lines && c == '\n');
        let mut rest = text;
        while let Some((at, c)) = rest.char_indices().find(|&(_, c)| is_escaped(c)) {
            // JSON has the same escapes, so JSON stays JSON.
            write!(self.to, "{}\\u{:04x}", &rest[..at], u32::from(c))?;
            rest = &rest[at + c.len_utf8()..];
        }
        self.to.write_str(rest)
    }
}

/// Control characters, and those that turn the direction of text around or break lines.
fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

pub(crate) fn listed_animations(asset: &Asset) -> String {
    format!("the file has {}", listed("animation", asset.animations().iter().map(|info| info.name.as_deref())))
}

/// Lists what there is of a kind: `2 lights: 0 (without a name), 1 `sun``.
pub(crate) fn listed<'a>(kind: &str, names: impl ExactSizeIterator<Item = Option<&'a str>>) -> String {
    const SHOWN: usize = 20;
    let count = names.len();
    let (plural, more) = (if count == 1 { "" } else { "s" }, if count > SHOWN { ", …" } else { "" });
    if count == 0 {
        return "none".into();
    }
    let shown: Vec<String> = names.take(SHOWN).enumerate().map(|(index, name)| numbered(index, name)).collect();
    format!("{count} {kind}{plural}: {}{more}", shown.join(", "))
}

fn numbered(index: usize, name: Option<&str>) -> String {
    name.map_or_else(|| format!("{index} (without a name)"), |name| format!("{index} `{name}`"))
}

/// An animation's number, and its name if it has one.
pub(crate) fn animation_name(index: usize, info: &AnimationInfo) -> String {
    numbered(index, info.name.as_deref())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_shown() {
        let hostile = "a\x1b[2J\u{9b}31mb\r\nc\x07\u{202e}d\x7f é";
        assert_eq!(Line(hostile).to_string(), r"a\u001b[2J\u009b31mb\u000d\u000ac\u0007\u202ed\u007f é");
        assert_eq!(Text("a\nb\tc").to_string(), "a\nb\\u0009c");
    }

    #[test]
    fn json_stays_json() {
        let value = serde_json::json!({ "name": "\u{9b}\x1b\u{202e}\"\n" });
        let shown = Text(format!("{value:#}")).to_string();
        assert!(!shown.contains(|c: char| steers(c) && c != '\n'), "{shown}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).ok(), Some(value));
    }

    #[test]
    fn numbers_and_names() {
        assert_eq!(listed("light", [].into_iter()), "none");
        assert_eq!(listed("light", [Some("sun")].into_iter()), "1 light: 0 `sun`");
        assert_eq!(listed("light", [None, Some("sun")].into_iter()), "2 lights: 0 (without a name), 1 `sun`");
        let many = listed("light", vec![None; 30].into_iter());
        assert!(many.starts_with("30 lights: 0 ") && many.ends_with("19 (without a name), …"), "{many}");
    }
}
