//! A report as one HTML file: no script, nothing from elsewhere, light or dark as the reader's system has it.

use std::fmt::Write as _;
use std::io;

use crate::chart::{Chart, PALETTE, ROLES, Target, escape};

/// The whole page.
pub(crate) struct Page {
    pub(crate) title: String,
    pub(crate) lead: String,
    /// On which machine, with what, when.
    pub(crate) facts: Vec<Fact>,
    /// Notices that a reader must know first.
    pub(crate) notices: Vec<String>,
    pub(crate) sections: Vec<Section>,
}

/// A line of the page's head.
pub(crate) struct Fact {
    pub(crate) name: &'static str,
    pub(crate) value: String,
}

/// A part of the page.
pub(crate) struct Section {
    pub(crate) title: String,
    pub(crate) lead: String,
    pub(crate) figures: Vec<Figure>,
}

/// A chart with its figures as a table, or a table alone.
pub(crate) struct Figure {
    /// Also the name of its PNG file.
    pub(crate) id: &'static str,
    pub(crate) title: String,
    /// How to read it.
    pub(crate) lead: String,
    pub(crate) chart: Option<Chart>,
    pub(crate) table: Table,
}

impl Figure {
    pub(crate) fn new(
        id: &'static str,
        title: impl Into<String>,
        lead: impl Into<String>,
        chart: Option<Chart>,
        table: Table,
    ) -> Self {
        Self { id, title: title.into(), lead: lead.into(), chart, table }
    }
}

/// Rows of text; the first cell of each says what the row is.
#[derive(Default)]
pub(crate) struct Table {
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
    /// Cells are sentences, which break into lines, not figures.
    pub(crate) is_prose: bool,
}

impl Table {
    pub(crate) fn new(head: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { head: head.into_iter().map(Into::into).collect(), ..Self::default() }
    }
}

const STYLE: &str = include_str!("style.css");

impl Page {
    pub(crate) fn html(&self) -> io::Result<String> {
        let mut html = String::new();
        let title = escape(&self.title);
        let _ = write!(
            html,
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
             <style>\n{}{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n<p class=\"lead\">{}</p>\n<dl>\n",
            palette(),
            escape(&self.lead)
        );
        for Fact { name, value } in &self.facts {
            let _ = writeln!(html, "<div><dt>{}</dt><dd>{}</dd></div>", escape(name), escape(value));
        }
        html.push_str("</dl>\n");
        for notice in &self.notices {
            let _ = writeln!(html, "<p class=\"notice\" role=\"note\">{}</p>", escape(notice));
        }
        html.push_str("</header>\n<main>\n");
        for section in &self.sections {
            let _ = writeln!(
                html,
                "<section>\n<h2>{}</h2>\n<p class=\"lead\">{}</p>",
                escape(&section.title),
                escape(&section.lead)
            );
            section.figures.iter().try_for_each(|figure| figure.write(&mut html))?;
            html.push_str("</section>\n");
        }
        html.push_str("</main>\n</body>\n</html>\n");
        Ok(html)
    }
}

/// The keys' colours as variables, for a light and a dark ground, and rules that give the plots' fixed colours the
/// variables' values.
fn palette() -> String {
    let list = |choose: fn(&(u32, u32)) -> u32| {
        PALETTE.iter().enumerate().fold(String::new(), |mut list, (index, colour)| {
            let _ = write!(list, "--key{index}: #{:06X}; ", choose(colour));
            list
        })
    };
    let mut css = format!(
        ":root {{ {}}}\n@media (prefers-color-scheme: dark) {{ :root {{ {}}} }}\n",
        list(|colour| colour.0),
        list(|colour| colour.1)
    );
    let keys = (0..).zip(PALETTE).map(|(index, (light, _)): (usize, _)| (format!("key{index}"), light));
    for (name, light) in ROLES.map(|(name, light)| (name.to_owned(), light)).into_iter().chain(keys) {
        for property in ["fill", "stroke"] {
            let _ = writeln!(css, ".plot [{property}=\"#{light:06X}\"] {{ {property}: var(--{name}); }}");
        }
    }
    css
}

impl Figure {
    fn write(&self, html: &mut String) -> io::Result<()> {
        let Self { id, title, lead, chart, table } = self;
        let title = escape(title);
        let _ = writeln!(html, "<figure id=\"{id}\">\n<h3>{title}</h3>\n<p>{}</p>", escape(lead));
        match chart {
            Some(chart) => {
                html.push_str("<div class=\"plot\">\n");
                // The style sheet shows one of the two.
                for (class, target) in [("wide", Target::Page), ("narrow", Target::Phone)] {
                    let label = format!("role=\"img\" aria-label=\"{title}; the table below has its figures\"");
                    let begin = format!("<svg class=\"{class}\" {label} ");
                    html.push_str(&chart.svg(target)?.replacen("<svg ", &begin, 1));
                }
                html.push_str("</div>\n<details>\n<summary>The figures as a table</summary>\n");
                table.write(html, &title);
                html.push_str("</details>\n");
            }
            None => table.write(html, &title),
        }
        html.push_str("</figure>\n");
        Ok(())
    }
}

impl Table {
    fn write(&self, html: &mut String, caption: &str) {
        let _ = write!(
            html,
            "<div class=\"table{}\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n<thead><tr>",
            if self.is_prose { " prose" } else { "" }
        );
        for head in &self.head {
            let _ = write!(html, "<th scope=\"col\">{}</th>", escape(head));
        }
        html.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            html.push_str("<tr>");
            for (at, cell) in row.iter().enumerate() {
                let cell = escape(cell);
                let _ = match (at, &*cell) {
                    (0, _) => write!(html, "<th scope=\"row\">{cell}</th>"),
                    (_, "0") => write!(html, "<td class=\"zero\">0</td>"),
                    _ => write!(html, "<td>{cell}</td>"),
                };
            }
            html.push_str("</tr>\n");
        }
        html.push_str("</tbody>\n</table>\n</div>\n");
    }
}
