//! Tests of drawings.

mod counts;
mod edge_cases;
mod outlines;
mod pictures;
mod support;
