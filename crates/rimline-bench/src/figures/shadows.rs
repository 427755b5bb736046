//! The report's section on shadows.

use super::{Quotient, cloud, ratios};
use crate::chart::{Point, Series};
use crate::engine::Metric;
use crate::page::{Figure, Section as Part, Table};
use crate::row::Row;
use crate::shadows::Z_PASS;
use crate::text::{grouped, three_digits};

pub(super) fn section(rows: &[&Row]) -> Part {
    let [size, frames] = ["size", "frames"].map(|fact| rows[0].number(fact));
    Part {
        title: "Shadow volumes".to_owned(),
        lead: format!(
            "One caster in the middle of a closed room, one point light, {size} × {size} pixels, paths of {frames} cameras, \
             after Hornus and others, ZP+: correct z-pass stencil shadows (2005). The stencil pass counts volumes; the whole \
             frame also extracts silhouettes, chooses, and draws depth and light. All methods of a path ran in turn, round \
             by round."
        ),
        figures: vec![
            time_against_error(rows),
            costs(rows, "shadow_stencil", "stencil", "stencil pass"),
            costs(rows, "shadow_frame", "frame", "whole frame"),
        ],
    }
}

/// One point a method and path.
fn time_against_error(rows: &[&Row]) -> Figure {
    let mut table =
        Table::new(["Method, model, path", "stencil ms a frame", "wrong pixels a frame", "frames looked at"]);
    let mut series = Vec::new();
    for (index, first) in rows[0].entries.iter().enumerate() {
        let variant = &first.variant;
        let mut points = Vec::new();
        for row in rows {
            let entry = &row.entries[index];
            let wrong = entry.values(Metric::Count("wrong_pixels"));
            let share = entry.count("wrong_pixels") / wrong.len().max(1) as f64;
            let ms = entry.median(Metric::Time("stencil")).unwrap_or(f64::NAN);
            points.push(Point { x: ms, y: share, quartiles: [share; 2] });
            let name = format!("{}: {}, {}", variant.name, row.group, row.title);
            table.rows.push(vec![name, three_digits(ms), three_digits(share), grouped(wrong.len())]);
        }
        series.push(Series { name: variant.name.clone(), mark: variant.mark, points });
    }
    let axes = ["stencil pass: ms a frame (left is faster)", "wrong pixels a frame"];
    let lead = format!(
        "One mark for each method, model and path. Wrong is a pixel that is lit or shadowed otherwise than by rays in double \
         precision, more than a pixel from the shadow's edge; of {} pixels. Where the camera stands in the shadow z-pass is \
         wrong nearly everywhere. The one pixel in a few frames that is wrong by every method has an edge within the \
         rasteriser's grid of its centre (docs/numerics/rasterisers.md, Hairlines).",
        grouped(rows[0].number("size").powi(2) as usize)
    );
    let title = "Shadows: run time against error";
    Figure::new("shadow_time_against_error", title, lead, Some(cloud(axes, series)), table)
}

/// Time ÷ time of z-pass, a line a model and path.
fn costs(rows: &[&Row], id: &'static str, part: &'static str, what: &str) -> Figure {
    let quotients = [
        Quotient::new("z-fail", "z-fail", Z_PASS, (0, 1, false)),
        Quotient::new("ZP+ as published", "zp+paper", Z_PASS, (1, 4, false)),
        Quotient::new("ZP+ clipped", "zp+", Z_PASS, (2, 3, false)),
        Quotient::new("auto", "auto", Z_PASS, (4, 0, false)),
    ];
    let (chart, table) =
        ratios(&format!("time of the {what} ÷ time with z-pass"), rows, Metric::Time(part), &quotients);
    let title = format!("Cost of counting: the {what} against z-pass");
    let lead = format!(
        "Time of the {what} over the path ÷ the same with z-pass, in the same run; on the dashed line it costs what z-pass \
         costs, which is wrong where the camera stands in a shadow. The last line is the mean of those above."
    );
    Figure::new(id, title, lead, Some(chart), table)
}
