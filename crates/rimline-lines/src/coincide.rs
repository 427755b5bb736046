//! Lines that coincide on the page are drawn once.

use rimline::cpu::Threads;

use crate::count::{Drawn, Piece};
use crate::exact::is_in_plane;
use crate::frame::{Frame, Part};
use crate::hiders::Reach;
use crate::options::LineClass;
use crate::parallel::ranges;
use crate::tree::{Box3, Tree};

/// Overlaps shorter than this share of a line's page are none. Shorter rests of lines that coincide are left out.
const LEAST: f64 = 1e-7;
/// Lines at a time.
const RUN: usize = 1024;

impl Drawn<'_> {
    /// The pieces without what coincides with a better piece, in front of it or behind it. Visible ones are better than hidden
    /// ones, then those of the higher class, then those with fewer faces in front, then those of the first line.
    pub(crate) fn once(&self, frame: &Frame, threads: Threads) -> Vec<Piece> {
        let item = |(line, part): (u32, &Option<Part>)| Some((frame.bounds_of_part(part.as_ref()?), line));
        let items: Vec<_> = (0..).zip(self.parts).filter_map(item).collect();
        let tree = Tree::new(items.len(), (2, &Box3::UNIT), threads, |at| items[at]);
        // A pair is found from both of its lines, and held for one line at a time: there may be as many as the square of the
        // lines.
        let found = ranges(threads, self.lines.len(), RUN, |range| {
            let [first, last] =
                [range.start, range.end].map(|line| self.pieces.partition_point(|piece| (piece.line as usize) < line));
            let (mut others, mut kept) = (Vec::new(), Vec::new());
            for of_line in self.pieces[first..last].chunk_by(|one, other| one.line == other.line) {
                self.find(frame, &tree, of_line[0].line, &mut others);
                if others.is_empty() {
                    kept.extend_from_slice(of_line);
                } else {
                    self.keep(of_line, &others, &mut kept);
                }
            }
            kept
        });
        found.concat()
    }

    /// The lines that coincide with one, in order.
    fn find(&self, frame: &Frame, tree: &Tree<u32>, line: u32, others: &mut Vec<u32>) {
        others.clear();
        let Some(part) = &self.parts[line as usize] else { return };
        let reach = Reach::new(frame, part).at_all_depths();
        // A line finds another that overlaps it by more than the least share of its length, and does not lie wholly behind it.
        let finds =
            |one: u32, other: u32| self.coincide(one as usize, other as usize) && !self.is_before(frame, one, other);
        tree.visit(
            |row| reach.meets(row),
            |other| {
                if other != line && (finds(line, other) || finds(other, line)) {
                    others.push(other);
                }
            },
        );
        others.sort_unstable();
    }

    /// Whether all of a line is nearer than all of another.
    fn is_before(&self, frame: &Frame, line: u32, other: u32) -> bool {
        let [one, other] =
            [line, other].map(|line| self.parts[line as usize].as_ref().map(|part| frame.bounds_of_part(part)));
        one.zip(other).is_some_and(|(one, other)| other.low[2] > one.high[2])
    }

    /// Whether two lines lie in one plane with the eye, and overlap on the page.
    fn coincide(&self, line: usize, other: usize) -> bool {
        let (Some(part), Some(other_part)) = (&self.parts[line], &self.parts[other]) else { return false };
        let [[px, py], [qx, qy]] =
            [part, other_part].map(|part| [0, 1].map(|axis| part.page[1][axis] - part.page[0][axis]));
        let sine = (px * qy - py * qx).abs();
        if sine * sine > 1e-8 * (px * px + py * py) * (qx * qx + qy * qy) {
            return false;
        }
        let [from, to] = overlap(part, other_part.page);
        if to - from <= LEAST {
            return false;
        }
        let vertices = [line, other].map(|line| self.lines[line].vertices);
        if vertices.as_flattened().iter().any(|&vertex| vertex as usize >= self.world.positions.len()) {
            // Points where faces meet are rounded.
            let across = other_part.page.map(|[x, y]| (x - part.page[0][0]) * py - (y - part.page[0][1]) * px);
            return across.into_iter().all(|across| across.abs() < LEAST * (px * px + py * py));
        }
        let [[a, b], ends] = vertices.map(|ends| ends.map(|vertex| self.world.positions[vertex as usize]));
        ends.into_iter().all(|end| is_in_plane(a, b, end, self.world.eye))
    }

    /// The pieces of one line that are kept, with the lines that coincide with it.
    fn keep(&self, of_line: &[Piece], coinciding: &[u32], kept: &mut Vec<Piece>) {
        let line = of_line[0].line as usize;
        let Some(part) = &self.parts[line] else { return };
        let is_perspective = self.world.view.is_perspective();
        // Pieces of other lines, by where they are along this one's page, and their ranks.
        let mut others = Vec::new();
        for &other in coinciding {
            let first = self.pieces.partition_point(|piece| piece.line < other);
            for piece in self.pieces[first..].iter().take_while(|piece| piece.line == other) {
                let points = self.lines[other as usize].vertices.map(|vertex| self.world.point(vertex));
                let page = piece.ends.map(|at| self.world.view.page(crate::frame::point_at(points, at)));
                let [from, to] = overlap(part, page);
                if to - from > LEAST {
                    others.push(([from, to], self.rank(piece)));
                }
            }
        }
        for piece in of_line {
            let ends = piece.ends.map(|at| part.along(at, is_perspective));
            let better = others.iter().filter(|(_, rank)| *rank < self.rank(piece)).map(|(ends, _)| *ends);
            let mut better: Vec<[f64; 2]> = better.collect();
            better.sort_unstable_by(|one, other| one[0].total_cmp(&other[0]));
            let at =
                |along: f64, of: usize| if along == ends[of] { piece.ends[of] } else { part.at(along, is_perspective) };
            let mut begin = ends[0];
            for [from, to] in better.into_iter().chain([[ends[1]; 2]]) {
                let end = from.min(ends[1]);
                if end - begin > LEAST {
                    kept.push(Piece { ends: [at(begin, 0), at(end, 1)], ..*piece });
                }
                begin = begin.max(to);
            }
        }
    }

    fn rank(&self, piece: &Piece) -> (bool, LineClass, u32, u32) {
        let class = self.lines[piece.line as usize].class;
        (piece.faces_in_front > 0, class, piece.faces_in_front, piece.line)
    }
}

/// Where points of the page lie along a part, 0 to 1: the lower one first.
fn overlap(part: &Part, page: [[f64; 2]; 2]) -> [f64; 2] {
    let [a, b] = part.page;
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    let along = page.map(|[px, py]| (((px - a[0]) * x + (py - a[1]) * y) / (x * x + y * y)).clamp(0.0, 1.0));
    [along[0].min(along[1]), along[0].max(along[1])]
}
