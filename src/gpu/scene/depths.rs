//! The casters of a scene that are drawn into a depth map.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use slotmap::DefaultKey;

use super::caster::{CasterEntry, Placement};
use super::handles::{CasterHandle, LightHandle};
use super::scene::Scene;
use super::sources::Source;
use crate::Matrix3x4;
use crate::gpu::shadow::errors::ShadowError;

/// The casters of a scene that are drawn into a depth map.
///
/// Leave out casters that have volumes for the same light: their shadows would be drawn twice, once as coarse as the map.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub enum SceneDepthCasters<'a> {
    /// All of them.
    #[default]
    All,
    /// These. A caster that is listed twice is drawn once.
    Only(&'a [CasterHandle]),
    /// All but these.
    Except(&'a [CasterHandle]),
    /// Casters whose [`Caster::lights`](crate::gpu::Caster::lights) do not have this light, so they have no volume for it.
    NotCastingFor(LightHandle),
}

/// Casters that are drawn together, with faces and positions in the same buffers.
#[derive(Debug)]
pub(crate) struct DepthGroup<'a> {
    pub(crate) faces: &'a wgpu::Buffer,
    pub(crate) positions: wgpu::Buffer,
    /// The bound part of `positions`, in bytes.
    pub(crate) range: Range<u64>,
    pub(crate) casters: Vec<DepthCaster>,
}

/// A caster of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthCaster {
    /// The matrix from mesh space to world space. `None`: positions are in world space.
    pub(crate) rows: Option<Matrix3x4>,
    /// The word of x of vertex 0, the words from one vertex to the next, the first face, and how many there are.
    pub(crate) layout: [u32; 4],
    /// The box of its positions, in their own space, if it is known.
    pub(crate) bounds: Option<[[f32; 3]; 2]>,
}

impl DepthCaster {
    /// `None`: its transform is singular or not finite.
    fn new(caster: &CasterEntry) -> Option<Self> {
        let mesh = &caster.mesh;
        let [offset, stride] = caster.position_words();
        let (rows, bounds) = match &caster.placement {
            Placement::Rigid(rigid) => {
                rigid.space?;
                // A face with a vertex that is not finite is in no box. The box is empty if all faces are such.
                let is_known = !mesh.is_holed && mesh.low[0] <= mesh.high[0];
                (Some(rigid.rows), is_known.then_some([mesh.low, mesh.high]))
            }
            Placement::World { .. } => (None, caster.bounds),
        };
        Some(Self { rows, layout: [offset, stride, mesh.region.ranges[0].start, mesh.faces], bounds })
    }
}

impl Scene {
    /// The casters of a choice, by group.
    #[allow(clippy::mutable_key_type, reason = "buffers are compared by identity")]
    pub(crate) fn depth_groups(&self, which: SceneDepthCasters<'_>) -> Result<Vec<DepthGroup<'_>>, ShadowError> {
        let (listed, is_left_out) = match which {
            SceneDepthCasters::All => (&[][..], true),
            SceneDepthCasters::Only(listed) => (listed, false),
            SceneDepthCasters::Except(listed) => (listed, true),
            SceneDepthCasters::NotCastingFor(light) => {
                self.content.lights.check(light)?;
                (&[][..], true)
            }
        };
        let mut keys = HashSet::new();
        for handle in listed {
            let key = handle.key_in(self.id)?;
            if !self.content.casters.contains_key(key) {
                return Err(ShadowError::Removed { what: "caster" });
            }
            keys.insert(key);
        }
        let is_chosen = |key: DefaultKey, caster: &CasterEntry| match which {
            SceneDepthCasters::NotCastingFor(light) => !caster.lights.contains(light),
            _ => keys.contains(&key) != is_left_out,
        };
        let mut groups: Vec<DepthGroup<'_>> = Vec::new();
        // The index of each source's group.
        let mut indices: HashMap<Source, usize> = HashMap::new();
        for (key, caster) in &self.content.casters {
            if !is_chosen(key, caster) {
                continue;
            }
            let Some(drawn) = DepthCaster::new(caster) else { continue };
            let source = Source::of(caster);
            if let Some(group) = indices.get(&source).and_then(|&index| groups.get_mut(index)) {
                group.casters.push(drawn);
            } else if let Some(group) = self.depth_group(&source, drawn) {
                indices.insert(source, groups.len());
                groups.push(group);
            }
        }
        Ok(groups)
    }

    /// A group with one caster.
    fn depth_group(&self, source: &Source, caster: DepthCaster) -> Option<DepthGroup<'_>> {
        let page = self.content.pages.get(source.page)?;
        let (positions, range) = source.bound_positions(page);
        Some(DepthGroup { faces: &page.faces, positions, range, casters: vec![caster] })
    }
}
