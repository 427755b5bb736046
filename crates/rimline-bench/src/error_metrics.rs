//! How wrong an extraction is: bits that differ from exact arithmetic, and vertices at which loops stay open.

use rimline::internals::cpu;
use rimline::internals::layout::{EdgeMasks, low_bits};
use rimline::internals::light::batches;
use rimline::mesh::{EdgeKind, Mesh};

/// Errors of one extraction, all lights together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Pairs of face and light.
    pub facing_bits: usize,
    /// Pairs of face and light that were decided wrongly. For a method without facing masks: wrongly at one edge of the face
    /// at least.
    pub wrong_facing_bits: usize,
    /// Pairs of edge record and light.
    pub silhouette_bits: usize,
    /// Pairs of edge record and light whose silhouette bit is wrong: silhouettes that were not found, or edges that are
    /// none.
    pub wrong_silhouette_bits: usize,
    /// Pairs of vertex and light at which outgoing less incoming multiplicities are not zero.
    pub unclosed_vertices: usize,
}

/// Why an extraction cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScoreError {
    /// A plane of masks a batch of lights is needed, and as many masks in it as the mesh has faces or edge records.
    #[error(
        "{got} {what} where the mesh and its lights need {expected}; compare extractions of the same mesh and lights"
    )]
    Length {
        /// Which masks.
        what: &'static str,
        /// How many there are.
        got: usize,
        /// How many there must be.
        expected: usize,
    },
}

/// Masks that [`Score::of`] compares with `exact`.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a> {
    /// Facing masks, ⌈N/32⌉ planes of one a face; `None` for the per-edge method, which has none: what each edge decided
    /// about its faces is then told from its silhouette and winding bits.
    pub facing: Option<&'a [u32]>,
    /// ⌈N/32⌉ planes of one [`EdgeMasks`] an edge record.
    pub masks: &'a [EdgeMasks],
}

impl Score {
    /// Holds an extraction for `lights` lights against an exact one of the same mesh, positions and lights, as
    /// [`rimline::internals::cpu::extract`] makes it with [`rimline::Predicate::Exact`].
    ///
    /// # Errors
    /// [`ScoreError::Length`] when the masks are not of this mesh and as many lights.
    pub fn of(
        mesh: &Mesh,
        lights: usize,
        exact: &cpu::Extraction,
        candidate: Candidate<'_>,
    ) -> Result<Self, ScoreError> {
        let (faces, edges) = (mesh.faces().len(), mesh.edges().len());
        let check = |what, got, items: usize| match items * batches(lights) {
            expected if got == expected => Ok(()),
            expected => Err(ScoreError::Length { what, got, expected }),
        };
        check("exact facing masks", exact.facing.len(), faces)?;
        check("exact edge masks", exact.masks.len(), edges)?;
        check("facing masks", candidate.facing.map_or(faces * batches(lights), <[u32]>::len), faces)?;
        check("edge masks", candidate.masks.len(), edges)?;

        let mut score = Self { facing_bits: faces * lights, silhouette_bits: edges * lights, ..Self::default() };
        for word in 0..batches(lights) {
            let live = low_bits(lights - 32 * word);
            let right = plane(&exact.facing, word, faces);
            let masks = plane(candidate.masks, word, edges);
            let count = |wrong: u32| (wrong & live).count_ones() as usize;
            score.wrong_facing_bits += match candidate.facing {
                Some(facing) => right
                    .iter()
                    .zip(plane(facing, word, faces))
                    .map(|(right, found)| count(right ^ found))
                    .sum::<usize>(),
                None => wrong_at_edges(mesh, right, masks).into_iter().map(count).sum(),
            };
            let differing = plane(&exact.masks, word, edges).iter().zip(masks);
            score.wrong_silhouette_bits +=
                differing.map(|(right, found)| count(right.silhouette ^ found.silhouette)).sum::<usize>();
        }
        score.unclosed_vertices =
            light_counts(mesh, candidate.masks, &[], lights).iter().map(|of| of.unclosed_vertices).sum();
        Ok(score)
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
