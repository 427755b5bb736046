//! The shadow volume BSP tree (Chin and Feiner 1989), as Batagelo and Costa Júnior (1999) grow it: no face is split.

use super::clipped::Clipped;
use super::plane::Plane;
use crate::light::Light;

/// A face that may be hidden.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    pub(crate) corners: [[f32; 3]; 3],
    /// The side of its plane that the light is on: 1 or −1, or 0 if the light is in it.
    pub(crate) side: i32,
    /// Whether it may hide others. The light is off its plane then.
    pub(crate) may_hide: bool,
}

/// The result for one face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    Hidden,
    Seen,
    /// The bound on steps or nodes was met, so the face stays.
    Undecided,
}

/// Where an edge of the tree leads.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// No hider is known here.
    Out,
    /// All directions of the leaf meet this hider.
    In(u32),
    Node(u32),
    /// Outside of the cone of this tree.
    Elsewhere,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    plane: u32,
    /// Where the plane's side is positive, and where it is negative. Each contains the plane.
    sides: [Place; 2],
}

/// A hider: its plane, and the side of it that the light is on.
#[derive(Clone, Copy, Debug)]
struct Hider {
    plane: Plane,
    side: i32,
}

/// The link that leads to a place: the root, or a side of a node.
type Link = Option<(u32, usize)>;

pub(crate) struct Tree {
    light: Light,
    root: Place,
    nodes: Vec<Node>,
    planes: Vec<Plane>,
    hiders: Vec<Hider>,
    /// The first nodes, which bound the cone.
    cone: usize,
    max_nodes: usize,
    max_steps: usize,
    /// Places that the current face still has to visit, with its edges that are on planes passed, as bits. It is kept, so that
    /// it is allocated once.
    waiting: Vec<(Link, u8, Clipped)>,
    /// Leaves that are out which the current face reached.
    outs: Vec<(Link, u8)>,
}

impl Tree {
    /// A tree for the directions on one side of each of some planes through the light.
    pub(crate) fn new(light: Light, cone: &[(Plane, i32)], max_nodes: usize, max_steps: usize) -> Self {
        let node = |(number, &(_, side)): (usize, &(Plane, i32))| {
            let is_last = number + 1 == cone.len();
            let next = if is_last { Place::Out } else { Place::Node(number as u32 + 1) };
            let sides = if side > 0 { [next, Place::Elsewhere] } else { [Place::Elsewhere, next] };
            Node { plane: number as u32, sides }
        };
        Self {
            light,
            root: if cone.is_empty() { Place::Out } else { Place::Node(0) },
            nodes: cone.iter().enumerate().map(node).collect(),
            planes: cone.iter().map(|(plane, _)| *plane).collect(),
            cone: cone.len(),
            hiders: Vec::new(),
            max_nodes: max_nodes.min(u32::MAX as usize / 4),
            max_steps,
            waiting: Vec::new(),
            outs: Vec::new(),
        }
    }

    pub(crate) fn nodes(&self) -> usize {
        self.nodes.len() - self.cone
    }

    /// Tells whether a face is hidden. If it is not, and may hide others, the tree grows by it.
    pub(crate) fn take(&mut self, face: &Face) -> Found {
        let found = self.find(face);
        if found == Found::Seen && face.may_hide && !self.outs.is_empty() {
            self.insert(face);
        }
        found
    }

    fn place(&self, link: Link) -> Option<Place> {
        match link {
            None => Some(self.root),
            Some((node, side)) => self.nodes.get(node as usize)?.sides.get(side).copied(),
        }
    }

    /// Visits all leaves that the face may reach, and lists those that are out.
    fn find(&mut self, face: &Face) -> Found {
        self.outs.clear();
        self.waiting.clear();
        self.waiting.push((None, 0, Clipped::whole(face.corners)));
        let (mut steps, mut is_hidden) = (0, true);
        while let Some((link, edges, part)) = self.waiting.pop() {
            steps += 1;
            if steps > self.max_steps {
                return Found::Undecided;
            }
            match self.place(link) {
                Some(Place::Node(number)) => {
                    let Some(plane) = self.nodes.get(number as usize).and_then(|n| self.planes.get(n.plane as usize))
                    else {
                        return Found::Undecided;
                    };
                    let sides = face.corners.map(|corner| plane.side(corner));
                    let on = |edge: usize| sides[edge] == 0 && sides[(edge + 1) % 3] == 0;
                    let edges = (0..3).filter(|&edge| on(edge)).fold(edges, |edges, edge| edges | 1 << edge);
                    for (child, sign) in [1, -1].into_iter().enumerate() {
                        // A face in the plane is on both sides.
                        if (sides.contains(&sign) || sides == [0; 3])
                            && let Some(part) = part.cut(plane, sign)
                        {
                            self.waiting.push((Some((number, child)), edges, part));
                        }
                    }
                }
                Some(Place::In(hider)) => is_hidden &= self.is_behind(face, &part, hider),
                Some(Place::Out) => {
                    is_hidden = false;
                    self.outs.push((link, edges));
                }
                Some(Place::Elsewhere) => {}
                None => return Found::Undecided,
            }
        }
        if is_hidden { Found::Hidden } else { Found::Seen }
    }

    /// Whether no part of the face that is in the leaf is in front of the hider's plane, as seen from the light.
    fn is_behind(&self, face: &Face, part: &Clipped, hider: u32) -> bool {
        self.hiders.get(hider as usize).is_some_and(|Hider { plane, side }| {
            part.is_on(plane, -side) || face.corners.iter().all(|&corner| plane.side(corner) != *side)
        })
    }

    /// Grows the leaves that are out and that the face reached, as long as there is room for nodes.
    fn insert(&mut self, face: &Face) {
        let [a, b, c] = face.corners;
        let first_plane = self.planes.len() as u32;
        let hider = self.hiders.len() as u32;
        self.planes.extend([(a, b), (b, c), (c, a)].map(|(from, to)| Plane::of_edge(from, to, self.light)));
        self.hiders.push(Hider { plane: Plane::of_face(face.corners), side: face.side });
        // The third corner is on this side of an edge's plane.
        let inner = usize::from(face.side < 0);
        for (link, edges) in std::mem::take(&mut self.outs) {
            // An edge on a plane that was passed needs no plane of its own: the face is on the side that was taken.
            if self.is_full() {
                break;
            }
            let mut place = Place::In(hider);
            for edge in (0..3).filter(|edge| edges >> edge & 1 == 0) {
                let mut sides = [Place::Out; 2];
                sides[inner] = place;
                place = Place::Node(self.nodes.len() as u32);
                self.nodes.push(Node { plane: first_plane + edge, sides });
            }
            match link {
                None => self.root = place,
                Some((node, side)) => {
                    if let Some(side) = self.nodes.get_mut(node as usize).and_then(|node| node.sides.get_mut(side)) {
                        *side = place;
                    }
                }
            }
        }
    }

    /// Whether there is no room for another hider.
    pub(crate) fn is_full(&self) -> bool {
        self.nodes() + 3 > self.max_nodes
    }
}
