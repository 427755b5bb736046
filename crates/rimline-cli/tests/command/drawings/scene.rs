//! The view of an eye on triangles, by rays through points of the page, and where lines must be between two such points. Nothing of it is
//! shared with the code under test: surfaces are walked from face to face in `f64`.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use rimline_lines::Object;
use serde_json::Value;

/// The angle of creases of the command's defaults.
const CREASE_COSINE: f64 = 0.838_670_567_945_424;
/// Signs and angles nearer to a change than this are left open.
const DOUBT: f64 = 1e-9;

/// An eye and a page, by what a JSON drawing says of them.
pub(super) struct Eye {
    /// A point, or the direction towards an eye at infinity.
    at: DVec3,
    is_point: bool,
    axes: [DVec3; 3],
    /// Pixels a unit of the view's page, and the pixel of its origin; rows count from the top.
    scale: f64,
    origin: [f64; 2],
}

impl Eye {
    /// An eye whose up is +Y, and that looks at the origin if it is a point. The scale comes from two ends of lines; all others
    /// must agree.
    pub(super) fn of(drawing: &Value, pixels_per_mm: f64) -> Result<Self, String> {
        let numbers =
            |value: &Value| value.as_array().into_iter().flatten().filter_map(Value::as_f64).collect::<Vec<_>>();
        let [x, y, z, w] = numbers(&drawing["view"]["eye"])[..] else { return Err("no eye".into()) };
        let at = DVec3::new(x, y, z);
        let right = DVec3::Y.cross(at).normalize();
        let up = at.cross(right).normalize();
        let mut eye = Self { at, is_point: w != 0.0, axes: [right, up, -at.normalize()], scale: 1.0, origin: [0.0; 2] };
        let mut ends = Vec::new();
        for span in drawing["spans"].as_array().ok_or("no spans")? {
            for end in 0..2 {
                let [world, page] = ["world", "page"].map(|key| numbers(&span[key][end]));
                let ([x, y, z], [u, v]) = (&world[..], &page[..]) else { return Err(format!("no ends: {span}")) };
                ends.push((eye.project(DVec3::new(*x, *y, *z)), [*u, *v].map(|mm| mm * pixels_per_mm)));
            }
        }
        let height = numbers(&drawing["page_mm"]).get(1).ok_or("no page")? * pixels_per_mm;
        let (first, its) = *ends.first().ok_or("no lines")?;
        let far = |end: &&([f64; 3], [f64; 2])| (0..2).map(|axis| (end.1[axis] - its[axis]).abs()).fold(0.0, f64::max);
        let (other, there) = *ends.iter().max_by(|one, other| far(one).total_cmp(&far(other))).ok_or("no lines")?;
        let axis = usize::from((there[1] - its[1]).abs() > (there[0] - its[0]).abs());
        let scale = (there[axis] - its[axis]) / (other[axis] - first[axis]);
        let corner = [0, 1].map(|axis| its[axis] - scale * first[axis]);
        let is_apart = |(found, page): &&([f64; 3], [f64; 2])| {
            (0..2).any(|axis| (scale * found[axis] + corner[axis] - page[axis]).abs() > 1e-4)
        };
        if let Some(apart) = ends.iter().find(is_apart) {
            return Err(format!("a point is not where the eye sees it: {apart:?}"));
        }
        (eye.scale, eye.origin) = (scale, [corner[0], height - corner[1]]);
        Ok(eye)
    }

    /// Where a point is on the view's page, and a depth that is linear there.
    fn project(&self, point: DVec3) -> [f64; 3] {
        if !self.is_point {
            return self.axes.map(|axis| axis.dot(point));
        }
        let [x, y, depth] = self.axes.map(|axis| axis.dot(point - self.at));
        [x / depth, y / depth, -1.0 / depth]
    }

    fn pixel(&self, point: DVec3) -> DVec3 {
        let [x, y, depth] = self.project(point);
        DVec3::new(self.origin[0] + self.scale * x, self.origin[1] - self.scale * y, depth)
    }

    fn towards(&self, point: DVec3) -> DVec3 {
        if self.is_point { (self.at - point).normalize() } else { self.at.normalize() }
    }
}

/// The neighbour beyond an edge of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    /// Another face, without a line between.
    Smooth(u32),
    Line,
    /// It is too near to a change to say.
    Perhaps,
}

/// The change between two points of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Between {
    Nothing,
    Perhaps,
    Line,
}

pub(super) struct Scene {
    /// Corners of the faces in pixels, with depths.
    corners: Vec<[DVec3; 3]>,
    sides: Vec<[Side; 3]>,
    /// Depths nearer to each other than this are the same.
    tolerance: f64,
}

impl Scene {
    pub(super) fn new(objects: &[Object<'_>], eye: &Eye) -> Self {
        let (mut corners, mut sides) = (Vec::new(), Vec::new());
        for object in objects {
            // Vertices at one position are one.
            let mut of_position = HashMap::new();
            let vertices: Vec<u32> = (0..)
                .zip(&*object.positions)
                .map(|(vertex, position)| *of_position.entry(position.map(|c| (c + 0.0).to_bits())).or_insert(vertex))
                .collect();
            let welded = object.mesh.faces().iter().map(|face| face.map(|vertex| vertices[vertex as usize]));
            // A face that is there twice is one.
            let mut met = HashSet::new();
            let mut is_new = |face: &[u32; 3]| {
                let mut sorted = *face;
                sorted.sort_unstable();
                met.insert(sorted)
            };
            let faces = welded.filter(|[a, b, c]| a != b && b != c && c != a).filter(|face| is_new(face));
            let faces: Vec<[u32; 3]> = faces.collect();
            let position = |vertex: u32| DVec3::from(object.positions[vertex as usize].map(f64::from));
            let first = corners.len() as u32;
            corners.extend(faces.iter().map(|face| face.map(|vertex| eye.pixel(position(vertex)))));
            sides.extend(sides_of(&faces, position, eye).into_iter().map(|sides| {
                sides.map(|side| if let Side::Smooth(face) = side { Side::Smooth(first + face) } else { side })
            }));
        }
        let depths = || corners.iter().flatten().map(|corner: &DVec3| corner.z);
        let tolerance = 1e-10 * (depths().fold(f64::MIN, f64::max) - depths().fold(f64::MAX, f64::min));
        Self { corners, sides, tolerance }
    }

    /// The faces seen at points of the page: from a corner in steps, so many each way.
    pub(super) fn look(&self, low: [f64; 2], step: f64, size: usize) -> Look<'_> {
        let mut nearest = vec![f64::INFINITY; size * size];
        let at = |face: u32, visit: &mut dyn FnMut(usize, f64)| {
            let corners = &self.corners[face as usize];
            let range = |axis: usize| {
                let along = corners.map(|corner| (corner[axis] - low[axis]) / step);
                let (least, most) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
                (least.ceil().max(0.0) as usize)..((most.floor() + 1.0).max(0.0) as usize).min(size)
            };
            let columns = range(0);
            for row in if columns.is_empty() { 0..0 } else { range(1) } {
                for column in columns.clone() {
                    let point = DVec3::new(low[0] + step * column as f64, low[1] + step * row as f64, 0.0);
                    if let Some(depth) = depth(corners, point) {
                        visit(row * size + column, depth);
                    }
                }
            }
        };
        let faces = 0..self.corners.len() as u32;
        for face in faces.clone() {
            at(face, &mut |point, depth| nearest[point] = nearest[point].min(depth));
        }
        let mut hits = vec![Vec::new(); size * size];
        for face in faces {
            at(face, &mut |point, depth| {
                if depth <= nearest[point] + self.tolerance {
                    hits[point].push(face);
                }
            });
        }
        Look { scene: self, low, step, size, nearest, hits }
    }

    /// Walks the surface from a point of a face to another one of the page, and ends in a face.
    fn walk(&self, mut face: u32, from: DVec3, to: DVec3) -> Result<u32, Between> {
        for _ in 0..10_000 {
            let corners = &self.corners[face as usize];
            let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).z;
            if area.abs() < 1e-12 {
                return Err(Between::Perhaps);
            }
            let mut exit = (1.0, 3);
            for side in 0..3 {
                let (a, along) = (corners[side], corners[(side + 1) % 3] - corners[side]);
                let [begin, end] = [from, to].map(|point| area.signum() * along.cross(point - a).z);
                if end < begin && begin / (begin - end) < exit.0 {
                    exit = (begin / (begin - end), side);
                }
            }
            match self.sides[face as usize].get(exit.1) {
                None => return Ok(face),
                Some(Side::Smooth(next)) => face = *next,
                Some(Side::Line) => return Err(Between::Line),
                Some(Side::Perhaps) => return Err(Between::Perhaps),
            }
        }
        Err(Between::Perhaps)
    }
}

/// The depth of a triangle at a point that it covers.
fn depth(&[a, b, c]: &[DVec3; 3], point: DVec3) -> Option<f64> {
    let area = (b - a).cross(c - a).z;
    let (s, t) = ((point - a).cross(c - a).z / area, (b - a).cross(point - a).z / area);
    (s >= -1e-12 && t >= -1e-12 && s + t <= 1.0 + 1e-12).then_some(a.z + s * (b.z - a.z) + t * (c.z - a.z))
}

/// The neighbours beyond the edges of each face.
fn sides_of(faces: &[[u32; 3]], position: impl Fn(u32) -> DVec3, eye: &Eye) -> Vec<[Side; 3]> {
    let mut of_edge: HashMap<[u32; 2], Vec<(u32, bool)>> = HashMap::new();
    let edge = |face: &[u32; 3], side: usize| [face[side], face[(side + 1) % 3]];
    for (number, face) in (0..).zip(faces) {
        for side in 0..3 {
            let [a, b] = edge(face, side);
            of_edge.entry([a.min(b), a.max(b)]).or_default().push((number, a < b));
        }
    }
    let normal = |face: u32| {
        let [a, b, c] = faces[face as usize].map(&position);
        let normal = (b - a).cross(c - a).normalize();
        (normal, normal.dot(eye.towards(a)))
    };
    let between = |(one, is_one_forward): (u32, bool), (other, is_other_forward): (u32, bool)| {
        let ((n, facing), (m, other_facing)) = (normal(one), normal(other));
        let turn = if is_one_forward == is_other_forward { -1.0 } else { 1.0 };
        let (fold, cosine) = (facing * turn * other_facing, turn * n.dot(m));
        // Some faces have no normal, which is NaN.
        if facing.abs().min(other_facing.abs()) > DOUBT && fold < 0.0 || cosine < CREASE_COSINE - DOUBT {
            Side::Line
        } else if facing.abs().min(other_facing.abs()) > DOUBT && cosine > CREASE_COSINE + DOUBT {
            Side::Smooth(other)
        } else {
            Side::Perhaps
        }
    };
    let side = |(number, face): (u32, &[u32; 3]), side: usize| {
        let [a, b] = edge(face, side);
        match of_edge[&[a.min(b), a.max(b)]][..] {
            [one, other] => {
                if one.0 == number {
                    between(one, other)
                } else {
                    between(other, one)
                }
            }
            _ => Side::Line,
        }
    };
    (0..).zip(faces).map(|face| [0, 1, 2].map(|at| side(face, at))).collect()
}

/// Faces seen at points of the page in a grid.
pub(super) struct Look<'a> {
    scene: &'a Scene,
    low: [f64; 2],
    step: f64,
    size: usize,
    nearest: Vec<f64>,
    hits: Vec<Vec<u32>>,
}

impl Look<'_> {
    /// Whether a face is seen at a point.
    pub(super) fn has_face(&self, column: usize, row: usize) -> bool {
        !self.hits[row * self.size + column].is_empty()
    }

    /// The pairs of points beside each other that have or may have a line between them, by the middle of the pair.
    pub(super) fn changes(&self) -> Vec<([f64; 2], Between)> {
        let mut changes = Vec::new();
        for (row, column) in (0..self.size).flat_map(|row| (0..self.size).map(move |column| (row, column))) {
            let here = row * self.size + column;
            let right = (column + 1 < self.size).then_some((here + 1, [0.5, 0.0]));
            let below = (row + 1 < self.size).then_some((here + self.size, [0.0, 0.5]));
            for (there, [x, y]) in [right, below].into_iter().flatten() {
                let between = self.one_way(here, there).max(self.one_way(there, here));
                if between != Between::Nothing {
                    let middle = [column as f64 + x, row as f64 + y];
                    changes.push(([0, 1].map(|axis| self.low[axis] + self.step * middle[axis]), between));
                }
            }
        }
        changes
    }

    fn point(&self, at: usize) -> DVec3 {
        let [column, row] = [at % self.size, at / self.size].map(|along| self.step * along as f64);
        DVec3::new(self.low[0] + column, self.low[1] + row, 0.0)
    }

    /// All faces seen here go on to one seen there.
    fn one_way(&self, here: usize, there: usize) -> Between {
        if self.hits[here].is_empty() != self.hits[there].is_empty() {
            return Between::Line;
        }
        // Inside of a face that both see.
        if self.hits[here] == self.hits[there] {
            return Between::Nothing;
        }
        let (from, to) = (self.point(here), self.point(there));
        // A surface that coincides with another one may go on behind it: they do not pass through each other.
        let ends = |hidden: Between| {
            let end = move |&face: &u32| match self.scene.walk(face, from, to) {
                Err(between) => between,
                Ok(end) if self.hits[there].contains(&end) => Between::Nothing,
                Ok(end) => match depth(&self.scene.corners[end as usize], to) {
                    Some(depth) if (depth - self.nearest[there]).abs() <= self.scene.tolerance => Between::Nothing,
                    Some(_) => hidden,
                    None => Between::Perhaps,
                },
            };
            self.hits[here].iter().map(end)
        };
        let is_one_seen = ends(Between::Line).any(|end| end == Between::Nothing);
        let ends = ends(if is_one_seen { Between::Perhaps } else { Between::Line });
        ends.max().unwrap_or(Between::Nothing)
    }
}
