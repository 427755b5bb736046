//! The chunks that a frame listed, what it knows of clusters and what it kept, as words for goldens.

use rimline::gpu::{SceneFrame, SceneStatistics};
use rimline::reference::cpu::SceneTable;
use rimline::reference::layout::FACE_ENTRY;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;

/// The numbers of chunks of faces and of edges that a frame listed, and of those of faces that it did not list.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Listed {
    pub(crate) faces: usize,
    pub(crate) edges: usize,
    pub(crate) unlisted: usize,
    /// Faces and edge records that clusters spared.
    pub(crate) spared: [u32; 2],
}

impl Listed {
    pub(crate) fn add(&mut self, other: Self) {
        self.faces += other.faces;
        self.edges += other.edges;
        self.unlisted += other.unlisted;
        self.spared = [0, 1].map(|kind| self.spared[kind] + other.spared[kind]);
    }
}

/// Adds to `words` the active and dirty lights of each pair, the versions that are kept, the lists in order, and the counters.
pub(crate) fn listed(gpu: &Gpu, frame: &SceneFrame, words: &mut Vec<u32>) -> Result<Listed, String> {
    let results = frame.results().map_err(text)?;
    let table: Vec<[u32; 4]> = gpu.read(results.table, usize::MAX)?;
    let table = SceneTable(&table);
    let work: Vec<u32> = gpu.read(results.work, usize::MAX)?;
    let kept: Vec<u32> = gpu.read(results.kept, usize::MAX)?;
    let mut listed = Listed::default();
    if let Some(group) = results.groups.first() {
        let (casters, batches) = (group.dispatch.casters as usize, group.dispatch.batches as usize);
        for pairs in [results.lit, results.taken] {
            words.extend(gpu.read::<u32>(pairs, casters * batches)?);
        }
        words.extend(&kept[..4 + 32 * batches + 2 * casters * batches]);
    }
    for group in &results.groups {
        let dispatch = group.dispatch;
        let counts = &work[dispatch.work_count as usize..][..4];
        words.extend(counts);
        let known = &kept[dispatch.clusters_at as usize..][..2 * dispatch.face_chunks as usize];
        let firsts =
            (0..dispatch.face_chunks).filter(|chunk| is_first_of_cluster(table, dispatch.face_chunks_at, *chunk));
        words.extend(firsts.flat_map(|chunk| [2 * chunk, 2 * chunk + 1]).map(|word| known[word as usize]));
        let entries = &work[dispatch.face_work as usize..][..(FACE_ENTRY * counts[0]) as usize];
        let mut entries: Vec<[u32; 4]> = entries.as_chunks().0.to_vec();
        entries.sort_unstable();
        words.extend(entries.as_flattened());
        let mut edges = work[dispatch.edge_work as usize..][..counts[1] as usize].to_vec();
        edges.sort_unstable();
        words.extend(&edges);
        listed.faces += entries.len();
        listed.edges += edges.len();
        listed.unlisted += dispatch.face_chunks as usize - entries.len();
    }
    let SceneStatistics { faces, edges, spared_faces, spared_edges, .. } = gpu.read(results.statistics, 1)?[0];
    words.extend([faces, edges, spared_faces, spared_edges]);
    listed.spared = [spared_faces, spared_edges];
    Ok(listed)
}

/// Whether a chunk of faces is the first of a cluster. Others have no words.
fn is_first_of_cluster(table: SceneTable<'_>, chunks_at: u32, chunk: u32) -> bool {
    let caster = table.caster(table.word(chunks_at, chunk));
    caster.clusters_or_figure != u32::MAX
        && caster.flags & 4 != 0
        && (chunk - caster.first_face_slot / 64).is_multiple_of(2)
}
