//! Tests of drawings.

mod counts;
mod edge_cases;
mod outlines;
mod support;
