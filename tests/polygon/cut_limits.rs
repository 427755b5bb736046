//! L-twisted outlines with as many cuts as the GPU takes. llvmpipe ends an invocation's loops after 65,535 turns without a word, so
//! pieces are compared with the twin's. docs/numerics/loops.md and docs/numerics/twisted-polygons.md.

use rimline::gpu::MAX_OUTLINE_EDGES;
use rimline::mesh::Weld;
use rimline::reference::cpu::{Outline, Piece, PieceEnd, cut_edges};
use rimline::{Light, Mesh};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::polygons::PolygonSet;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same};

use crate::stages::{Listed, check_closed, check_listed, listed, piece_counts};

pub(crate) const TESTS: &[Test] = &[
    ("pieces_of_coordinates_of_all_sizes", of_all_sizes),
    ("pieces_of_the_most_cuts_that_turns_order", most_ordered),
    ("pieces_of_few_edges_and_the_most_triangles", most_triangles),
    ("pieces_of_the_most_cuts_of_an_edge", most_cuts),
    ("pieces_that_there_is_room_for", most_pieces),
    ("more_cuts_than_there_is_room_for_are_counted", too_many),
];

/// The most cuts of an edge that turns order, as in `cut_edges.wgsl`.
const MOST_ORDERED: usize = 256;

/// The most triangles of a polygon, as `ExtractorError::PolygonTooLarge` says it.
const MOST_TRIANGLES: usize = 2048;

struct Loop {
    set: PolygonSet,
    mesh: Mesh,
    light: Light,
}

impl Loop {
    fn new(corners: Vec<[f32; 3]>, light: [f32; 3]) -> Result<Self, String> {
        let mut set = PolygonSet::default();
        set.push_points(&[corners]);
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        Ok(Self { set, mesh, light: Light::directional(light) })
    }

    fn outline(&self) -> Result<Outline, String> {
        let polygons = self.mesh.polygons().ok_or("no polygons")?;
        Outline::new(polygons.outline(0), &self.set.positions).ok_or_else(|| "not finite".to_owned())
    }

    fn expected(&self) -> Result<Vec<Piece>, String> {
        let triangles: Vec<_> =
            self.mesh.faces().iter().map(|face| face.map(|v| self.set.positions[v as usize])).collect();
        Ok(cut_edges(&self.outline()?, &triangles, self.light.to_array()))
    }

    fn found(&self, gpu: &Gpu) -> Result<Vec<Listed>, String> {
        listed(gpu, &self.set, &self.mesh, &[self.light])?.pop().ok_or_else(|| "no list".to_owned())
    }
}

/// The most cuts of an edge.
fn cuts_of_an_edge(pieces: &[Piece]) -> usize {
    pieces.chunk_by(|one, other| one.edge == other.edge).map(|pieces| pieces.len() - 1).max().unwrap_or(0)
}

/// Corners in one plane with the light but for one, so that turns are those of the moved light, and integers decide them.
fn of_all_sizes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for count in [24, 200] {
        let mut random = Random::new(62 + count as u64);
        let mut coordinate = || random.between(-4.0, 4.0) * (-(random.below(100) as f32)).exp2();
        let mut corners: Vec<_> = (0..count).map(|_| [coordinate(), 0.0, coordinate()]).collect();
        corners[0][1] = 1.0;
        let outline = Loop::new(corners, [1.0, 0.0, 0.0])?;
        let (found, expected) = (outline.found(gpu)?, outline.expected()?);
        println!("{count} corners: {} pieces", expected.len());
        same(&format!("pieces of {count} corners"), &[found.len()], &[expected.len()])?;
    }
    Ok(())
}

/// Zigzag corners of all sizes in one plane with the light, but for the first, which is above what is farthest on both sides, where it
/// crosses nothing. So they are seen in line, and each edge is cut in its middle, by the twin and by the GPU.
fn in_line(random: &mut Random, corners: usize, last: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut points = vec![[0.0, 1.0, 0.0], [1.0, 0.0, 8.0]];
    for at in 0..corners {
        let size = (-(random.below(100) as f32)).exp2();
        let side = [-size, size][at % 2];
        let up = [-1.0, 1.0][random.below(2)] * random.between(0.25, 1.0);
        points.push([side * random.between(0.5, 1.0), 0.0, size * up]);
    }
    points.extend(last);
    points.push([3.0, 0.0, -8.0]);
    points
}

/// Pieces of an outline whose edges are cut in their middles, to the bit.
fn check_halves(found: &[Listed], expected: &[Piece], outline: &Outline) -> Result<(), String> {
    let bits = |point: [f32; 3]| point.map(|c| (c + 0.0).to_bits());
    let end = |piece: &Piece, end: usize| match piece.ends[end] {
        PieceEnd::Corner => outline.edges()[piece.edge][end],
        PieceEnd::Touch(point) => point,
        PieceEnd::Crossing { edge, .. } => {
            let [a, b] = outline.edges()[piece.edge.min(edge)];
            [0, 1, 2].map(|axis| 0.5_f32.mul_add(b[axis] - a[axis], a[axis]))
        }
    };
    let ends = |piece: &Piece| {
        let first = usize::from(piece.is_turned);
        [bits(end(piece, first)), bits(end(piece, 1 - first))]
    };
    let mut found: Vec<_> = found.iter().map(|&[from, to, _]| [bits(from), bits(to)]).collect();
    let mut expected: Vec<_> = expected.iter().map(ends).collect();
    found.sort_unstable();
    expected.sort_unstable();
    same("pieces", &found, &expected)
}

/// An edge that as many others cut as turns order. Integers decide all of them, so each order takes many turns of loops.
fn most_ordered() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let corners = in_line(&mut Random::new(63), MOST_ORDERED, &[[0.0, 0.0, -6.0], [0.0, 0.0, 6.0]]);
    let outline = Loop::new(corners, [1.0, 0.0, 0.0])?;
    let (found, expected) = (outline.found(gpu)?, outline.expected()?);
    println!("{} pieces", expected.len());
    same("cuts of an edge", &[cuts_of_an_edge(&expected)], &[MOST_ORDERED])?;
    check_halves(&found, &expected, &outline.outline()?)?;
    let mut wrong = found;
    let (one, other) = (wrong[0][1], wrong[1][1]);
    (wrong[0][1], wrong[1][1]) = (other, one);
    must_fail("two ends exchanged", &check_halves(&wrong, &expected, &outline.outline()?))
}

/// Outlines of few edges, with more and more triangles: beside a zigzag the polygon walks to a hole and back.
fn most_triangles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let hole = [[0.0, 0.0, -3.0], [-0.25, 0.0, -2.5], [0.25, 0.0, -2.7]];
    for (edges, triangles) in [(32, 32), (32, 34), (24, MOST_TRIANGLES)] {
        let mut random = Random::new(66 + triangles as u64);
        let mut corners = in_line(&mut random, edges - 8, &[[-6.0, 0.0, -6.0], [0.0, 0.0, -7.0]]);
        let bridge = (triangles - edges) / 2;
        let there: Vec<_> = (1..=bridge)
            .map(|at| [random.between(-1e-25, 1e-25), 0.0, -7.0 + 4.0 * at as f32 / (bridge + 1) as f32])
            .collect();
        let after = corners.len() - 1;
        let back = there.iter().rev().chain([&corners[after - 1]]).copied().collect();
        corners.splice(after..after, [there, hole.to_vec(), vec![hole[0]], back].concat());
        let outline = Loop::new(corners, [1.0, 0.0, 0.0])?;
        same("edges", &[outline.outline()?.edges().len()], &[edges])?;
        same("triangles", &[outline.mesh.faces().len()], &[triangles])?;
        let (found, expected) = (outline.found(gpu)?, outline.expected()?);
        println!("{edges} edges, {triangles} triangles: {} pieces", expected.len());
        check_halves(&found, &expected, &outline.outline()?).map_err(|error| format!("{triangles}: {error}"))?;
    }
    Ok(())
}

/// Back and forth over a line, from one end of it to the other.
fn zigzag(random: &mut Random, edges: usize, reach: f32) -> Vec<[f32; 3]> {
    let along = |at: usize| 0.9 * (2.0 * at as f32 / edges as f32 - 1.0);
    (0..=edges).map(|at| [along(at), random.between(-0.1, 0.1), [-reach, reach][at % 2]]).collect()
}

/// An outline of the most edges, of which all that can cut the last but one. Seen from above.
fn most_cuts() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let cuts = MAX_OUTLINE_EDGES - 5;
    let mut corners = zigzag(&mut Random::new(64), cuts, 1.0);
    // Around to the beginning, and along the line.
    corners.extend([[2.0, 0.0, -3.0], [-2.0, 0.1, -3.0], [-2.0, -0.1, 0.01], [2.0, 0.1, 0.02]]);
    corners.rotate_right(1);
    let outline = Loop::new(corners, [0.0, 1.0, 0.0])?;
    let (found, expected) = (outline.found(gpu)?, outline.expected()?);
    println!("{} edges, {} cuts of one", outline.outline()?.edges().len(), cuts_of_an_edge(&expected));
    same("edges", &[outline.outline()?.edges().len()], &[MAX_OUTLINE_EDGES])?;
    if cuts_of_an_edge(&expected) < cuts {
        return Err(format!("only {} cuts of an edge", cuts_of_an_edge(&expected)));
    }
    check_closed(&found)?;
    check_listed(&found, &expected, &outline.outline()?, outline.light)
}

/// Rows that a zigzag cuts as often as turns order, and nearly as many pieces as there is room for. Seen from above.
fn most_pieces() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(65);
    let mut corners = zigzag(&mut random, MOST_ORDERED, -2.0);
    let rows = 62;
    for row in 0..rows {
        let z = 0.5 - row as f32 / rows as f32;
        let ends = [1.0, -1.0].map(|x| [x, random.between(-0.1, 0.1), z + random.between(-0.001, 0.001)]);
        corners.extend([ends[row % 2], ends[1 - row % 2]]);
    }
    // Around the rows to where the zigzag begins.
    corners.extend([[1.5, 0.0, -3.0], [-1.5, 0.1, -3.0], [-1.5, -0.1, 2.5]]);
    let outline = Loop::new(corners, [0.0, 1.0, 0.0])?;
    let (found, expected) = (outline.found(gpu)?, outline.expected()?);
    println!("{} pieces, {} cuts of an edge", expected.len(), cuts_of_an_edge(&expected));
    same("cuts of an edge", &[cuts_of_an_edge(&expected)], &[MOST_ORDERED])?;
    same("pieces", &[found.len()], &[expected.len()])?;
    check_closed(&found)
}

/// A star of which each edge cuts all others but its neighbours: the most cuts that an outline can have.
fn too_many() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let corners = MAX_OUTLINE_EDGES - 1;
    let corner = |at: usize| {
        let angle = (at * (corners / 2) % corners) as f32 / corners as f32 * std::f32::consts::TAU;
        [angle.sin(), 0.0, angle.cos()]
    };
    let outline = Loop::new((0..corners).map(corner).collect(), [0.0, 1.0, 0.0])?;
    let (counts, capacity) = piece_counts(gpu, &outline.set, &outline.mesh, &[outline.light; 2])?;
    println!("{} pieces, and room for {capacity}", counts[0]);
    same("pieces", &counts, &[(corners * (corners - 2)) as u32; 2])?;
    if counts[0] > capacity { Ok(()) } else { Err("there is room".to_owned()) }
}
