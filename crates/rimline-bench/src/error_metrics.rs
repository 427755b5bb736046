//! How wrong an extraction is: bits that differ from exact arithmetic, and vertices at which loops stay open.

use rimline::cpu;
use rimline::internals::layout::{EdgeMasks, low_bits};
use rimline::mesh::{EdgeKind, Mesh};

/// Errors of one extraction, all lights together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Pairs of face and light that were decided wrongly. For a method without facing masks: wrongly at one edge of the face
    /// at least.
    pub wrong_facing_bits: usize,
    /// Pairs of edge record and light whose silhouette bit is wrong: silhouettes that were not found, or edges that are
    /// none.
    pub wrong_silhouette_bits: usize,
    /// Pairs of vertex and light at which outgoing less incoming multiplicities are not zero.
    pub unclosed_vertices: usize,
}

impl Score {
    /// Holds an extraction for `lights` lights against an exact one, as [`cpu::extract`] makes it with
    /// [`rimline::Predicate::Exact`]. The per-edge method finds no facing masks: what each edge decided about its faces is
    /// then decided from its silhouette and winding bits. `None` if masks are not of this mesh and as many lights.
    pub fn of(mesh: &Mesh, lights: usize, exact: &cpu::Extraction, found: &cpu::Extraction) -> Option<Self> {
        let (faces, edges) = (mesh.faces().len(), mesh.edges().len());
        let fits = |extraction: &cpu::Extraction| extraction.masks.len() == edges * lights.div_ceil(32);
        let has_facing = |extraction: &cpu::Extraction| extraction.facing.len() == faces * lights.div_ceil(32);
        let is_per_edge = found.facing.is_empty();
        if !fits(exact) || !fits(found) || !has_facing(exact) || !(is_per_edge || has_facing(found)) {
            return None;
        }
        let mut score = Self::default();
        for word in 0..lights.div_ceil(32) {
            let live = low_bits(lights - 32 * word);
            let right = plane(&exact.facing, word, faces);
            let masks = plane(&found.masks, word, edges);
            let count = |wrong: u32| (wrong & live).count_ones() as usize;
            let facing = right.iter().zip(plane(&found.facing, word, faces)).map(|(right, found)| right ^ found);
            let at_edges = if is_per_edge { wrong_at_edges(mesh, right, masks) } else { Vec::new() };
            score.wrong_facing_bits += facing.chain(at_edges).map(count).sum::<usize>();
            let differing = plane(&exact.masks, word, edges).iter().zip(masks);
            score.wrong_silhouette_bits +=
                differing.map(|(right, found)| count(right.silhouette ^ found.silhouette)).sum::<usize>();
        }
        score.unclosed_vertices =
            light_counts(mesh, &found.masks, &[], lights).iter().map(|of| of.unclosed_vertices).sum();
        Some(score)
    }
}

/// A word's masks; of masks that are too few, none.
fn plane<T>(masks: &[T], word: usize, items: usize) -> &[T] {
    masks.get(word * items..(word + 1) * items).unwrap_or_default()
}

/// For each face the lights for which one of its edges decided it otherwise than `right`.
fn wrong_at_edges(mesh: &Mesh, right: &[u32], masks: &[EdgeMasks]) -> Vec<u32> {
    let mut wrong = vec![0; right.len()];
    let mut compare = |face: u32, decided: u32| {
        if let (Some(wrong), Some(right)) = (wrong.get_mut(face as usize), right.get(face as usize)) {
            *wrong |= right ^ decided;
        }
    };
    for (edge, masks) in mesh.edges().iter().zip(masks) {
        compare(edge.face_0, masks.winding);
        if let Some(face) = edge.face_1 {
            let differs = if edge.kind == EdgeKind::Inconsistent { !masks.silhouette } else { masks.silhouette };
            compare(face, masks.winding ^ differs);
        }
    }
    wrong
}

/// Counts of one light, from its masks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightCounts {
    /// Edge records that are silhouettes; boundaries always are.
    pub silhouette_edges: usize,
    /// Vertices at which outgoing less incoming multiplicities are not zero; docs/numerics/watertight.md.
    pub unclosed_vertices: usize,
}

/// [`LightCounts`] of each light, from ⌈N/32⌉ planes of masks an edge record, and of masks of twisted polygons, if the mesh
/// has polygons. Masks that are missing count as zeros.
pub fn light_counts(mesh: &Mesh, masks: &[EdgeMasks], twisted: &[u32], lights: usize) -> Vec<LightCounts> {
    let mut sums = vec![0_i32; mesh.vertex_count() as usize];
    let mut counts = Vec::with_capacity(lights);
    for light in 0..lights {
        let bit = light % 32;
        let mut silhouette_edges = 0;
        let twisted = plane(twisted, light / 32, mesh.face_count());
        let counts_once = |face: u32| i32::from(twisted.get(face as usize).is_none_or(|mask| mask >> bit & 1 == 0));
        for (edge, masks) in mesh.edges().iter().zip(plane(masks, light / 32, mesh.edges().len())) {
            if masks.silhouette >> bit & 1 == 0 {
                continue;
            }
            silhouette_edges += 1;
            // Where it is a silhouette, both terms of the multiplicity have one sign.
            let weight = counts_once(edge.face_0) + edge.face_1.map_or(0, counts_once);
            let multiplicity = if masks.winding >> bit & 1 == 1 { weight } else { -weight };
            let [a, b] = edge.vertices.map(|v| v as usize);
            for (vertex, signed) in [(a, multiplicity), (b, -multiplicity)] {
                if let Some(sum) = sums.get_mut(vertex) {
                    *sum += signed;
                }
            }
        }
        let unclosed_vertices = sums.iter().filter(|sum| **sum != 0).count();
        sums.fill(0);
        counts.push(LightCounts { silhouette_edges, unclosed_vertices });
    }
    counts
}
