//! The programs of extraction: which pipelines its options need.

use super::buffers::Shape;
use super::options::ExtractorOptions;
use crate::gpu::common::pipelines::Program;
use crate::method::Predicate;
use crate::stages::{
    ARGUMENTS, COMPACT, CUT_EDGES, CUT_QUADS, EDGES, EXACT_FACING, FACING, OUTLINE, PER_EDGE, POLYGON_FACING,
    POLYGON_MASKS, POLYGON_TURNS, Stage,
};

/// All programs of a mesh of this shape whose positions fit one window, in the order of the stages. `facing_words` are those of
/// a window of facing masks.
pub(super) fn all(device: &wgpu::Device, options: &ExtractorOptions, shape: &Shape, facing_words: u32) -> Vec<Program> {
    let mut programs = Vec::new();
    let Some(polygons) = &shape.polygons else {
        programs.extend(faces(options));
        programs.extend(from_facing(options, 0, facing_words));
        return programs;
    };
    let cut: &[_] = if polygons.pieces > 0 { &[&CUT_QUADS, &CUT_EDGES] } else { &[] };
    let stages = [&POLYGON_FACING, &POLYGON_TURNS, &OUTLINE, &POLYGON_MASKS];
    programs.extend(stages.iter().chain(cut).map(|stage| of_polygons(device, stage, 0)));
    programs.extend(cut_rows(device, 0).filter(|_| !cut.is_empty()));
    programs.extend(from_facing(options, shape.faces, facing_words));
    programs
}

/// All programs of a mesh of triangles whose arrays each fit one window.
pub(crate) fn of_triangles(options: &ExtractorOptions) -> Vec<Program> {
    faces(options).chain(from_facing(options, 0, 0)).collect()
}

/// The programs that read positions of triangles.
fn faces(options: &ExtractorOptions) -> impl Iterator<Item = Program> {
    [from_positions(options, 0)].into_iter().chain(is_exact(options).then(|| exact_facing(0)))
}

/// The programs after facing. Polygons' masks that are twisted begin at `twisted_at`, if it is not 0.
fn from_facing(options: &ExtractorOptions, twisted_at: usize, facing_words: u32) -> Vec<Program> {
    let mut programs = Vec::new();
    if !options.method().is_per_edge() && (options.masks || options.lists.is_some()) {
        programs.push(edges(options, twisted_at, facing_words));
    }
    if let Some(lists) = options.lists {
        programs.extend(compact().into_iter().filter(|_| lists.ordered));
        programs.push(arguments());
    }
    programs
}

/// The program that reads positions: facing, or the per-edge method.
pub(super) fn from_positions(options: &ExtractorOptions, window_words: u32) -> Program {
    let windows = ("WINDOW_WORDS", f64::from(window_words));
    let predicate = options.method().predicate(options.predicate);
    let plane = ("PLANE", f64::from(u8::from(predicate.is_plane())));
    if options.method().is_per_edge() {
        let [masks, append] = emit_constants(options);
        return Program::of(&PER_EDGE, &[windows, plane, masks, append]);
    }
    Program::of(&FACING, &[windows, plane, ("EXACT", f64::from(u8::from(is_exact(options))))])
}

/// Exact facing, which also reads positions.
pub(super) fn exact_facing(window_words: u32) -> Program {
    Program::of(&EXACT_FACING, &[("WINDOW_WORDS", f64::from(window_words))])
}

/// A stage of polygons.
pub(super) fn of_polygons(device: &wgpu::Device, stage: &'static Stage, window_words: u32) -> Program {
    let row = ("ENTRY_ROW", f64::from(device.limits().max_compute_workgroups_per_dimension));
    Program::of(stage, &[row, ("WINDOW_WORDS", f64::from(window_words))])
}

/// The passes of cut edges after the first, which go over what that lists.
pub(super) fn cut_rows(device: &wgpu::Device, window_words: u32) -> impl Iterator<Item = Program> {
    let first = of_polygons(device, &CUT_EDGES, window_words);
    CUT_EDGES.entry_points.iter().skip(1).map(move |&entry_point| Program { entry_point, ..first.clone() })
}

/// Edges from facing masks, which are read in windows of so many words. With polygons, `twisted_at` is where the masks of those
/// that are twisted begin.
pub(super) fn edges(options: &ExtractorOptions, twisted_at: usize, window_words: u32) -> Program {
    let [masks, append] = emit_constants(options);
    Program::of(
        &EDGES,
        &[("FACING_WINDOW_WORDS", f64::from(window_words)), masks, append, ("TWISTED_AT", twisted_at as f64)],
    )
}

/// Compaction in edge order: count, scan, scatter.
pub(super) fn compact() -> [Program; 3] {
    ["compact_count", "compact_scan", "compact_scatter"].map(|entry_point| Program {
        stage: &COMPACT,
        entry_point,
        constants: Vec::new(),
    })
}

/// Draw arguments.
pub(super) fn arguments() -> Program {
    Program::of(&ARGUMENTS, &[])
}

fn is_exact(options: &ExtractorOptions) -> bool {
    options.method().predicate(options.predicate) == Predicate::Exact
}

/// Masks are written if they are asked for or if ordered lists are made from them. Appending makes unordered lists.
fn emit_constants(options: &ExtractorOptions) -> [(&'static str, f64); 2] {
    let ordered = options.lists.is_some_and(|lists| lists.ordered);
    let append = options.lists.is_some() && !ordered;
    [("WRITE_MASKS", f64::from(u8::from(options.masks || ordered))), ("APPEND", f64::from(u8::from(append)))]
}
