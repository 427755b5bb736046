//! Texts of a plot, and whether any two of them collide. Widths are estimated apart from the code under test.

use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("plot_labels::colliding_texts_are_found", negative)];

/// A horizontal text of an SVG.
struct Text {
    words: String,
    x: [f64; 2],
    y: [f64; 2],
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    tag.split(&format!(" {name}=\"")).nth(1)?.split('"').next()
}

fn texts(svg: &str) -> Result<Vec<Text>, String> {
    let mut texts = Vec::new();
    for part in svg.split("<text").skip(1) {
        let (tag, rest) = part.split_once('>').ok_or("a text without an end")?;
        if tag.contains("rotate") {
            continue;
        }
        let text = rest.split('<').next().unwrap_or_default().trim().to_owned();
        let number = |name: &str| attribute(tag, name).and_then(|value| value.parse::<f64>().ok());
        let (Some(x), Some(y), Some(size)) = (number("x"), number("y"), number("font-size")) else {
            return Err(format!("no place of {text}"));
        };
        // Narrower and lower than letters mostly are, so that what collides here collides in any font.
        let (width, height) = (0.42 * size * text.chars().count() as f64, 0.6 * size);
        let left = match attribute(tag, "text-anchor") {
            Some("end") => x - width,
            Some("middle") => x - 0.5 * width,
            _ => x,
        };
        let middle = match attribute(tag, "dy") {
            Some("0.5ex") => y,
            Some("0.76em") => y + 0.4 * size,
            other => return Err(format!("{text} lies at {other:?}")),
        };
        let y = [middle - 0.5 * height, middle + 0.5 * height];
        texts.push(Text { words: text, x: [left, left + width], y });
    }
    Ok(texts)
}

/// Every text of the SVG is within its width and height, and no two collide.
pub(crate) fn check(svg: &str) -> Outcome {
    let view = attribute(svg, "viewBox").ok_or("no size")?;
    let view: Vec<f64> = view.split(' ').filter_map(|number| number.parse().ok()).collect();
    let texts = texts(svg)?;
    ensure!(view.len() == 4 && texts.len() > 5, "{} texts in {view:?}", texts.len());
    for (index, one) in texts.iter().enumerate() {
        let is_inside = one.x[0] >= 0.0 && one.x[1] <= view[2] && one.y[0] >= 0.0 && one.y[1] <= view[3];
        ensure!(is_inside, "`{}` at {:?}, {:?} leaves the plot of {view:?}", one.words, one.x, one.y);
        let apart = |a: [f64; 2], b: [f64; 2]| a[1] <= b[0] || b[1] <= a[0];
        let hit = texts[..index].iter().find(|other| !apart(one.x, other.x) && !apart(one.y, other.y));
        ensure!(hit.is_none(), "`{}` and {:?} collide", one.words, hit.map(|other| &other.words));
    }
    Ok(())
}

fn negative() -> Outcome {
    let svg = |x: i32, y: i32| {
        let text = |x, y| format!("<text x=\"{x}\" y=\"{y}\" dy=\"0.5ex\" font-size=\"20\">label</text>");
        let others: String = (0..5).map(|row| text(10, 20 + 20 * row)).collect();
        format!("<svg class=\"wide\" viewBox=\"0 0 200 200\">{others}{}</svg>", text(x, y))
    };
    check(&svg(60, 20))?;
    for (x, y) in [(30, 25), (190, 150), (-1, 150)] {
        ensure!(check(&svg(x, y)).is_err(), "a text at {x}, {y} passed");
    }
    Ok(())
}
