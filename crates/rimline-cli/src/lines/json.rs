//! JSON: every span and chain, with the indices of its objects, edges and faces. An element of a list is a line.

use std::io::{self, Write};

use rimline_lines::{Chain, FaceId, Span};
use serde_json::{Value, json};

use super::Picture;
use crate::coordinates;

pub(super) fn write(to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
    let Picture { drawing, sheet, .. } = picture;
    let (view, is_perspective) = (&picture.eye.view, picture.eye.view.is_perspective());
    let eye = coordinates::light(&view.eye(), picture.origin);
    let left_out = drawing.left_out.iter().map(|left| json!({ "object": left.object, "why": left.fault.to_string() }));
    let head = [
        ("rimline", json!(env!("CARGO_PKG_VERSION"))),
        ("title", json!(picture.title())),
        ("view", json!({ "eye": eye, "perspective": is_perspective })),
        ("page_mm", json!(sheet.size_mm)),
        ("mm_per_unit", if is_perspective { Value::Null } else { json!(sheet.mm_per_unit) }),
        ("objects", picture.objects.iter().map(|object| json!(object.name)).collect()),
        ("left_out", left_out.collect()),
    ];
    writeln!(to, "{{")?;
    for (key, value) in head {
        writeln!(to, "{}: {value},", json!(key))?;
    }
    let origin = picture.origin.to_array();
    let face = |face: FaceId| json!({ "object": face.object, "face": face.face });
    let span = |span: &Span| {
        json!({
            "class": span.class.name(),
            "faces_in_front": span.faces_in_front,
            "object": span.object,
            "edge": span.edge,
            "faces": span.faces.into_iter().flatten().map(face).collect::<Vec<_>>(),
            "world": span.ends.map(|end| [0, 1, 2].map(|axis| end[axis] + origin[axis])),
            "page": span.page.map(|end| sheet.to_mm(end).map(|mm| libm::round(1e6 * mm) / 1e6)),
        })
    };
    let chain = |chain: &Chain| {
        json!({
            "class": chain.class.name(),
            "hidden": chain.is_hidden,
            "closed": chain.is_closed,
            "first": chain.spans.start,
            "count": chain.spans.len(),
        })
    };
    list(to, "spans", drawing.spans.iter().map(span))?;
    writeln!(to, ",")?;
    list(to, "chains", drawing.chains.iter().map(chain))?;
    writeln!(to, "\n}}")
}

fn list(to: &mut impl Write, key: &str, elements: impl Iterator<Item = Value>) -> io::Result<()> {
    write!(to, "{}: [", json!(key))?;
    for (number, element) in elements.enumerate() {
        write!(to, "{}\n{element}", if number == 0 { "" } else { "," })?;
    }
    write!(to, "]")
}
