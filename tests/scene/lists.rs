//! The chunks that a frame listed, and what it knows of clusters, against the twins.

use std::collections::HashMap;

use rimline::gpu::{SceneFrame, SceneStatistics};
use rimline::reference::clusters::list_faces;
use rimline::reference::cpu::{self, SceneTable, Taken};
use rimline::reference::layout::FACE_ENTRY;
use rimline_measure::device::Gpu;
use rimline_measure::on_gpu::text;
use rimline_measure::{must_fail, same};

/// Decisions on clusters that are cached from earlier frames of one layout, for each group and batch.
pub(crate) type Known = HashMap<(usize, usize), Vec<u32>>;

/// The chunks of faces and of edges that a frame listed, and those that it did not list.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Listed {
    pub(crate) faces: usize,
    pub(crate) edges: usize,
    pub(crate) unlisted: usize,
    /// Faces and edge records that clusters spared.
    pub(crate) spared: [u32; 2],
}

/// Compares the lists of a frame with the twins. `taken` is the twin's, and `known` what the frame before left.
pub(crate) fn check_lists(
    gpu: &Gpu,
    frame: &SceneFrame,
    lit: &[u32],
    taken: &Taken,
    known: &mut Known,
) -> Result<Listed, String> {
    let results = frame.results().map_err(text)?;
    let table: Vec<[u32; 4]> = gpu.read(results.table, usize::MAX)?;
    let table = SceneTable(&table);
    let work: Vec<u32> = gpu.read(results.work, usize::MAX)?;
    let kept: Vec<u32> = gpu.read(results.kept, usize::MAX)?;
    let mut listed = Listed::default();
    let mut tested = [0_u32; 2];
    for group in &results.groups {
        let (dispatch, key) = (group.dispatch, (group.group, group.batch));
        let what = format!("group {}, batch {}", group.group, group.batch);
        let part = group.group * frame.batches() + group.batch;
        let [face_count, edge_count, anew, keeps] = [0, 1, 2, 3].map(|word| work[dispatch.work_count as usize + word]);
        same(
            &format!("{what}: lists made anew, and bits kept"),
            &[anew, keeps],
            &[taken.anew[part], taken.keeps[part]],
        )?;
        let words: Vec<u32> = gpu.read(group.clusters, usize::MAX)?;
        let before = known.remove(&key).unwrap_or_default();
        let faces = list_faces(table, &dispatch, &taken.taken, &words, &before);
        let kept = &kept[dispatch.clusters_at as usize..][..2 * dispatch.face_chunks as usize];
        for chunk in
            (0..dispatch.face_chunks).filter(|chunk| is_first_of_cluster(table, dispatch.face_chunks_at, *chunk))
        {
            let of = |kept: &[u32]| kept[2 * chunk as usize..][..2].to_vec();
            same(&format!("{what}: the cluster from chunk {chunk} on"), &of(kept), &of(&faces.kept))?;
        }
        let entries = &work[dispatch.face_work as usize..][..(FACE_ENTRY * face_count) as usize];
        let mut entries: Vec<[u32; 4]> = entries.as_chunks().0.to_vec();
        entries.sort_unstable();
        same(&format!("{what}: chunks of faces"), &entries, &faces.chunks)?;
        if entries.pop().is_some() {
            must_fail("a missing chunk of faces", &same("chunks", &entries, &faces.chunks))?;
        }
        let edges = cpu::chunks(table, &dispatch, lit, anew, &words, &faces.kept);
        let mut entries = work[dispatch.edge_work as usize..][..edge_count as usize].to_vec();
        entries.sort_unstable();
        same(&format!("{what}: chunks of edges"), &entries, &edges.chunks)?;
        if entries.pop().is_some() {
            must_fail("a missing chunk of edges", &same("chunks", &entries, &edges.chunks))?;
        }
        listed.faces += faces.chunks.len();
        listed.edges += edges.chunks.len();
        listed.unlisted += dispatch.face_chunks as usize - faces.chunks.len();
        listed.spared = [listed.spared[0] + faces.faces[1], listed.spared[1] + edges.edges[1]];
        tested = [tested[0] + faces.faces[0], tested[1] + edges.edges[0]];
        known.insert(key, faces.kept);
    }
    let SceneStatistics { faces, edges, spared_faces, spared_edges, .. } = gpu.read(results.statistics, 1)?[0];
    same("faces and edges tested", &[faces, edges], &tested)?;
    same("faces and edges spared", &[spared_faces, spared_edges], &listed.spared)?;
    Ok(listed)
}

/// Whether a chunk of faces is the first of a cluster. Others have no words.
fn is_first_of_cluster(table: SceneTable<'_>, chunks_at: u32, chunk: u32) -> bool {
    let caster = table.caster(table.word(chunks_at, chunk));
    caster.clusters_or_figure != u32::MAX
        && caster.flags & 4 != 0
        && (chunk - caster.first_face_slot / 64).is_multiple_of(2)
}
