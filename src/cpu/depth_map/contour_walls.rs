//! Contour walls: walks along the contours of each tile, fits segments to them, and lists walls over the segments.

use super::contour::{Edge, FAR, LEAST, Map, OUT, TEXEL, TILE, TURN, edge_of_cell, sum};
use super::contour_marks::{code_of_cell, is_marked};
use super::contour_places::{place_of, point_of};
use super::contour_rim::surface;
use super::contour_tiles::contour_tiles;

/// Nodes that a segment may have.
const WINDOW: usize = 32;
/// Nodes that a segment is tried to reach beyond the last that it fits.
const TRIES: usize = 8;
/// Texels whose slope the nearer surface goes away by at least, up to a wall.
const STEEP: i32 = 4;

/// A vertex: its place on the lattice in parts of 256 of a texel, and its distance from the near plane.
pub type WallVertex = [i32; 3];
/// A quadrilateral: a wall, or the flap that joins it to the nearer surface.
pub type Wall = [WallVertex; 4];

/// The output of the stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WallList {
    /// Walls of all tiles, whether there is room for them or not.
    pub count: u32,
    /// Walls, in their order, as far as there is room.
    pub walls: Vec<Wall>,
    /// The places on marked edges, moved onto the segments.
    pub places: Vec<u32>,
    /// For each tile that contours cross the walls of those before it.
    pub before: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// No contour, or one that goes through.
    Through,
    /// One that ends, or several that meet.
    Star,
}

/// A place that a contour goes through.
#[derive(Clone, Copy, Debug)]
struct Node {
    at: [i32; 2],
    /// The distances of the surfaces on the left and right.
    copies: [i32; 2],
    /// The same, as the surfaces go on.
    surfaces: [i32; 2],
    /// The nearer side, and the sample that it begins at. `None`: the node itself.
    inner: Option<(usize, WallVertex)>,
    /// The edge, with what a segment may not pass on the left and on the right. `None`: the middle of a star.
    edge: Option<(Edge, [[i32; 2]; 2])>,
    /// The cell of a star.
    star: Option<[i32; 2]>,
}

/// Where a walk is: the cell, and the edge that it leaves it over.
type Step = ([i32; 2], usize);

/// How a walk in a tile ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// At the tile's border, after a step.
    Border(Step),
    /// In a star, which it enters over an edge.
    Star(Step),
    /// Back where it began, or never.
    Loop,
}

struct Tracer<'a> {
    map: &'a Map<'a>,
    marks: &'a [u32],
    places: Vec<u32>,
    walls: Vec<Wall>,
}

fn opposite(bit: usize) -> usize {
    (bit + 2) % 4
}

fn cross(a: [i32; 2], b: [i32; 2]) -> i32 {
    a[0] * b[1] - a[1] * b[0]
}

fn less(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Whether the edge of a cell lies on the border of its tile.
fn is_border(cell: [i32; 2], bit: usize) -> bool {
    edge_of_cell(cell, bit).at[1 - bit % 2] % TILE == 0
}

impl Tracer<'_> {
    fn code(&self, cell: [i32; 2]) -> u32 {
        code_of_cell(self.map, self.marks, cell)
    }

    fn kind(&self, cell: [i32; 2]) -> Kind {
        if matches!(self.code(cell).count_ones(), 0 | 2) { Kind::Through } else { Kind::Star }
    }

    /// The way out of a cell that a walk enters over an edge.
    fn other(&self, cell: [i32; 2], entered: usize) -> usize {
        (self.code(cell) & !(1 << entered)).trailing_zeros() as usize % 4
    }

    fn surface(&self, from: ([i32; 2], [i32; 2]), place: i32, texels: i32) -> i32 {
        surface(self.map, self.marks, from, place, texels)
    }

    /// The node on the edge that a step goes over.
    fn node(&self, (cell, bit): Step) -> Node {
        let edge = edge_of_cell(cell, bit);
        let place = place_of(self.map, &self.places, edge);
        let point = point_of(self.map, &self.places, cell, bit);
        let [left, right] = [bit, (bit + 1) % 4].map(|corner| sum(cell, TURN[corner]));
        // From the left to the right sample.
        let step = less(right, left);
        let of_left = if left == edge.at { place } else { TEXEL - place };
        let back = step.map(|step| -step);
        // Walks to both sides take the same sample, of equal ones, too.
        let [own_left, own_right] = [left, right].map(|sample| self.map.distance(sample));
        let is_right = own_right < own_left || own_right == own_left && right == edge.at;
        let side = usize::from(is_right);
        let beside = |texels| {
            [((left, step), of_left), ((right, back), TEXEL - of_left)]
                .map(|(from, place)| self.surface(from, place, texels))
        };
        let surfaces = beside(0);
        let mut depths = surfaces;
        depths[side] = beside(STEEP)[side];
        // The nearer surface ends before the other one.
        depths[side] = depths[0].min(depths[1]);
        let sideways = self.map.shape.sideways;
        let limit = |place: i32| {
            let mut limit = left.map(|at| at * TEXEL);
            let place = place.clamp(LEAST, TEXEL - LEAST);
            limit[0] += step[0] * place;
            limit[1] += step[1] * place;
            limit
        };
        let limits = [limit(of_left - sideways), limit(of_left + sideways)];
        let out = [step, back][side];
        let sample = [left, right][side];
        // The surface goes on to the sample before.
        let before = less(sample, out);
        let between = Edge { at: [0, 1].map(|axis| before[axis].min(sample[axis])), axis: edge.axis };
        let sample = if is_marked(self.map, self.marks, between) { sample } else { before };
        let [x, y] = sample.map(|at| at * TEXEL);
        let inner = Some((side, [x, y, self.map.moved(sample)]));
        Node { at: point, copies: depths, surfaces, inner, edge: Some((edge, limits)), star: None }
    }

    /// The distance in the middle of a star, of the surface that has a corner of the cell: the mean of those of its samples.
    fn middle(&self, cell: [i32; 2], corner: usize) -> i32 {
        let code = self.code(cell);
        let mut corners = vec![corner % 4];
        let mut at = corner % 4;
        while code >> at & 1 == 0 && corners.len() < 4 {
            at = (at + 1) % 4;
            corners.push(at);
        }
        at = (corner + 3) % 4;
        while code >> at & 1 == 0 && corners.len() < 4 {
            corners.push(at);
            at = (at + 3) % 4;
        }
        let shift = corners.len() / 2;
        let distances = corners.iter().map(|&corner| self.map.moved(sum(cell, TURN[corner])));
        distances.fold(0, |total, own| if total == FAR || own == FAR { FAR } else { total + (own >> shift) })
    }

    /// The node in the middle of a star. A walk leaves it over the edge, or enters it.
    fn star(&self, (cell, bit): Step, is_entered: bool) -> Node {
        let [x, y] = cell.map(|at| at * TEXEL + TEXEL / 2);
        let [left, right] = [bit, bit + 1].map(|corner| self.middle(cell, corner));
        let copies = if is_entered { [right, left] } else { [left, right] };
        Node { at: [x, y], copies, surfaces: copies, inner: None, edge: None, star: Some(cell) }
    }

    /// Walks to the end.
    fn end_of(&self, start: Step) -> End {
        let (mut cell, mut bit) = start;
        for _ in 0..=TILE * TILE {
            if is_border(cell, bit) {
                return End::Border((cell, bit));
            }
            cell = sum(cell, OUT[bit]);
            if self.kind(cell) == Kind::Star {
                return End::Star((cell, opposite(bit)));
            }
            bit = self.other(cell, opposite(bit));
            if (cell, bit) == start {
                return End::Loop;
            }
        }
        End::Loop
    }

    /// Whether a loop has no cell before this one.
    fn is_first_of_loop(&self, start: Step) -> bool {
        let order = |[x, y]: [i32; 2]| [y, x];
        let (mut cell, mut bit) = start;
        loop {
            if is_border(cell, bit) {
                return false;
            }
            cell = sum(cell, OUT[bit]);
            if self.kind(cell) == Kind::Star || order(cell) < order(start.0) {
                return false;
            }
            bit = self.other(cell, opposite(bit));
            if cell == start.0 {
                return true;
            }
        }
    }

    /// Both ends of a walk find it. The one with the smaller number lists it.
    fn number(step: Step, is_star: bool) -> [i32; 4] {
        let ([x, y], bit) = step;
        [y, x, bit as i32, i32::from(is_star)]
    }

    fn is_listed(start: [i32; 4], end: End) -> bool {
        match end {
            End::Border(step) => start <= Self::number(step, false) || start == Self::number(step, true),
            End::Star(step) => start <= Self::number(step, true),
            End::Loop => false,
        }
    }

    /// Lists the walls that begin in a cell.
    fn cell(&mut self, cell: [i32; 2]) {
        let code = self.code(cell);
        let bits: Vec<usize> = (0..4).filter(|bit| code >> bit & 1 == 1).collect();
        if self.kind(cell) == Kind::Star {
            for &bit in &bits {
                if Self::is_listed(Self::number((cell, bit), true), self.end_of((cell, bit))) {
                    self.trace(self.star((cell, bit), false), (cell, bit), false);
                }
            }
        } else if let [first, second] = bits[..] {
            for (entered, out) in [(first, second), (second, first)] {
                if is_border(cell, entered)
                    && Self::is_listed(Self::number((cell, entered), false), self.end_of((cell, out)))
                {
                    let start = self.node((sum(cell, OUT[entered]), opposite(entered)));
                    self.trace(start, (cell, out), false);
                }
            }
            if !is_border(cell, first) && !is_border(cell, second) && self.is_first_of_loop((cell, first)) {
                let next = sum(cell, OUT[first]);
                let start = self.node((cell, first));
                self.trace(start, (next, self.other(next, opposite(first))), true);
            }
        }
    }

    /// Whether a segment from the first node to the last is near enough to those between them.
    fn fits(&self, nodes: &[Node]) -> bool {
        let [first, between @ .., last] = nodes else { return true };
        let from = first.at;
        let way = less(last.at, from);
        let axis = usize::from(way[1].abs() > way[0].abs());
        let length = way[axis].abs();
        between.iter().all(|node| {
            let Some((_, limits)) = node.edge else { return false };
            let [left, right] = limits.map(|limit| less(limit, from));
            let passes = cross(left, right) > 0
                && cross(left, way) >= 0
                && cross(way, right) >= 0
                && cross(less(left, way), less(right, way)) <= 0;
            let gone = ((node.at[axis] - from[axis]) * way[axis].signum()).clamp(0, length);
            passes && (0..2).all(|side| self.is_near([first, node, last].map(|node| node.surfaces[side]), gone, length))
        })
    }

    /// Whether the second of three distances is on the line between the others, but for the tolerance.
    fn is_near(&self, [first, own, last]: [i32; 3], gone: i32, length: i32) -> bool {
        if first == FAR || own == FAR || last == FAR {
            return first == own && own == last;
        }
        let shift = self.map.shape.shift;
        let [own, last] = [own - first, last - first].map(|difference| difference >> shift);
        own.abs() <= 1 << 16
            && last.abs() <= 1 << 16
            && (own * length - last * gone).abs() <= self.map.shape.tolerance * length
    }

    /// Walks from a node to the end, and lists a wall for each segment.
    fn trace(&mut self, start: Node, first: Step, is_loop: bool) {
        let mut nodes = vec![start];
        let mut next = Some(first);
        let mut entering = None;
        loop {
            while nodes.len() < WINDOW {
                if let Some(step) = entering.take() {
                    nodes.push(self.star(step, true));
                    continue;
                }
                let Some((cell, bit)) = next.take() else { break };
                nodes.push(self.node((cell, bit)));
                if is_border(cell, bit) {
                    continue;
                }
                let there = sum(cell, OUT[bit]);
                if self.kind(there) == Kind::Star {
                    entering = Some((there, opposite(bit)));
                    continue;
                }
                let step = (there, self.other(there, opposite(bit)));
                if !is_loop || step != first {
                    next = Some(step);
                }
            }
            let mut best = 1;
            for last in 2..nodes.len() {
                if last > best + TRIES {
                    break;
                }
                if self.fits(&nodes[..=last]) {
                    best = last;
                }
            }
            self.wall(&nodes[..=best]);
            nodes.drain(..best);
            if nodes.len() == 1 && next.is_none() && entering.is_none() {
                return;
            }
        }
    }

    /// Lists the wall over a segment, and moves the places between its ends onto it.
    fn wall(&mut self, nodes: &[Node]) {
        let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else { return };
        let sides = [first, last].map(|node| self.copies(node));
        let [a, b] = [first.at, last.at];
        let mut wall = |of_a: [i32; 2], of_b: [i32; 2]| {
            let at = |[x, y]: [i32; 2], distance| [x, y, distance];
            self.walls.push([at(a, of_a[0]), at(a, of_a[1]), at(b, of_b[1]), at(b, of_b[0])]);
        };
        let pairs = sides.each_ref().map(|side| side.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>());
        let (first_a, first_b) = (pairs[0][0], pairs[1][0]);
        wall(first_a, first_b);
        for &pair in &pairs[0][1..] {
            wall(pair, [first_b[1]; 2]);
        }
        for &pair in &pairs[1][1..] {
            wall([first.copies[1]; 2], pair);
        }
        for side in 0..2 {
            let [inner_a, inner_b] = [first, last].map(|node| node.inner.filter(|&(own, _)| own == side));
            if inner_a.is_some() || inner_b.is_some() {
                let copy = |node: &Node| [node.at[0], node.at[1], node.copies[side]];
                let inner = |inner: Option<(usize, WallVertex)>, node| inner.map_or(copy(node), |(_, vertex)| vertex);
                self.walls.push([inner(inner_a, first), copy(first), copy(last), inner(inner_b, last)]);
            }
        }
        for node in &nodes[1..nodes.len() - 1] {
            let Some((edge, _)) = node.edge else { continue };
            // Where the segment crosses the line of the edge.
            let (along, beside) = (edge.axis, 1 - edge.axis);
            let mut way = less(b, a);
            if way[beside] < 0 {
                way = way.map(|way| -way);
            }
            let number = way[along] * (edge.at[beside] * TEXEL - a[beside]);
            let whole = number.div_euclid(way[beside].max(1));
            let rest = number.rem_euclid(way[beside].max(1));
            let place = (a[along] + whole - edge.at[along] * TEXEL) * 256 + rest * 256 / way[beside].max(1);
            self.set_place(edge, place.clamp(1, 65_535) as u32);
        }
    }

    fn set_place(&mut self, edge: Edge, place: u32) {
        let [x, y] = edge.at;
        if let Some(word) = self.places.get_mut((y * self.map.lattice()[0] + x) as usize) {
            *word = *word & !(0xffff << (16 * edge.axis)) | place << (16 * edge.axis);
        }
    }

    /// The distances at a node, from left to right, with those of other surfaces of a star between them.
    fn copies(&self, node: &Node) -> Vec<i32> {
        let [left, right] = node.copies;
        let Some(cell) = node.star else { return vec![left, right] };
        let mut between: Vec<i32> = (0..4).map(|corner| self.middle(cell, corner)).collect();
        between.retain(|own| left.min(right) < *own && *own < left.max(right));
        between.sort_unstable();
        between.dedup();
        if left > right {
            between.reverse();
        }
        [&[left], &between[..], &[right]].concat()
    }
}

/// Lists the walls. Tiles follow each other row by row, and so do the cells of a tile.
pub fn contour_walls(map: &Map<'_>, marks: &[u32], places: &[u32]) -> WallList {
    let mut tracer = Tracer { map, marks, places: places.to_vec(), walls: Vec::new() };
    let cells = map.lattice().map(|samples| samples - 1);
    let across = map.shape.tiles[0] as i32;
    let mut before = Vec::new();
    for tile in contour_tiles(map, marks) {
        before.push(tracer.walls.len() as u32);
        let tile = tile as i32;
        let corner = [tile % across, tile / across].map(|at| at * TILE);
        for number in 0..TILE * TILE {
            let cell = sum(corner, [number % TILE, number / TILE]);
            if cell[0] < cells[0] && cell[1] < cells[1] {
                tracer.cell(cell);
            }
        }
    }
    let Tracer { places, mut walls, .. } = tracer;
    let count = walls.len() as u32;
    walls.truncate(map.shape.capacity as usize);
    WallList { count, walls, places, before }
}
