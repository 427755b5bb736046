//! Chunks: lists the chunks of faces and of edges of the casters that any light of the batch reaches.

use super::table::SceneTable;
use crate::layout::SceneDispatch;

/// The listed chunks of faces and of edges of a group, in order. `lit` is what [`super::reach::reach`] returns.
pub fn chunks(table: SceneTable<'_>, group: &SceneDispatch, lit: &[u32]) -> [Vec<u32>; 2] {
    let SceneDispatch { face_chunks_at, face_chunks, edge_chunks_at, edge_chunks, .. } = *group;
    [(face_chunks_at, face_chunks), (edge_chunks_at, edge_chunks)].map(|(at, count)| {
        let is_lit = |&chunk: &u32| {
            let caster = table.word(at, chunk);
            lit.get((group.batch * group.casters + caster) as usize).is_some_and(|&lights| lights != 0)
        };
        (0..count).filter(is_lit).collect()
    })
}
