//! Which edges are drawn, and as what.

use rimline::cpu::{Extraction, extract};
use rimline::mesh::{Edge, EdgeKind};
use rimline::{Mesh, Predicate};

use crate::crease::Crease;
use crate::drawing::FaceId;
use crate::error::{Fault, LeftOut, LinesError};
use crate::exact::Eye;
use crate::fold::Fold;
use crate::options::{LineClass, LineOptions};
use crate::parallel::ranges;
use crate::world::{Placed, World};

/// A line that is drawn, from one vertex to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Vertices among those of all objects; then points where edges pierce faces.
    pub(crate) vertices: [u32; 2],
    pub(crate) class: LineClass,
    /// The index among the objects that are drawn.
    pub(crate) placed: u32,
    /// The edge record, the first of its edge; for an intersection the index of its faces in [`World::meetings`].
    pub(crate) record: u32,
}

impl Line {
    /// The faces that meet there.
    pub(crate) fn faces(&self, world: &World<'_>) -> [Option<FaceId>; 2] {
        if self.class == LineClass::Intersection {
            return world.meetings[self.record as usize].map(Some);
        }
        let placed = &world.placed[self.placed as usize];
        let edge = placed.object.mesh.edges().get(self.record as usize);
        let face = |face| FaceId { object: placed.number, face };
        [edge.map(|edge| face(edge.face_0)), edge.and_then(|edge| edge.face_1).map(face)]
    }
}

/// Edge records at a time.
const RUN: usize = 1 << 14;

/// The lines of all objects, but those where faces meet.
pub(crate) fn lines(
    world: &World<'_>,
    options: &LineOptions,
    left_out: &mut Vec<LeftOut>,
) -> Result<Vec<Line>, LinesError> {
    let mut lines = Vec::new();
    for (number, placed) in (0..).zip(&world.placed) {
        let object = placed.object;
        let masks = extract(&object.positions, &object.mesh, &[world.view.eye()], Predicate::Exact, options.threads)?;
        let shared = shared_edges(&object.mesh);
        let marked = Marked::new(placed, left_out);
        let crease = Crease::new(options.crease_degrees);
        let (eye, folds) = (world.eye, Vec::new());
        let mut asked = Asked { placed, number, options, eye, crease, masks, shared, folds, marked };
        asked.folds = asked.folds();
        let found = ranges(options.threads, object.mesh.edges().len(), RUN, |range| {
            range.filter_map(|record| asked.line(record as u32)).collect::<Vec<_>>()
        });
        lines.extend(found.into_iter().flatten());
    }
    Ok(once(lines, world))
}

/// An object whose edges are asked.
struct Asked<'a> {
    placed: &'a Placed<'a>,
    number: u32,
    options: &'a LineOptions,
    eye: Eye,
    crease: Crease,
    masks: Extraction,
    /// Records of edges that have several, and the first of each edge.
    shared: Vec<[u32; 2]>,
    /// Edges of several records whose faces lie in two half-planes, by the first record, in order. A mesh of polygons has none.
    folds: Vec<(u32, Fold)>,
    marked: Marked,
}

impl Asked<'_> {
    fn line(&self, record: u32) -> Option<Line> {
        let edge = self.placed.object.mesh.edges().get(record as usize)?;
        let masks = self.masks.masks[record as usize];
        let is_silhouette = masks.silhouette & 1 != 0;
        let first = self.shared.binary_search_by_key(&record, |&[shared, _]| shared).map(|at| self.shared[at][1]);
        let fold = first.ok().and_then(|first| self.folds.binary_search_by_key(&first, |&(first, _)| first).ok());
        let fold = fold.map(|at| self.folds[at].1);
        let is = |class: LineClass| match class {
            LineClass::Silhouette => match fold {
                Some(fold) => fold.is_silhouette,
                None => is_silhouette && edge.kind != EdgeKind::Boundary,
            },
            LineClass::Boundary => edge.kind == EdgeKind::Boundary && first.is_err(),
            LineClass::NonManifold => first.is_ok() && fold.is_none(),
            LineClass::Crease => fold.map_or_else(|| self.is_crease(&edge), |fold| fold.is_crease),
            LineClass::Intersection => false,
            LineClass::Marked => self.marked.contains(edge.vertices),
        };
        let class = LineClass::ALL.into_iter().find(|&class| self.options.classes.contains(class) && is(class))?;
        let is_forward = match fold {
            Some(fold) => fold.is_left == (edge.vertices[0] < edge.vertices[1]),
            None => masks.winding & 1 != 0,
        };
        let [a, b] = edge.vertices.map(|vertex| vertex + self.placed.first_vertex);
        let vertices = if is_forward { [a, b] } else { [b, a] };
        Some(Line { vertices, class, placed: self.number, record: first.unwrap_or(record) })
    }

    fn folds(&self) -> Vec<(u32, Fold)> {
        let object = self.placed.object;
        if object.mesh.polygons().is_some() {
            return Vec::new();
        }
        let mut by_edge: Vec<[u32; 2]> = self.shared.iter().map(|&[record, first]| [first, record]).collect();
        by_edge.sort_unstable();
        let fold = |records: &[[u32; 2]]| {
            let mut faces = Vec::new();
            let mut vertices = [0; 2];
            for &[_, record] in records {
                let edge = object.mesh.edges().get(record as usize)?;
                let masks = self.masks.masks[record as usize];
                vertices = sorted(edge.vertices);
                // A face is to the left of the edge if the eye is in front of it and it walks the edge that way, or neither.
                let (is_forward, facing) = (edge.vertices == vertices, masks.winding & 1 != 0);
                faces.push((edge.face_0, is_forward == facing));
                if let Some(face_1) = edge.face_1 {
                    let is_same_way = edge.kind == EdgeKind::Inconsistent;
                    let is_facing = facing != ((masks.silhouette & 1 != 0) != is_same_way);
                    faces.push((face_1, (is_forward == is_same_way) == is_facing));
                }
            }
            Some((records[0][0], Fold::new(object, vertices, &faces, self.crease, self.eye)?))
        };
        by_edge.chunk_by(|one, other| one[0] == other[0]).filter_map(fold).collect()
    }

    fn is_crease(&self, edge: &Edge) -> bool {
        let Some(face_1) = edge.face_1 else { return false };
        let object = self.placed.object;
        let triangles = |face: u32| {
            let face = face as usize;
            let triangles = object.mesh.polygons().map_or(face..face + 1, |polygons| polygons.triangles(face));
            let corners = object.mesh.faces()[triangles].iter();
            corners.map(|corners| corners.map(|vertex| object.positions[vertex as usize]))
        };
        self.crease.is_between(triangles(edge.face_0), triangles(face_1), edge.kind == EdgeKind::Inconsistent)
    }
}

/// Records of edges that have several, in order, each with the first one of its edge.
fn shared_edges(mesh: &Mesh) -> Vec<[u32; 2]> {
    let records = mesh.edges().vertices();
    // Most edges are alone with their bit of a hash; only the others are sorted.
    let bits = (32 * records.len() as u64).next_power_of_two().max(64);
    let (mut met, mut met_twice) = (vec![0_u64; bits as usize / 64], vec![0_u64; bits as usize / 64]);
    let bit = |edge: [u32; 2]| {
        let [low, high] = sorted(edge).map(u64::from);
        let hash = (high << 32 | low).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (64 - bits.trailing_zeros());
        (hash as usize / 64, 1_u64 << (hash % 64))
    };
    for &edge in records {
        let (word, bit) = bit(edge);
        met_twice[word] |= met[word] & bit;
        met[word] |= bit;
    }
    let is_doubtful = |&(_, edge): &(u32, &[u32; 2])| {
        let (word, bit) = bit(*edge);
        met_twice[word] & bit != 0
    };
    let doubtful = (0..).zip(records).filter(is_doubtful);
    let mut doubtful: Vec<_> = doubtful.map(|(record, &edge)| (sorted(edge), record)).collect();
    doubtful.sort_unstable();
    let runs = doubtful.chunk_by(|one, other| one.0 == other.0).filter(|run| run.len() > 1);
    let mut shared: Vec<_> = runs.flat_map(|run| run.iter().map(|&(_, record)| [record, run[0].1])).collect();
    shared.sort_unstable();
    shared
}

/// Marked edges in order, each once.
struct Marked(Vec<[u32; 2]>);

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Marked {
    /// Names those that are no edges.
    fn new(placed: &Placed<'_>, left_out: &mut Vec<LeftOut>) -> Self {
        let object = placed.object;
        let mut all: Vec<_> = object.marked.iter().copied().map(sorted).collect();
        all.sort_unstable();
        // A search finds one of those that are equal.
        all.dedup();
        let mut is_edge = vec![false; all.len()];
        if !all.is_empty() {
            for &edge in object.mesh.edges().vertices() {
                if let Ok(at) = all.binary_search(&sorted(edge)) {
                    is_edge[at] = true;
                }
            }
        }
        for (vertices, _) in all.iter().zip(is_edge).filter(|&(_, is_edge)| !is_edge) {
            let (object, name) = (placed.number as usize, object.name.clone());
            left_out.push(LeftOut { object, name, fault: Fault::NoSuchEdge { vertices: *vertices } });
        }
        Self(all)
    }

    fn contains(&self, vertices: [u32; 2]) -> bool {
        !self.0.is_empty() && self.0.binary_search(&sorted(vertices)).is_ok()
    }
}

/// Each line once where several have the same ends: the highest class, then the first. Lines without a length are left out.
fn once(lines: Vec<Line>, world: &World<'_>) -> Vec<Line> {
    let ranked = |(at, line): (u32, &Line)| (world.key(line.vertices), line.class, at);
    let mut order: Vec<_> = (0..).zip(&lines).map(ranked).collect();
    order.sort_unstable();
    let mut is_drawn = vec![false; lines.len()];
    for same in order.chunk_by(|one, other| one.0 == other.0) {
        let (ends, _, best) = same[0];
        is_drawn[best as usize] = ends.is_some_and(|[a, b]| a != b);
    }
    lines.into_iter().zip(is_drawn).filter_map(|(line, is_drawn)| is_drawn.then_some(line)).collect()
}
