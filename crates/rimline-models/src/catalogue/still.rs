//! Files in which nothing moves, and what they are put together from.

use rimline_bench::shapes::{self, Shape};
use serde_json::{Value, json};

use crate::maker::{I16, Maker, U8, U16, U32, flat};

/// Adds a mesh of these primitives at a node with these properties.
pub(super) fn add_node(maker: &mut Maker, primitives: &[Value], mut node: Value) -> usize {
    node["mesh"] = json!(maker.push("meshes", json!({ "primitives": primitives })));
    maker.push("nodes", node)
}

/// A file with one shape.
pub(super) fn alone(shape: &Shape, indices: u32) -> Maker {
    let mut maker = Maker::new();
    let primitive = maker.primitive(shape, indices);
    let node = add_node(&mut maker, &[primitive], json!({}));
    maker.scene(&[node]);
    maker
}

/// Hard normals, and a node with a matrix.
pub(super) fn cube() -> Maker {
    let shape = flat(&shapes::cube());
    let mut maker = alone(&shape, U16);
    let faces = shape.positions.as_chunks::<3>().0.iter();
    let normals: Vec<f32> =
        faces.flat_map(|[a, b, c]| [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0).repeat(3)).collect();
    let normals = maker.floats("VEC3", &normals);
    maker.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    maker.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]);
    maker
}

/// Strips, fans and lists of triangles, with and without indices; lines and points beside them and alone; colours.
pub(super) fn modes() -> Maker {
    let mut maker = Maker::new();
    let zigzag: Vec<f32> = (0..6).flat_map(|i| [(i / 2) as f32, (i % 2) as f32, 0.1 * i as f32]).collect();
    let apart: Vec<f32> = zigzag.iter().map(|axis| axis + 2.5).collect();
    let corners = [&zigzag, &zigzag, &zigzag, &apart].map(|corners| maker.floats("VEC3", corners));
    let colours = maker.accessor(U8, "VEC4", 6, &[200, 100, 50, 255].repeat(6));
    maker.json["accessors"][colours]["normalized"] = json!(true);
    let order = maker.indices(U8, &[0, 1, 3, 5, 4, 2]);
    let of =
        |corners: usize, mode: u32| json!({ "attributes": { "POSITION": corners, "COLOR_0": colours }, "mode": mode });
    let mut indexed = of(corners[2], 6);
    indexed["indices"] = json!(order);
    let mixed = [0, 1, 0, 2, 5].map(|mode| of(corners[0], mode));
    let mixed = [&mixed[..], &[of(corners[3], 4)]].concat();
    let lines = [0, 3, 0].map(|mode| of(corners[0], mode));
    let nodes = [
        add_node(&mut maker, &mixed, json!({})),
        add_node(&mut maker, &[of(corners[1], 5)], json!({ "translation": [0, 2, 0] })),
        add_node(&mut maker, &[indexed], json!({ "translation": [0, 0, 3] })),
        add_node(&mut maker, &lines, json!({})),
    ];
    maker.scene(&nodes);
    maker
}

pub(super) fn moebius() -> Maker {
    alone(&shapes::moebius(24, 4), U16)
}

/// Edges with three faces, faces that are turned or there twice; two bodies that touch in a vertex.
pub(super) fn sheets() -> Maker {
    let mut shape = shapes::three_sheets(6);
    for face in [1, 14, 30] {
        shape.faces[face].reverse();
    }
    let [a, b, c] = shape.faces[8];
    shape.faces.push([a, c, b]);
    let mut maker = alone(&flat(&shape), U8);
    let double = Shape {
        positions: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]
            .map(|corner: [i32; 3]| corner.map(|axis| axis as f32))
            .to_vec(),
        faces: [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [0, 4, 5], [0, 6, 4], [0, 5, 6], [4, 6, 5]].to_vec(),
    };
    let primitive = maker.primitive(&double, U8);
    let node = add_node(&mut maker, &[primitive], json!({ "translation": [3, 0, 0] }));
    maker.scene(&[0, node]);
    maker
}

/// Closed and open meshes: one of two primitives that share vertices and one across a seam, a folded cloth, a ball of
/// facets.
pub(super) fn parts() -> Maker {
    let mut maker = Maker::new();
    let ring = shapes::torus(16, 10, 1.0, 0.4);
    let thirds: Vec<_> = ring.faces.chunks(107).collect();
    let first = maker.primitive(&Shape { faces: thirds[0].to_vec(), ..ring.clone() }, U32);
    let mut second = first.clone();
    second["indices"] = json!(maker.indices(U16, thirds[1].as_flattened()));
    let seam = maker.primitive(&Shape { faces: thirds[2].to_vec(), ..ring.clone() }, U16);
    let mut cloth = shapes::plane_grid(40, 30);
    cloth.positions.iter_mut().for_each(|[x, y, z]| *y = 0.3 * (5.0 * *x).sin() + 0.2 * (7.0 * *z).cos());
    let cloth = maker.primitive(&cloth, U16);
    let facets = maker.primitive(&flat(&shapes::sphere(6)), U16);
    let cube = maker.primitive(&shapes::cube(), U8);
    let nodes = [
        add_node(&mut maker, &[first, second, seam], json!({})),
        add_node(&mut maker, &[cloth], json!({ "translation": [0, -1, 0], "scale": [3, 1, 2] })),
        add_node(&mut maker, &[facets], json!({ "translation": [3, 1, 0] })),
        add_node(&mut maker, &[cube], json!({ "translation": [-3, 0, 1], "rotation": [0.6, 0, 0, 0.8] })),
    ];
    maker.scene(&nodes);
    maker
}

/// A flat plate, some of whose vertices are moved; its buffer is a file.
pub(super) fn sparse() -> Maker {
    let mut maker = alone(&shapes::plane_grid(3, 4), U16);
    maker.sparse(0, &[6, 7, 13], &[-0.3, 0.5, 0.0, -0.3, -0.25, 0.1, 0.4, 0.75, -0.5]);
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len(), "uri": "sparse.bin" }]);
    maker
}

/// Two scenes, of which the second is shown: meshes at several nodes, mirrored below mirrored ones, with degenerate
/// faces and normals that are NaN.
pub(super) fn scenes() -> Maker {
    let mut maker = Maker::new();
    let mut shape = shapes::cube();
    shape.faces.extend([[0, 1, 1], [2, 2, 2]]);
    let mut cube = maker.primitive(&shape, U16);
    cube["attributes"]["NORMAL"] = json!(maker.floats("VEC3", &[f32::NAN; 24]));
    let ring = maker.primitive(&shapes::torus(8, 6, 1.0, 0.4), U16);
    let strip = maker.primitive(&shapes::moebius(8, 1), U8);
    add_node(&mut maker, &[cube], json!({ "translation": [3, 0, 0] }));
    add_node(&mut maker, &[ring], json!({ "rotation": [0, 0.6, 0, 0.8], "scale": [1, 1, 2] }));
    let unshown = add_node(&mut maker, &[strip], json!({}));
    let upright = maker.push("nodes", json!({ "mesh": 0, "translation": [0, 4, 0], "scale": [1, -1, 1] }));
    let root = maker.push("nodes", json!({ "scale": [-1, 1, 1], "children": [0, 1, upright] }));
    let alone = maker.push("nodes", json!({ "mesh": 1, "translation": [0, 0, 5], "scale": [1, 1, -0.5] }));
    maker.scene(&[unshown]);
    maker.scene(&[root, alone]);
    maker
}

/// At a position of a survey, in millimetres.
pub(super) fn far() -> Maker {
    let mut maker = alone(&shapes::cube(), U16);
    let near = maker.push("nodes", json!({ "mesh": 0, "translation": [4.017, 0.5, -0.002] }));
    let root =
        maker.push("nodes", json!({ "translation": [392_143.517, 34.128, -5_820_467.702], "children": [0, near] }));
    maker.json["scenes"][0]["nodes"] = json!([root]);
    maker
}

/// More vertices than 16 bits can name.
pub(super) fn large() -> Maker {
    alone(&shapes::blob(128, 0.3, 5), U32)
}

/// A shape in 16-bit integers of 8 bytes a vertex.
pub(super) fn quantized(maker: &mut Maker, shape: &Shape, scale: f32, normalized: bool) -> Value {
    let short = |axis: f32| ((axis * scale).round() as i16).to_le_bytes();
    let bytes: Vec<u8> = shape.positions.iter().flat_map(|&[x, y, z]| [x, y, z, 0.0].map(short)).flatten().collect();
    let positions = maker.accessor(I16, "VEC3", shape.positions.len(), &bytes);
    let view = maker.json["bufferViews"].as_array().map_or(0, |views| views.len() - 1);
    maker.json["bufferViews"][view]["byteStride"] = json!(8);
    maker.json["accessors"][positions]["normalized"] = json!(normalized);
    let mut primitive = maker.primitive(&Shape { positions: Vec::new(), ..shape.clone() }, U16);
    primitive["attributes"]["POSITION"] = json!(positions);
    primitive
}
