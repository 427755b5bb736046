//! Clipped sides, near caps and light caps on the GPU: their surface closes, bit for bit, and their vertices lie where exact
//! clipping in `f64` has them.
//!
//! The stages are `sides` and `cap_faces`.

use std::collections::{BTreeMap, HashMap};

use glam::{DMat4, DVec2, DVec3, DVec4};
use rimline::ShadowCamera;
use rimline::internals::cpu;
use rimline::internals::layout::{ShadowLight, ShadowShape, ShadowView};
use rimline::internals::shadow::{self, CAST_NOTHING, COUNT_ZP_PLUS};
use rimline::internals::stages::SIDES;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::scene;

use crate::clipped::{Drawn, NOTHING, Shapes, Vertices};
use crate::stages::{LAYOUTS, Staged, shape};
use rimline_testkit::stage_probe::{Input, Probe};
use rimline_testkit::{is_long, must_fail};

pub(crate) const TESTS: &[Test] = &[
    ("clipped_sides_and_near_caps_close", volumes_close),
    ("light_caps_close_clipped_volumes", volumes_of_proxies_close),
    ("vertices_lie_where_exact_clipping_has_them", exact_vertices),
    ("sides_of_an_edge_in_both_directions_have_the_same_triangles", opposite_sides),
];

type Outcome = Result<(), String>;

/// Points that the ends of an edge, first that of lower index, and the edge have on the near plane of a camera, for a light.
pub(crate) struct OfEdge(Vec<[f32; 4]>);

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
        Ok(probe.run(gpu, &[], seen, edges)?.into_iter().map(Self).collect())
    }

    pub(crate) fn near(&self) -> [[f32; 4]; 2] {
        [self.0[0], self.0[1]]
    }

    /// Where the light has the ends on the near plane.
    pub(crate) fn stars(&self) -> [[f32; 4]; 2] {
        [self.0[6], self.0[7]]
    }

    fn meeting(&self) -> [f32; 4] {
        self.0[8]
    }

    fn turn(&self) -> [f32; 4] {
        self.0[9]
    }

    pub(crate) fn heights(&self) -> [f32; 2] {
        [self.0[10][0], self.0[10][1]]
    }

    pub(crate) fn far_heights(&self) -> [f32; 2] {
        [self.0[10][2], self.0[10][3]]
    }

    fn are_far(&self) -> [bool; 2] {
        [self.0[11][0] > 0.0, self.0[11][1] > 0.0]
    }

    /// Vertices that a polygon may have at the edge.
    fn vertices(&self) -> [(Kind, [f32; 4]); 8] {
        let [_, _, near_a, near_b, far_a, far_b, star_a, star_b, meeting, turn, ..] = self.0[..] else {
            unreachable!()
        };
        [
            (Kind::Far, far_a),
            (Kind::Far, far_b),
            (Kind::Near, near_a),
            (Kind::Near, near_b),
            (Kind::Star, star_a),
            (Kind::Star, star_b),
            (Kind::Meets, meeting),
            (Kind::Turns, turn),
        ]
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

/// The shaders that draw sides, near caps of both classes, and light caps of both.
struct Shaders {
    sides: Shapes,
    caps: [Shapes; 4],
}

impl Shaders {
    fn new(gpu: &Gpu) -> Self {
        let near = |kind| Shapes::caps(gpu, "near_cap", kind, 5);
        let light = |kind| Shapes::caps(gpu, "seen_light_cap", kind, 4);
        Self { sides: Shapes::sides(gpu), caps: [near(0), near(1), light(2), light(3)] }
    }
}

/// Polygons of a light by labels, with how often each counts; sides first, then near caps and, if the depth buffer does
/// not have the caster, light caps.
fn polygons(
    gpu: &Gpu,
    shaders: &Shaders,
    drawn: &Drawn<'_>,
    of_edges: &HashMap<[u32; 2], OfEdge>,
) -> Result<Vec<(Vec<Label>, i64)>, String> {
    let (_, _, mesh) = &drawn.scene.caster;
    let mut polygons: Vec<(Vec<Label>, i64)> = Vec::new();
    let mut add = |edges: Vec<[u32; 2]>, strip: &[[f32; 4]], count: i64| {
        // Without vertices: not between light and near plane.
        if strip.iter().all(|vertex| *vertex == NOTHING) {
            return Ok(());
        }
        let label = |clip: [f32; 4]| {
            let bits = clip.map(f32::to_bits);
            let known = edges.iter().flat_map(|&[p, q]| of_edges[&edge_of(p, q)].vertices());
            let found = known.into_iter().find(|(_, vertex)| vertex.map(f32::to_bits) == bits);
            let (kind, _) =
                found.ok_or_else(|| format!("{clip:?} is no vertex of {edges:?} for {:?}", drawn.light()))?;
            check_vertex(drawn, clip, kind)?;
            Ok((kind, bits))
        };
        let labels = polygon(strip).into_iter().map(label).collect::<Result<_, String>>()?;
        polygons.push((labels, count));
        Ok::<_, String>(())
    };
    let checks = drawn.index.is_multiple_of(4);
    let (entries, strips): (_, Vertices) = drawn.sides(gpu, &shaders.sides, checks)?;
    for (entry, strip) in entries.iter().zip(strips.chunks(5)) {
        add(vec![mesh.edges().vertices()[(entry & !cpu::WINDING) as usize]], strip, 1)?;
    }
    for (cap, sign) in shaders.caps.iter().zip([1, -1, 1, -1]) {
        let (faces, strips) = drawn.caps(gpu, cap, checks)?;
        for (face, strip) in faces.iter().zip(strips.chunks(cap.vertices)) {
            let [a, b, c] = mesh.faces()[*face as usize];
            add(vec![[a, b], [b, c], [c, a]], strip, sign)?;
        }
    }
    Ok(polygons)
}

/// Nothing before the near plane, no negative w; far vertices but for the rounding of their depth, which decides nothing.
fn check_vertex(drawn: &Drawn<'_>, [x, y, z, w]: [f32; 4], kind: Kind) -> Outcome {
    let columns = drawn.view.view_projection[..3].as_flattened();
    let largest = columns.iter().fold(1.0_f32, |largest, c| c.abs().max(largest));
    let size = x.abs().max(y.abs()).max(z.abs()).max(w.abs());
    let slack = if kind == Kind::Far { 4e-6 * largest * size } else { 0.0 };
    let depth = if drawn.view.near_z == 0.0 { z } else { w - z };
    if w >= -slack && depth >= -slack {
        return Ok(());
    }
    Err(format!("{}: {kind:?} {:?} for {:?}", drawn.scene.name, [x, y, z, w], drawn.light()))
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
    closes(92, true)
}

fn volumes_of_proxies_close() -> Outcome {
    closes(94, false)
}

/// Every face that casts is counted by ZP+.
fn closes(seed: u64, in_depth: bool) -> Outcome {
    let gpu = &*Gpu::shared()?;
    let open_segments = |polygons: &[_]| open_segments(polygons, if in_depth { is_inner } else { is_before_dark_caps });
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let shaders = Shaders::new(gpu);
    let (mut caps, mut sides, mut noticed) = (0, 0, 0);
    for number in 0..if is_long() { 600 } else { 24 } {
        let scene = scene(&mut random, number, 24);
        let (_, positions, mesh) = &scene.caster;
        let options = ShadowShape {
            counting: COUNT_ZP_PLUS,
            cull_by_view: 0,
            proxies: u32::from(!in_depth),
            ..shape(mesh, scene.lights.len())
        };
        let staged = Staged::new(gpu, &scene, LAYOUTS[0], options, vec![0; mesh.faces().len()])?;
        let (lights, _) = staged.choose(gpu, 0)?;
        let seen: Vec<_> = lights.iter().map(|&light| (staged.view, light)).collect();
        // A face may have an edge that has no record.
        let of_faces = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut edges: Vec<_> = of_faces.map(|[p, q]| edge_of(p, q)).collect();
        edges.sort_unstable();
        edges.dedup();
        for index in 0..lights.len() {
            if lights[index].casting == CAST_NOTHING {
                continue;
            }
            let inputs: Vec<_> =
                edges.iter().map(|edge| (index as u32, edge.map(|vertex| positions[vertex as usize]))).collect();
            let of_edges = edges.iter().copied().zip(OfEdge::of(gpu, &seen, &inputs)?).collect();
            let drawn = Drawn::of(&staged, &lights, &[true; 24], index);
            let mut polygons = polygons(gpu, &shaders, &drawn, &of_edges)?;
            let open = open_segments(&polygons);
            if let Some(first) = open.first() {
                let (name, light, more) = (&scene.name, lights[index], open.len() - 1);
                return Err(format!("{name}: light {index}, {light:?}: open at {first:?} and {more} more"));
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
    if caps > 100 && noticed * 10 > caps * 9 { Ok(()) } else { Err("not vacuous".to_owned()) }
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

fn exact_vertices() -> Outcome {
    let (gpu, mut random) = Gpu::seeded(93)?;
    let (mut stars, mut meetings, mut turns) = (Worst::default(), Worst::default(), Worst::default());
    let mut doubtful = 0;
    for number in 0..if is_long() { 2000 } else { 60 } {
        let scene = scene(&mut random, number, 24);
        let (_, positions, mesh) = &scene.caster;
        let view = shadow::view(&scene.camera).map_err(|error| error.to_string())?;
        let near_w = f64::from(view.near_w);
        let seen: Vec<_> =
            scene.lights.iter().map(|&given| (view, shadow::light(&scene.camera, &view, given))).collect();
        let ends = |edge: [u32; 2]| edge_of(edge[0], edge[1]).map(|vertex| positions[vertex as usize]);
        let edges: Vec<_> = mesh.edges().vertices().iter().step_by(11).map(|&edge| ends(edge)).collect();
        let inputs: Vec<_> =
            (0..seen.len() as u32).flat_map(|light| edges.iter().map(move |&edge| (light, edge))).collect();
        let of_edges = OfEdge::of(&gpu, &seen, &inputs)?;
        for ((_, light), of_edges) in seen.iter().zip(of_edges.chunks(edges.len())) {
            let exact = ExactView::new(&scene.camera, &view, light);
            let xy = |clip: [f32; 4]| xy(DVec4::from_array(clip.map(f64::from)));
            for (&[low, high], of_edge) in edges.iter().zip(of_edges) {
                let (a, b) = (exact.vertex(low), exact.vertex(high));
                let is_sure = |v: &Exact| {
                    v.height.abs() > ROUNDINGS * v.height_size && v.far_height.abs() > ROUNDINGS * v.rise_size
                };
                if !is_sure(&a) || !is_sure(&b) {
                    doubtful += 1;
                    continue;
                }
                for (end, v) in [&a, &b].into_iter().enumerate() {
                    let (height, far_height) = (of_edge.heights()[end], of_edge.far_heights()[end]);
                    assert_eq!((v.height >= 0.0, v.far_height >= 0.0), (height >= 0.0, far_height >= 0.0));
                    if (v.height >= 0.0) != (v.far_height >= 0.0) {
                        let star = of_edge.stars()[end];
                        assert!(star[3] >= 0.0 && star[2] == star[3] * view.near_z, "{star:?}");
                        let Star { exact, by_vertex, by_light } = exact.star(v);
                        let bound = if of_edge.are_far()[end] { by_vertex } else { by_light };
                        let found = xy(star) * (near_w / f64::from(star[3]));
                        stars.add(&scene.name, found, exact, bound, near_w)?;
                    }
                }
                if (a.height >= 0.0) != (b.height >= 0.0) {
                    let meeting = of_edge.meeting();
                    assert!(meeting[3] == view.near_w && meeting[2] == meeting[3] * view.near_z);
                    let t = a.height / (a.height - b.height);
                    let apart = (b.clip - a.clip).abs();
                    let bound = ROUNDINGS
                        * (a.clip_size
                            + b.clip_size
                            + apart * (2.0 * (a.height_size + b.height_size) / (a.height - b.height).abs()));
                    meetings.add(&scene.name, xy(meeting), a.clip.lerp(b.clip, t), bound, near_w)?;
                }
                if (a.far_height >= 0.0) != (b.far_height >= 0.0) {
                    let turn = of_edge.turn();
                    let t = a.far_height / (a.far_height - b.far_height);
                    let apart = (b.far - a.far).abs();
                    let bound = ROUNDINGS
                        * (a.far_size
                            + b.far_size
                            + apart * (2.0 * (a.rise_size + b.rise_size) / (a.far_height - b.far_height).abs()));
                    let size = a.far.abs().max_element().max(b.far.abs().max_element());
                    turns.add(&scene.name, xy(turn) / size, a.far.lerp(b.far, t) / size, bound / size, 1.0)?;
                }
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
        let has_area = a != b && b != c && c != a;
        has_area.then(|| {
            if a < b && a < c {
                [a, b, c]
            } else if b < c {
                [b, c, a]
            } else {
                [c, a, b]
            }
        })
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
        let scene = scene(&mut random, number, 8);
        let (_, positions, mesh) = &scene.caster;
        let view = shadow::view(&scene.camera).map_err(|error| error.to_string())?;
        let seen: Vec<_> =
            scene.lights.iter().map(|&given| (view, shadow::light(&scene.camera, &view, given))).collect();
        let ends = |edge: [u32; 2]| edge_of(edge[0], edge[1]).map(|vertex| positions[vertex as usize]);
        let edges: Vec<_> = mesh.edges().vertices().iter().step_by(7).map(|&edge| ends(edge)).collect();
        let inputs: Vec<_> =
            (0..seen.len() as u32).flat_map(|light| edges.iter().map(move |&edge| (light, edge))).collect();
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
