//! How a summary of times is written.

use serde_json::{Value, json};

use super::measure::Summary;

pub(super) fn summary_json(summary: &Summary) -> Value {
    json!({
        "median": summary.median,
        "q1": summary.quartiles.0,
        "q3": summary.quartiles.1,
        "low": summary.range.0,
        "high": summary.range.1,
        "runs": summary.count,
    })
}
