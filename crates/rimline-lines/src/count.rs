//! The spans of a line: where the number of faces in front changes.

use crate::cover::{Segment, Triangle};
use crate::edges::Line;
use crate::frame::{Frame, Part};
use crate::hiders::Reach;
use crate::tree::Tree;
use crate::world::World;

/// A part of a line with one number of faces in front.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// The index of the line.
    pub(crate) line: u32,
    pub(crate) faces_in_front: u32,
    /// From 0 to 1 along the line.
    pub(crate) ends: [f64; 2],
}

/// All lines of a drawing, with their pieces in order.
pub(crate) struct Drawn<'a> {
    pub(crate) world: &'a World<'a>,
    pub(crate) lines: &'a [Line],
    pub(crate) parts: &'a [Option<Part>],
    pub(crate) pieces: &'a [Piece],
}

/// Changes within this share of the line's page after the first are one cut; so near to an end of the part they are none.
const TOLERANCE: f64 = 1.0 / (1 << 26) as f64;

/// Lists that lines use one after the other.
#[derive(Default)]
pub(crate) struct Scratch {
    /// Where faces begin and end to hide the line.
    changes: Vec<(f64, i32)>,
    /// The same for triangles of polygons.
    toggles: Vec<(u32, f64)>,
}

/// Adds the pieces of a line.
pub(crate) fn count(
    world: &World<'_>,
    frame: &Frame,
    tree: &Tree<Triangle>,
    (number, line, part): (u32, &Line, &Part),
    scratch: &mut Scratch,
    pieces: &mut Vec<Piece>,
) {
    let is_perspective = world.view.is_perspective();
    let is_cut_off = part.ends != [0.0, 1.0];
    let segment = Segment::new(world, line.vertices, is_cut_off);
    scratch.changes.clear();
    scratch.toggles.clear();
    let reach = Reach::new(frame, part);
    tree.visit(
        |row| reach.meets(row),
        |triangle| {
            let Some(behind) = segment.part_behind(triangle) else { return };
            if triangle.polygon() == Triangle::ALONE {
                scratch.changes.extend([(behind[0], 1), (behind[1], -1)]);
            } else {
                scratch.toggles.extend(behind.map(|at| (triangle.polygon(), at)));
            }
        },
    );
    scratch.count_polygons();
    let Scratch { changes, .. } = scratch;
    changes.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
    let along = |at: f64| part.along(at.clamp(part.ends[0], part.ends[1]), is_perspective);
    let mut faces_in_front = 0;
    let (mut begin, mut at) = (part.ends[0], 0);
    let mut add = |ends: [f64; 2], faces: i32| {
        pieces.push(Piece { line: number, faces_in_front: faces.max(0) as u32, ends });
    };
    while at < changes.len() {
        let cut = changes[at].0;
        let from = along(cut);
        let mut change = 0;
        while let Some(next) = changes.get(at).filter(|next| along(next.0) <= from + TOLERANCE) {
            change += next.1;
            at += 1;
        }
        if from >= 1.0 - TOLERANCE {
            break;
        }
        if change != 0 && from > TOLERANCE {
            add([begin, cut], faces_in_front);
            begin = cut;
        }
        faces_in_front += change;
    }
    add([begin, part.ends[1]], faces_in_front);
}

impl Scratch {
    /// A polygon hides a point that an odd number of its triangles hide.
    fn count_polygons(&mut self) {
        self.toggles.sort_unstable_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
        for polygon in self.toggles.chunk_by(|one, other| one.0 == other.0) {
            let mut change = 1;
            for toggles in polygon.chunk_by(|one, other| one.1 == other.1).filter(|same| same.len() % 2 == 1) {
                self.changes.push((toggles[0].1, change));
                change = -change;
            }
        }
    }
}
