//! How many turns the loops of an entry point have at most. llvmpipe ends all loops of an invocation after 65,535
//! turns. It counts for the lanes of a subgroup together, so a loop has as many turns as the lane with the most. It
//! counts the turn in which a loop ends, and it walks into branches that no lane takes: there each loop has one turn
//! (docs/numerics/loops.md).
//!
//! Each loop says how many turns it has whenever it is come to: by its head, where that tells, else by a comment above it,
//! `// Turns: 8.` or `// Turns: CELLS + 1.` Names are constants of the module or limits that the caller states. With
//! `in all` the turns are those of all times together, for all lanes of a subgroup. `// Turns: of one branch.` above an
//! `if` says that all lanes take the same.

mod bounds;
mod expression;

use std::collections::BTreeMap;

use naga::{Block, Module, Span, Statement};

pub use bounds::{MOST_TURNS, limits};
use expression::{head_turns, value};

/// The names that comments may use in addition to the constants of the module.
pub type Limits<'a> = BTreeMap<&'a str, u64>;

/// The turns of each entry point of a module, in order.
///
/// # Errors
/// For WGSL that does not parse, and for a loop of which neither head nor comment tells the turns.
pub fn turns(source: &str, limits: &Limits<'_>) -> Result<Vec<(String, u64)>, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let walk = Walk { source, module: &module, names: names(source, limits) };
    let entries = module.entry_points.iter();
    entries
        .map(|entry| Ok((entry.name.clone(), walk.block(&entry.function.body, Arrivals { active: 1, idle: 0 })?)))
        .collect()
}

/// The integer constants of a module, as far as they follow from numbers and constants above, with the limits.
fn names(source: &str, limits: &Limits<'_>) -> BTreeMap<String, i64> {
    let mut names: BTreeMap<_, _> = limits.iter().map(|(&name, &value)| (name.to_owned(), value as i64)).collect();
    for line in source.lines() {
        let code = line.split("//").next().unwrap_or_default().trim();
        let constant = code.strip_prefix("const ").and_then(|line| line.strip_suffix(';'));
        let Some((name, text)) = constant.and_then(|line| line.split_once('=')) else { continue };
        let name = name.split(':').next().unwrap_or(name).trim();
        if let Some(value) = value(text, &names) {
            names.insert(name.to_owned(), value);
        }
    }
    names
}

/// How often something is come to: with a lane that takes it, and without.
#[derive(Clone, Copy)]
struct Arrivals {
    active: u64,
    idle: u64,
}

struct Walk<'a> {
    source: &'a str,
    module: &'a Module,
    names: BTreeMap<String, i64>,
}

impl Walk<'_> {
    fn block(&self, block: &Block, at: Arrivals) -> Result<u64, String> {
        block
            .span_iter()
            .try_fold(0_u64, |sum, (statement, span)| Ok(sum.saturating_add(self.statement(statement, *span, at)?)))
    }

    fn statement(&self, statement: &Statement, span: Span, at: Arrivals) -> Result<u64, String> {
        let both = |first: &Block, second: &Block| Ok(self.block(first, at)?.saturating_add(self.block(second, at)?));
        match statement {
            Statement::Block(block) => self.block(block, at),
            Statement::If { accept, reject, .. } if self.comment(span) == Some("of one branch.") => {
                let idle = Arrivals { active: 0, idle: at.active.saturating_add(at.idle) };
                let first = self.block(accept, at)?.saturating_add(self.block(reject, idle)?);
                Ok(first.max(self.block(accept, idle)?.saturating_add(self.block(reject, at)?)))
            }
            Statement::If { accept, reject, .. } => both(accept, reject),
            Statement::Switch { cases, .. } => {
                cases.iter().try_fold(0_u64, |sum, case| Ok(sum.saturating_add(self.block(&case.body, at)?)))
            }
            Statement::Call { function, .. } => self.block(&self.module.functions[*function].body, at),
            Statement::Loop { body, continuing, .. } => {
                let turns = if at.active == 0 { 0 } else { self.loop_turns(span, at)? };
                // Each time the body is walked through once more, by no lane, and finds that the loop ends.
                let idle = at.active.saturating_add(at.idle);
                let inner = Arrivals { active: turns, idle };
                let ends = turns.saturating_add(idle);
                Ok(ends.saturating_add(self.block(body, inner)?).saturating_add(self.block(continuing, inner)?))
            }
            _ => Ok(0),
        }
    }

    /// The number of turns in the comment above a statement, as text.
    fn comment(&self, span: Span) -> Option<&str> {
        let begin = span.to_range()?.start;
        let lines_above = self.source[..begin].lines().rev().skip(1).map(str::trim);
        lines_above.take_while(|line| line.starts_with("//")).find_map(|line| line.strip_prefix("// Turns: "))
    }

    /// The turns of a loop, all times together.
    fn loop_turns(&self, span: Span, at: Arrivals) -> Result<u64, String> {
        let begin = span.to_range().map_or(0, |range| range.start);
        let rest = &self.source[begin..];
        let head = rest.split_once('{').map_or(rest, |(head, _)| head).trim();
        let untold = || format!("neither head nor comment tells the turns of the loop `{head}`");
        let Some(comment) = self.comment(span) else {
            return Ok(at.active.saturating_mul(head_turns(head, &self.names).ok_or_else(untold)?));
        };
        let stated = comment.strip_suffix('.').ok_or_else(untold)?;
        let (stated, in_all) = stated.strip_suffix(" in all").map_or((stated, false), |stated| (stated, true));
        let turns = value(stated, &self.names).and_then(|turns| u64::try_from(turns).ok());
        let turns = turns.ok_or_else(|| format!("`{stated}` above the loop `{head}` is no number"))?;
        Ok(if in_all { turns } else { at.active.saturating_mul(turns) })
    }
}
