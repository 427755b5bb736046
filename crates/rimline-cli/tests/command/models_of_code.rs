//! Models that cases name: what no file of a few lines could be.

use std::f64::consts::TAU;

use base64::Engine as _;
use rimline_testkit::shapes::{self, Shape};
use serde_json::{Value, json};

use super::archive::write_zip;
use super::makers::{npz_mesh, obj, rows, tetrahedron};

pub(crate) enum Made {
    /// Triangles, which may be scaled and moved.
    Shape(Shape),
    File(Vec<u8>),
}

/// A model by its name, whole numbers, words and position.
pub(crate) fn of(name: &str, whole: &[u32], words: &str, at: [f64; 3]) -> Result<Made, String> {
    let file = |text: String| Ok(Made::File(text.into_bytes()));
    let has = |word: &str| words.split(' ').any(|other| other == word);
    match (name, whole) {
        ("tetrahedron", []) => Ok(Made::File(tetrahedron())),
        ("stack", &[layers]) => Ok(Made::Shape(stack(layers))),
        ("leaky", &[subdivisions]) => {
            let mut shape = shapes::sphere(subdivisions);
            let mut number = 0;
            shape.faces.retain(|_| {
                number += 1;
                number % 3 != 0
            });
            Ok(Made::Shape(shape))
        }
        ("strip", &[vertices, faces]) => Ok(Made::File(strip(vertices, faces))),
        ("lattice", []) => {
            let points = (0..700).map(|i| [i % 7, i / 7 % 9, i / 63].map(|c| 0.5 * c as f32 - 1.0));
            Ok(Made::File(write_zip(&[rows("points", &points.collect::<Vec<_>>())])))
        }
        ("bar", []) => file(bar(has("double"), has("triangles"))),
        ("flat", []) => file(flat(has("double"))),
        ("sheet", []) => file(sheet()),
        ("house", []) => file(house(at)),
        ("lathe", &[profile, steps]) => file(lathe(PROFILES[profile as usize], steps as usize)),
        ("circle", &[corners]) => file(circle(corners as usize)),
        _ => Err(format!("there is no shape {name} {words}")),
    }
}

/// Open sheets under a light: `layers` times the same square, one over the other.
fn stack(layers: u32) -> Shape {
    let mut shape = shapes::plane_grid(1, 1);
    let (positions, faces) = (shape.positions.clone(), shape.faces.clone());
    for layer in 1..layers {
        let first = shape.positions.len() as u32;
        let raised = |&[x, y, z]: &[f32; 3]| [x, y + layer as f32 / 4096.0, z];
        shape.positions.extend(positions.iter().map(raised));
        shape.faces.extend(faces.iter().map(|face| face.map(|v| v + first)));
    }
    shape
}

/// A strip of triangles with so many vertices, of which faces name only the first 92.
fn strip(vertices: u32, faces: u32) -> Vec<u8> {
    let positions: Vec<[f32; 3]> = (0..vertices).map(|v| [(v / 2) as f32, (v % 2) as f32, 0.0]).collect();
    npz_mesh(&positions, &(0..faces).map(|f| [f % 90, f % 90 + 1, f % 90 + 2]).collect::<Vec<_>>())
}

fn rounded(point: [f64; 3], to: f64) -> [f64; 3] {
    point.map(|c| (c * to).round() / to)
}

/// A bar of two by three that is twisted once around as it rises: its quadrilaterals are not planar. Each is also
/// turned over if `is_double`. Written as polygons, or as the triangles of fans.
fn bar(is_double: bool, are_triangles: bool) -> String {
    const LAYERS: usize = 18;
    let vertices = (0..=LAYERS).flat_map(|layer| {
        let part = layer as f64 / LAYERS as f64;
        let (sin, cos) = (5.0 * part).sin_cos();
        [[-0.6, -0.25], [0.6, -0.25], [0.6, 0.25], [-0.6, 0.25]]
            .map(|[x, z]| rounded([cos * x + sin * z, 2.6 * part, cos * z - sin * x], 1e6))
    });
    let mut faces = vec![[1, 2, 3, 4], [3, 2, 1, 0].map(|corner| 4 * LAYERS + corner + 1)];
    for layer in 0..LAYERS {
        for side in 0..4 {
            let next = (side + 1) % 4;
            let [low, high] = [4 * layer + 1, 4 * layer + 5];
            faces.push([low + side, high + side, high + next, low + next]);
        }
    }
    let all = faces.into_iter().flat_map(|[a, b, c, d]| {
        // The second side begins elsewhere.
        let sides = if are_triangles {
            [vec![vec![a, b, c], vec![a, c, d]], vec![vec![c, b, a], vec![d, c, a]]]
        } else {
            [vec![vec![a, b, c, d]], vec![vec![d, c, b, a]]]
        };
        sides.into_iter().take(1 + usize::from(is_double)).flatten()
    });
    obj(vertices, all)
}

/// A cube of flat sides, and each side a second time, turned over and cut along the other diagonal, if `is_double`.
fn flat(is_double: bool) -> String {
    let vertices =
        (0..8).map(|corner| [corner & 1, corner >> 1 & 1, corner >> 2].map(|side| 2.0 * f64::from(side) - 0.9));
    let sides = [[1, 5, 7, 3], [2, 4, 8, 6], [1, 2, 6, 5], [3, 7, 8, 4], [1, 3, 4, 2], [5, 6, 8, 7]];
    let faces = sides.into_iter().flat_map(|[a, b, c, d]| {
        let both = [vec![a, b, c], vec![a, c, d], vec![d, b, a], vec![d, c, b]];
        both.into_iter().take(if is_double { 4 } else { 2 })
    });
    obj(vertices, faces)
}

/// A folded sheet of 8 by 8, each face followed by its other side.
fn sheet() -> String {
    let vertices =
        (0..81).map(|v| [f64::from(v % 9), [0.0, 0.05, 0.1][(v / 9 * (v % 9) % 3) as usize], f64::from(v / 9)]);
    let faces = (0..64).flat_map(|face| {
        let a = 9 * (face / 8) + face % 8 + 1;
        let [b, c, d] = [a + 1, a + 10, a + 9];
        [vec![a, d, c], vec![c, d, a], vec![a, c, b], vec![b, c, a]]
    });
    obj(vertices, faces)
}

/// A circle that rounding dents, as one face.
fn circle(corners: usize) -> String {
    let vertices = (0..corners).map(|corner| {
        let (sin, cos) = (corner as f64 / corners as f64 * TAU).sin_cos();
        [cos, sin, 0.0].map(|c| f64::from(c as f32))
    });
    obj(vertices, [(1..=corners).collect()])
}

/// A cone, a vase and a ring. Points on the axis are one each, at any angle.
const PROFILES: [&[[f64; 2]]; 3] = [
    &[[0.0, -1.0], [1.0, -1.0], [0.0, 1.0]],
    &[[0.0, -1.0], [0.7, -1.0], [1.0, 0.0], [0.5, 0.8], [0.6, 1.0], [0.0, 1.0]],
    &[[1.0, -0.3], [1.3, 0.0], [1.0, 0.3], [0.7, 0.0], [1.0, -0.3]],
];

/// Rings of a profile turned about the y axis, by the angles that a full turn ends with: the last ring is the first but for
/// rounding.
fn lathe(profile: &[[f64; 2]], steps: usize) -> String {
    let vertices = (0..=steps).flat_map(|step| {
        let (sin, cos) = (TAU * step as f64 / steps as f64).sin_cos();
        profile.iter().map(move |[radius, height]| [radius * cos, *height, radius * sin])
    });
    let rings = profile.len();
    let faces = (0..steps * (rings - 1)).flat_map(|face| {
        let a = face / (rings - 1) * rings + face % (rings - 1) + 1;
        [vec![a, a + 1, a + rings + 1], vec![a, a + rings + 1, a + rings]]
    });
    obj(vertices, faces)
}

/// Boxes of a house: walls, eaves that stand out by 0.2, three steps. Each by its lowest and highest corner.
const BOXES: [[[f64; 3]; 2]; 5] = [
    [[0.2, 0.0, 0.2], [4.8, 2.0, 3.8]],
    [[0.0, 2.0, 0.0], [5.0, 2.4, 4.0]],
    [[4.8, 0.0, 1.0], [5.1, 0.6, 2.2]],
    [[5.1, 0.0, 1.0], [5.4, 0.4, 2.2]],
    [[5.4, 0.0, 1.0], [5.7, 0.2, 2.2]],
];

/// Sides of a box, whose corners have a bit an axis: counter-clockwise from outside.
pub(crate) const SIDES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// A corner of a box.
pub(crate) fn corner(bounds: &[[f64; 3]; 2], corner: usize) -> [f64; 3] {
    [0, 1, 2].map(|axis| bounds[corner >> axis & 1][axis])
}

/// The house at a position, after a vertex at zero that no face has.
fn house(at: [f64; 3]) -> String {
    let corners = BOXES.iter().flat_map(|bounds| (0..8).map(move |number| corner(bounds, number)));
    let placed = corners.map(|p| rounded([0, 1, 2].map(|axis| p[axis] + at[axis]), 1e3));
    let faces = (0..BOXES.len()).flat_map(|number| {
        SIDES.into_iter().flat_map(move |side| {
            let [a, b, c, d] = side.map(|corner| 8 * number + corner + 2);
            [vec![a, b, c], vec![a, c, d]]
        })
    });
    obj([[0.0; 3]].into_iter().chain(placed), faces)
}

/// A glTF of triangles, one after the other, and of a node with a light.
fn with_light(corners: &[[f32; 3]], nodes: &Value) -> Value {
    let bytes: Vec<u8> = corners.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    json!({
        "asset": { "version": "2.0" }, "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "name": "lamp" }] } },
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}") }],
        "bufferViews": [{ "buffer": 0, "byteLength": bytes.len() }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": corners.len(), "type": "VEC3",
            "min": [0, 0, 0], "max": [5, 2.5, 4] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": nodes,
        "scenes": [{ "nodes": [0] }], "scene": 0,
    })
}

/// The house's walls and eaves, in a node at a position, with a lamp.
pub(crate) fn house_gltf(at: [f64; 3]) -> Value {
    let sides = SIDES.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]);
    let corners =
        BOXES[..2].iter().flat_map(|bounds| sides.clone().map(move |side| corner(bounds, side).map(|c| c as f32)));
    let lamp = json!({ "translation": [7, 6, 5], "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    with_light(&corners.collect::<Vec<_>>(), &json!([{ "mesh": 0, "translation": at, "children": [1] }, lamp]))
}

/// A triangle near the origin and a light, 4 above it, that shines down.
pub(crate) fn lit_triangle() -> Value {
    let turn = std::f64::consts::FRAC_1_SQRT_2;
    let lamp = json!({ "name": "lamp", "translation": [0, 4, 0], "rotation": [-turn, 0, 0, turn],
        "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    with_light(&[[0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 1.0, 0.0]], &json!([{ "mesh": 0, "children": [1] }, lamp]))
}
