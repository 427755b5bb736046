//! From objects to a drawing.

use std::ops::ControlFlow;

use crate::chains::chains;
use crate::count::{Drawn, Piece, Scratch, count};
use crate::cover::Triangle;
use crate::drawing::{Drawing, Span};
use crate::edges::{Line, lines};
use crate::error::{LinesError, check_count};
use crate::frame::{Frame, Part};
use crate::hiders::hiders;
use crate::meet::meet;
use crate::object::Object;
use crate::options::{LineClass, LineOptions, PageBox};
use crate::parallel::blocks;
use crate::touching::without_touching;
use crate::tree::{Box3, Tree};
use crate::view::View;
use crate::world::World;

/// Lines at a time.
const RUN: usize = 256;

/// Draws objects as an eye sees them. `progress` is called now and then with about the number of lines that are done, and that
/// of all; both are 0 while intersections are looked for. It may end the drawing. The same input gives the same drawing with
/// any number of threads.
///
/// [`Drawing::left_out`] names faulty objects. They are left out, but for [`Fault::NoSuchEdge`](crate::Fault::NoSuchEdge).
///
/// # Errors
/// [`LinesError`] for options out of range, too many faces, too little memory by [`LineOptions::memory_limit`], or if
/// `progress` ends it.
pub fn draw(
    objects: &[Object<'_>],
    view: &View,
    options: &LineOptions,
    mut progress: impl FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<Drawing, LinesError> {
    check(options)?;
    let mut left_out = Vec::new();
    let mut world = World::new(objects, *view, &mut left_out)?;
    check_memory(&world, 0, options)?;
    let mut lines = lines(&world, options, &mut left_out)?;
    if options.classes.contains(LineClass::Intersection) {
        let mut tick = |_| progress(0, 0);
        meet(&mut world, &mut lines, options.threads, &mut tick)?;
        without_touching(&mut lines, &world);
    }
    check_memory(&world, lines.len(), options)?;
    if progress(0, lines.len()).is_break() {
        return Err(LinesError::Cancelled);
    }
    let (frame, parts) = Frame::new(&world, &lines, options)?;
    let tree = hiders(&world, &frame, &parts, options.threads);
    let pieces = pieces(&world, &frame, &tree, &lines, &parts, options, &mut progress)?;
    drop(tree);
    let pieces = Drawn { world: &world, lines: &lines, parts: &parts, pieces: &pieces }.once(&frame, options.threads);
    check_count("pieces of lines", pieces.len(), u32::MAX as usize / 2)?;
    let (spans, chains) = chains(&Drawn { world: &world, lines: &lines, parts: &parts, pieces: &pieces });
    left_out.sort_by_key(|left_out| left_out.object);
    Ok(Drawing { spans, chains, left_out })
}

fn pieces(
    world: &World<'_>,
    frame: &Frame,
    tree: &Tree<Triangle>,
    lines: &[Line],
    parts: &[Option<Part>],
    options: &LineOptions,
    progress: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<Vec<Piece>, LinesError> {
    let run = |block: usize| {
        let (mut scratch, mut pieces) = (Scratch::default(), Vec::new());
        let numbers = block * RUN..((block + 1) * RUN).min(lines.len());
        for number in numbers {
            if let Some(part) = &parts[number] {
                count(world, frame, tree, (number as u32, &lines[number], part), &mut scratch, &mut pieces);
            }
        }
        pieces
    };
    let mut tick = |block: usize| progress(block * RUN, lines.len());
    let found = blocks(options.threads, lines.len().div_ceil(RUN), run, &mut tick).ok_or(LinesError::Cancelled)?;
    Ok(found.concat())
}

fn check(options: &LineOptions) -> Result<(), LinesError> {
    let degrees = options.crease_degrees;
    if !(0.0..=180.0).contains(&degrees) {
        return Err(LinesError::Crease { degrees });
    }
    if let Some(PageBox { low, high }) = options.window {
        let is_finite = [low, high].as_flattened().iter().all(|c| c.is_finite());
        if !is_finite || (0..2).any(|axis| low[axis] >= high[axis]) {
            return Err(LinesError::Window { low, high });
        }
    }
    Ok(())
}

/// Compares an estimate with the limit. With `lines` 0 it is what finding the lines takes, without those where faces meet.
fn check_memory(world: &World<'_>, lines: usize, options: &LineOptions) -> Result<(), LinesError> {
    let Some(limit) = options.memory_limit else { return Ok(()) };
    let vertices = world.positions.len();
    let meshes = world.placed.iter().map(|placed| &placed.object.mesh);
    let (faces, edges) =
        meshes.fold((0, 0), |(faces, edges), mesh| (faces + mesh.faces().len(), edges + mesh.edges().len()));
    let joined_positions = if world.placed.len() == 1 { 0 } else { 12 * vertices };
    // Masks and buckets of edges; then boxes and nodes of faces, and lines with their parts, pieces and spans.
    let finding = 4 * vertices + 4 * faces + 16 * edges;
    let hiding = size_of::<Box3>() * vertices + (size_of::<(Box3, Triangle)>() + size_of::<Box3>() / 2) * faces;
    let drawing =
        (size_of::<Line>() + size_of::<Option<Part>>() + 2 * size_of::<Piece>() + 2 * size_of::<Span>() + 32) * lines;
    let needed = (joined_positions + finding.max(hiding) + drawing) as u64;
    if needed > limit { Err(LinesError::Memory { needed, limit }) } else { Ok(()) }
}
