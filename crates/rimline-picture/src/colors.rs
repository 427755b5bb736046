//! Base colours of the corners of a model.

use rimline::Model;
use rimline::gltf::Colors;

/// Colours of the corners of the faces of all instances, packed for shaders: the last two corners of turned instances
/// are swapped. `turned` is of all instances. `of` tells the colours of a geometry. `None`: the model has no colours.
pub fn corner_colors<'c>(
    model: &Model,
    turned: impl IntoIterator<Item = bool>,
    of: impl Fn(usize) -> Option<&'c Colors>,
) -> Option<Vec<[u32; 3]>> {
    let instances = || model.instances().iter().map(|instance| of(instance.geometry()));
    if instances().all(|colors| colors.is_none()) {
        return None;
    }
    let mut corners = Vec::new();
    for ((geometry, colors), is_turned) in model.placed_geometries().zip(instances()).zip(turned) {
        let of_face = |face: usize| colors?.faces.as_ref()?.get(face).copied();
        let of_vertex = |vertex: u32| colors?.vertices.as_ref()?.get(vertex as usize).copied();
        let white = [1.0; 3];
        corners.extend(geometry.faces().iter().enumerate().map(|(number, &face)| {
            let color = of_face(number).unwrap_or(white);
            let corner = |vertex| {
                let vertex_color = of_vertex(vertex).unwrap_or(white);
                packed([0, 1, 2].map(|channel| color[channel] * vertex_color[channel]))
            };
            let [a, b, c] = face.map(corner);
            if is_turned { [a, c, b] } else { [a, b, c] }
        }));
    }
    Some(corners)
}

/// Roots of the channels in ten bits each, as `unpack_color` of `common.wgsl` takes them.
fn packed(color: [f32; 3]) -> u32 {
    let [r, g, b] = color.map(|channel| (channel.clamp(0.0, 1.0).sqrt() * 1023.0).round() as u32);
    r | g << 10 | b << 20
}

#[cfg(test)]
mod tests {
    use rimline::{Geometry, GeometryOptions, Instance};

    use super::*;

    #[test]
    fn corners_have_the_colors_of_face_and_vertex() {
        let geometry = || {
            let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            Geometry::new(positions, vec![[0, 1, 2]], GeometryOptions::default()).expect("a triangle")
        };
        let instances = [0, 1, 0].map(|geometry| Instance::new(geometry, None)).to_vec();
        let model = Model::new(vec![geometry(), geometry()], instances).expect("three triangles");
        let vertices = Some(vec![[1.0; 3], [0.0; 3], [1.0, 0.25, 0.0]]);
        let colors = Colors { faces: Some(vec![[1.0, 1.0, 0.25]]), vertices };
        let turned = [false, false, true];
        let found = corner_colors(&model, turned, |geometry| (geometry == 0).then_some(&colors));
        let white = 1023 | 1023 << 10 | 1023 << 20;
        let [a, b, c] = [1023 | 1023 << 10 | 512 << 20, 0, 1023 | 512 << 10];
        assert_eq!(found, Some(vec![[a, b, c], [white; 3], [a, c, b]]));
        assert_eq!(corner_colors(&model, turned, |_| None), None);
    }
}
