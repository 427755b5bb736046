//! Chains: pieces of one class, visible or hidden, joined at their ends.

use crate::count::Drawn;
use crate::drawing::{Chain, Span};
use crate::edges::Line;
use crate::frame::point_at;
use crate::options::LineClass;

/// An end of a piece: twice the piece, and 1 for where it ends.
type End = u32;
const NONE: End = u32::MAX;

/// Where more ends than this meet, each is joined with the next that fits, not by angle, and some may stay alone.
const BY_ANGLE: usize = 16;

/// The spans of all pieces in the order of their chains.
pub(crate) fn chains(drawn: &Drawn<'_>) -> (Vec<Span>, Vec<Chain>) {
    let pieces = drawn.pieces;
    let next = drawn.joined();
    let mut order: Vec<End> = (0..pieces.len() as u32).collect();
    order.sort_by_key(|&piece| drawn.kind(piece));
    let (mut spans, mut chains) = (Vec::with_capacity(pieces.len()), Vec::new());
    let mut is_taken = vec![false; pieces.len()];
    let mut walk = |begin: End, spans: &mut Vec<Span>| {
        let first = spans.len();
        let mut end = begin;
        while !std::mem::replace(&mut is_taken[end as usize / 2], true) {
            spans.push(drawn.span(end));
            end = next[(end ^ 1) as usize];
            if end == NONE {
                break;
            }
        }
        if spans.len() > first {
            let (class, is_hidden) = drawn.kind(begin / 2);
            let is_closed = end == begin;
            chains.push(Chain { class, is_hidden, spans: first..spans.len(), is_closed });
        }
    };
    for pieces in order.chunk_by(|&one, &other| drawn.kind(one) == drawn.kind(other)) {
        // Open chains from the end where they begin, then closed ones.
        for &piece in pieces {
            for end in [2 * piece, 2 * piece + 1] {
                let may_begin = end % 2 == 0 || !is_directed(drawn.kind(piece).0);
                if next[end as usize] == NONE && may_begin {
                    walk(end, &mut spans);
                }
            }
        }
        for &piece in pieces {
            walk(2 * piece, &mut spans);
        }
    }
    (spans, chains)
}

/// Whether the two sides of a line differ, so that it has a direction.
fn is_directed(class: LineClass) -> bool {
    matches!(class, LineClass::Silhouette | LineClass::Boundary)
}

impl Drawn<'_> {
    fn line(&self, piece: u32) -> &Line {
        &self.lines[self.pieces[piece as usize].line as usize]
    }

    fn kind(&self, piece: u32) -> (LineClass, bool) {
        (self.line(piece).class, self.pieces[piece as usize].faces_in_front > 0)
    }

    /// The span of a piece that begins at this end of it.
    fn span(&self, end: End) -> Span {
        let piece = &self.pieces[end as usize / 2];
        let line = self.line(end / 2);
        let points = line.vertices.map(|vertex| self.world.point(vertex));
        let mut ends = piece.ends.map(|at| point_at(points, at));
        if end % 2 == 1 {
            ends.reverse();
        }
        Span {
            class: line.class,
            faces_in_front: piece.faces_in_front,
            object: self.world.placed[line.placed as usize].number,
            edge: (line.class != LineClass::Intersection).then_some(line.record),
            faces: line.faces(self.world),
            ends,
            page: ends.map(|end| self.world.view.page(end)),
        }
    }

    /// For each end the one that it is joined with.
    fn joined(&self) -> Vec<End> {
        let mut next = vec![NONE; 2 * self.pieces.len()];
        let mut join = |one: End, other: End| {
            next[one as usize] = other;
            next[other as usize] = one;
        };
        // Pieces of one line follow each other.
        for (piece, pair) in (0..).zip(self.pieces.windows(2)) {
            let is_next = pair[0].line == pair[1].line && pair[0].ends[1] == pair[1].ends[0];
            if is_next && self.kind(piece) == self.kind(piece + 1) {
                join(2 * piece + 1, 2 * piece + 2);
            }
        }
        let mut at_vertices: Vec<(u32, (LineClass, bool), End)> = Vec::new();
        for (number, piece) in (0..).zip(self.pieces) {
            for (side, vertex) in self.line(number).vertices.into_iter().enumerate() {
                if piece.ends[side] == side as f64 {
                    at_vertices.push((vertex, self.kind(number), 2 * number + side as u32));
                }
            }
        }
        at_vertices.sort_unstable();
        for ends in at_vertices.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            let ends: Vec<End> = ends.iter().map(|&(.., end)| end).collect();
            self.pairs(&ends).into_iter().for_each(|[one, other]| join(one, other));
        }
        next
    }

    /// Which ends at a vertex go on as which: those in the straightest row on the page first.
    fn pairs(&self, ends: &[End]) -> Vec<[End; 2]> {
        let may_join = |one: End, other: End| {
            one / 2 != other / 2 && (!is_directed(self.line(one / 2).class) || one % 2 != other % 2)
        };
        if let &[one, other] = ends {
            return if may_join(one, other) { vec![[one, other]] } else { Vec::new() };
        }
        let mut possible = Vec::new();
        for (at, &one) in ends.iter().enumerate() {
            for &other in &ends[at + 1..] {
                if may_join(one, other) {
                    let turn = if ends.len() > BY_ANGLE { 0.0 } else { self.cosine(one, other) };
                    possible.push((turn, one, other));
                    if ends.len() > BY_ANGLE {
                        break;
                    }
                }
            }
        }
        possible.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut pairs: Vec<[End; 2]> = Vec::new();
        let mut is_used = vec![false; ends.len()];
        let index = |end: End| ends.binary_search(&end).unwrap_or(0);
        for (_, one, other) in possible {
            if !is_used[index(one)] && !is_used[index(other)] {
                is_used[index(one)] = true;
                is_used[index(other)] = true;
                pairs.push([one, other]);
            }
        }
        pairs
    }

    /// The cosine of the angle on the page between the directions in which two pieces leave their common end: −1 for a straight
    /// row.
    fn cosine(&self, one: End, other: End) -> f64 {
        let direction = |end: End| {
            let page = self.parts[self.pieces[end as usize / 2].line as usize].map_or([[0.0; 2]; 2], |part| part.page);
            let [x, y] =
                [0, 1].map(|axis| (page[1][axis] - page[0][axis]) * if end.is_multiple_of(2) { 1.0 } else { -1.0 });
            let length = (x * x + y * y).sqrt();
            [x / length, y / length]
        };
        let ([x, y], [u, v]) = (direction(one), direction(other));
        x * u + y * v
    }
}
