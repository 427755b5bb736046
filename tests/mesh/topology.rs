//! Edge records against a brute-force oracle that is written from their definition.

mod oracle {
    //! The definition of edge records, word for word and quadratic at each edge.

    use std::collections::HashMap;

    use rimline::mesh::{Edge, EdgeKind};

    /// One face at an edge: its index, its corner there, and whether it runs from the lower vertex to the upper.
    #[derive(Clone, Copy)]
    struct Traversal {
        face: u32,
        corner: usize,
        upwards: bool,
    }

    pub(crate) fn edge_records(faces: &[[u32; 3]]) -> Vec<Edge> {
        let mut edges: HashMap<[u32; 2], Vec<Traversal>> = HashMap::new();
        for (face, &[a, b, c]) in faces.iter().enumerate() {
            if a == b || b == c || c == a {
                continue;
            }
            for (corner, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
                edges.entry([from.min(to), from.max(to)]).or_default().push(Traversal {
                    face: face as u32,
                    corner,
                    upwards: from < to,
                });
            }
        }
        let mut records = Vec::new();
        for (edge, mut left) in edges {
            // Opposite traversals first, then any two, then single ones; in each round the lowest faces first.
            for allowed in [|a: Traversal, b: Traversal| a.upwards != b.upwards, |_, _| true] {
                while let Some((i, j)) = first_pair(&left, allowed) {
                    let second = left.remove(j);
                    let first = left.remove(i);
                    records.push(record(edge, first, Some(second)));
                }
            }
            records.extend(left.into_iter().map(|single| record(edge, single, None)));
        }
        records.sort_by_key(|&(index, _)| index);
        records.into_iter().map(|(_, edge)| edge).collect()
    }

    fn first_pair(left: &[Traversal], allowed: fn(Traversal, Traversal) -> bool) -> Option<(usize, usize)> {
        (0..left.len()).flat_map(|i| (i + 1..left.len()).map(move |j| (i, j))).find(|&(i, j)| allowed(left[i], left[j]))
    }

    fn record([low, high]: [u32; 2], first: Traversal, second: Option<Traversal>) -> ((u32, usize), Edge) {
        let kind = match second {
            None => EdgeKind::Boundary,
            Some(second) if second.upwards == first.upwards => EdgeKind::Inconsistent,
            Some(_) => EdgeKind::Consistent,
        };
        let edge = Edge {
            vertices: if first.upwards { [low, high] } else { [high, low] },
            face_0: first.face,
            face_1: second.map(|second| second.face),
            kind,
        };
        ((first.face, first.corner), edge)
    }
}

use rimline::mesh::{Edge, EdgeCounts, EdgeKind, MeshDiagnostics};
use rimline::{Mesh, MeshError};
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};

/// Faces thrown over few vertices: most edges have many faces, many faces are duplicates or degenerate. Each vertex
/// has a position of its own.
fn soup(seed: u64) -> Shape {
    let mut random = Random::new(seed);
    let vertices = 3 + random.below(if seed.is_multiple_of(3) { 40 } else { 8 });
    let faces = 1 + random.below(120);
    Shape {
        positions: (0..vertices).map(|v| [v as f32, 0.0, 0.0]).collect(),
        faces: (0..faces).map(|_| [(); 3].map(|()| random.below(vertices) as u32)).collect(),
    }
}

/// The first difference between a mesh's records and the oracle's.
fn difference(records: &[Edge], faces: &[[u32; 3]]) -> Option<String> {
    let expected = oracle::edge_records(faces);
    if records.len() != expected.len() {
        return Some(format!("{} records, not {}", records.len(), expected.len()));
    }
    let index = records.iter().zip(&expected).position(|(a, b)| a != b)?;
    Some(format!("record {index}: {:?}, not {:?}", records[index], expected[index]))
}

fn assert_like_oracle(name: &str, shape: &Shape) {
    let mesh = shape.mesh().expect("a mesh");
    let records: Vec<Edge> = mesh.edges().iter().collect();
    assert_eq!(difference(&records, &shape.faces), None, "{name}");
    let count = |kind| records.iter().filter(|edge| edge.kind == kind).count();
    let counts = EdgeCounts {
        consistent: count(EdgeKind::Consistent),
        inconsistent: count(EdgeKind::Inconsistent),
        boundary: count(EdgeKind::Boundary),
    };
    let ends = [mesh.edges().get(0), mesh.edges().get(records.len())];
    assert_eq!((mesh.edges().counts(), ends), (counts, [records.first().copied(), None]), "{name}");
}

fn all_shapes() -> Vec<(&'static str, Shape)> {
    vec![
        ("cube", shapes::cube()),
        ("torus", shapes::torus(17, 9, 1.0, 0.25)),
        ("sphere", shapes::sphere(7)),
        ("blob", shapes::blob(9, 0.4, 1)),
        ("plane grid", shapes::plane_grid(6, 5)),
        ("moebius", shapes::moebius(12, 3)),
        ("three sheets", shapes::three_sheets(5)),
        ("fan of few", shapes::fan(11)),
        // Hubs with many edges.
        ("fan of many", shapes::fan(500)),
    ]
}

#[test]
fn meshes_have_the_oracle_s_records() {
    for seed in 0..600 {
        assert_like_oracle(&format!("seed {seed}"), &soup(seed));
    }
    let shapes = all_shapes().into_iter().map(|(name, shape)| (name.to_owned(), shape));
    // A hub in a soup.
    let hubs = (0..40).map(|seed| {
        let (mut fan, soup) = (shapes::fan(60 + seed), soup(u64::from(seed)));
        let count = fan.positions.len() as u32;
        fan.faces.extend(soup.faces.iter().map(|face| face.map(|v| v % count)));
        (format!("hub {seed}"), fan)
    });
    for (name, shape) in shapes.chain(hubs) {
        assert_like_oracle(&name, &shape);
        assert_like_oracle(&format!("{name}, shuffled"), &shape.shuffled(1));
    }
}

#[test]
fn the_comparison_notices_one_changed_record() {
    // Closed, so every change is one.
    let shape = shapes::torus(5, 4, 1.0, 0.25);
    let records: Vec<Edge> = shape.mesh().expect("a mesh").edges().iter().collect();
    let changes: [fn(&mut Vec<Edge>); 6] = [
        |records| records[20].vertices.swap(0, 1),
        |records| records[20].face_0 += 1,
        |records| records[20].face_1 = None,
        |records| records[20].kind = EdgeKind::Boundary,
        |records| records.swap(20, 21),
        |records| records.truncate(records.len() - 1),
    ];
    assert_eq!(difference(&records, &shape.faces), None);
    for (index, change) in changes.iter().enumerate() {
        let mut changed = records.clone();
        change(&mut changed);
        assert!(difference(&changed, &shape.faces).is_some(), "change {index}");
    }
}

#[test]
fn closed_meshes_take_at_most_28_bytes_a_face() {
    for (name, shape) in all_shapes() {
        let mesh = shape.mesh().expect("a mesh");
        let limit = if mesh.is_closed() { 28 } else { 48 };
        let (bytes, faces) = (mesh.edge_record_bytes(), shape.faces.len());
        assert!(bytes <= limit * faces, "{name}: {bytes} bytes for {faces} faces");
    }
}

#[test]
fn edges_that_both_faces_traverse_alike_are_not_closed() {
    // A face and the same again: every edge has two faces, none of them consistent.
    let mesh = Mesh::from_faces(3, vec![[0, 1, 2], [0, 1, 2]]).expect("a mesh");
    assert_eq!(mesh.edges().counts(), EdgeCounts { inconsistent: 3, ..EdgeCounts::default() });
    assert!(!mesh.is_closed() && !MeshDiagnostics::of(&mesh, 0).is_closed());
    let other = Mesh::from_faces(3, vec![[0, 1, 2], [2, 1, 0]]).expect("a mesh");
    assert!(other.is_closed() && MeshDiagnostics::of(&other, 0).is_closed());
    // Meshes are equal by what they hold.
    let more_vertices = Mesh::from_faces(4, mesh.faces().to_vec());
    assert_eq!(Mesh::from_faces(3, mesh.faces().to_vec()).as_ref(), Ok(&mesh));
    assert!(mesh != other && more_vertices.as_ref() != Ok(&mesh), "{more_vertices:?}");
}

#[test]
fn more_vertices_than_indices_can_name_are_refused() {
    let vertices = u32::MAX as usize;
    assert_eq!(Mesh::from_faces(vertices, vec![[0, 1, 2]]), Err(MeshError::TooManyVertices { vertices }));
}

/// Buckets for each vertex would take 34 GB.
#[test]
fn vertices_that_no_face_names_cost_nothing() {
    for seed in 0..100 {
        let shape = soup(seed);
        let apart = |vertex: u32| u32::MAX - 2 - vertex * 50_000_000;
        let faces: Vec<_> = shape.faces.iter().map(|face| face.map(apart)).collect();
        let mesh = Mesh::from_faces(u32::MAX as usize - 1, faces.clone()).expect("a mesh");
        let records: Vec<Edge> = mesh.edges().iter().collect();
        assert_eq!(difference(&records, &faces), None, "seed {seed}");
    }
}
