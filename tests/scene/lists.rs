//! Lists of a frame, and all that it keeps, from the lights that reach each caster, the decisions on clusters and what was kept before, all
//! read from the GPU. `reach`, `clusters` and `chunks` find the rest from these by integers.

use rimline::gpu::{SceneFrame, SceneStatistics};
use rimline::internals::layout::{CHUNK, FACE_ENTRY, SceneCaster, SceneDispatch};
use rimline::internals::scene::SceneTable;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{must_fail, same};

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

/// Flags of a caster.
const RIGID: u32 = 4;
const UNCACHED: u32 = 32;
const GROUP_EXCLUDES: u32 = 64;
const NO_CLUSTERS: u32 = u32::MAX;
const CLUSTER_CHUNKS: u32 = 2;
const BOUND_WORDS: u32 = 12;

/// Words of a frame.
#[derive(Clone)]
struct Words {
    table: Vec<[u32; 4]>,
    lit: Vec<u32>,
    taken: Vec<u32>,
    kept: Vec<u32>,
    work: Vec<u32>,
    statistics: SceneStatistics,
    /// For each group and batch the number of the group, the uniform, and the clusters of the page.
    groups: Vec<(u32, SceneDispatch, Vec<u32>)>,
}

/// Checks a frame. `kept` is what the frame before kept, none for the first of a scene, and becomes what this one keeps.
pub(crate) fn listed(gpu: &Gpu, frame: &SceneFrame, kept: &mut Vec<u32>) -> Result<Listed, String> {
    let results = frame.results().map_err(text)?;
    let group = |group: &rimline::gpu::SceneGroupResults<'_>| {
        Ok((group.group as u32, group.dispatch, gpu.read(group.clusters, usize::MAX)?))
    };
    let words = Words {
        table: gpu.read(results.table, usize::MAX)?,
        lit: gpu.read(results.relevant_lights, usize::MAX)?,
        taken: gpu.read(results.active_lights, usize::MAX)?,
        kept: gpu.read(results.cache, usize::MAX)?,
        work: gpu.read(results.work, usize::MAX)?,
        statistics: gpu.read(results.statistics, 1)?[0],
        groups: results.groups.iter().map(group).collect::<Result<_, String>>()?,
    };
    let listed = words.check(kept)?;
    words.check_controls(kept, listed)?;
    *kept = words.kept;
    Ok(listed)
}

fn has_clusters(caster: &SceneCaster) -> bool {
    caster.clusters_or_deforming_index != NO_CLUSTERS && caster.flags & RIGID != 0
}

/// The bits of the lights in `bits`, by their numbers among those that are allowed.
fn places_of(allowed: u32, bits: u32) -> u32 {
    let lights = (0..32).filter(|light| allowed >> light & 1 != 0);
    lights.enumerate().fold(0, |places, (place, light)| places | (bits >> light & 1) << place)
}

impl Words {
    fn table(&self) -> SceneTable<'_> {
        SceneTable(&self.table)
    }

    fn check(&self, before: &[u32]) -> Result<Listed, String> {
        let (mut listed, mut sums) = (Listed::default(), [0; 6]);
        for (group, dispatch, clusters) in &self.groups {
            let what = |error: String| format!("group {group}, batch {}: {error}", dispatch.batch);
            // Nothing of another layout is kept.
            let before = if before.first() == Some(&dispatch.structure) { before } else { &[] };
            let anew = self.check_pairs(*group, dispatch, before, &mut sums).map_err(what)?;
            self.check_faces(dispatch, before, anew, &mut sums).map_err(what)?;
            self.check_edges(dispatch, clusters, anew, &mut sums).map_err(what)?;
            let [faces, edges] = [0, 1].map(|kind| self.work[dispatch.work_count as usize + kind] as usize);
            listed.add(Listed { faces, edges, unlisted: dispatch.face_chunks as usize - faces, spared: [0; 2] });
        }
        let SceneStatistics { pairs, cached_pairs, faces, edges, untested_faces, untested_edges, .. } = self.statistics;
        same("counts", &[pairs, cached_pairs, faces, untested_faces, edges, untested_edges], &sums)?;
        listed.spared = [untested_faces, untested_edges];
        Ok(listed)
    }

    /// The lights that are taken, and versions. Returns the lights of the batch whose lists are made anew.
    fn check_pairs(
        &self,
        group: u32,
        dispatch: &SceneDispatch,
        before: &[u32],
        sums: &mut [u32; 6],
    ) -> Result<u32, String> {
        let (table, batch, batches) = (self.table(), dispatch.batch, dispatch.batches);
        let lights_offset = (4 + 32 * batch) as usize;
        let versions = (0..32).map(|light| table.word(dispatch.ranges_offset + 8 * (batches + batch), light));
        let versions: Vec<u32> = versions.collect();
        same("versions of lights", &self.kept[lights_offset..][..32], &versions)?;
        let is_same = |light: &u32| before.get(lights_offset + *light as usize) == Some(&versions[*light as usize]);
        let same_lights = (0..32).filter(is_same).fold(0, |bits, light| bits | 1 << light);
        let (mut anew, mut keeps) = (0, 0);
        for caster in (0..dispatch.casters).filter(|&caster| table.caster(caster).group == group) {
            let own = table.caster(caster);
            let pair = batch * dispatch.casters + caster;
            let at = (4 + 32 * batches + 2 * pair) as usize;
            let lit = self.lit[pair as usize];
            if lit & !table.part(dispatch.lights_offset + pair)[0] != 0 {
                return Err(format!("caster {caster} has lights that it does not allow: {lit:b}"));
            }
            let mut kept = 0;
            if dispatch.uses_cache != 0 && !before.is_empty() {
                let [version, was_lit] = [before[at], before[at + 1]];
                if version == own.version && own.flags & (UNCACHED | GROUP_EXCLUDES) == 0 {
                    kept = lit & was_lit & same_lights;
                }
                anew |= lit & !kept | was_lit & !lit;
            } else {
                anew = u32::MAX;
            }
            keeps |= kept;
            same(&format!("lights taken for caster {caster}"), &[self.taken[pair as usize]], &[lit & !kept])?;
            same(&format!("what is kept of caster {caster}"), &self.kept[at..][..2], &[own.version, lit])?;
            sums[0] += lit.count_ones();
            sums[1] += kept.count_ones();
        }
        same("lists made anew, lights kept", &self.work[dispatch.work_count as usize + 2..][..2], &[anew, keeps])?;
        let encode = table.part(dispatch.ranges_offset + 16 * batches)[0];
        for light in 0..32 {
            let at = (dispatch.lists_offset + light) as usize;
            let expected = if anew >> light & 1 != 0 { encode } else { before[at] };
            same(&format!("the encode of the list of light {light}"), &[self.kept[at]], &[expected])?;
        }
        Ok(anew)
    }

    /// The words of clusters, and the chunks of faces with what is decided for them.
    fn check_faces(
        &self,
        dispatch: &SceneDispatch,
        before: &[u32],
        anew: u32,
        sums: &mut [u32; 6],
    ) -> Result<(), String> {
        let table = self.table();
        let mut expected = Vec::new();
        for chunk in (0..dispatch.face_chunks).filter(|_| anew != 0) {
            let caster = table.word(dispatch.face_chunks_offset, chunk);
            let own = table.caster(caster);
            let pair = dispatch.batch * dispatch.casters + caster;
            let (matter, allowed) = (self.taken[pair as usize], table.part(dispatch.lights_offset + pair)[0]);
            let faces_in = |chunk: u32| CHUNK.min(own.first_face_slot + own.faces - CHUNK * chunk);
            let (mut chunks, mut known, mut was_known) = (chunk..chunk + 1, [0; 2], [0; 2]);
            if has_clusters(&own) {
                if !(chunk - own.first_face_slot / CHUNK).is_multiple_of(CLUSTER_CHUNKS) {
                    continue;
                }
                let at = (dispatch.clusters_offset + 2 * chunk) as usize;
                known = [self.kept[at], self.kept[at + 1]];
                was_known = if before.is_empty() { [0; 2] } else { [before[at], before[at + 1]] };
                let others = [known, was_known].map(|words| words.map(|word| word & !matter));
                same(&format!("lights of chunk {chunk} that are not taken"), &others[0], &others[1])?;
                chunks = chunk..(chunk + CLUSTER_CHUNKS).min((own.first_face_slot + own.faces).div_ceil(CHUNK));
            }
            let [decided, facing] = known.map(|word| word & matter);
            if facing & !decided != 0 {
                return Err(format!("chunk {chunk} faces lights that are not decided"));
            }
            let is_known = matter & !(decided & was_known[0]) == 0 && (facing ^ was_known[1]) & matter == 0;
            for chunk in chunks {
                let is_tested = matter & !decided != 0;
                sums[if is_tested { 2 } else { 3 }] += if matter == 0 { 0 } else { faces_in(chunk) };
                let places = if decided == 0 { u32::MAX } else { places_of(allowed, matter & !decided) };
                expected.extend((!is_known).then_some([chunk, decided, facing, places]));
            }
        }
        let count = self.work[dispatch.work_count as usize];
        let entries = &self.work[dispatch.face_work as usize..][..(FACE_ENTRY * count) as usize];
        let mut entries: Vec<[u32; 4]> = entries.as_chunks().0.to_vec();
        entries.sort_unstable();
        same("chunks of faces", &entries, &expected)
    }

    /// The chunks of edges that may have a silhouette in a list that is made anew.
    fn check_edges(
        &self,
        dispatch: &SceneDispatch,
        clusters: &[u32],
        anew: u32,
        sums: &mut [u32; 6],
    ) -> Result<(), String> {
        let table = self.table();
        let mut expected = Vec::new();
        for chunk in 0..dispatch.edge_chunks {
            let caster = table.word(dispatch.edge_chunks_offset, chunk);
            let own = table.caster(caster);
            let wanted = self.lit[(dispatch.batch * dispatch.casters + caster) as usize] & anew;
            if wanted == 0 {
                continue;
            }
            let is_spared = has_clusters(&own) && {
                let bounds_at = own.clusters_or_deforming_index;
                let at = bounds_at + BOUND_WORDS * own.faces.div_ceil(128) + chunk - own.first_edge_slot / CHUNK;
                let [begin, end] = [0, 1].map(|next| clusters[at as usize + next]);
                let names = (begin & 0x3fff_ffff)..(end & 0x3fff_ffff);
                let known = names.map(|name| {
                    let cluster = clusters[(bounds_at + name) as usize];
                    let chunk = own.first_face_slot / CHUNK + CLUSTER_CHUNKS * cluster;
                    [0, 1].map(|word| self.kept[(dispatch.clusters_offset + 2 * chunk + word) as usize])
                });
                let known: Vec<[u32; 2]> = known.collect();
                let are_decided = known.iter().all(|[decided, _]| wanted & !decided == 0);
                let are_alike = known.windows(2).all(|two| (two[0][1] ^ two[1][1]) & wanted == 0);
                match begin >> 30 {
                    1 => are_decided,
                    2 => are_decided && are_alike,
                    _ => false,
                }
            };
            sums[if is_spared { 5 } else { 4 }] += CHUNK.min(own.first_edge_slot + own.edges - CHUNK * chunk);
            expected.extend((!is_spared).then_some(chunk));
        }
        let count = self.work[dispatch.work_count as usize + 1];
        let mut edges = self.work[dispatch.edge_work as usize..][..count as usize].to_vec();
        edges.sort_unstable();
        same("chunks of edges", &edges, &expected)
    }

    /// Negative controls: a light that is taken needlessly, another version, another entry of each list.
    fn check_controls(&self, before: &[u32], listed: Listed) -> Result<(), String> {
        let Some((_, dispatch, _)) = self.groups.first() else { return Ok(()) };
        let [mut taken, mut version, mut faces, mut edges] = [0; 4].map(|_| self.clone());
        taken.taken[0] ^= 1;
        must_fail("another light", &taken.check(before))?;
        version.kept[4] ^= 1;
        must_fail("another version", &version.check(before))?;
        let counts = &self.work[dispatch.work_count as usize..][..2];
        if listed.faces > 0 && counts[0] > 0 {
            faces.work[dispatch.face_work as usize + 1] ^= 1;
            must_fail("another decision", &faces.check(before))?;
        }
        if listed.edges > 0 && counts[1] > 0 {
            edges.work[dispatch.edge_work as usize] ^= 1;
            must_fail("another chunk of edges", &edges.check(before))?;
        }
        Ok(())
    }
}
