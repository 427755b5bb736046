//! The drawing: spans of lines and chains of them.

use std::ops::Range;

use crate::error::LeftOut;
use crate::options::{LineClass, PageBox};

/// A piece of a line with one number of faces in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Why the line is drawn.
    pub class: LineClass,
    /// How many faces hide it; 0 is visible. A polygon counts once. A face that contains the point itself hides nothing.
    pub faces_in_front: u32,
    /// The object, by its number among those given. For an intersection that of the first face.
    pub object: u32,
    /// The edge, as an index in [`rimline::Mesh::edges`]; an edge of several records has the lowest. `None` for an
    /// intersection.
    pub edge: Option<u32>,
    /// The faces of the edge record, or those that pass through each other. The second is `None` if the record has one face.
    /// The further faces of an edge of several records are not here.
    pub faces: [Option<FaceId>; 2],
    /// Its ends in world space.
    pub ends: [[f64; 3]; 2],
    /// Its ends on the page; see [`View`](crate::View) for the unit.
    pub page: [[f64; 2]; 2],
}

/// A face of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceId {
    /// The object, by its number among those given.
    pub object: u32,
    /// The face: a polygon, or a triangle in [`rimline::Mesh::faces`].
    pub face: u32,
}

/// Spans in a row, all visible or all hidden, of one class. Each begins where the one before ends. Faces that the eye
/// sees are on the left of silhouettes and boundaries.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chain {
    /// Their class.
    pub class: LineClass,
    /// Whether they are hidden.
    pub is_hidden: bool,
    /// Where they are in [`Drawing::spans`].
    pub spans: Range<usize>,
    /// Whether the last one goes on as the first one, and so ends where that begins.
    pub is_closed: bool,
}

/// The lines that an eye sees, and those behind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The spans, one chain after the other.
    pub spans: Vec<Span>,
    /// The chains: by class, visible ones first.
    pub chains: Vec<Chain>,
    /// Objects that are not drawn, or not as asked.
    pub left_out: Vec<LeftOut>,
}

impl Drawing {
    /// The points of a chain on the page. A closed chain does not repeat its first point.
    pub fn page_points(&self, chain: &Chain) -> Vec<[f64; 2]> {
        let spans = self.spans.get(chain.spans.clone()).unwrap_or_default();
        let last = spans.last().filter(|_| !chain.is_closed).map(|span| span.page[1]);
        spans.iter().map(|span| span.page[0]).chain(last).collect()
    }

    /// The smallest rectangle of the page around the spans with at most this many faces in front. `None` if there are none.
    pub fn bounds(&self, faces_in_front: u32) -> Option<PageBox> {
        let spans = self.spans.iter().filter(|span| span.faces_in_front <= faces_in_front);
        let boxes = spans.flat_map(|span| span.page).map(|point| PageBox { low: point, high: point });
        boxes.reduce(|one, other| PageBox {
            low: [0, 1].map(|axis| one.low[axis].min(other.low[axis])),
            high: [0, 1].map(|axis| one.high[axis].max(other.high[axis])),
        })
    }
}
