//! Clipped sides and near caps against exact clipping in `f64`: where their vertices lie, and that the surface closes.

use std::collections::BTreeMap;

use glam::{DMat4, DVec2, DVec3, DVec4, Vec4};
use rimline::Predicate;
use rimline::mesh::EdgeKind;
use rimline::reference::cpu::{self, Corner, End, Threads};
use rimline::reference::layout::{ShadowLight, ShadowShape, ShadowView};
use rimline::reference::shadow::{self, CAST_EVERY, COUNT_ZP_PLUS};
use rimline_testkit::is_long;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Scene, scene};

type Outcome = Result<(), String>;

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

/// A scene with every face that casts counted by ZP+.
struct Cast<'a> {
    scene: &'a Scene,
    view: ShadowView,
    lights: Vec<ShadowLight>,
    facing: Vec<u32>,
}

impl<'a> Cast<'a> {
    fn new(scene: &'a Scene) -> Self {
        let (_, positions, mesh) = &scene.caster;
        let view = shadow::view(&scene.camera).expect("a good camera");
        let mut lights: Vec<_> = scene.lights.iter().map(|&light| shadow::light(&scene.camera, &view, light)).collect();
        let counts = mesh.edges().counts();
        let averted = u32::from(counts.boundary == 0 && counts.inconsistent == 0);
        let shape = ShadowShape { averted, counting: COUNT_ZP_PLUS, skip_unreached: 1, ..bytemuck::Zeroable::zeroed() };
        cpu::choose(&shape, &view, cpu::bounds(positions, mesh.faces()), false, &mut lights);
        let plain = &scene.lights;
        let facing = cpu::facing(positions, mesh.faces(), plain, Predicate::Exact, Threads::ONE);
        Self { scene, view, lights, facing }
    }

    fn end(&self, vertex: u32) -> End {
        (vertex, self.scene.caster.1[vertex as usize])
    }

    fn corner(&self, light: &ShadowLight, vertex: u32) -> Corner {
        cpu::corner(&self.view, light, self.end(vertex).1)
    }

    /// Label of a polygon's vertex, by its bits, among those that the edges have.
    fn label(&self, light: &ShadowLight, clip: Vec4, edges: &[[u32; 2]]) -> Result<Label, String> {
        let bits = clip.to_array().map(f32::to_bits);
        for &[p, q] in edges {
            let [low, high] = edge_of(p, q);
            let (a, b) = (self.corner(light, low), self.corner(light, high));
            let near = |corner: &Corner| {
                let near = corner.near;
                let z = if self.view.near_z == 0.0 { near.z.max(0.0) } else { near.z.min(near.w) };
                Vec4::new(near.x, near.y, z, near.w)
            };
            let candidates = [
                (Kind::Far, a.far),
                (Kind::Far, b.far),
                (Kind::Near, near(&a)),
                (Kind::Near, near(&b)),
                (Kind::Star, cpu::project_to_near_plane(&self.view, light, &a)),
                (Kind::Star, cpu::project_to_near_plane(&self.view, light, &b)),
                (Kind::Meets, cpu::on_near_plane(&self.view, &a, &b)),
                (Kind::Turns, cpu::parallel_to_near_plane(&a, &b)),
            ];
            let found = candidates.iter().find(|(_, candidate)| candidate.to_array().map(f32::to_bits) == bits);
            if let Some((kind, _)) = found {
                return Ok((*kind, bits));
            }
        }
        Err(format!("{clip} is no vertex of {edges:?} for {light:?}"))
    }

    /// Polygons of a light by labels, with how often each counts; sides first, then near caps and, if the depth buffer does
    /// not have the caster, light caps.
    fn polygons(&self, index: usize, in_depth: bool) -> Result<Vec<(Vec<Label>, i64)>, String> {
        let (_, _, mesh) = &self.scene.caster;
        let light = &self.lights[index];
        let mut polygons = Vec::new();
        let faces = mesh.faces();
        let plane = &self.facing[index / 32 * faces.len()..][..faces.len()];
        let masks = cpu::edges(mesh.edges(), &self.facing, faces.len(), self.lights.len(), Threads::ONE);
        let masks = &masks[index / 32 * mesh.edges().len()..][..mesh.edges().len()];
        let bit = |mask: u32| mask >> (index % 32) & 1 != 0;
        for (edge, masks) in mesh.edges().iter().zip(masks) {
            if !bit(masks.silhouette) {
                continue;
            }
            let [a, b] = edge.vertices;
            let ends = if bit(masks.winding) { [b, a] } else { [a, b] };
            let weight = if light.casting == CAST_EVERY && edge.kind != EdgeKind::Boundary { 2 } else { 1 };
            let polygon = cpu::side_clipped(&self.view, light, ends.map(|vertex| self.end(vertex)));
            polygons.push((polygon, vec![ends], weight));
        }
        for (&face, &mask) in faces.iter().zip(plane) {
            let [a, b, c] = face;
            if a != b && b != c && c != a && cpu::casts(light, bit(mask)) {
                let polygon = cpu::near_cap(&self.view, light, face.map(|vertex| self.end(vertex)));
                let edges = vec![[a, b], [b, c], [c, a]];
                let sign = if cpu::near_kind(light, bit(mask)) == 0 { 1 } else { -1 };
                polygons.push((polygon, edges.clone(), sign));
                if !in_depth {
                    let polygon = cpu::seen_light_cap(&self.view, light, face.map(|vertex| self.end(vertex)));
                    let sign = if cpu::far_kind(bit(mask)) == 2 { 1 } else { -1 };
                    polygons.push((polygon, edges, sign));
                }
            }
        }
        let labelled = polygons.into_iter().map(|(polygon, edges, count)| {
            if polygon.len() > 5 {
                return Err(format!("{}: light {index}: {} vertices of {edges:?}", self.scene.name, polygon.len()));
            }
            let labelled = polygon.iter().map(|&clip| {
                let label = self.label(light, clip, &edges)?;
                self.check_vertex(light, clip, label.0)?;
                Ok(label)
            });
            Ok((labelled.collect::<Result<_, String>>()?, count))
        });
        labelled.collect()
    }

    /// Nothing before the near plane, no negative w; far vertices but for the rounding of their depth, which decides
    /// nothing.
    fn check_vertex(&self, light: &ShadowLight, clip: Vec4, kind: Kind) -> Outcome {
        let columns = self.view.view_projection[..3].as_flattened();
        let largest = columns.iter().fold(1.0_f32, |largest, c| c.abs().max(largest));
        let slack = if kind == Kind::Far { 4e-6 * largest * clip.abs().max_element() } else { 0.0 };
        let depth = if self.view.near_z == 0.0 { clip.z } else { clip.w - clip.z };
        if clip.w >= -slack && depth >= -slack {
            return Ok(());
        }
        Err(format!("{}: {kind:?} {clip} for {light:?}", self.scene.name))
    }
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

#[test]
fn clipped_sides_and_near_caps_close() -> Outcome {
    volumes_close(92, true)
}

#[test]
fn light_caps_close_clipped_volumes() -> Outcome {
    volumes_close(94, false)
}

fn volumes_close(seed: u64, in_depth: bool) -> Outcome {
    let open_segments = |polygons: &[_]| open_segments(polygons, if in_depth { is_inner } else { is_before_dark_caps });
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut caps, mut sides, mut noticed) = (0, 0, 0);
    for number in 0..if is_long() { 600 } else { 24 } {
        let scene = scene(&mut random, number, 24);
        let cast = Cast::new(&scene);
        for index in 0..scene.lights.len() {
            if cast.lights[index].casting == 0 {
                continue;
            }
            let mut polygons = cast.polygons(index, in_depth)?;
            let open = open_segments(&polygons);
            if !open.is_empty() {
                let light = cast.lights[index];
                return Err(format!(
                    "{}: light {index}, {light:?}: open at {:?} and {} more",
                    scene.name,
                    open[0],
                    open.len() - 1
                ));
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
    assert!(caps > 100 && noticed * 10 > caps * 9, "not vacuous");
    Ok(())
}

/// A vertex in `f64`, for the near plane and the light as the stages see them; and the sums of absolute terms.
struct Exact {
    clip: DVec2,
    clip_size: DVec2,
    height: f64,
    height_size: f64,
    far: DVec2,
    far_size: DVec2,
    far_height: f64,
    rise_size: f64,
}

impl Exact {
    fn new(scene: &Scene, view: &ShadowView, light: DVec4, position: [f32; 3]) -> Self {
        let absolute = |m: DMat4| DMat4::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs(), m.w_axis.abs());
        let matrix = DMat4::from_cols_array_2d(&scene.camera.view_projection.map(|column| column.map(f64::from)));
        let plane = DVec4::from_array(view.near_plane.map(f64::from));
        let q = (DVec3::from_array(position.map(f64::from)) - DVec3::from_array(scene.camera.origin.map(f64::from)))
            .extend(1.0);
        let d = (light.w * q.truncate() - light.truncate()).extend(0.0);
        let xy = |c: DVec4| c.truncate().truncate();
        Self {
            clip: xy(matrix * q),
            clip_size: xy(absolute(matrix) * q.abs()),
            height: plane.dot(q),
            height_size: plane.abs().dot(q.abs()),
            far: xy(matrix * d),
            far_size: xy(absolute(matrix) * d.abs()),
            far_height: plane.dot(d),
            rise_size: plane.abs().dot(d.abs()),
        }
    }
}

/// Roundings that a vertex goes through at most, one unit in the last place each.
const ROUNDINGS: f64 = 12.0 / 8_388_608.0;

/// The worst error of a kind of vertex, in parts of its bound and in normalised device coordinates within the view.
#[derive(Debug, Default)]
struct Worst {
    count: usize,
    of_bound: f64,
    ndc: f64,
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
        if exact.abs().max_element() <= near_w {
            self.ndc = self.ndc.max(error.max_element() / near_w);
        }
        Ok(())
    }
}

#[test]
fn vertices_lie_where_exact_clipping_has_them() -> Outcome {
    let seed = 93;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut stars, mut meetings, mut turns) = (Worst::default(), Worst::default(), Worst::default());
    let mut doubtful = 0;
    for number in 0..if is_long() { 2000 } else { 60 } {
        let scene = scene(&mut random, number, 24);
        let (_, positions, mesh) = &scene.caster;
        let view = shadow::view(&scene.camera).map_err(|error| error.to_string())?;
        let near_w = f64::from(view.near_w);
        for &given in &scene.lights {
            let light = shadow::light(&scene.camera, &view, given);
            let [x, y, z, w] = light.light.map(f64::from);
            let at = (DVec3::new(x, y, z) - w * DVec3::from_array(scene.camera.origin.map(f64::from))).extend(w);
            let at_clip =
                DMat4::from_cols_array_2d(&scene.camera.view_projection.map(|column| column.map(f64::from))) * at;
            let at_height = DVec4::from_array(view.near_plane.map(f64::from)).dot(at);
            let at_xy = at_clip.truncate().truncate();
            let xy = |clip: Vec4| clip.as_dvec4().truncate().truncate();
            let exact = |position| Exact::new(&scene, &view, at, position);
            for edge in mesh.edges().iter().step_by(11) {
                let [low, high] = edge_of(edge.vertices[0], edge.vertices[1]).map(|v| positions[v as usize]);
                let (a, b) = (exact(low), exact(high));
                let corners = [low, high].map(|position| cpu::corner(&view, &light, position));
                let is_sure = |v: &Exact| {
                    v.height.abs() > ROUNDINGS * v.height_size && v.far_height.abs() > ROUNDINGS * v.rise_size
                };
                if !is_sure(&a) || !is_sure(&b) {
                    doubtful += 1;
                    continue;
                }
                for (v, corner) in [&a, &b].into_iter().zip(&corners) {
                    assert_eq!(
                        (v.height >= 0.0, v.far_height >= 0.0),
                        (corner.height >= 0.0, corner.far_height >= 0.0)
                    );
                    if (v.height >= 0.0) != (v.far_height >= 0.0) {
                        let star = cpu::project_to_near_plane(&view, &light, corner);
                        assert!(star.w >= 0.0 && star.z == star.w * view.near_z, "{star}");
                        let place = (v.clip * at_height - at_xy * v.height) / -v.far_height;
                        let (size, weight) = if corner.is_far {
                            (v.clip_size * at_height.abs() + at_xy.abs() * v.height_size, 1.0)
                        } else {
                            (v.far_size * at_height.abs() + at_xy.abs() * v.rise_size, w)
                        };
                        let bound = ROUNDINGS * (size / weight + place.abs() * v.rise_size) / v.far_height.abs();
                        let found = xy(star) * (near_w / f64::from(star.w));
                        stars.add(&scene.name, found, place, bound, near_w)?;
                    }
                }
                let [p, q] = &corners;
                if (a.height >= 0.0) != (b.height >= 0.0) {
                    let meeting = cpu::on_near_plane(&view, p, q);
                    assert!(meeting.w == view.near_w && meeting.z == meeting.w * view.near_z);
                    let t = a.height / (a.height - b.height);
                    let apart = (b.clip - a.clip).abs();
                    let bound = ROUNDINGS
                        * (a.clip_size
                            + b.clip_size
                            + apart * (2.0 * (a.height_size + b.height_size) / (a.height - b.height).abs()));
                    meetings.add(&scene.name, xy(meeting), a.clip.lerp(b.clip, t), bound, near_w)?;
                }
                if (a.far_height >= 0.0) != (b.far_height >= 0.0) {
                    let turn = cpu::parallel_to_near_plane(p, q);
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
    rimline_testkit::must_fail("a moved vertex", &moved)
}
