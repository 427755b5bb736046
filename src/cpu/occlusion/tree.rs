//! The shadow volume BSP tree (Chin and Feiner 1989), as Batagelo and Costa Júnior (1999) grow it: no face is split.

use super::clipped::Clipped;
use super::plane::Plane;
use crate::light::Light;

/// A face that may be occluded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    pub(crate) corners: [[f32; 3]; 3],
    /// The side of its plane that the light is on: 1 or −1, or 0 if the light is in it.
    pub(crate) side: i32,
    /// Whether it may occlude others. The light is then not in its plane.
    pub(crate) may_occlude: bool,
}

/// The result for one face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Decision {
    Occluded,
    Visible,
    /// Visible. It may occlude others, but the tree has no room for it, or only for a part.
    WithoutRoom,
    /// The bound on steps was met, so the face stays.
    Undecided,
}

/// A child of a node, or the root.
#[derive(Clone, Copy, Debug)]
enum Child {
    /// A leaf without an occluder.
    Open,
    /// A leaf whose directions all meet this occluder.
    Occluded(u32),
    Node(u32),
    /// Outside of the cone of this tree.
    OutsideCone,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    plane: u32,
    /// The children on the positive and the negative side of the plane. Both contain the plane.
    sides: [Child; 2],
}

/// An occluder: its plane, and the side of it that the light is on.
#[derive(Clone, Copy, Debug)]
struct Occluder {
    plane: Plane,
    side: i32,
}

/// The link to a child: `None` for the root, else a node and its side.
type Link = Option<(u32, usize)>;

/// A child that a face has yet to visit.
struct Waiting {
    link: Link,
    /// The edges of the face that lie in planes of visited nodes, as bits.
    edges: u8,
    /// The part of the face that may be in it.
    part: Clipped,
}

pub(crate) struct Tree {
    light: Light,
    root: Child,
    nodes: Vec<Node>,
    planes: Vec<Plane>,
    occluders: Vec<Occluder>,
    /// The first nodes, which bound the cone.
    cone: usize,
    max_nodes: usize,
    max_steps: usize,
    /// Children that the current face has yet to visit. A field, so that it is allocated once.
    waiting: Vec<Waiting>,
    /// Open leaves that the current face is in.
    open_leaves: Vec<(Link, u8)>,
}

impl Tree {
    /// A tree for the directions on one side of each of some planes through the light.
    pub(crate) fn new(light: Light, cone: &[(Plane, i32)], max_nodes: usize, max_steps: usize) -> Self {
        let node = |(number, &(_, side)): (usize, &(Plane, i32))| {
            let is_last = number + 1 == cone.len();
            let next = if is_last { Child::Open } else { Child::Node(number as u32 + 1) };
            let sides = if side > 0 { [next, Child::OutsideCone] } else { [Child::OutsideCone, next] };
            Node { plane: number as u32, sides }
        };
        Self {
            light,
            root: if cone.is_empty() { Child::Open } else { Child::Node(0) },
            nodes: cone.iter().enumerate().map(node).collect(),
            planes: cone.iter().map(|(plane, _)| *plane).collect(),
            cone: cone.len(),
            occluders: Vec::new(),
            max_nodes: max_nodes.min(u32::MAX as usize / 4),
            max_steps,
            waiting: Vec::new(),
            open_leaves: Vec::new(),
        }
    }

    pub(crate) fn nodes(&self) -> usize {
        self.nodes.len() - self.cone
    }

    /// Decides whether a face is occluded. If it is not and may occlude others, the tree grows by it.
    pub(crate) fn decide(&mut self, face: &Face) -> Decision {
        let decision = self.find(face);
        let grows = decision == Decision::Visible && face.may_occlude && !self.open_leaves.is_empty();
        if grows && !self.insert(face) { Decision::WithoutRoom } else { decision }
    }

    fn child(&self, link: Link) -> Option<Child> {
        match link {
            None => Some(self.root),
            Some((node, side)) => self.nodes.get(node as usize)?.sides.get(side).copied(),
        }
    }

    /// Visits all leaves that the face may be in, and lists the open ones.
    fn find(&mut self, face: &Face) -> Decision {
        self.open_leaves.clear();
        self.waiting.clear();
        self.waiting.push(Waiting { link: None, edges: 0, part: Clipped::whole(face.corners) });
        let (mut steps, mut is_occluded) = (0, true);
        while let Some(Waiting { link, edges, part }) = self.waiting.pop() {
            steps += 1;
            if steps > self.max_steps {
                return Decision::Undecided;
            }
            match self.child(link) {
                Some(Child::Node(number)) => {
                    let Some(plane) = self.nodes.get(number as usize).and_then(|n| self.planes.get(n.plane as usize))
                    else {
                        return Decision::Undecided;
                    };
                    let sides = face.corners.map(|corner| plane.side(corner));
                    let on = |edge: usize| sides[edge] == 0 && sides[(edge + 1) % 3] == 0;
                    let edges = (0..3).filter(|&edge| on(edge)).fold(edges, |edges, edge| edges | 1 << edge);
                    for (child, sign) in [1, -1].into_iter().enumerate() {
                        // A face in the plane is on both sides.
                        if (sides.contains(&sign) || sides == [0; 3])
                            && let Some(part) = part.cut(plane, sign)
                        {
                            self.waiting.push(Waiting { link: Some((number, child)), edges, part });
                        }
                    }
                }
                Some(Child::Occluded(occluder)) => is_occluded &= self.is_behind(face, &part, occluder),
                Some(Child::Open) => {
                    is_occluded = false;
                    self.open_leaves.push((link, edges));
                }
                Some(Child::OutsideCone) => {}
                None => return Decision::Undecided,
            }
        }
        if is_occluded { Decision::Occluded } else { Decision::Visible }
    }

    /// Whether no part of the face that is in the leaf is in front of the occluder's plane, as seen from the light.
    fn is_behind(&self, face: &Face, part: &Clipped, occluder: u32) -> bool {
        self.occluders.get(occluder as usize).is_some_and(|Occluder { plane, side }| {
            part.is_on(plane, -side) || face.corners.iter().all(|&corner| plane.side(corner) != *side)
        })
    }

    /// Replaces the open leaves that the face is in by nodes, as long as there is room. Returns whether it replaced all.
    fn insert(&mut self, face: &Face) -> bool {
        // The bound on nodes bounds the planes, too.
        if self.is_full() {
            return false;
        }
        let [a, b, c] = face.corners;
        let first_plane = self.planes.len() as u32;
        let occluder = self.occluders.len() as u32;
        self.planes.extend([(a, b), (b, c), (c, a)].map(|(from, to)| Plane::of_edge(from, to, self.light)));
        self.occluders.push(Occluder { plane: Plane::of_face(face.corners), side: face.side });
        // The third corner is on this side of an edge's plane.
        let inner = usize::from(face.side < 0);
        for (link, edges) in std::mem::take(&mut self.open_leaves) {
            if self.is_full() {
                return false;
            }
            let mut child = Child::Occluded(occluder);
            // An edge in the plane of a visited node needs no node: the face is on the visited side.
            for edge in (0..3).filter(|edge| edges >> edge & 1 == 0) {
                let mut sides = [Child::Open; 2];
                sides[inner] = child;
                child = Child::Node(self.nodes.len() as u32);
                self.nodes.push(Node { plane: first_plane + edge, sides });
            }
            match link {
                None => self.root = child,
                Some((node, side)) => {
                    if let Some(side) = self.nodes.get_mut(node as usize).and_then(|node| node.sides.get_mut(side)) {
                        *side = child;
                    }
                }
            }
        }
        true
    }

    /// Whether there is no room for an occluder in another leaf.
    fn is_full(&self) -> bool {
        self.nodes() + 3 > self.max_nodes
    }
}
