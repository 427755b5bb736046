//! Pens: widths, colours and dashes of lines.

use std::path::Path;

use rimline_lines::LineClass;
use toml::{Table, Value};

use super::args::Hidden;
use crate::failure::Failure;
use crate::files;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pen {
    pub(crate) width_mm: f64,
    /// Red, green and blue, as in sRGB.
    pub(crate) color: [u8; 3],
    /// Lengths of dashes and gaps in turn, in millimetres; none for a whole line.
    pub(crate) dash_mm: Vec<f64>,
}

/// The least sum of dashes and gaps, in millimetres. Finer ones nobody sees, and they round to none or are too many to draw.
const LEAST_DASHES: f64 = 0.1;

/// The contents of a style file; omitted keys have defaults.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Style {
    /// Default widths are halved.
    pub(crate) is_fine: bool,
    /// A table for all hidden lines comes first.
    tables: Vec<Strokes>,
}

/// A table of a style.
#[derive(Clone, Debug, Default, PartialEq)]
struct Strokes {
    is_hidden: bool,
    /// `None` for lines of all classes.
    class: Option<LineClass>,
    width_mm: Option<f64>,
    color: Option<[u8; 3]>,
    dash_mm: Option<Vec<f64>>,
}

impl Style {
    pub(crate) fn has_hidden(&self) -> bool {
        self.tables.iter().any(|table| table.is_hidden)
    }

    pub(crate) fn pen(&self, class: LineClass, is_hidden: bool, hidden: Hidden) -> Pen {
        let width_mm = match (is_hidden, hidden, class) {
            (true, Hidden::Thin, _) => 0.09,
            (true, ..) => 0.18,
            (false, _, LineClass::Silhouette | LineClass::Boundary) => 0.5,
            (false, _, LineClass::NonManifold | LineClass::Marked) => 0.35,
            (false, ..) => 0.25,
        };
        let width_mm = if self.is_fine { 0.5 * width_mm } else { width_mm };
        let is_dashed = is_hidden && hidden == Hidden::Dashed;
        let pen = Pen { width_mm, color: [0; 3], dash_mm: if is_dashed { vec![1.5, 0.8] } else { Vec::new() } };
        let is_of = |table: &&Strokes| table.is_hidden == is_hidden && table.class.is_none_or(|of| of == class);
        self.tables.iter().filter(is_of).fold(pen, |pen, table| Pen {
            width_mm: table.width_mm.unwrap_or(pen.width_mm),
            color: table.color.unwrap_or(pen.color),
            dash_mm: table.dash_mm.clone().unwrap_or(pen.dash_mm),
        })
    }
}

pub(crate) fn read(file: &Path) -> Result<Style, Failure> {
    // A style that changes nothing.
    if std::fs::metadata(file).is_ok_and(|there| there.is_file() && there.len() == 0) {
        return Ok(Style::default());
    }
    parse(&files::read_text(file)?).map_err(|problem| Failure::input(file, problem))
}

fn parse(text: &str) -> Result<Style, String> {
    let table: Table = text.parse().map_err(|error: toml::de::Error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        format!("line {}: {}", before.matches('\n').count() + 1, error.message().trim_end())
    })?;
    let mut tables = Vec::new();
    for (key, value) in &table {
        let heading = format!("[{key}]");
        if key != "hidden" {
            let class = Some(class(key, &heading)?);
            tables.push(Strokes { class, ..strokes(as_table(value, &heading)?, &heading)? });
            continue;
        }
        let mut all = Table::new();
        for (key, value) in as_table(value, &heading)? {
            if let Value::Table(table) = value {
                let heading = format!("[hidden.{key}]");
                let class = Some(class(key, &heading)?);
                tables.push(Strokes { is_hidden: true, class, ..strokes(table, &heading)? });
            } else {
                all.insert(key.clone(), value.clone());
            }
        }
        if !all.is_empty() {
            tables.insert(0, Strokes { is_hidden: true, ..strokes(&all, &heading)? });
        }
    }
    Ok(Style { is_fine: false, tables })
}

fn as_table<'a>(value: &'a Value, heading: &str) -> Result<&'a Table, String> {
    value.as_table().ok_or_else(|| format!("{heading} is no table; write it in a line of its own and keys below it"))
}

fn class(key: &str, heading: &str) -> Result<LineClass, String> {
    let classes = || LineClass::ALL.into_iter().filter(|class| *class != LineClass::Marked);
    classes().find(|class| class.name() == key).ok_or_else(|| {
        let names: Vec<_> = classes().map(LineClass::name).collect();
        format!("{heading} is no class of lines; tables are {}, hidden, or hidden.CLASS", names.join(", "))
    })
}

fn strokes(table: &Table, heading: &str) -> Result<Strokes, String> {
    let mut strokes = Strokes::default();
    for (key, value) in table {
        let wrong = |what: &str| format!("{heading} {key}: {what}");
        match key.as_str() {
            "width" => {
                let width = length(value).filter(|&width| width > 0.0);
                strokes.width_mm = Some(width.ok_or_else(|| wrong("give millimetres above 0, at most 100"))?);
            }
            "color" => {
                let color = value.as_str().and_then(color);
                strokes.color = Some(color.ok_or_else(|| wrong("give a colour as \"#RRGGBB\""))?);
            }
            "dash" => {
                let lengths: Option<Vec<f64>> = value.as_array().and_then(|all| all.iter().map(length).collect());
                // An odd number of lengths is gone through twice, so each of them is a dash.
                let has_dash = |all: &[f64]| all.len() % 2 == 1 || all.iter().step_by(2).any(|&dash| dash > 0.0);
                // The sum is rounded.
                let is_long = |all: &[f64]| all.iter().sum::<f64>() + 1e-9 >= LEAST_DASHES;
                let is_drawn = |all: &[f64]| all.is_empty() || (is_long(all) && has_dash(all));
                let lengths = lengths.filter(|all| all.len() <= 16 && is_drawn(all));
                strokes.dash_mm = Some(lengths.ok_or_else(|| {
                    wrong(
                        "give lengths of dashes and gaps in millimetres, such as [1.5, 0.8], at most 16, together 0.1 at least, \
                         a dash above 0 among them; [] is a whole line",
                    )
                })?);
            }
            _ => return Err(wrong("keys are width, color and dash")),
        }
    }
    Ok(strokes)
}

fn length(value: &Value) -> Option<f64> {
    let length = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))?;
    (0.0..=100.0).contains(&length).then_some(length)
}

fn color(text: &str) -> Option<[u8; 3]> {
    let digits = text
        .strip_prefix('#')
        .filter(|digits| digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit()))?;
    let part = |at: usize| u8::from_str_radix(digits.get(at..at + 2)?, 16).ok();
    Some([part(0)?, part(2)?, part(4)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn styles_change_what_they_name() {
        let style = "[silhouette]\nwidth = 1\n[hidden]\ndash = []\n[hidden.crease]\ncolor = \"#80ff00\"";
        let mut style = parse(style).expect("it is a style");
        assert_eq!(style.pen(LineClass::Silhouette, false, Hidden::None).width_mm, 1.0);
        assert_eq!(style.pen(LineClass::Boundary, false, Hidden::None).width_mm, 0.5);
        let crease = style.pen(LineClass::Crease, true, Hidden::Dashed);
        assert_eq!(crease, Pen { width_mm: 0.18, color: [128, 255, 0], dash_mm: Vec::new() });
        assert_eq!(style.pen(LineClass::Boundary, true, Hidden::Dashed).color, [0; 3]);
        style.is_fine = true;
        assert_eq!(style.pen(LineClass::Silhouette, false, Hidden::None).width_mm, 1.0);
        assert_eq!(style.pen(LineClass::Boundary, false, Hidden::None).width_mm, 0.25);
        parse(&format!("[hidden]\ndash = {:?}", [0.01; 10])).expect("0.1 is not too short");
        parse("[crease]\ndash = [0, 1, 2, 1]\n[hidden]\ndash = [0, 1, 0]").expect("some dashes are drawn");
    }

    #[test]
    fn wrong_styles_say_where() {
        for (text, expected) in [
            ("[outline]\nwidth = 1", "[outline] is no class"),
            ("[crease]\nwidth = 0", "[crease] width: give millimetres"),
            ("[crease]\ncolor = \"red\"", "[crease] color: give a colour"),
            ("[crease]\ncolor = \"#+f+f+f\"", "[crease] color: give a colour"),
            ("[hidden]\ndash = [0, 0]", "[hidden] dash: give lengths"),
            ("[hidden]\ndash = [1e-9, 1e-9]", "[hidden] dash: give lengths"),
            ("[crease]\ndash = [0, 1, 0, 2]", "[crease] dash: give lengths"),
            ("[hidden.crease]\nwide = 1", "[hidden.crease] wide: keys are"),
            ("crease = 1", "[crease] is no table"),
            ("[crease", "line 1: "),
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }
}
