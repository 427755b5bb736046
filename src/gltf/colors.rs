//! Base colours of faces and vertices.

use super::document::{Primitive, VEC4, checked};
use super::error::GltfError;
use super::reader::{self, Reader};
use crate::mesh::weld::{bits, same_bits};
use crate::model::Geometry;

/// Base colours of a geometry: red, green and blue, linear, from 0 to 1. The corner of a face has the colour of the face
/// multiplied by that of the vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Colors {
    /// One for each face. `None`: all are white.
    pub faces: Option<Vec<[f32; 3]>>,
    /// One for each vertex. `None`: all are white.
    pub vertices: Option<Vec<[f32; 3]>>,
}

pub(super) const WHITE: [f32; 3] = [1.0; 3];

/// A component from 0 to 1. NaN is 0.
fn clamped(component: f32) -> f32 {
    if component.is_nan() { 0.0 } else { component.clamp(0.0, 1.0) }
}

/// The factor of a primitive's material.
pub(super) fn of_material(reader: &Reader<'_>, primitive: &Primitive) -> Result<[f32; 3], GltfError> {
    let material = checked(&primitive.material)?.map(|material| checked(&reader.document.materials[material].part));
    Ok(material.transpose()?.map_or(WHITE, |color| color.map(clamped)))
}

/// The colours of a primitive's vertices, if it has some; `json_path` is its JSON path.
pub(super) fn of_vertices(
    reader: &Reader<'_>,
    primitive: &Primitive,
    vertices: usize,
    json_path: &str,
) -> Result<Option<Vec<[f32; 3]>>, GltfError> {
    let Some(accessor) = *checked(&primitive.color)? else { return Ok(None) };
    let json_path = format!("{json_path}.attributes.COLOR_0");
    reader.check_count(accessor, vertices, &json_path)?;
    reader.budget.charge(vertices as u64, 12, &|| json_path.clone())?;
    Ok(Some(if reader.accessor(accessor)?.kind == VEC4 {
        let colors = reader.vectors::<4>(accessor, reader::COLORS_WITH_ALPHA, &json_path)?;
        colors.iter().map(|&[red, green, blue, _]| [red, green, blue].map(clamped)).collect()
    } else {
        let colors = reader.vectors::<3>(accessor, reader::COLORS, &json_path)?;
        colors.iter().map(|color| color.map(clamped)).collect()
    }))
}

/// Bytes that [`Colors::split_seams`] and [`Colors::welded`] take for a vertex and for a face, if vertices have colours.
pub(super) const WELDING: [u64; 2] = [4 + 12, 12];

impl Colors {
    /// Multiplies the colour of every face by the mean colour of its corners, and removes the colours of vertices, if any
    /// vertices at one position have different colours: welding would mix these. The faces may have any number of corners;
    /// without corners they keep their colour. Colours that are missing are white.
    pub fn split_seams<'a>(&mut self, positions: &[[f32; 3]], faces: impl ExactSizeIterator<Item = &'a [u32]>) {
        let Some(vertices) = &self.vertices else { return };
        let mut order: Vec<u32> = (0..positions.len() as u32).collect();
        order.sort_unstable_by_key(|&v| positions[v as usize].map(bits));
        let is_seam = |pair: &[u32]| {
            let [a, b] = [pair[0] as usize, pair[1] as usize];
            same_bits(positions[a], positions[b]) && vertices.get(a) != vertices.get(b)
        };
        if !order.windows(2).any(is_seam) {
            return;
        }
        let of_faces = self.faces.get_or_insert_default();
        of_faces.resize(of_faces.len().max(faces.len()), WHITE);
        for (color, corners) in of_faces.iter_mut().zip(faces).filter(|(_, corners)| !corners.is_empty()) {
            for (channel, value) in color.iter_mut().enumerate() {
                let of_corner = |&v: &u32| f64::from(vertices.get(v as usize).unwrap_or(&WHITE)[channel]);
                let sum: f64 = corners.iter().map(of_corner).sum();
                *value *= (sum / corners.len() as f64) as f32;
            }
        }
        self.vertices = None;
    }

    /// The colours once vertices are welded, where the same faces name other vertices. A welded vertex has the colour of the
    /// first that a face names. [`Self::split_seams`] sees to it that those at one position have the same, but not those
    /// that [`Weld::Distance`](crate::mesh::Weld::Distance) welds.
    #[must_use]
    pub fn welded(self, before: &[[u32; 3]], after: &Geometry) -> Self {
        let renumbered = |old: Vec<[f32; 3]>| {
            let mut new = vec![WHITE; after.positions().len()];
            let corners = before.as_flattened().iter().zip(after.faces().as_flattened());
            for (&from, &to) in corners.rev() {
                if let (Some(new), Some(&old)) = (new.get_mut(to as usize), old.get(from as usize)) {
                    *new = old;
                }
            }
            new
        };
        Self { vertices: self.vertices.map(renumbered), ..self }
    }

    /// Whether all is white.
    pub(super) fn is_white(&self) -> bool {
        self.faces.is_none() && self.vertices.is_none()
    }

    /// The size in memory, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        [&self.faces, &self.vertices].into_iter().flatten().map(|colors| 12 * colors.capacity() as u64).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::GeometryOptions;

    #[test]
    fn colours_that_are_missing_are_white() {
        let (red, faces) = ([1.0, 0.0, 0.0], [[0, 1, 2]]);
        let positions = vec![[0.0; 3], [0.0; 3], [1.0; 3]];
        let given = Colors { faces: None, vertices: Some(vec![red]) };
        let mut split = given.clone();
        split.split_seams(&positions, faces.iter().map(<[u32; 3]>::as_slice));
        let mean = (2.0_f64 / 3.0) as f32;
        assert_eq!(split, Colors { faces: Some(vec![[1.0, mean, mean]]), vertices: None });
        let mut of_few = Colors { faces: Some(vec![red]), ..given.clone() };
        let corners: [&[u32]; 3] = [&[], &faces[0], &[]];
        of_few.split_seams(&positions, corners.into_iter());
        assert_eq!(of_few.faces, Some(vec![red, [1.0, mean, mean], WHITE]));
        let geometry = Geometry::new(positions, faces.to_vec(), GeometryOptions::default()).expect("a face");
        assert_eq!(given.welded(&faces, &geometry).vertices, Some(vec![red, WHITE, WHITE]));
    }
}
