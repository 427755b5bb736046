//! Font sizes of plots, and about how wide texts are in them.

/// Font sizes.
pub(super) const SMALL: f64 = 24.0;
pub(super) const NORMAL: f64 = 26.0;

/// About how wide a text is, a little more rather than less; fonts differ.
pub(super) fn text_width(text: &str, size: f64) -> i32 {
    let of = |c: char| match c {
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | 'I' | '.' | ',' | ':' | ';' | '\'' | '|' | ' ' | '(' | ')' | '-' => 0.34,
        'm' | 'w' | 'M' | 'W' | '—' | '…' => 0.92,
        'A'..='Z' => 0.7,
        _ => 0.61,
    };
    (size * text.chars().map(of).sum::<f64>()).ceil() as i32
}

/// The parts of a text that is broken between words where it is wider than `width`.
pub(super) fn wrapped(text: &str, size: f64, width: i32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
