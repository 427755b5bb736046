//! The shadow volume BSP tree (Chin and Feiner 1989), as Batagelo and Costa Júnior (1999) grow it: no face is split.

use super::plane::Plane;
use crate::light::Light;

/// A face that may be hidden, with the light off its plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    pub(crate) corners: [[f32; 3]; 3],
    /// The side of its plane that the light is on: 1 or −1.
    pub(crate) side: i32,
    /// Whether it may hide others.
    pub(crate) may_hide: bool,
}

/// What a face came to.
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
    max_nodes: usize,
    max_steps: usize,
    /// Places that the current face still has to visit, with its edges that are on planes passed, as bits. It is kept, so that
    /// it is allocated once.
    waiting: Vec<(Link, u8)>,
    /// Leaves that are out which the current face reached.
    outs: Vec<(Link, u8)>,
}

impl Tree {
    pub(crate) fn new(light: Light, max_nodes: usize, max_steps: usize) -> Self {
        Self {
            light,
            root: Place::Out,
            nodes: Vec::new(),
            planes: Vec::new(),
            hiders: Vec::new(),
            max_nodes: max_nodes.min(u32::MAX as usize / 4),
            max_steps,
            waiting: Vec::new(),
            outs: Vec::new(),
        }
    }

    pub(crate) fn nodes(&self) -> usize {
        self.nodes.len()
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
        self.waiting.push((None, 0));
        let (mut steps, mut is_hidden) = (0, true);
        while let Some((link, edges)) = self.waiting.pop() {
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
                        if sides.contains(&sign) {
                            self.waiting.push((Some((number, child)), edges));
                        }
                    }
                }
                Some(Place::In(hider)) => is_hidden &= self.is_behind(face, hider),
                Some(Place::Out) => {
                    is_hidden = false;
                    self.outs.push((link, edges));
                }
                None => return Found::Undecided,
            }
        }
        if is_hidden { Found::Hidden } else { Found::Seen }
    }

    /// Whether no part of the face is in front of the hider's plane, as seen from the light.
    fn is_behind(&self, face: &Face, hider: u32) -> bool {
        let hider = self.hiders.get(hider as usize);
        hider.is_some_and(|hider| face.corners.iter().all(|&corner| hider.plane.side(corner) != hider.side))
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
            if self.nodes.len() + 3 > self.max_nodes {
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
        self.nodes.len() + 3 > self.max_nodes
    }
}
