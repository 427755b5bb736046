//! Clipped sides, near caps and light caps on the GPU: their surface closes, bit for bit, and their vertices lie where exact
//! clipping in `f64` has them.
//!
//! The stages are `sides` and `cap_faces`.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use glam::{DMat4, DVec2, DVec3, DVec4};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::{ShadowLight, ShadowView};
use rimline::internals::shadow::{self, CAST_BACK_FACING, CAST_EVERY, COUNT_ZP_PLUS};
use rimline::internals::stages::{CAP_FACES, SIDES};
use rimline::mesh::{INCONSISTENT_BIT, NO_FACE};
use rimline::{Light, Mesh, Predicate, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Scene, scene};

use crate::margins::view::{Eye, stepped};
use rimline_testkit::stage_probe::{Input, Probe};
use rimline_testkit::{is_long, must_fail};

pub(crate) const TESTS: &[Test] = &[
    ("clipped_sides_near_caps_and_light_caps_close", volumes_close),
    ("vertices_lie_where_exact_clipping_has_them", exact_vertices),
    ("sides_of_an_edge_in_both_directions_have_the_same_triangles", opposite_sides),
];

type Outcome = Result<(), String>;

/// Points that the ends of an edge, first that of lower index, and the edge have on the near plane of a camera, for a light.
pub(crate) struct OfEdge {
    /// The ends in clip space; and those that are behind the near plane by their height are by their depth.
    pub(crate) near: [[f32; 4]; 2],
    behind: [[f32; 4]; 2],
    far: [[f32; 4]; 2],
    /// Where the light has the ends on the near plane.
    pub(crate) stars: [[f32; 4]; 2],
    meeting: [f32; 4],
    turn: [f32; 4],
    pub(crate) heights: [f32; 2],
    pub(crate) far_heights: [f32; 2],
    are_far: [bool; 2],
}

impl OfEdge {
    /// For each number of a camera and light and each edge.
    pub(crate) fn of(gpu: &Gpu, seen: &[(ShadowView, ShadowLight)], edges: &[Input<2>]) -> Result<Vec<Self>, String> {
        let probe = Probe::of(
            gpu,
            &SIDES,
            [2, 12],
            "
    let a = corner(pair.view, pair.light, input_position(0u));
    let b = corner(pair.view, pair.light, input_position(1u));
    out[0] = a.near;
    out[1] = b.near;
    out[2] = behind_near_plane(pair.view, a.near);
    out[3] = behind_near_plane(pair.view, b.near);
    out[4] = a.far;
    out[5] = b.far;
    out[6] = project_to_near_plane(pair.view, pair.light, a);
    out[7] = project_to_near_plane(pair.view, pair.light, b);
    out[8] = on_near_plane(pair.view, a, b);
    out[9] = parallel_to_near_plane(a, b);
    out[10] = vec4<f32>(a.height, b.height, a.far_height, b.far_height);
    let is_far = vec4<bool>(a.is_light_farther, b.is_light_farther, false, false);
    out[11] = select(vec4<f32>(0.0), vec4<f32>(1.0), is_far);",
        )?;
        let of_edge = |found: Vec<[f32; 4]>| Self {
            near: [found[0], found[1]],
            behind: [found[2], found[3]],
            far: [found[4], found[5]],
            stars: [found[6], found[7]],
            meeting: found[8],
            turn: found[9],
            heights: [found[10][0], found[10][1]],
            far_heights: [found[10][2], found[10][3]],
            are_far: [found[11][0] > 0.0, found[11][1] > 0.0],
        };
        Ok(probe.run(gpu, &[], seen, edges)?.into_iter().map(of_edge).collect())
    }

    /// Vertices that a polygon may have at the edge.
    fn vertices(&self) -> [(Kind, [f32; 4]); 8] {
        let Self { behind, far, stars, meeting, turn, .. } = self;
        let of = |kind, of_ends: &[[f32; 4]; 2]| of_ends.map(|end| (kind, end));
        let [[a, b], [c, d], [e, f]] = [of(Kind::Far, far), of(Kind::Near, behind), of(Kind::Star, stars)];
        [a, b, c, d, e, f, (Kind::Meets, *meeting), (Kind::Turns, *turn)]
    }
}

/// Kind of a vertex of a clipped polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Near,
    Far,
    Star,
    Meets,
    Turns,
}

/// A vertex of a clipped polygon by its bits: that seams have equal ones is what is tested.
type Label = (Kind, [u32; 4]);

fn edge_of(p: u32, q: u32) -> [u32; 2] {
    [p.min(q), p.max(q)]
}

/// The polygon that a strip draws.
fn polygon(strip: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let order: &[usize] = if strip.len() == 5 { &[0, 1, 3, 4, 2] } else { &[0, 1, 3, 2] };
    let mut corners: Vec<_> = order.iter().map(|&at| strip[at]).collect();
    corners.dedup_by_key(|corner| corner.map(f32::to_bits));
    corners
}

/// The share of each face in the shadow of the light of a bit: 0 or ±1, from its mask and the light's choice alone.
fn shares((bit, light): (usize, &ShadowLight), facing: &[u32]) -> Vec<i32> {
    let share = |mask: &u32| match (light.casting, mask >> bit & 1 != 0) {
        (CAST_EVERY, true) => 1,
        (CAST_EVERY | CAST_BACK_FACING, false) => -1,
        _ => 0,
    };
    facing.iter().map(share).collect()
}

/// The lists of cap faces: near caps that count up on their front and on their back, then light caps of casters that are
/// not in the depth buffer, likewise. Near caps are of every face that casts, wherever it is.
fn cap_faces(mesh: &Mesh, light: (usize, &ShadowLight), facing: &[u32], in_depth: bool) -> [Vec<u32>; 4] {
    let mut lists: [Vec<u32>; 4] = Default::default();
    for ((index, &[a, b, c]), share) in (0..).zip(mesh.faces()).zip(shares(light, facing)) {
        if share == 0 || a == b || b == c || c == a {
            continue;
        }
        // The front of a face that faces the light is seen on the near plane if the light is on the eye's side.
        let is_back = (share > 0) != (light.1.height < 0.0);
        lists[usize::from(is_back)].extend((light.1.counting == COUNT_ZP_PLUS).then_some(index));
        lists[if share > 0 { 2 } else { 3 }].extend((!in_depth).then_some(index));
    }
    lists
}

/// The entries of a light's sides, in the order of the edge records: an index, with bit 31 if the side is along its
/// edge. A record with the sum 2 or -2 has two entries.
fn side_entries(mesh: &Mesh, light: (usize, &ShadowLight), facing: &[u32]) -> Vec<u32> {
    let shares = shares(light, facing);
    // Whether a face has an edge from its first vertex to its second one, or the other way round.
    let turn = |[a, b, c]: [u32; 3], edge: [u32; 2]| if [[a, b], [b, c], [c, a]].contains(&edge) { 1 } else { -1 };
    let records = (0..).zip(mesh.edges().vertices()).zip(mesh.edges().packed_faces());
    let entries = records.flat_map(|((edge, &ends), faces)| {
        let present = faces.iter().filter(|face| **face != NO_FACE).map(|face| (face & !INCONSISTENT_BIT) as usize);
        let sum: i32 = present.map(|face| shares[face] * turn(mesh.faces()[face], ends)).sum();
        std::iter::repeat_n(edge | if sum > 0 { cpu::WINDING } else { 0 }, sum.unsigned_abs() as usize)
    });
    entries.collect()
}

/// Nothing before the near plane, no negative w; far vertices but for the rounding of their depth, which decides nothing.
fn is_behind(view: &ShadowView, [x, y, z, w]: [f32; 4], kind: Kind) -> bool {
    let columns = view.view_projection[..3].as_flattened();
    let largest = columns.iter().fold(1.0_f32, |largest, c| c.abs().max(largest));
    let size = x.abs().max(y.abs()).max(z.abs()).max(w.abs());
    let slack = if kind == Kind::Far { 4e-6 * largest * size } else { 0.0 };
    let depth = if view.near_z == 0.0 { z } else { w - z };
    w >= -slack && depth >= -slack
}

/// Whether a segment must cancel: a ray from a vertex away from the light, or a piece of an edge seen on the near plane.
/// Others bound light caps, dark caps, and the faces' own meeting with the near plane.
fn is_inner((a, _): Label, (b, _): Label) -> bool {
    match (a.min(b), a.max(b)) {
        // Only of one vertex; or of an edge that turns at its far vertex where that is the same for both ends.
        // The last only of one edge.
        (Kind::Near, Kind::Far) | (Kind::Far, Kind::Meets) | (Kind::Meets, Kind::Turns) => true,
        (low, high) => low == Kind::Star || high == Kind::Star,
    }
}

/// Whether a segment must cancel where there are light caps, too: all but those of dark caps.
fn is_before_dark_caps((a, _): Label, (b, _): Label) -> bool {
    let is_dark = |kind| matches!(kind, Kind::Far | Kind::Turns);
    !(is_dark(a) && is_dark(b))
}

/// Segments that must cancel over all polygons and do not.
fn open_segments(polygons: &[(Vec<Label>, i64)], must_close: fn(Label, Label) -> bool) -> Vec<((Label, Label), i64)> {
    let mut sums = BTreeMap::new();
    for (polygon, count) in polygons {
        for (at, &a) in polygon.iter().enumerate() {
            let b = polygon[(at + 1) % polygon.len()];
            if a != b && must_close(a, b) {
                *sums.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { *count } else { -count };
            }
        }
    }
    sums.into_iter().filter(|&(_, sum)| sum != 0).collect()
}

fn volumes_close() -> Outcome {
    closes(92, true)?;
    closes(94, false)
}

/// Polygons by labels, with how often each counts.
type Polygons = Vec<(Vec<Label>, i64)>;

/// Strips of sides, by positions and whether the first end has the lower index; and of near caps and light caps, by positions
/// and indices.
fn probes(gpu: &Gpu) -> Result<[Arc<Probe>; 2], String> {
    let of_sides = Probe::of(
        gpu,
        &SIDES,
        [3, 5],
        "let is_ordered = input_position(2u).x != 0.0;
    for (var vertex = 0u; vertex < 5u; vertex++) {
      out[vertex] = clipped_side_vertex(pair.view, pair.light, input_position(0u), input_position(1u), is_ordered, vertex);
    }",
    )?;
    let of_caps = Probe::of(
        gpu,
        &CAP_FACES,
        [4, 9],
        "let face = CapFace(input_position(0u), input_position(1u), input_position(2u), vec3<u32>(input_position(3u)));
    for (var vertex = 0u; vertex < 5u; vertex++) {
      out[vertex] = near_cap_vertex(pair.view, pair.light, face, vertex);
    }
    for (var vertex = 0u; vertex < 4u; vertex++) {
      out[5u + vertex] = seen_light_cap_vertex(pair.view, pair.light, face, true, vertex);
    }",
    )?;
    Ok([of_sides, of_caps])
}

/// With light caps of a caster that is not in the depth buffer, too. Every face casts, or back-facing ones of closed casters
/// for every other light.
fn closes(seed: u64, in_depth: bool) -> Outcome {
    let (gpu, mut random) = Gpu::seeded(seed)?;
    let open_segments = |polygons: &[_]| open_segments(polygons, if in_depth { is_inner } else { is_before_dark_caps });
    let [of_sides, of_caps] = probes(&gpu)?;
    let (mut caps, mut sides, mut noticed, mut would_be_cut) = (0, 0, 0, 0);
    for number in 0..if is_long() { 600 } else { 24 } {
        let mut scene = scene(&mut random, number, 24);
        // Some vertices are a few ulps off the near plane.
        let eye = Eye::new(&scene.camera);
        for position in scene.caster.1.iter_mut().step_by(4).take(100 * (number % 2)) {
            *position = eye.on_picture(&mut random).as_vec3().to_array();
            let axis = random.below(3);
            position[axis] = stepped(position[axis], random.below(9) as i32 - 4);
        }
        let (_, positions, mesh) = &scene.caster;
        let at = |vertex: u32| positions[vertex as usize];
        let (view, counts) = (shadow::view(&scene.camera).map_err(text)?, mesh.edges().counts());
        let is_closed = counts.boundary + counts.inconsistent == 0;
        let light = |(index, &given): (usize, &Light)| {
            let casting = if in_depth && is_closed && index % 2 == 1 { CAST_BACK_FACING } else { CAST_EVERY };
            let light = shadow::light(&scene.camera, &view, given);
            (view, ShadowLight { casting, counting: COUNT_ZP_PLUS, ..light })
        };
        let seen: Vec<_> = scene.lights.iter().enumerate().map(light).collect();
        let facing = cpu::facing(positions, mesh.faces(), &scene.lights, Predicate::Exact, Threads::ONE);
        // A face may have an edge that has no record.
        let of_faces = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut edges: Vec<_> = of_faces.map(|[p, q]| edge_of(p, q)).collect();
        edges.sort_unstable();
        edges.dedup();
        for (index, (_, light)) in (0..).zip(&seen) {
            let what = |error: String| format!("{}: light {index}, {light:?}: {error}", scene.name);
            let inputs: Vec<_> = edges.iter().map(|edge| (index, edge.map(at))).collect();
            let of_edges: HashMap<_, _> = edges.iter().copied().zip(OfEdge::of(&gpu, &seen, &inputs)?).collect();
            for (near, height) in of_edges.values().flat_map(|of| of.near.into_iter().zip(of.heights)) {
                would_be_cut += usize::from(height >= 0.0 && !is_behind(&view, near, Kind::Near));
            }
            let mut polygons = Polygons::new();
            let mut add = |edges: &[[u32; 2]], strip: &[[f32; 4]], count: i64| {
                // Without vertices: not between light and near plane.
                if strip.iter().all(|vertex| *vertex == [0.0, 0.0, 0.0, 1.0]) {
                    return Ok(());
                }
                let label = |clip: [f32; 4]| {
                    let bits = clip.map(f32::to_bits);
                    let mut known = edges.iter().flat_map(|&[p, q]| of_edges[&edge_of(p, q)].vertices());
                    let found = known.find(|(_, vertex)| vertex.map(f32::to_bits) == bits);
                    let (kind, _) = found.ok_or_else(|| what(format!("{clip:?} is no vertex of {edges:?}")))?;
                    if is_behind(&view, clip, kind) {
                        Ok((kind, bits))
                    } else {
                        Err(what(format!("{kind:?} {clip:?}")))
                    }
                };
                polygons.push((polygon(strip).into_iter().map(label).collect::<Result<_, String>>()?, count));
                Ok::<_, String>(())
            };
            let of_light = (index as usize, light);
            let ends = |entry: u32| {
                let [p, q] = mesh.edges().vertices()[(entry & !cpu::WINDING) as usize];
                if entry & cpu::WINDING == 0 { [p, q] } else { [q, p] }
            };
            let ends: Vec<_> = side_entries(mesh, of_light, &facing).into_iter().map(ends).collect();
            let side = |&[p, q]: &[u32; 2]| (index, [at(p), at(q), [f32::from(u8::from(p < q)), 0.0, 0.0]]);
            let strips = of_sides.run(&gpu, &[], &seen, &ends.iter().map(side).collect::<Vec<_>>())?;
            ends.iter().zip(strips).try_for_each(|(&ends, strip)| add(&[ends], &strip, 1))?;
            let kinds = cap_faces(mesh, of_light, &facing, in_depth);
            for (listed, (part, sign)) in kinds.iter().zip([(0..5, 1), (0..5, -1), (5..9, 1), (5..9, -1)]) {
                let faces: Vec<_> = listed.iter().map(|&face| mesh.faces()[face as usize]).collect();
                let cap = |&[a, b, c]: &[u32; 3]| (index, [at(a), at(b), at(c), [a, b, c].map(|rank| rank as f32)]);
                let strips = of_caps.run(&gpu, &[], &seen, &faces.iter().map(cap).collect::<Vec<_>>())?;
                for (&[a, b, c], strip) in faces.iter().zip(strips) {
                    add(&[[a, b], [b, c], [c, a]], &strip[part.clone()], sign)?;
                }
            }
            let open = open_segments(&polygons);
            if let Some(first) = open.first() {
                return Err(what(format!("open at {first:?} and {} more", open.len() - 1)));
            }
            let has_star = |(labels, _): &(Vec<Label>, i64)| labels.iter().any(|label| label.0 == Kind::Star);
            sides += polygons.iter().filter(|polygon| has_star(polygon)).count();
            if let Some(at) = polygons.iter().rposition(has_star) {
                caps += 1;
                polygons.swap_remove(at);
                noticed += usize::from(!open_segments(&polygons).is_empty());
            }
        }
    }
    println!("{caps} lights with vertices on the near plane, {sides} polygons with them; {noticed} thefts noticed");
    println!("{would_be_cut} ends behind the near plane by their height and before it by their depth");
    if caps > 100 && noticed * 10 > caps * 9 && would_be_cut > 30 { Ok(()) } else { Err("not vacuous".to_owned()) }
}

/// A camera's matrix and origin, its near plane as the stages see it, and a light in `f64`, about the origin.
pub(crate) struct ExactView {
    matrix: DMat4,
    plane: DVec4,
    origin: DVec3,
    light: DVec4,
}

/// A vertex of a view; and the sums of absolute terms.
pub(crate) struct Exact {
    clip: DVec2,
    clip_size: DVec2,
    height: f64,
    height_size: f64,
    far: DVec2,
    far_size: DVec2,
    far_height: f64,
    rise_size: f64,
}

/// Where the light has a vertex on the near plane, and what rounding moves it by at most, in the terms of the vertex or
/// of the light: docs/numerics/shadow-volumes.md, "Rounding of vertices".
pub(crate) struct Star {
    pub(crate) exact: DVec2,
    pub(crate) by_vertex: DVec2,
    pub(crate) by_light: DVec2,
}

impl ExactView {
    pub(crate) fn new(camera: &ShadowCamera, view: &ShadowView, light: &ShadowLight) -> Self {
        let origin = DVec3::from_array(camera.origin.map(f64::from));
        let [x, y, z, w] = light.light.map(f64::from);
        Self {
            matrix: DMat4::from_cols_array_2d(&camera.view_projection.map(|column| column.map(f64::from))),
            plane: DVec4::from_array(view.near_plane.map(f64::from)),
            origin,
            light: (DVec3::new(x, y, z) - w * origin).extend(w),
        }
    }

    pub(crate) fn vertex(&self, position: [f32; 3]) -> Exact {
        let Self { matrix, plane, origin, light } = self;
        let absolute =
            DMat4::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs(), matrix.w_axis.abs());
        let q = (DVec3::from_array(position.map(f64::from)) - origin).extend(1.0);
        let d = (light.w * q.truncate() - light.truncate()).extend(0.0);
        Exact {
            clip: xy(matrix * q),
            clip_size: xy(absolute * q.abs()),
            height: plane.dot(q),
            height_size: plane.abs().dot(q.abs()),
            far: xy(matrix * d),
            far_size: xy(absolute * d.abs()),
            far_height: plane.dot(d),
            rise_size: plane.abs().dot(d.abs()),
        }
    }

    pub(crate) fn star(&self, v: &Exact) -> Star {
        let (height, at) = (self.plane.dot(self.light), xy(self.matrix * self.light));
        let exact = (v.clip * height - at * v.height) / -v.far_height;
        let bound = |size: DVec2, slope: f64, weight: f64| {
            let terms = (size * height.abs() + at.abs() * slope) / weight;
            ROUNDINGS * (terms + exact.abs() * v.rise_size) / v.far_height.abs()
        };
        let by_vertex = bound(v.clip_size, v.height_size, 1.0);
        Star { exact, by_vertex, by_light: bound(v.far_size, v.rise_size, self.light.w) }
    }
}

fn xy(clip: DVec4) -> DVec2 {
    clip.truncate().truncate()
}

/// Roundings that a vertex goes through at most, one unit in the last place each.
const ROUNDINGS: f64 = 12.0 / 8_388_608.0;

/// The worst error of a kind of vertex, in parts of its bound.
#[derive(Debug, Default)]
struct Worst {
    count: usize,
    of_bound: f64,
}

impl Worst {
    fn add(&mut self, what: &str, found: DVec2, exact: DVec2, bound: DVec2, near_w: f64) -> Outcome {
        let error = (found - exact).abs();
        // A bound beyond the picture says nothing.
        if !bound.is_finite() || bound.max_element() > 0.5 * near_w {
            return Ok(());
        }
        if !error.cmple(bound).all() {
            return Err(format!("{what}: {found}, exact {exact}, bound {bound}"));
        }
        self.count += 1;
        self.of_bound = self.of_bound.max((error / bound.max(DVec2::splat(1e-300))).max_element());
        Ok(())
    }
}

/// Lights of a scene and some of its edges, as the stages see them.
type SeenEdges = (Scene, Vec<(ShadowView, ShadowLight)>, Vec<Input<2>>);

fn seen_edges(random: &mut Random, number: usize, lights: usize, step: usize) -> Result<SeenEdges, String> {
    let scene = scene(random, number, lights);
    let (_, positions, mesh) = &scene.caster;
    let view = shadow::view(&scene.camera).map_err(text)?;
    let seen: Vec<_> = scene.lights.iter().map(|&given| (view, shadow::light(&scene.camera, &view, given))).collect();
    let edges = mesh.edges().vertices().iter().step_by(step);
    let edges: Vec<_> = edges.map(|&[p, q]| edge_of(p, q).map(|vertex| positions[vertex as usize])).collect();
    let inputs = (0..seen.len() as u32).flat_map(|light| edges.iter().map(move |&edge| (light, edge))).collect();
    Ok((scene, seen, inputs))
}

fn exact_vertices() -> Outcome {
    let (gpu, mut random) = Gpu::seeded(93)?;
    let (mut stars, mut meetings, mut turns) = (Worst::default(), Worst::default(), Worst::default());
    let mut doubtful = 0;
    for number in 0..if is_long() { 2000 } else { 60 } {
        let (scene, seen, inputs) = seen_edges(&mut random, number, 24, 11)?;
        let of_edges = OfEdge::of(&gpu, &seen, &inputs)?;
        for (&(light, [low, high]), of_edge) in inputs.iter().zip(&of_edges) {
            let (view, light) = &seen[light as usize];
            let (near_w, exact) = (f64::from(view.near_w), ExactView::new(&scene.camera, view, light));
            let xy = |clip: [f32; 4]| xy(DVec4::from_array(clip.map(f64::from)));
            let (a, b) = (exact.vertex(low), exact.vertex(high));
            let is_sure =
                |v: &Exact| v.height.abs() > ROUNDINGS * v.height_size && v.far_height.abs() > ROUNDINGS * v.rise_size;
            if !is_sure(&a) || !is_sure(&b) {
                doubtful += 1;
                continue;
            }
            for (end, v) in [&a, &b].into_iter().enumerate() {
                let (height, far_height) = (of_edge.heights[end], of_edge.far_heights[end]);
                assert_eq!((v.height >= 0.0, v.far_height >= 0.0), (height >= 0.0, far_height >= 0.0));
                if (v.height >= 0.0) != (v.far_height >= 0.0) {
                    let star = of_edge.stars[end];
                    assert!(star[3] >= 0.0 && star[2] == star[3] * view.near_z, "{star:?}");
                    let Star { exact, by_vertex, by_light } = exact.star(v);
                    let bound = if of_edge.are_far[end] { by_vertex } else { by_light };
                    let found = xy(star) * (near_w / f64::from(star[3]));
                    stars.add(&scene.name, found, exact, bound, near_w)?;
                }
            }
            // Where an edge is at height 0, and the bound: docs/numerics/shadow-volumes.md, "Rounding of vertices".
            let between = |ends: [DVec2; 2], sizes: DVec2, [h, k]: [f64; 2], height_sizes: f64| {
                let apart = (ends[1] - ends[0]).abs();
                let bound = ROUNDINGS * (sizes + apart * (2.0 * height_sizes / (h - k).abs()));
                (ends[0].lerp(ends[1], h / (h - k)), bound)
            };
            if (a.height >= 0.0) != (b.height >= 0.0) {
                let meeting = of_edge.meeting;
                assert!(meeting[3] == view.near_w && meeting[2] == meeting[3] * view.near_z);
                let (sizes, height_sizes) = (a.clip_size + b.clip_size, a.height_size + b.height_size);
                let (at, bound) = between([a.clip, b.clip], sizes, [a.height, b.height], height_sizes);
                meetings.add(&scene.name, xy(meeting), at, bound, near_w)?;
            }
            if (a.far_height >= 0.0) != (b.far_height >= 0.0) {
                let (sizes, rise_sizes) = (a.far_size + b.far_size, a.rise_size + b.rise_size);
                let (at, bound) = between([a.far, b.far], sizes, [a.far_height, b.far_height], rise_sizes);
                let size = a.far.abs().max_element().max(b.far.abs().max_element());
                turns.add(&scene.name, xy(of_edge.turn) / size, at / size, bound / size, 1.0)?;
            }
        }
    }
    println!("stars {stars:?}, meetings {meetings:?}, turns {turns:?}; {doubtful} edges within rounding of a plane");
    assert!(stars.count.min(meetings.count).min(turns.count) > 300, "not vacuous");
    assert!(stars.of_bound.min(meetings.of_bound).min(turns.of_bound) > 0.02, "the bounds are near");
    let moved = Worst::default().add("moved", DVec2::ONE, DVec2::splat(0.99), DVec2::splat(1e-3), 1.0);
    must_fail("a moved vertex", &moved)
}

type Triangle = [[u32; 4]; 3];

/// The triangles of a strip by their bits, in the order of their corners, each from its lowest corner on.
fn triangles(strip: &[[f32; 4]]) -> Vec<Triangle> {
    let corners: Vec<_> = strip.iter().map(|corner| corner.map(f32::to_bits)).collect();
    let of = |first: usize| -> Option<Triangle> {
        let [a, b, c] = [0, 1 + first % 2, 2 - first % 2].map(|at| corners[first + at]);
        (a != b && b != c && c != a).then(|| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c]))
    };
    let mut all: Vec<_> = (0..corners.len() - 2).filter_map(of).collect();
    all.sort_unstable();
    all
}

/// The same triangles with opposite orders of their corners.
fn turned(all: Vec<Triangle>) -> Vec<Triangle> {
    let mut turned: Vec<Triangle> = all.into_iter().map(|[a, b, c]| [a, c, b]).collect();
    turned.sort_unstable();
    turned
}

fn opposite_sides() -> Outcome {
    let (gpu, mut random) = Gpu::seeded(94)?;
    let probe = Probe::of(
        &gpu,
        &SIDES,
        [2, 18],
        "
    let a = input_position(0u);
    let b = input_position(1u);
    for (var vertex = 0u; vertex < 4u; vertex++) {
      out[vertex] = side_vertex(pair.view, pair.light, a, b, vertex);
      out[4u + vertex] = side_vertex(pair.view, pair.light, b, a, vertex);
    }
    for (var vertex = 0u; vertex < 5u; vertex++) {
      out[8u + vertex] = clipped_side_vertex(pair.view, pair.light, a, b, true, vertex);
      out[13u + vertex] = clipped_side_vertex(pair.view, pair.light, b, a, false, vertex);
    }",
    )?;
    let mut compared = 0;
    for number in 0..12 {
        let (scene, seen, inputs) = seen_edges(&mut random, number, 8, 7)?;
        for strips in probe.run(&gpu, &[], &seen, &inputs)? {
            for [one, other] in [[0..4, 4..8], [8..13, 13..18]] {
                let (one, other) = (triangles(&strips[one]), triangles(&strips[other]));
                compared += one.len();
                if one != turned(other) {
                    return Err(format!("{}: sides in both directions have other triangles", scene.name));
                }
            }
        }
    }
    // By another diagonal they would.
    let corner = |x: f32, y: f32| [x, y, 0.0, 1.0];
    let quad = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0)];
    let other = [quad[1], quad[0], quad[3], quad[2]];
    let same = if triangles(&quad) == turned(triangles(&other)) { Ok(()) } else { Err("another diagonal".to_owned()) };
    must_fail("another diagonal", &same)?;
    println!("{compared} triangles");
    if compared > 5000 { Ok(()) } else { Err("too few triangles".to_owned()) }
}
