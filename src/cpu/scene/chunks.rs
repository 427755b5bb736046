//! Chunks: lists the chunks of edges of the casters with a light whose list is made anew, but for those without a silhouette
//! for such a light.

use super::clusters::has_clusters;
use super::table::SceneTable;
use crate::layout::{SceneCaster, SceneDispatch};

/// Faces of a cluster, and words of its bound.
const CLUSTER: u32 = 128;
const BOUND: u32 = 12;

/// The listed chunks of edges of a group and batch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ListedEdges {
    /// In order.
    pub chunks: Vec<u32>,
    /// Edge records that are tested, and those that need not be.
    pub edges: [u32; 2],
}

/// The chunks of edges that are listed. `lit` is what [`super::reach::reach`] returns, `anew` the word of
/// [`super::reach::take`] for the group and batch, `words` are the clusters of the group's page, and `kept` is
/// [`super::clusters::ListedFaces::kept`].
pub fn chunks(
    table: SceneTable<'_>,
    group: &SceneDispatch,
    lit: &[u32],
    anew: u32,
    words: &[u32],
    kept: &[u32],
) -> ListedEdges {
    let mut listed = ListedEdges::default();
    for chunk in 0..group.edge_chunks {
        let index = table.word(group.edge_chunks_at, chunk);
        let caster = table.caster(index);
        let wanted = anew & lit.get((group.batch * group.casters + index) as usize).copied().unwrap_or(0);
        let edges = (caster.first_edge_slot + caster.edges - 64 * chunk).min(64);
        let is_spared = has_clusters(&caster) && {
            let names = names(words, &caster, chunk - caster.first_edge_slot / 64);
            (0..32).filter(|light| wanted >> light & 1 != 0).all(|light| is_without(&caster, &names, kept, light))
        };
        match (wanted != 0, is_spared) {
            (true, false) => {
                listed.chunks.push(chunk);
                listed.edges[0] += edges;
            }
            (true, true) => listed.edges[1] += edges,
            (false, _) => {}
        }
    }
    listed
}

/// When a chunk has no silhouette (0: never), and its clusters.
fn names<'a>(words: &'a [u32], caster: &SceneCaster, number: u32) -> (u32, &'a [u32]) {
    let own = words.get(caster.clusters_or_figure as usize..).unwrap_or_default();
    let at = (BOUND * caster.faces.div_ceil(CLUSTER) + number) as usize;
    let Some(&[begin, end]) = own.get(at..at + 2) else { return (0, &[]) };
    let [first, last] = [begin, end].map(|place| (place << 2 >> 2) as usize);
    (begin >> 30, own.get(first..last).unwrap_or_default())
}

/// Whether no edge of a chunk is a silhouette for a light.
fn is_without(caster: &SceneCaster, (rule, names): &(u32, &[u32]), kept: &[u32], light: u32) -> bool {
    let sides = names.iter().map(|cluster| {
        let at = (caster.first_face_slot / 32 + 4 * cluster) as usize;
        let words = kept.get(at..at + 2)?;
        (words[0] >> light & 1 != 0).then_some(words[1] >> light & 1)
    });
    let sides: Option<Vec<u32>> = sides.collect();
    match (rule, sides) {
        (1, Some(_)) => true,
        (2, Some(sides)) => sides.windows(2).all(|pair| pair[0] == pair[1]),
        _ => false,
    }
}
