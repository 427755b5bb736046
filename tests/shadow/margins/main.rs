//! The margins of shadow volumes: where a rounding more or less decides whether something is skipped, where volumes end,
//! and what no count exceeds. Each against `f64` or counting by hand, written apart from `src/`.

mod boxes;
mod counts;
mod ends;
mod near_plane;
mod view;
