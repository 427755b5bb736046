//! The search of all cones, on several threads.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::cones::Cone;
use super::options::OcclusionOptions;
use super::tree::{Decision, Face, Tree};
use crate::light::Light;

/// The most faces of a cone that a thread searches between two calls of its progress.
const STRIDE: usize = 256;

/// The result of searching some faces.
#[derive(Default)]
pub(crate) struct Searched {
    /// Indices of faces that are not occluded in some cone. `search` returns each once, ascending.
    pub(crate) staying: Vec<usize>,
    /// Faces that met the bound on steps. Here and in `without_room` a face counts in each of its cones.
    pub(crate) undecided: usize,
    /// Faces that are not occluded and may occlude others, but that the tree had no room for, or only for a part.
    pub(crate) without_room: usize,
    /// Nodes of the trees, without those of the planes of cones.
    pub(crate) nodes: usize,
}

/// State that threads share.
struct Work<'a> {
    faces: &'a [Face],
    light: Light,
    options: OcclusionOptions,
    cones: &'a [Cone],
    /// Faces of all cones. A face counts in each of its cones.
    total: usize,
    /// The index of the next cone that a thread takes.
    next_cone: AtomicUsize,
    /// Faces, counted as in `total`, that threads have begun to search.
    begun: AtomicUsize,
    is_cancelled: AtomicBool,
}

/// Faces of all cones. A face counts in each of its cones.
pub(crate) fn total(cones: &[Cone]) -> usize {
    cones.iter().map(|cone| cone.faces.len()).sum()
}

/// Searches all cones, each by itself. The result does not depend on the number of threads. `progress` is called on the
/// caller's thread, with the faces that were begun before and those of all cones; a face counts in each of its cones.
/// `None` if it ends the search.
pub(crate) fn search(
    faces: &[Face],
    light: Light,
    options: OcclusionOptions,
    cones: &[Cone],
    mut progress: impl FnMut(usize, usize) -> ControlFlow<()>,
) -> Option<Searched> {
    let work = Work {
        faces,
        light,
        options,
        cones,
        total: total(cones),
        next_cone: AtomicUsize::new(0),
        begun: AtomicUsize::new(0),
        is_cancelled: AtomicBool::new(false),
    };
    let threads = options.threads.count().min(cones.len());
    let mut searched = std::thread::scope(|scope| {
        // Threads that the system does not start leave their cones to the others.
        let run = || work.run(|_, _| ControlFlow::Continue(()));
        let workers: Vec<_> =
            (1..threads).map_while(|_| std::thread::Builder::new().spawn_scoped(scope, run).ok()).collect();
        let mut searched = work.run(&mut progress);
        for worker in workers {
            searched.add(worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        searched
    });
    searched.staying.sort_unstable();
    searched.staying.dedup();
    (!work.is_cancelled.into_inner()).then_some(searched)
}

impl Work<'_> {
    /// Searches cones that no other thread has taken, one after the other.
    fn run(&self, mut progress: impl FnMut(usize, usize) -> ControlFlow<()>) -> Searched {
        let mut searched = Searched::default();
        while let Some(cone) = self.cones.get(self.next_cone.fetch_add(1, Ordering::Relaxed)) {
            let mut tree = Tree::new(self.light, &cone.planes, self.room(cone), self.options.max_steps);
            for faces in cone.faces.chunks(STRIDE) {
                if progress(self.begun.fetch_add(faces.len(), Ordering::Relaxed), self.total).is_break() {
                    self.is_cancelled.store(true, Ordering::Relaxed);
                }
                if self.is_cancelled.load(Ordering::Relaxed) {
                    return searched;
                }
                for &number in faces {
                    let Some(face) = self.faces.get(number) else { continue };
                    match tree.decide(face) {
                        Decision::Occluded => continue,
                        Decision::Undecided => searched.undecided += 1,
                        Decision::WithoutRoom => searched.without_room += 1,
                        Decision::Visible => {}
                    }
                    searched.staying.push(number);
                }
            }
            searched.nodes += tree.nodes();
        }
        searched
    }

    /// The nodes that a cone's tree may have: its share of `max_nodes`, by its faces.
    fn room(&self, cone: &Cone) -> usize {
        let share = self.options.max_nodes as u128 * cone.faces.len() as u128 / self.total.max(1) as u128;
        usize::try_from(share).unwrap_or(usize::MAX)
    }
}

impl Searched {
    fn add(&mut self, other: Self) {
        self.staying.extend(other.staying);
        self.undecided += other.undecided;
        self.without_room += other.without_room;
        self.nodes += other.nodes;
    }
}
