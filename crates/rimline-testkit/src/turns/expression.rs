//! Whole numbers and heads of loops, as WGSL writes them.

use std::collections::BTreeMap;

type Names = BTreeMap<String, i64>;

/// The value of an expression of whole numbers, names, `+ - * /`, parentheses and calls that return what they are given.
/// Quotients are cut to whole numbers, as in WGSL.
pub(super) fn value(text: &str, names: &Names) -> Option<i64> {
    let mut tokens = tokens(text);
    tokens.reverse();
    let value = sum(&mut tokens, names)?;
    tokens.is_empty().then_some(value)
}

fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut joins = false;
    for c in text.chars() {
        let is_word = c.is_ascii_alphanumeric() || c == '_';
        match tokens.last_mut() {
            Some(last) if joins && is_word => last.push(c),
            _ if !c.is_whitespace() => tokens.push(c.to_string()),
            _ => {}
        }
        joins = is_word;
    }
    tokens
}

fn take(tokens: &mut Vec<String>, token: &str) -> bool {
    let found = tokens.last().is_some_and(|last| last == token);
    if found {
        tokens.pop();
    }
    found
}

fn sum(tokens: &mut Vec<String>, names: &Names) -> Option<i64> {
    let mut value = product(tokens, names)?;
    loop {
        if take(tokens, "+") {
            value += product(tokens, names)?;
        } else if take(tokens, "-") {
            value -= product(tokens, names)?;
        } else {
            return Some(value);
        }
    }
}

fn product(tokens: &mut Vec<String>, names: &Names) -> Option<i64> {
    let mut value = term(tokens, names)?;
    loop {
        if take(tokens, "*") {
            value *= term(tokens, names)?;
        } else if take(tokens, "/") {
            value = value.checked_div(term(tokens, names)?)?;
        } else {
            return Some(value);
        }
    }
}

fn term(tokens: &mut Vec<String>, names: &Names) -> Option<i64> {
    if take(tokens, "-") {
        return term(tokens, names).map(|value| -value);
    }
    if take(tokens, "(") {
        let value = sum(tokens, names)?;
        return take(tokens, ")").then_some(value);
    }
    let token = tokens.pop()?;
    if ["opaque", "i32", "u32"].contains(&token.as_str()) {
        return term(tokens, names);
    }
    let digits = token.trim_end_matches(['u', 'i']);
    digits.parse().ok().or_else(|| names.get(&token).copied())
}

/// The turns of a `for` that counts between constants, or clears bit after bit of a word.
pub(super) fn head_turns(head: &str, names: &Names) -> Option<u64> {
    let parts = head.strip_prefix("for")?.trim().strip_prefix('(')?.strip_suffix(')')?;
    let [first, condition, step]: [&str; 3] = parts.split(';').map(str::trim).collect::<Vec<_>>().try_into().ok()?;
    let (counter, condition) = condition.split_once(' ')?;
    let clears = format!("{counter} &= {counter} - 1u");
    if condition == "!= 0u" && step == clears {
        return Some(32);
    }
    let begin = value(first.strip_prefix("var ")?.strip_prefix(counter)?.trim().strip_prefix('=')?, names)?;
    let (comparison, end) = condition.split_once(' ')?;
    let end = value(end, names)?;
    let step = step.strip_prefix(counter)?.trim();
    let by = |operator: &str| step.strip_prefix(operator).and_then(|by| value(by, names)).filter(|&by| by > 0);
    let next = |at: i64| match step {
        "++" => Some(at + 1),
        "--" => Some(at - 1),
        _ => by("+=").map(|by| at + by).or(by("*=").map(|by| at * by)).or(by("/=").map(|by| at / by)),
    };
    let goes_on = |at: i64| match comparison {
        "<" => Some(at < end),
        "<=" => Some(at <= end),
        ">" => Some(at > end),
        ">=" => Some(at >= end),
        _ => None,
    };
    let (mut at, mut turns) = (begin, 0);
    while goes_on(at)? {
        let after = next(at)?;
        if after == at || turns == 1 << 20 {
            return None;
        }
        (at, turns) = (after, turns + 1);
    }
    Some(turns)
}
