//! Composes WGSL modules from files. A file names at its top what it takes (`#import common/positions`), and may have
//! variants (`#if SCENE`, `#else`, `#endif`). A module holds what the entry points of one stage reach, and the
//! constants that a pipeline may set, so that a device still refuses the name of a constant that is in none of the
//! files. Items are in the order of the imports, and each file once.

use std::collections::HashMap;

/// A module, and where its lines come from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Composed {
    /// The WGSL.
    pub wgsl: String,
    /// The file and the line, counted from 1, of each line of `wgsl`.
    pub origins: Vec<(&'static str, usize)>,
}

/// Reads a file by its name without `.wgsl`.
pub(crate) type Read<'a> = dyn Fn(&str) -> Option<&'static str> + 'a;

/// A declaration at the top of a file, with the comment above it and its attributes.
#[derive(Default)]
struct Item {
    file: &'static str,
    lines: Vec<(usize, &'static str)>,
    /// The name that it declares.
    name: &'static str,
    /// The names that it uses.
    uses: Vec<&'static str>,
    /// `compute`, `vertex` or `fragment` of an entry point.
    entry: Option<&'static str>,
    /// A constant that a pipeline may set.
    is_override: bool,
}

/// A module of a file: the compute entry points of it that are named, all entry points of it for draws, all constants that a
/// pipeline may set, and what they, or the names in `further`, reach. `flags` are the names for which `#if` holds.
pub(crate) fn compose(
    file: &'static str,
    flags: &[&str],
    entry_points: &[&str],
    further: &str,
    read: &Read<'_>,
) -> Result<Composed, String> {
    let mut items = Vec::new();
    take(file, flags, read, &mut Vec::new(), &mut items)?;
    let mut indices: HashMap<&str, usize> = HashMap::new();
    for (index, item) in items.iter().enumerate() {
        if let Some(other) = indices.insert(item.name, index).and_then(|other| items.get(other)) {
            return Err(format!("wgsl/{}.wgsl: {} is declared in {} too", item.file, item.name, other.file));
        }
    }
    let mut remaining: Vec<usize> = words(further).iter().filter_map(|word| indices.get(word.text).copied()).collect();
    let is_requested = |entry: &str, item: &Item| entry != "compute" || entry_points.contains(&item.name);
    let is_entry = |item: &Item| item.file == file && item.entry.is_some_and(|entry| is_requested(entry, item));
    remaining.extend((0..).zip(&items).filter(|(_, item)| item.is_override || is_entry(item)).map(|(index, _)| index));
    let mut is_reached = vec![false; items.len()];
    while let Some(index) = remaining.pop() {
        let (Some(reached), Some(item)) = (is_reached.get_mut(index), items.get(index)) else { continue };
        if !std::mem::replace(reached, true) {
            remaining.extend(item.uses.iter().filter_map(|name| indices.get(name).copied()));
        }
    }
    let mut composed = Composed::default();
    for (item, _) in items.iter().zip(is_reached).filter(|(_, is_reached)| *is_reached) {
        for &(number, line) in &item.lines {
            composed.wgsl.push_str(line);
            composed.wgsl.push('\n');
            composed.origins.push((item.file, number));
        }
    }
    Ok(composed)
}

/// Appends the items of the imports of a file, then those of the file.
fn take(
    file: &'static str,
    flags: &[&str],
    read: &Read<'_>,
    appended: &mut Vec<&'static str>,
    items: &mut Vec<Item>,
) -> Result<(), String> {
    if appended.contains(&file) {
        return Ok(());
    }
    appended.push(file);
    let text = read(file).ok_or_else(|| format!("wgsl/{file}.wgsl: there is no such file"))?;
    let (imports, file_items) = parse(file, text, flags)?;
    for import in imports {
        take(import, flags, read, appended, items)?;
    }
    items.extend(file_items);
    Ok(())
}

/// The imports and the items of a file.
fn parse(file: &'static str, text: &'static str, flags: &[&str]) -> Result<(Vec<&'static str>, Vec<Item>), String> {
    let (mut imports, mut items) = (Vec::new(), Vec::new());
    // Whether the lines between each `#if` and its end count.
    let mut conditions: Vec<bool> = Vec::new();
    let mut item = Item::default();
    let mut depth = 0;
    for (number, line) in (1..).zip(text.lines()) {
        let wrong = |what: &str| Err(format!("wgsl/{file}.wgsl:{number}: {what}: {line}"));
        let (directive, name) = line.split_once(' ').unwrap_or((line, ""));
        match directive {
            "#if" => conditions.push(flags.contains(&name)),
            "#else" => match conditions.last_mut() {
                Some(holds) => *holds = !*holds,
                None => return wrong("no #if before"),
            },
            "#endif" if conditions.pop().is_none() => return wrong("no #if before"),
            "#endif" => {}
            _ if conditions.contains(&false) => {}
            "#import" => imports.push(name),
            _ if line.starts_with('#') => return wrong("no such directive"),
            // Lines above are a comment by themselves, such as the head of the file.
            "" if item.name.is_empty() => item.lines.clear(),
            _ => {
                let code = line.split("//").next().unwrap_or_default().trim_end();
                item.lines.push((number, line));
                read_code(&mut item, code);
                depth += code.matches('{').count();
                depth = depth.saturating_sub(code.matches('}').count());
                if depth == 0 && code.ends_with([';', '}']) {
                    items.push(Item { file, ..std::mem::take(&mut item) });
                }
            }
        }
    }
    let open = if item.name.is_empty() { "#if" } else { item.name };
    if conditions.is_empty() && item.name.is_empty() {
        Ok((imports, items))
    } else {
        Err(format!("wgsl/{file}.wgsl: the end of {open} is missing"))
    }
}

/// Takes the names of a line of code: what it declares, if nothing is declared yet, and what it uses.
fn read_code(item: &mut Item, code: &'static str) {
    let is_case = code.trim_start().starts_with("case ");
    let mut words = words(code).into_iter().peekable();
    while let Some(Word { text, before, after }) = words.next() {
        match text {
            "builtin" if before == '@' => _ = words.next(),
            "compute" | "vertex" | "fragment" if before == '@' && item.name.is_empty() => item.entry = Some(text),
            "fn" | "struct" | "const" | "override" | "alias" | "var" if item.name.is_empty() => {
                // The words of `var<storage, read_write>` are in angle brackets.
                while words.peek().is_some_and(|next| text == "var" && matches!(next.before, '<' | ',')) {
                    words.next();
                }
                item.name = words.next().map_or("", |name| name.text);
                item.is_override = text == "override";
            }
            // Attributes, members, and what is declared with its type.
            _ if matches!(before, '@' | '.') || after == ':' && !is_case => {}
            _ => item.uses.push(text),
        }
    }
}

/// A name in a text, with the nearest characters around it that are no spaces.
struct Word<'a> {
    text: &'a str,
    before: char,
    after: char,
}

fn words(text: &str) -> Vec<Word<'_>> {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
    let mut words = Vec::new();
    let mut before = ' ';
    let mut rest = text.trim_start();
    while let Some(letter) = rest.chars().next() {
        let length = rest.find(|letter| !is_part(letter)).unwrap_or(rest.len()).max(letter.len_utf8());
        let (word, after) = rest.split_at(length);
        rest = after.trim_start();
        if is_part(letter) && !letter.is_numeric() {
            words.push(Word { text: word, before, after: rest.chars().next().unwrap_or(' ') });
        }
        before = word.chars().last().unwrap_or(letter);
    }
    words
}

impl Composed {
    /// A message of a compiler about a line, counted from 1, as one about the file that the line comes from.
    pub fn located(&self, line: usize, message: &str) -> String {
        match line.checked_sub(1).and_then(|line| self.origins.get(line)) {
            Some((file, line)) => format!("wgsl/{file}.wgsl:{line}: {message}"),
            None => message.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests;
