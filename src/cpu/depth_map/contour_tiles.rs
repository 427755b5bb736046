//! Contour tiles: the tiles that a contour crosses.

use super::contour::{Map, TILE, sum};
use super::contour_marks::code_of_cell;

/// The tiles that have a cell with a marked edge, in their order.
pub fn contour_tiles(map: &Map<'_>, marks: &[u32]) -> Vec<u32> {
    let [width, height] = map.lattice().map(|samples| samples - 1);
    let across = map.shape.tiles[0] as i32;
    let is_crossed = |&tile: &u32| {
        let corner = [tile as i32 % across, tile as i32 / across].map(|at| at * TILE);
        (0..TILE * TILE).any(|number| {
            let cell = sum(corner, [number % TILE, number / TILE]);
            cell[0] < width && cell[1] < height && code_of_cell(map, marks, cell) != 0
        })
    };
    (0..map.shape.tiles[1]).filter(is_crossed).collect()
}
