//! Depth cells: lists the cells of a depth map that have a triangle to draw.

use super::edge_code::Cell;
use super::samples::Samples;
use crate::layout::DepthMapShape;

/// The output of the stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellList {
    /// Cells that have a triangle to draw, whether the list has room for them or not.
    pub count: u32,
    /// Their entries, strip by strip, as far as there is room.
    pub entries: Vec<u32>,
    /// The indirect draw.
    pub draw: [u32; 4],
}

/// Lists the cells. `depths` has one for each texel.
pub fn depth_cells(shape: &DepthMapShape, depths: &[f32]) -> CellList {
    depth_cells_of_objects(shape, depths, &[])
}

/// Lists the cells of a map with an object for each texel.
pub fn depth_cells_of_objects(shape: &DepthMapShape, depths: &[f32], objects: &[u32]) -> CellList {
    let samples = Samples { shape, depths, objects };
    list_cells(shape, |number| Cell::of(&samples, number))
}

/// The numbers of all cells: map by map strips of eight cells across and four down, row by row, and the rows of each strip.
fn in_strips(shape: &DepthMapShape) -> impl Iterator<Item = u32> {
    let faces = shape.faces;
    let [across, down] = shape.size.map(|side| if faces > 1 { side - 1 } else { side + 1 });
    let corners = (0..faces).flat_map(move |face| {
        let row = move |y| (0..across).step_by(8).map(move |x| (face, x, y));
        (0..down).step_by(4).flat_map(row)
    });
    corners.flat_map(move |(face, x, y)| {
        let number = move |row| (x..across.min(x + 8)).map(move |column| (face * down + row) * across + column);
        (y..down.min(y + 4)).flat_map(number)
    })
}

/// Lists cells that are decided so.
pub(super) fn list_cells(shape: &DepthMapShape, cell: impl Fn(u32) -> Cell) -> CellList {
    let cells = in_strips(shape).map(|number| (number, cell(number)));
    let drawn = cells.filter(|(_, cell)| cell.is_drawn() != [false; 2]);
    let mut entries: Vec<_> = drawn.map(|(number, cell)| cell.entry(number)).collect();
    let count = entries.len() as u32;
    entries.truncate(shape.capacity as usize);
    let taken = if count > shape.capacity { shape.cells } else { count };
    CellList { count, entries, draw: [6 * taken, 1, 0, 0] }
}
