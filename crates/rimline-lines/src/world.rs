//! All objects together, in one numbering of vertices.

use std::borrow::Cow;

use rimline::mesh::MAX_FACES;

use crate::drawing::FaceId;
use crate::error::{Fault, LeftOut, LinesError, check_count};
use crate::exact::{Eye, Plane, face_value, facing};
use crate::object::Object;
use crate::view::View;

/// The bits of two positions.
pub(crate) type Ends = [[u32; 3]; 2];

/// An object that is drawn.
pub(crate) struct Placed<'a> {
    /// Its number among the objects given.
    pub(crate) number: u32,
    pub(crate) object: &'a Object<'a>,
    /// Its first vertex among all.
    pub(crate) first_vertex: u32,
    /// The first of its numbers of polygons. They differ from those of other objects, but are no numbers of triangles.
    pub(crate) first_face: u32,
}

/// The objects that can be drawn, and the eye.
pub(crate) struct World<'a> {
    pub(crate) placed: Vec<Placed<'a>>,
    /// The vertices of all objects. Those that no edge record names may be infinite or NaN.
    pub(crate) positions: Cow<'a, [[f32; 3]]>,
    pub(crate) view: View,
    pub(crate) eye: Eye,
    /// Points that lines name after all vertices.
    pub(crate) pierces: Vec<Pierce>,
    /// The faces that pass through each other, for lines that name them.
    pub(crate) meetings: Vec<[FaceId; 2]>,
}

/// The point where an edge pierces the plane of a face: a mean of the edge's ends.
pub(crate) struct Pierce {
    /// Vertices, the lower one first.
    pub(crate) edge: [u32; 2],
    pub(crate) face: [u32; 3],
    /// Weights of the edge's ends.
    pub(crate) weights: [f64; 2],
    pub(crate) point: [f64; 3],
}

impl Pierce {
    pub(crate) fn new(positions: &[[f32; 3]], edge: [u32; 2], face: [u32; 3]) -> Self {
        let [a, b, c] = face.map(|vertex| positions[vertex as usize]);
        let [p, q] = edge.map(|vertex| positions[vertex as usize]);
        let [from_p, from_q] = [p, q].map(|p| face_value(a, b, c, p).number().abs());
        let weights = [from_q, from_p].map(|height| height / (from_p + from_q));
        let point = [0, 1, 2].map(|axis| weights[0] * f64::from(p[axis]) + weights[1] * f64::from(q[axis]));
        Self { edge, face, weights, point }
    }
}

impl<'a> World<'a> {
    pub(crate) fn new(objects: &'a [Object<'a>], view: View, left_out: &mut Vec<LeftOut>) -> Result<Self, LinesError> {
        let mut placed = Vec::new();
        let (mut vertices, mut faces) = (0_usize, 0_usize);
        for (number, object) in objects.iter().enumerate() {
            if let Some(fault) = fault(object) {
                left_out.push(LeftOut { object: number, name: object.name.clone(), fault });
                continue;
            }
            let number = number as u32;
            placed.push(Placed { number, object, first_vertex: vertices as u32, first_face: faces as u32 });
            vertices += object.mesh.vertex_count() as usize;
            faces += object.mesh.face_count().max(object.mesh.faces().len());
            check_count("vertices", vertices, u32::MAX as usize - 1)?;
            check_count("faces", faces, MAX_FACES)?;
        }
        let positions_of = |placed: &Placed<'a>| &placed.object.positions[..placed.object.mesh.vertex_count() as usize];
        let positions = if let [only] = &*placed {
            Cow::Borrowed(positions_of(only))
        } else {
            Cow::Owned(placed.iter().map(positions_of).collect::<Vec<_>>().concat())
        };
        Ok(Self { placed, positions, view, eye: view.eye().to_array(), pierces: Vec::new(), meetings: Vec::new() })
    }

    /// Where a vertex or the end of a line is.
    pub(crate) fn point(&self, vertex: u32) -> [f64; 3] {
        match self.positions.get(vertex as usize) {
            Some(position) => position.map(f64::from),
            None => self.pierces[vertex as usize - self.positions.len()].point,
        }
    }

    /// The bits of the positions of a line's ends, −0 as 0, the lower one first. `None` if one is no vertex.
    pub(crate) fn key(&self, vertices: [u32; 2]) -> Option<Ends> {
        let bits = |vertex: u32| Some(self.positions.get(vertex as usize)?.map(|c| (c + 0.0).to_bits()));
        let (a, b) = (bits(vertices[0])?, bits(vertices[1])?);
        Some([a.min(b), a.max(b)])
    }

    /// The exact sign of the side of a triangle that the eye sees.
    pub(crate) fn facing(&self, [a, b, c]: [[f32; 3]; 3]) -> i32 {
        let [x, y, z, w] = self.eye;
        let certain = if w == 0.0 {
            Plane::of_face(a, b, c).along([x, y, z].map(f64::from)).certain_sign()
        } else {
            Plane::of_face(a, b, c).height([x, y, z].map(f64::from)).certain_sign()
        };
        if certain == 0 { facing(a, b, c, self.eye) } else { certain }
    }
}

fn fault(object: &Object<'_>) -> Option<Fault> {
    if object.mesh.edges().is_empty() {
        return Some(Fault::NoFaces);
    }
    let (given, needed) = (object.positions.len(), object.mesh.vertex_count());
    if given < needed as usize {
        return Some(Fault::TooFewPositions { given, needed });
    }
    let is_finite = |position: &[f32; 3]| position.iter().all(|c| c.is_finite());
    if object.positions.iter().all(is_finite) {
        return None;
    }
    let mut corners = object.mesh.edges().vertices().iter().flatten();
    corners.find(|&&vertex| !is_finite(&object.positions[vertex as usize])).map(|&vertex| Fault::NotFinite { vertex })
}
