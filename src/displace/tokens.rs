//! Bounds on the tokens of a displacement, checked before naga reads it. naga's parser and evaluator recurse, and they
//! allocate what an array's type says. Deep or huge source would end the process there.

use std::collections::HashMap;
use std::ops::Range;

use super::DisplaceError;
use super::bounds::{MAX_ARRAY_ELEMENTS, MAX_DECLARATIONS, MAX_EXPANDED, MAX_NESTING, MAX_SOURCE_BYTES, too_large};

/// A word (identifier or number) or a single character, and its line from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Token<'a> {
    text: &'a str,
    line: u32,
}

/// Checks size, nesting, declarations, array lengths and constants.
pub(super) fn check(source: &str) -> Result<(), DisplaceError> {
    if source.len() > MAX_SOURCE_BYTES {
        return Err(too_large(1, "bytes of source", source.len() as u64, MAX_SOURCE_BYTES as u64));
    }
    let tokens = tokens(source);
    check_directives(&tokens)?;
    check_nesting(&tokens)?;
    check_constants(&tokens, &check_arrays(&tokens)?)
}

fn tokens(source: &str) -> Vec<Token<'_>> {
    let (mut tokens, mut line) = (Vec::new(), 1);
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find(ends_line).unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if is_word(first) {
            rest.find(|c| !(is_word(c) || c == '.' && first.is_ascii_digit())).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        let (text, after) = rest.split_at(length);
        if !text.starts_with("//") && !text.starts_with("/*") && !is_blank(first) {
            tokens.push(Token { text, line });
        }
        line += text.matches('\n').count() as u32;
        rest = after;
    }
    tokens
}

/// Whether a line comment of naga ends here.
fn ends_line(c: char) -> bool {
    matches!(c, '\n'..='\r' | '\u{85}' | '\u{2028}' | '\u{2029}')
}

/// Whether it is blank space for naga.
fn is_blank(c: char) -> bool {
    ends_line(c) || matches!(c, ' ' | '\t' | '\u{200e}' | '\u{200f}')
}

/// Whether it may be in a word. naga refuses some of those beyond ASCII.
fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || !c.is_ascii() && !is_blank(c)
}

/// The length of the block comment at the start of `text`. Block comments may be nested.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    let bytes = text.as_bytes();
    while at < bytes.len() {
        match bytes.get(at..at + 2) {
            Some(b"/*") => (depth, at) = (depth + 1, at + 2),
            Some(b"*/") => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    // Only ASCII characters are compared, so this is the end of a character.
    at.min(bytes.len())
}

/// Refuses `enable NAME;`, which devices refuse unless they were opened with what it names. `enable` is a keyword, so it
/// names nothing else.
fn check_directives(tokens: &[Token<'_>]) -> Result<(), DisplaceError> {
    let Some(at) = tokens.iter().position(|token| token.text == "enable") else { return Ok(()) };
    let names = tokens[at + 1..].iter().take_while(|token| token.text != ";").take(MOST_NAMES);
    let names: Vec<String> = names.map(|token| token.text.chars().take(LONGEST_NAME).collect()).collect();
    Err(DisplaceError::Enable { line: tokens[at].line, names: names.concat().replace(',', ", ") })
}

/// Limits on the part of a directive that a message shows: tokens, and characters of each.
const MOST_NAMES: usize = 16;
const LONGEST_NAME: usize = 40;

/// Nesting at a token: open brackets, the operators since the last separator in each, and the `else` of a chain.
#[derive(Clone, Copy, Default)]
struct Level {
    operators: u64,
    elses: u64,
}

fn check_nesting(tokens: &[Token<'_>]) -> Result<(), DisplaceError> {
    let mut open = vec![Level::default()];
    // The nesting outside the innermost bracket.
    let mut outside = 0;
    let mut declarations = 0;
    for (at, token) in tokens.iter().enumerate() {
        let top = open.len() - 1;
        let is_outermost = top == 0;
        match token.text {
            "(" | "[" | "{" => {
                // A bracket counts as an operator: `a[0][0]` nests like `a + 0 + 0`.
                open[top].operators += u64::from(token.text != "{");
                outside += 1 + open[top].operators + open[top].elses;
                open.push(Level::default());
            }
            ")" | "]" | "}" => {
                if !is_outermost {
                    open.pop();
                }
                let level = &mut open[top.saturating_sub(1)];
                if !is_outermost {
                    outside -= 1 + level.operators + level.elses;
                }
                if token.text == "}" {
                    level.operators = 0;
                    if tokens.get(at + 1).is_none_or(|next| next.text != "else") {
                        level.elses = 0;
                    }
                    declarations += u64::from(top <= 1);
                }
            }
            ";" => {
                open[top] = Level::default();
                declarations += u64::from(is_outermost);
            }
            "," => open[top].operators = 0,
            "else" => open[top].elses += 1,
            "." | "+" | "-" | "*" | "/" | "%" | "&" | "|" | "^" | "!" | "~" | "<" | ">" | "=" => {
                open[top].operators += 1;
            }
            _ => {}
        }
        let level = open[open.len() - 1];
        let depth = outside + level.operators + level.elses;
        if depth > MAX_NESTING {
            return Err(too_large(token.line, "brackets and operators within each other", depth, MAX_NESTING));
        }
        if declarations > MAX_DECLARATIONS {
            return Err(too_large(token.line, "declarations", declarations, MAX_DECLARATIONS));
        }
    }
    Ok(())
}

/// Checks each `array<T, N>`. naga makes a list of N elements for a constant of this type, four bytes each: about a
/// sixteenth of what it takes for a token. Returns what each token counts.
fn check_arrays(tokens: &[Token<'_>]) -> Result<Vec<u64>, DisplaceError> {
    let mut counts = vec![1; tokens.len()];
    let mut lengths = Product { all: tokens, left: MOST_LEAVES };
    for (at, pair) in tokens.windows(2).enumerate() {
        if pair[0].text == "array" && pair[1].text == "<" {
            let count = count_of_array(&tokens[at + 2..]);
            let most = lengths.of(count, 0);
            if most > MAX_ARRAY_ELEMENTS {
                let line = pair[0].line;
                if most == u64::MAX {
                    return Err(DisplaceError::ArrayLength { line });
                }
                return Err(too_large(line, "possible elements of an array", most, MAX_ARRAY_ELEMENTS));
            }
            counts[at] += most / 16;
        }
    }
    Ok(counts)
}

/// The tokens of the second template argument. An array of runtime size has none.
fn count_of_array<'a, 'b>(tokens: &'b [Token<'a>]) -> &'b [Token<'a>] {
    let (mut depth, mut begin) = (0_usize, tokens.len());
    for (at, token) in tokens.iter().enumerate() {
        let is_next = |text: &str| tokens.get(at + 1).is_some_and(|next| next.text == text);
        match token.text {
            // `<<` is a shift.
            "<" if is_next("<") || (at > 0 && tokens[at - 1].text == "<") => {}
            "<" | "(" | "[" => depth += 1,
            ">" | ")" | "]" if depth == 0 => return tokens.get(begin..at).unwrap_or_default(),
            ">" | ")" | "]" => depth -= 1,
            "," if depth == 0 => begin = at + 1,
            ";" | "{" | "}" => break,
            _ => {}
        }
    }
    &[]
}

/// The largest number of tokens in the lengths of all arrays, together with the constants that they name.
const MOST_LEAVES: u32 = 4096;

/// An upper bound of a sum or product of positive numbers and constants: the product of all leaves, each increased by
/// one. Everything else counts as infinite.
struct Product<'a, 'b> {
    all: &'b [Token<'a>],
    /// How many more tokens may be read. Constants may name further constants.
    left: u32,
}

impl Product<'_, '_> {
    fn of(&mut self, expression: &[Token<'_>], depth: u32) -> u64 {
        let mut most = 1_u64;
        for token in expression {
            if self.left == 0 {
                return u64::MAX;
            }
            self.left -= 1;
            let value = match token.text {
                // An expression of one leaf is that leaf.
                "+" | "*" | "-" | "/" | "%" | "(" | ")" | "," => continue,
                text if text.starts_with(|c: char| c.is_ascii_digit()) => number(text),
                name if is_word(name.chars().next().unwrap_or(' ')) && depth < 8 => {
                    initialiser(self.all, name).map_or(u64::MAX, |value| self.of(value, depth + 1))
                }
                _ => u64::MAX,
            };
            let extra = u64::from(expression.len() > 1);
            most = most.saturating_mul(value.saturating_add(extra));
        }
        most
    }
}

fn number(text: &str) -> u64 {
    let text = text.trim_end_matches(['u', 'i']);
    match text.strip_prefix("0x").or(text.strip_prefix("0X")) {
        Some(digits) => u64::from_str_radix(digits, 16),
        None => text.parse(),
    }
    .unwrap_or(u64::MAX)
}

/// The expression of `const name = …;`. The last declaration would be the one that matters, but a name is declared once
/// in a scope.
fn initialiser<'a, 'b>(all: &'b [Token<'a>], name: &str) -> Option<&'b [Token<'a>]> {
    // A pipeline may set an override to another value. Nobody sets those of a displacement.
    let begins = |pair: &[Token<'_>]| matches!(pair[0].text, "const" | "override") && pair[1].text == name;
    let mut matches = all.windows(2).enumerate().filter(|(_, pair)| begins(pair));
    let (at, _) = matches.next()?;
    if matches.next().is_some() {
        return None;
    }
    let statement = all[at..].split(|token| token.text == ";").next()?;
    let equals = statement.iter().position(|token| token.text == "=")?;
    statement.get(equals + 1..)
}

/// Counts the tokens with names of constants and types replaced by what they stand for. `const B = array(A, A);` doubles
/// a constant, so a few lines can name billions of elements.
fn check_constants(tokens: &[Token<'_>], counts: &[u64]) -> Result<(), DisplaceError> {
    let (mut globals, mut depth, mut begin) = (HashMap::new(), 0_usize, 0);
    for (at, token) in tokens.iter().enumerate() {
        match token.text {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "const" | "alias" | "struct" if depth == 0 => begin = at + 1,
            _ => {}
        }
        if depth == 0 && begin > 0 && matches!(token.text, ";" | "}") {
            globals.insert(tokens[begin].text, begin + 1..at);
            begin = 0;
        }
    }
    let mut expanded = Expanded { tokens, counts, globals, known: HashMap::new(), cyclic: None };
    let (mut all, mut depth) = (0_u64, 0_usize);
    // The counts of the function's constants.
    let mut locals: HashMap<&str, u64> = HashMap::new();
    // The constant that is being declared in it, and its count so far.
    let mut declared: Option<(usize, u64)> = None;
    for (at, token) in tokens.iter().enumerate() {
        if at > 0 && tokens[at - 1].text == "const" {
            declared = (depth > 0).then_some((at, 0));
            continue;
        }
        let count = locals.get(token.text).copied().unwrap_or_else(|| expanded.of(at));
        all = all.saturating_add(count);
        if let Some(Token { text, line }) = expanded.cyclic {
            let name: String = text.chars().take(LONGEST_NAME).collect();
            let message = format!("declaration of `{name}` is cyclic");
            return Err(DisplaceError::Wgsl { line, column: 1, message });
        }
        if all > MAX_EXPANDED {
            return Err(too_large(token.line, "words and signs with constants written out", all, MAX_EXPANDED));
        }
        if let Some((_, sum)) = &mut declared {
            *sum = sum.saturating_add(count);
        }
        match token.text {
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    // Constants of a function end with it.
                    locals.clear();
                }
            }
            ";" => {
                if let Some((name, sum)) = declared.take() {
                    // A constant of a block does not hide the one of this name from what follows the block.
                    let known = locals.entry(tokens[name].text).or_insert_with(|| expanded.of(name));
                    *known = sum.max(*known);
                }
            }
            _ => {}
        }
    }
    Ok(())
}

struct Expanded<'a, 'b> {
    tokens: &'b [Token<'a>],
    /// The count of each token by itself.
    counts: &'b [u64],
    /// Constants and types outside functions, in any order, with the tokens that declare them.
    globals: HashMap<&'a str, Range<usize>>,
    /// The counts of those so far. `None` while one is counted.
    known: HashMap<&'a str, Option<u64>>,
    /// A name that needs itself. naga would refuse it, too.
    cyclic: Option<Token<'a>>,
}

impl Expanded<'_, '_> {
    fn of(&mut self, at: usize) -> u64 {
        let word = self.tokens[at].text;
        if let Some(&count) = self.known.get(word) {
            if count.is_none() {
                self.cyclic = Some(self.tokens[at]);
            }
            return count.unwrap_or(1);
        }
        let Some(declaration) = self.globals.get(word).cloned() else { return self.counts[at] };
        self.known.insert(word, None);
        let count = declaration.fold(0_u64, |sum, at| {
            let is_member = self.is_member(at);
            sum.saturating_add(if is_member { self.counts[at] } else { self.of(at) })
        });
        self.known.insert(word, Some(count));
        count
    }

    /// Whether a word of a constant, alias or structure names a member or an attribute. These are no constants or types.
    fn is_member(&self, at: usize) -> bool {
        let is = |token: Option<&Token<'_>>, text: &str| token.is_some_and(|token| token.text == text);
        let before = at.checked_sub(1).and_then(|at| self.tokens.get(at));
        is(before, ".") || is(before, "@") || is(self.tokens.get(at + 1), ":")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_numbers_are_single_steps() {
        let texts: Vec<_> = tokens("a/* x /* y */ z */+1.5e3 // (((\n.b").iter().map(|token| token.text).collect();
        assert_eq!(texts, ["a", "+", "1.5e3", ".", "b"]);
        assert_eq!(tokens("/* é\n").len(), 0);
        assert_eq!(tokens("é\n\n/*\n*/ü").last(), Some(&Token { text: "ü", line: 4 }));
    }

    #[test]
    fn array_lengths_are_bounded_from_above() {
        let most = |text: &str| {
            let all = tokens(text);
            let at = all.windows(2).position(|pair| pair[0].text == "array").expect("an array");
            Product { all: &all, left: MOST_LEAVES }.of(count_of_array(&all[at + 2..]), 0)
        };
        assert_eq!(most("var a: array<f32, 7>;"), 7);
        assert_eq!(most("var a: array<vec2<f32>, 0x10u>;"), 16);
        assert_eq!(most("var a: array<f32>;"), 1);
        assert_eq!(most("const N: u32 = 5; var a: array<array<f32, 3>, N>;"), 5);
        assert!(most("const N = 5; var a: array<f32, N * 3>;") >= 15);
        assert_eq!(most("var a: array<f32, 1 << 20>;"), u64::MAX);
        assert_eq!(most("const N = N; var a: array<f32, N>;"), u64::MAX);
        assert_eq!(most("const N = 1; fn f() { const N = 4000000000; var a: array<f32, N>; }"), u64::MAX);
    }
}
