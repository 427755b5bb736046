//! Outlines: what objects cover of the page, as polygons with holes.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::overlay::FloatOverlay;
use rimline::cpu::{Threads, extract};
use rimline::mesh::EdgeKind;
use rimline::{Mesh, Predicate};

use crate::error::{Fault, LeftOut, LinesError};
use crate::frame::near_of;
use crate::object::Object;
use crate::options::LineOptions;
use crate::view::View;
use crate::world::{Placed, World};

/// The part of the page that objects cover.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Polygons that do not overlap.
    pub polygons: Vec<OutlinePolygon>,
    /// Their area, in the square of the page's unit. Overlaps count once.
    pub area: f64,
}

/// A polygon of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutlinePolygon {
    /// Its outer loop, counter-clockwise.
    pub outer: Vec<[f64; 2]>,
    /// Its holes, clockwise.
    pub holes: Vec<Vec<[f64; 2]>>,
}

/// The outlines of objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outlines {
    /// One for each object given. Objects that are left out have an empty one.
    pub objects: Vec<Outline>,
    /// The part that any of the objects covers.
    pub all: Outline,
    /// Objects without an outline.
    pub left_out: Vec<LeftOut>,
}

/// The outlines of objects, each by itself and of all together. Only silhouette and boundary edges are united. Points are
/// rounded to about a thousand-millionth of the size of what is united.
///
/// The options [`LineOptions::near`], by default a thousandth of the greatest depth of a vertex, and [`LineOptions::threads`]
/// matter, no others. An object that reaches nearer to the eye is left out.
///
/// # Errors
/// [`LinesError`] for a `near` out of range, or too many faces.
pub fn outlines(objects: &[Object<'_>], view: &View, options: &LineOptions) -> Result<Outlines, LinesError> {
    let mut left_out = Vec::new();
    let world = World::new(objects, *view, &mut left_out)?;
    let points = || world.positions.iter().filter(|p| p.iter().all(|c| c.is_finite())).map(|p| p.map(f64::from));
    let near = near_of(view, options, points)?;
    let mut found = vec![Outline::default(); objects.len()];
    let mut all = Vec::new();
    for placed in &world.placed {
        let object = placed.number as usize;
        if is_too_near(placed, view, near) {
            left_out.push(LeftOut { object, name: placed.object.name.clone(), fault: Fault::TooNear });
            continue;
        }
        let loops = loops(placed, view, options.threads)?;
        found[object] = united(&loops);
        all.extend(loops);
    }
    left_out.sort_by_key(|left_out| left_out.object);
    let all = if let [only] = &*world.placed { found[only.number as usize].clone() } else { united(&all) };
    Ok(Outlines { objects: found, all, left_out })
}

fn is_too_near(placed: &Placed<'_>, view: &View, near: f64) -> bool {
    let mut vertices = placed.object.mesh.edges().vertices().as_flattened().iter();
    let depth = |vertex: u32| view.depth(placed.object.positions[vertex as usize].map(f64::from));
    view.is_perspective() && vertices.any(|&vertex| depth(vertex) < near)
}

/// Closed loops whose winding number about a point of the page is the number of faces there; half of it if the mesh is closed
/// and consistently oriented.
///
/// A face whose back the eye sees is walked the other way round. Edges between two faces with the same facing cancel.
fn loops(placed: &Placed<'_>, view: &View, threads: Threads) -> Result<Vec<Vec<[f64; 2]>>, LinesError> {
    let object = placed.object;
    // A polygon that is not planar may have a twisted outline. Its triangles have not.
    let triangles = || Mesh::from_faces(object.mesh.vertex_count() as usize, object.mesh.faces().to_vec());
    let of_triangles = object.mesh.polygons().map(|_| triangles()).transpose().map_err(rimline::ModelError::from)?;
    let mesh = of_triangles.as_ref().unwrap_or(&object.mesh);
    let facing = extract(&object.positions, mesh, &[view.eye()], Predicate::Exact, threads)?.facing;
    let mut edges = Vec::new();
    for edge in mesh.edges().iter() {
        let side = |face: u32| if facing[face as usize] & 1 != 0 { 1 } else { -1 };
        let turned = if edge.kind == EdgeKind::Inconsistent { 1 } else { -1 };
        let sum: i32 = side(edge.face_0) + edge.face_1.map_or(0, |face| turned * side(face));
        let [a, b] = edge.vertices;
        let directed = if sum > 0 { [a, b] } else { [b, a] };
        let count = if mesh.is_closed() { sum.abs() / 2 } else { sum.abs() };
        edges.extend(std::iter::repeat_n(directed, count as usize));
    }
    let point = |vertex: u32| view.page(object.positions[vertex as usize].map(f64::from));
    Ok(walks(edges).into_iter().map(|walk| walk.into_iter().map(point).collect()).collect())
}

/// Closed walks of directed edges, each in one of them. As many begin as end at each vertex.
fn walks(mut edges: Vec<[u32; 2]>) -> Vec<Vec<u32>> {
    edges.sort_unstable();
    let first = |vertex: u32| edges.partition_point(|edge| edge[0] < vertex);
    // Where the next edge is that begins where each one does, by the first of them.
    let mut next: Vec<usize> = (0..edges.len()).collect();
    let mut walks = Vec::new();
    for start in 0..edges.len() {
        let begin = edges[start][0];
        if first(begin) != start {
            continue;
        }
        while next[start] < edges.len() && edges[next[start]][0] == begin {
            let (mut walk, mut vertex) = (Vec::new(), begin);
            loop {
                let start_index = first(vertex);
                let Some(edge) = next.get(start_index).and_then(|&at| edges.get(at)).filter(|edge| edge[0] == vertex)
                else {
                    break;
                };
                next[start_index] += 1;
                walk.push(vertex);
                vertex = edge[1];
                if vertex == begin {
                    break;
                }
            }
            walks.push(walk);
        }
    }
    walks
}

fn united(loops: &[Vec<[f64; 2]>]) -> Outline {
    let shapes = FloatOverlay::<[f64; 2]>::with_subj(loops).overlay(OverlayRule::Subject, FillRule::NonZero);
    let mut outline = Outline::default();
    for shape in shapes {
        let mut loops = shape.into_iter();
        let Some(outer) = loops.next() else { continue };
        let polygon = OutlinePolygon { outer, holes: loops.collect() };
        outline.area += area(&polygon.outer) + polygon.holes.iter().map(|hole| area(hole)).sum::<f64>();
        outline.polygons.push(polygon);
    }
    outline
}

/// Above 0 if the loop is counter-clockwise.
fn area(points: &[[f64; 2]]) -> f64 {
    let Some(&[x, y]) = points.first() else { return 0.0 };
    let pairs = points.windows(2).map(|pair| (pair[0][0] - x) * (pair[1][1] - y) - (pair[1][0] - x) * (pair[0][1] - y));
    0.5 * pairs.sum::<f64>()
}
