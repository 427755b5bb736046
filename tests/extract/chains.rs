//! Silhouettes as oriented edges and as chains, against integers.

use std::collections::BTreeMap;

use rimline::cpu::{self, Threads};
use rimline::mesh::{Chain, Silhouette, SilhouetteEdge};
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::cases::{Case, case, random_soup, topologies};
use rimline_testkit::random::Random;
use rimline_testkit::shapes;

const LIGHTS: usize = 35;

/// The cases on a lattice, where `f64` decides exactly, with lights on it.
fn cases(random: &mut Random) -> Vec<(Case, Vec<Light>)> {
    let mut cases = topologies();
    cases.extend((0..40).map(|number| case(format!("soup {number}"), random_soup(random))));
    let snapped = |p: [f32; 3]| p.map(|c| (c * 64.0).round());
    let mut light = || {
        let p = snapped(random.direction().map(|c| 5.0 * c));
        Light::homogeneous([p[0], p[1], p[2], [1.0, 0.0, 2.0][random.below(3)]])
    };
    let cases = cases.into_iter().map(|(name, positions, mesh)| {
        ((name, positions.into_iter().map(snapped).collect(), mesh), (0..LIGHTS).map(|_| light()).collect())
    });
    cases.collect()
}

fn silhouettes(case: &Case, lights: &[Light]) -> Vec<Silhouette> {
    let extraction = cpu::extract(&case.1, &case.2, lights, Predicate::Exact, Threads::ONE).expect("good input");
    (0..lights.len()).map(|light| extraction.silhouette(&case.2, light)).collect()
}

/// The side of a light of three points: positive where they are counter-clockwise as seen from it.
fn side([a, b, c]: [[f32; 3]; 3], light: Light) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| p.map(f64::from));
    let [x, y, z, w] = light.to_array().map(f64::from);
    let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    let l = [x - w * a[0], y - w * a[1], z - w * a[2]];
    (u[1] * v[2] - u[2] * v[1]) * l[0] + (u[2] * v[0] - u[0] * v[2]) * l[1] + (u[0] * v[1] - u[1] * v[0]) * l[2]
}

/// Whether a face of an edge lies to its left as seen from the light, or in a plane with it.
fn lies_to_the_left(edge: &SilhouetteEdge, (_, positions, mesh): &Case, light: Light) -> bool {
    let record = mesh.edges().get(edge.record as usize).expect("an edge of the mesh");
    std::iter::once(record.face_0).chain(record.face_1).all(|face| {
        let corners = mesh.faces()[face as usize];
        let third = corners.into_iter().find(|v| !edge.vertices.contains(v)).expect("three corners");
        side([edge.vertices[0], edge.vertices[1], third].map(|v| positions[v as usize]), light) >= 0.0
    })
}

/// The first fault of chains.
fn fault(silhouette: &Silhouette, chains: &[Chain], mesh: &Mesh) -> Option<String> {
    let by_record: BTreeMap<u32, [u32; 2]> =
        silhouette.edges().iter().map(|edge| (edge.record, edge.vertices)).collect();
    let mut records: Vec<u32> = chains.iter().flat_map(|chain| chain.records.clone()).collect();
    records.sort_unstable();
    if !records.iter().eq(by_record.keys()) {
        return Some("not each edge once".into());
    }
    let (mut begins, mut ends) = (BTreeMap::new(), BTreeMap::new());
    for chain in chains {
        let Chain { vertices, records, is_closed } = chain;
        if vertices.len() != records.len() + usize::from(!is_closed) {
            return Some(format!("wrong number of vertices: {chain:?}"));
        }
        for (at, record) in records.iter().enumerate() {
            if by_record[record] != [vertices[at], vertices[(at + 1) % vertices.len()]] {
                return Some(format!("edge {record} is not in {chain:?}"));
            }
        }
        if !is_closed {
            *begins.entry(vertices[0]).or_insert(0) += 1;
            *ends.entry(vertices[vertices.len() - 1]).or_insert(0) += 1;
        }
    }
    if begins.keys().any(|vertex| ends.contains_key(vertex)) {
        return Some("a chain ends where another one begins".into());
    }
    (mesh.is_closed() && !begins.is_empty()).then(|| "an open chain on a closed mesh".into())
}

/// Faces lie to the left of silhouette edges; chains hold each edge once, and end only where nothing goes on.
#[test]
fn silhouettes_are_oriented_and_chained() {
    let ([mut edges, mut refused], [mut closed, mut open]) = ([0; 2], [0; 2]);
    for (case, lights) in cases(&mut Random::new(92)) {
        for (silhouette, &light) in silhouettes(&case, &lights).iter().zip(&lights) {
            for edge in silhouette.edges() {
                edges += 1;
                assert!(lies_to_the_left(edge, &case, light), "{}: {edge:?}", case.0);
                let [from, to] = edge.vertices;
                let turned = SilhouetteEdge { vertices: [to, from], ..*edge };
                refused += usize::from(!lies_to_the_left(&turned, &case, light));
            }
            let chains = silhouette.chains();
            assert_eq!(fault(silhouette, &chains, &case.2), None, "{}", case.0);
            closed += chains.iter().filter(|chain| chain.is_closed).count();
            open += chains.iter().filter(|chain| !chain.is_closed).count();
            // Negative controls: a chain less, and one that is cut.
            let Some((last, others)) = chains.split_last() else { continue };
            assert!(fault(silhouette, others, &case.2).is_some());
            if last.is_closed {
                let whole = Chain { vertices: [&*last.vertices, &last.vertices[..1]].concat(), ..last.clone() };
                let cut = [others, &[Chain { is_closed: false, ..whole }]].concat();
                assert!(fault(silhouette, &cut, &case.2).is_some());
            }
        }
    }
    // Negative control: but for faces in a plane with the light.
    assert!(edges > 50_000 && refused > edges * 9 / 10, "{refused} of {edges}");
    assert!(closed > 300 && open > 300, "{closed} closed, {open} open");
    let (_, _, mesh) = case("grid", shapes::plane_grid(5, 3));
    assert_eq!(cpu::Extraction::default().silhouette(&mesh, 0), Silhouette::default());
    assert_eq!(Silhouette::default().chains(), []);
}
