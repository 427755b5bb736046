//! A report as one HTML file: no script, nothing from elsewhere, light or dark as the reader's system has it.

use std::fmt::Write as _;

use crate::chart::{Chart, PALETTE, ROLES, Target, escape};

pub(crate) struct Page {
    pub(crate) title: String,
    pub(crate) lead: String,
    /// On which machine, with what, when: names and values.
    pub(crate) facts: Vec<(&'static str, String)>,
    /// Notices that a reader must know first.
    pub(crate) notices: Vec<String>,
    pub(crate) sections: Vec<Section>,
}

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
    pub(crate) fn html(&self) -> String {
        let (title, lead, palette) = (escape(&self.title), escape(&self.lead), palette());
        let mut html = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
             <style>\n{palette}{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n<p class=\"lead\">{lead}</p>\n<dl>\n"
        );
        for (name, value) in &self.facts {
            let _ = writeln!(html, "<div><dt>{}</dt><dd>{}</dd></div>", escape(name), escape(value));
        }
        html.push_str("</dl>\n");
        for notice in &self.notices {
            let _ = writeln!(html, "<p class=\"notice\" role=\"note\">{}</p>", escape(notice));
        }
        html.push_str("</header>\n<main>\n");
        for Section { title, lead, figures } in &self.sections {
            let (title, lead) = (escape(title), escape(lead));
            let _ = writeln!(html, "<section>\n<h2>{title}</h2>\n<p class=\"lead\">{lead}</p>");
            for figure in figures {
                figure.write(&mut html);
            }
            html.push_str("</section>\n");
        }
        html + "</main>\n</body>\n</html>\n"
    }
}

/// The keys' colours as variables, for a light and a dark ground, and rules that give the plots' fixed colours the
/// variables' values.
fn palette() -> String {
    let list = |ground: usize| -> String {
        (0..).zip(PALETTE).fold(String::new(), |list, (key, colours): (usize, _)| {
            list + &format!("--key{key}: {}; ", colours[ground])
        })
    };
    let mut css = format!(":root {{ {}}}\n@media (prefers-color-scheme: dark) {{ :root {{ {}}} }}\n", list(0), list(1));
    let keys = (0..).zip(PALETTE).map(|(key, colours): (usize, _)| (format!("key{key}"), colours[0]));
    for (name, light) in ROLES.map(|(name, light)| (name.to_owned(), light)).into_iter().chain(keys) {
        for property in ["fill", "stroke"] {
            let _ = writeln!(css, ".plot [{property}=\"{light}\"] {{ {property}: var(--{name}); }}");
        }
    }
    css
}

impl Figure {
    fn write(&self, html: &mut String) {
        let Self { id, title, lead, chart, table } = self;
        let title = escape(title);
        let _ = writeln!(html, "<figure id=\"{id}\">\n<h3>{title}</h3>\n<p>{}</p>", escape(lead));
        match chart {
            Some(chart) => {
                html.push_str("<div class=\"plot\">\n");
                // The style sheet shows one of the two.
                for (class, target) in [("wide", Target::Page), ("narrow", Target::Phone)] {
                    let label = format!("role=\"img\" aria-label=\"{title}; the table below has its figures\"");
                    html.push_str(&chart.svg(target, &format!("class=\"{class}\" {label}")));
                }
                html.push_str("</div>\n<details>\n<summary>The figures as a table</summary>\n");
                table.write(html, &title);
                html.push_str("</details>\n");
            }
            None => table.write(html, &title),
        }
        html.push_str("</figure>\n");
    }
}

impl Table {
    fn write(&self, html: &mut String, caption: &str) {
        let prose = if self.is_prose { " prose" } else { "" };
        let head =
            self.head.iter().fold(String::new(), |list, head| list + "<th scope=\"col\">" + &escape(head) + "</th>");
        let _ = writeln!(
            html,
            "<div class=\"table{prose}\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n<thead><tr>{head}</tr></thead>\n<tbody>"
        );
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
