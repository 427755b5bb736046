//! SVG, written down shape by shape.

use std::fmt::Write as _;

use super::{Key, Target};
use crate::shown::Text;

/// Colours of keys, told apart by people who do not see all colours (Okabe and Ito, "Color Universal Design", 2008),
/// for a light and for a dark ground; the dark ones are lifted where the original would sink.
pub(crate) const PALETTE: [(&str, &str); 8] = [
    ("#D55E00", "#E8793A"),
    ("#B97700", "#E69F00"),
    ("#0072B2", "#4BA3E0"),
    ("#3A93C9", "#8CCBF0"),
    ("#00805F", "#2FC397"),
    ("#B0568C", "#D98BB9"),
    ("#5B5B5B", "#B4B4B4"),
    ("#8A7B00", "#E0D34A"),
];

/// A colour by its role.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Ink {
    Text,
    Muted,
    Grid,
    Ground,
    Band,
    Link,
    Key(usize),
}

/// Where a text's given point is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A text's place and look.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Label {
    pub(crate) x: f64,
    /// Of the baseline.
    pub(crate) y: f64,
    pub(crate) size: f64,
    pub(crate) anchor: Anchor,
    pub(crate) ink: Ink,
    pub(crate) bold: bool,
}

/// A drawing under way.
#[derive(Debug)]
pub(crate) struct Svg {
    width: f64,
    height: f64,
    on_page: bool,
    /// Moves everything down, for a heading.
    top: f64,
    body: String,
}

/// Heights that a file's heading and its line below take.
const HEADING: f64 = 46.0;
const ORIGIN: f64 = 30.0;

impl Svg {
    /// An empty drawing of this size, heading and last line of a file not counted.
    pub(crate) fn new(width: f64, height: f64, target: Target<'_>) -> Self {
        let mut svg = Self { width, height, on_page: true, top: 0.0, body: String::new() };
        if let Target::File { title, origin } = target {
            svg.on_page = false;
            let heading = Label { x: 18.0, y: 32.0, size: 19.0, anchor: Anchor::Start, ink: Ink::Text, bold: true };
            svg.text(heading, title);
            let y = HEADING + height + 16.0;
            svg.text(Label { y, size: 12.0, ink: Ink::Muted, bold: false, ..heading }, origin);
            svg.top = HEADING;
            svg.height += HEADING + ORIGIN;
        }
        svg
    }

    fn colour(&self, ink: Ink) -> String {
        let fixed = |name: &str, value: &str| if self.on_page { format!("var(--{name})") } else { value.to_owned() };
        match ink {
            Ink::Text => fixed("text", "#1B1F24"),
            Ink::Muted => fixed("muted", "#59636E"),
            Ink::Grid => fixed("grid", "#DDE2E7"),
            Ink::Ground => fixed("ground", "#FFFFFF"),
            Ink::Link => fixed("link", "#B9C2CB"),
            Ink::Band => fixed("band", "#EDF5F0"),
            Ink::Key(index) => {
                let index = index % PALETTE.len();
                fixed(&format!("key{index}"), PALETTE[index].0)
            }
        }
    }

    pub(crate) fn text(&mut self, label: Label, text: &str) {
        let Label { x, y, size, anchor, ink, bold } = label;
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let colour = self.colour(ink);
        // The files' only font has one weight; a thin outline in its colour makes it bolder.
        let weight = match (bold, self.on_page) {
            (true, true) => " font-weight=\"600\"".to_owned(),
            (true, false) => format!(" stroke=\"{colour}\" stroke-width=\"{:.2}\"", size * 0.036),
            (false, true) => String::new(),
            (false, false) => format!(" stroke=\"{colour}\" stroke-width=\"{:.2}\"", size * 0.012),
        };
        let y = y + self.top;
        let _ = writeln!(
            self.body,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{colour}\"{weight}>{}</text>",
            escape(text)
        );
    }

    /// A text that runs upwards, its middle at a point.
    pub(crate) fn upright_text(&mut self, x: f64, y: f64, size: f64, text: &str) {
        let y = y + self.top;
        let top = std::mem::take(&mut self.top);
        let _ = write!(self.body, "<g transform=\"translate({x:.1} {y:.1}) rotate(-90)\">");
        self.text(Label { x: 0.0, y: 0.0, size, anchor: Anchor::Middle, ink: Ink::Text, bold: false }, text);
        self.body.push_str("</g>\n");
        self.top = top;
    }

    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], ink: Ink, width: f64, dash: &str) {
        let (colour, top) = (self.colour(ink), self.top);
        let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
        let _ = writeln!(
            self.body,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>",
            from[0],
            from[1] + top,
            to[0],
            to[1] + top
        );
    }

    pub(crate) fn polyline(&mut self, points: &[[f64; 2]], ink: Ink, width: f64, dash: &str) {
        let (colour, top) = (self.colour(ink), self.top);
        let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
        let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{:.1}", y + top)).collect();
        let _ = writeln!(
            self.body,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{dash}/>",
            points.join(" ")
        );
    }

    /// A filled rectangle with what a pointer on it is told.
    pub(crate) fn rectangle(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], ink: Ink, tip: &str) {
        let (colour, y) = (self.colour(ink), y + self.top);
        let _ = writeln!(
            self.body,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{colour}\">{}</rect>",
            width.max(0.0),
            title(tip)
        );
    }

    /// A key's bar: filled, or an outline.
    pub(crate) fn bar(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], key: &Key, tip: &str) {
        if !key.hollow {
            return self.rectangle([x, y], [width, height], Ink::Key(key.colour), tip);
        }
        let [colour, ground] = [Ink::Key(key.colour), Ink::Ground].map(|ink| self.colour(ink));
        let (x, y, width, height) = (x + 1.0, y + 1.0 + self.top, (width - 2.0).max(0.5), height - 2.0);
        let _ = writeln!(
            self.body,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{ground}\" \
             stroke=\"{colour}\" stroke-width=\"2\">{}</rect>",
            title(tip)
        );
    }

    /// A key's mark with what a pointer on it is told.
    pub(crate) fn mark(&mut self, [x, y]: [f64; 2], key: &Key, size: f64, tip: &str) {
        let (colour, y) = (self.colour(Ink::Key(key.colour)), y + self.top);
        let look = if key.hollow {
            // Not filled, so that a mark beneath it shows; a pointer finds its inside all the same.
            format!("fill=\"none\" pointer-events=\"all\" stroke=\"{colour}\" stroke-width=\"2\"")
        } else {
            format!("fill=\"{colour}\" stroke=\"{}\" stroke-width=\"1\"", self.colour(Ink::Ground))
        };
        let path = |corners: &[[f64; 2]]| {
            let corners: Vec<String> =
                corners.iter().map(|[dx, dy]| format!("{:.1},{:.1}", x + dx * size, y + dy * size)).collect();
            format!("<polygon points=\"{}\" {look}>{}</polygon>", corners.join(" "), title(tip))
        };
        let shape = match key.shape % 5 {
            0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{size:.1}\" {look}>{}</circle>", title(tip)),
            1 => path(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
            2 => path(&[[0.0, -1.25], [1.15, 0.85], [-1.15, 0.85]]),
            3 => path(&[[0.0, -1.35], [1.35, 0.0], [0.0, 1.35], [-1.35, 0.0]]),
            _ => path(&[[0.0, 1.25], [1.15, -0.85], [-1.15, -0.85]]),
        };
        self.body.push_str(&shape);
        self.body.push('\n');
    }

    /// A row of keys with their names, broken into lines. Returns the height it took.
    pub(crate) fn legend(&mut self, keys: &[Key], left: f64, top: f64, right: f64) -> f64 {
        const LINE: f64 = 22.0;
        let (mut x, mut y) = (left, top + 11.0);
        for key in keys {
            let width = 20.0 + text_width(&key.name, 13.0) + 20.0;
            if x + width - 20.0 > right && x > left {
                (x, y) = (left, y + LINE);
            }
            self.mark([x + 6.0, y], key, 5.5, "");
            let label =
                Label { x: x + 18.0, y: y + 4.5, size: 13.0, anchor: Anchor::Start, ink: Ink::Text, bold: false };
            self.text(label, &key.name);
            x += width;
        }
        y - top + 11.0
    }

    pub(crate) fn finish(self) -> String {
        let Self { width, height, on_page, body, .. } = self;
        let ground = if on_page {
            String::new()
        } else {
            "<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n".to_owned()
        };
        // HTML knows what an svg element is; a file by itself has to say so.
        let (font, space) = if on_page { ("inherit", "") } else { ("Ubuntu", "xmlns=\"http://www.w3.org/2000/svg\" ") };
        format!(
            "<svg {space}viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
             height=\"{height:.0}\" font-family=\"{font}\">\n{ground}{body}</svg>\n"
        )
    }
}

fn title(tip: &str) -> String {
    if tip.is_empty() { String::new() } else { format!("<title>{}</title>", escape(tip)) }
}

/// Text as it stands in XML and HTML.
pub(crate) fn escape(text: &str) -> String {
    Text(text).to_string().replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// About how wide a text is, a little more rather than less; fonts differ.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let of = |c: char| match c {
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | 'I' | '.' | ',' | ':' | ';' | '\'' | '|' | ' ' | '(' | ')' | '-' => 0.34,
        'm' | 'w' | 'M' | 'W' | '—' | '…' => 0.92,
        'A'..='Z' => 0.7,
        _ => 0.61,
    };
    size * text.chars().map(of).sum::<f64>()
}
