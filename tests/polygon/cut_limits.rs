//! twisted boundaries with as many cuts as the GPU takes. llvmpipe ends an invocation's loops after 65,535 turns
//! without a word, so pieces are counted, and must close. Those of edges that are seen in line are goldens, made of the
//! twin that there was. docs/numerics/loops.md and docs/numerics/twisted-polygons.md.

use rimline::Light;
use rimline::gpu::MAX_BOUNDARY_EDGES;
use rimline::mesh::Weld;
use robust::{Coord, orient2d};

use rimline_testkit::device::Gpu;
use rimline_testkit::goldens::golden;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::polygons::PolygonSet;
use rimline_testkit::random::Random;
use rimline_testkit::{polygon_oracle, same};

use crate::limits::MOST_TRIANGLES;
use crate::pieces::{Twisted, bits, check_closed, piece_counts, twisted};

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

/// A loop of these corners, and how many triangles it has.
fn looped(gpu: &Gpu, corners: Vec<[f32; 3]>, towards: [f32; 3]) -> Result<(Twisted, usize), String> {
    let mut set = PolygonSet::default();
    set.push_points(&[corners]);
    let mesh = set.mesh(Weld::Position).map_err(text)?;
    let polygon = twisted(gpu, &set, &mesh, &[Light::directional(towards)])?.pop().ok_or("not twisted")?;
    Ok((polygon, mesh.faces().len()))
}

/// For each edge the others that cut it, seen from above, in exact arithmetic.
fn cuts_from_above(boundary: &Twisted) -> Vec<usize> {
    let coord = |p: &[f32; 3]| Coord { x: p[0], y: p[2] };
    polygon_oracle::cuts_by(&boundary.edges, |a, b, c| {
        let side = orient2d(coord(a), coord(b), coord(c));
        i32::from(side > 0.0) - i32::from(side < 0.0)
    })
}

/// Corners in one plane with the light but for one, so that turns are those of the moved light, and integers decide them.
fn of_all_sizes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for (count, pieces) in [(24, 100), (200, 5854)] {
        let mut random = Random::new(62 + count as u64);
        let mut coordinate = || random.between(-4.0, 4.0) * (-(random.below(100) as f32)).exp2();
        let mut corners: Vec<_> = (0..count).map(|_| [coordinate(), 0.0, coordinate()]).collect();
        corners[0][1] = 1.0;
        let (boundary, _) = looped(gpu, corners, [1.0, 0.0, 0.0])?;
        same(&format!("pieces of {count} corners"), &[boundary.pieces.len()], &[pieces])?;
    }
    Ok(())
}

/// Zigzag corners of all sizes in one plane with the light, but for the first, which is above what is farthest on both
/// sides, where it crosses nothing. So they are seen in line, and each edge is cut in its middle.
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

/// Pieces of a boundary whose edges are cut in their middles, to the bit. Edges of all sizes in line need not close.
fn check_halves(boundary: &Twisted, name: &str, count: usize) -> Result<(), String> {
    same("pieces", &[boundary.pieces.len()], &[count])?;
    let mut ends: Vec<_> = boundary.pieces.iter().map(|&[from, to, _]| [bits(from), bits(to)]).collect();
    ends.sort_unstable();
    golden("polygon", name, ends.as_flattened().as_flattened())
}

/// An edge that as many others cut as turns order. Integers decide all of them, so each order takes many turns of loops.
fn most_ordered() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let corners = in_line(&mut Random::new(63), MOST_ORDERED, &[[0.0, 0.0, -6.0], [0.0, 0.0, 6.0]]);
    let (boundary, _) = looped(gpu, corners, [1.0, 0.0, 0.0])?;
    check_halves(&boundary, "most cuts that turns order", 16_803)
}

/// Boundaries of few edges, with more and more triangles: beside a zigzag the polygon walks to a hole and back.
fn most_triangles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let hole = [[0.0, 0.0, -3.0], [-0.25, 0.0, -2.5], [0.25, 0.0, -2.7]];
    for (edges, triangles, pieces) in [(32, 32, 150), (32, 34, 134), (24, MOST_TRIANGLES, 58)] {
        let mut random = Random::new(66 + triangles as u64);
        let mut corners = in_line(&mut random, edges - 8, &[[-6.0, 0.0, -6.0], [0.0, 0.0, -7.0]]);
        let bridge = (triangles - edges) / 2;
        let there: Vec<_> = (1..=bridge)
            .map(|at| [random.between(-1e-25, 1e-25), 0.0, -7.0 + 4.0 * at as f32 / (bridge + 1) as f32])
            .collect();
        let after = corners.len() - 1;
        let back = there.iter().rev().chain([&corners[after - 1]]).copied().collect();
        corners.splice(after..after, [there, hole.to_vec(), vec![hole[0]], back].concat());
        let (boundary, found) = looped(gpu, corners, [1.0, 0.0, 0.0])?;
        same("edges and triangles", &[boundary.edges.len(), found], &[edges, triangles])?;
        let name = format!("{edges} edges and {triangles} triangles");
        check_halves(&boundary, &name, pieces).map_err(|error| format!("{name}: {error}"))?;
    }
    Ok(())
}

/// Back and forth over a line, from one end of it to the other.
fn zigzag(random: &mut Random, edges: usize, reach: f32) -> Vec<[f32; 3]> {
    let along = |at: usize| 0.9 * (2.0 * at as f32 / edges as f32 - 1.0);
    (0..=edges).map(|at| [along(at), random.between(-0.1, 0.1), [-reach, reach][at % 2]]).collect()
}

/// Pieces of a boundary that is seen from above: there are as many as cuts say, they close, and wind around what is dark.
fn check_from_above(boundary: &Twisted, cuts: &[usize]) -> Result<(), String> {
    boundary.check_count(cuts)?;
    check_closed(&boundary.pieces)?;
    let [steps, dark] = boundary.check_dark(&mut Random::new(67), 100)?;
    println!("{steps} steps between points, {dark} of them from light to dark or back");
    if dark > 10 { Ok(()) } else { Err("too few steps".to_owned()) }
}

/// A boundary of the most edges, of which all that can cut the last but one. It is seen from above.
fn most_cuts() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let most = MAX_BOUNDARY_EDGES - 5;
    let mut corners = zigzag(&mut Random::new(64), most, 1.0);
    // Around to the beginning, and along the line.
    corners.extend([[2.0, 0.0, -3.0], [-2.0, 0.1, -3.0], [-2.0, -0.1, 0.01], [2.0, 0.1, 0.02]]);
    corners.rotate_right(1);
    let (boundary, _) = looped(gpu, corners, [0.0, 1.0, 0.0])?;
    same("edges", &[boundary.edges.len()], &[MAX_BOUNDARY_EDGES])?;
    let cuts = cuts_from_above(&boundary);
    if cuts.iter().all(|&cuts| cuts < most) {
        return Err(format!("only {:?} cuts of an edge", cuts.iter().max()));
    }
    check_from_above(&boundary, &cuts)
}

/// Rows that a zigzag cuts as often as turns order, and nearly as many pieces as there is room for. It is seen from above.
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
    let (boundary, _) = looped(gpu, corners, [0.0, 1.0, 0.0])?;
    let cuts = cuts_from_above(&boundary);
    same("most cuts of an edge", &[cuts.iter().max()], &[Some(&MOST_ORDERED)])?;
    check_from_above(&boundary, &cuts)
}

/// A star of which each edge cuts all others but its neighbours: the most cuts that a boundary can have.
fn too_many() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let corners = MAX_BOUNDARY_EDGES - 1;
    let corner = |at: usize| {
        let angle = (at * (corners / 2) % corners) as f32 / corners as f32 * std::f32::consts::TAU;
        [angle.sin(), 0.0, angle.cos()]
    };
    let mut set = PolygonSet::default();
    set.push_points(&[(0..corners).map(corner).collect()]);
    let mesh = set.mesh(Weld::Position).map_err(text)?;
    let (counts, capacity) = piece_counts(gpu, &set, &mesh, &[Light::directional([0.0, 1.0, 0.0]); 2])?;
    println!("{} pieces, and room for {capacity}", counts[0]);
    same("pieces", &counts, &[(corners * (corners - 2)) as u32; 2])?;
    if counts[0] > capacity { Ok(()) } else { Err("there is room".to_owned()) }
}
