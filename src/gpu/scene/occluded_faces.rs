//! Occluded faces: excluded while the light and the searched casters stay the same.

use std::collections::HashSet;
use std::sync::Arc;

use super::caster::{OccludedFacesOfLight, OcclusionCaster, Placement};
use super::handles::{CasterHandle, LightHandle};
use super::scene::Scene;
use crate::Transform;
use crate::cpu::OccludedFaces;
use crate::gpu::shadow::errors::ShadowError;

/// Counts of occluded faces in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OccludedCounts {
    /// Culled faces, summed over lights.
    pub faces: usize,
    /// Lights whose occluded faces the scene ignored, because a condition of
    /// [`Scene::set_occluded_faces`](crate::gpu::Scene::set_occluded_faces) failed.
    pub ignored: usize,
    /// The occluded faces of these lights, which cast.
    pub ignored_faces: usize,
}

impl Scene {
    /// Culls occluded faces of static casters for a light. `casters` are the casters of [`OccludedFaces::find`], in that
    /// order. `occluded` replaces the faces that were set for the light before; `None` ends it. Other casters of the
    /// scene do not matter.
    ///
    /// Each encode checks these conditions:
    ///
    /// * The light has the same bits.
    /// * Each caster exists and casts for the light. It is rigid with the identity for its transform, or the positions in
    ///   your buffer have the version that was searched. An instance of a model never meets this.
    /// * [`Self::set_excluded`] excludes no face of a caster for the light.
    ///
    /// If a condition fails, the encode ignores the light's occluded faces, and
    /// [`SceneFrame::occluded_faces`](crate::gpu::SceneFrame::occluded_faces) counts them. A later encode uses them
    /// again once all conditions hold. Each such change makes a new layout. While faces are culled, nothing is cached for
    /// the [groups](crate::gpu::SceneFrame::groups) of their casters.
    ///
    /// The caller must make sure that the positions are those that were searched: for a rigid caster those of its mesh.
    ///
    /// # Errors
    /// [`ShadowError::OcclusionCasters`], [`ShadowError::OcclusionCaster`], [`ShadowError::Polygons`] if faces of a caster
    /// of polygons are occluded, or an error of a handle.
    pub fn set_occluded_faces(
        &mut self,
        light: LightHandle,
        casters: &[CasterHandle],
        occluded: Option<&OccludedFaces>,
    ) -> Result<(), ShadowError> {
        self.content.lights.check(light)?;
        let made = occluded.map(|occluded| self.occluded_of_light(light, casters, occluded)).transpose()?;
        let Self { occluded: all, content, structure, .. } = self;
        if let Some(index) = all.iter().position(|of| of.light.bit == light.bit) {
            all.swap_remove(index);
            for entry in content.casters.values_mut() {
                entry.occluded.retain(|(of, _)| of.bit != light.bit);
            }
            *structure = None;
        }
        all.extend(made);
        Ok(())
    }

    fn occluded_of_light(
        &self,
        light: LightHandle,
        casters: &[CasterHandle],
        occluded: &OccludedFaces,
    ) -> Result<OccludedFacesOfLight, ShadowError> {
        let (given, found) = (casters.len(), occluded.casters.len());
        if given != found {
            return Err(ShadowError::OcclusionCasters { given, found });
        }
        let mut keys = HashSet::new();
        let mut sources = Vec::with_capacity(given);
        for (number, (caster, of_caster)) in casters.iter().zip(&occluded.casters).enumerate() {
            let key = caster.key_in(self.id)?;
            let entry = self.content.casters.get(key).ok_or(ShadowError::Removed { what: "caster" })?;
            let faces = entry.mesh.face_count();
            if faces != of_caster.face_count || !keys.insert(key) {
                return Err(ShadowError::OcclusionCaster { caster: number, faces, found: of_caster.face_count });
            }
            if entry.mesh.polygons.is_some() && !of_caster.faces.is_empty() {
                return Err(ShadowError::Polygons);
            }
            let slots = entry.mesh.slots(&of_caster.faces);
            sources.push(OcclusionCaster { key, version: of_caster.version, slots });
        }
        let count = sources.iter().map(|source| source.slots.len()).sum();
        let bits = occluded.light().to_array().map(f32::to_bits);
        Ok(OccludedFacesOfLight { light, bits, casters: sources, count, is_used: false })
    }

    /// Checks the conditions of each light, and excludes its occluded faces while they hold.
    pub(super) fn update_occluded_faces(&mut self) {
        let mut all = std::mem::take(&mut self.occluded);
        // Occluded faces of removed lights end.
        all.retain(|of| self.content.lights.check(of.light).is_ok());
        for of in &mut all {
            let holds = self.holds(of);
            if holds == of.is_used {
                continue;
            }
            of.is_used = holds;
            self.structure = None;
            for source in of.casters.iter().filter(|source| !source.slots.is_empty()) {
                let Some(entry) = self.content.casters.get_mut(source.key) else { continue };
                entry.occluded.retain(|(light, _)| *light != of.light);
                if holds {
                    entry.occluded.push((of.light, Arc::clone(&source.slots)));
                }
            }
        }
        self.occluded = all;
    }

    /// Whether the light and all casters meet the conditions.
    fn holds(&self, of: &OccludedFacesOfLight) -> bool {
        let light = self.content.lights.get(of.light.bit);
        let is_same = |source: &OcclusionCaster| {
            self.content.casters.get(source.key).is_some_and(|entry| {
                let is_placed = match &entry.placement {
                    Placement::Rigid(rigid) => source.version.is_none() && rigid.rows == Transform::UNIT,
                    Placement::World { .. } => {
                        !entry.is_of_model && source.version.is_some() && entry.positions_version == source.version
                    }
                };
                is_placed
                    && entry.lights.has(of.light.bit)
                    && entry.excluded.iter().all(|(light, _)| *light != of.light)
            })
        };
        light.is_some_and(|light| light.to_array().map(f32::to_bits) == of.bits) && of.casters.iter().all(is_same)
    }

    pub(super) fn count_occluded(&self) -> OccludedCounts {
        let (used, ignored): (Vec<_>, Vec<_>) = self.occluded.iter().partition(|of| of.is_used);
        let faces = |of: &[&OccludedFacesOfLight]| of.iter().map(|of| of.count).sum();
        OccludedCounts { faces: faces(&used), ignored: ignored.len(), ignored_faces: faces(&ignored) }
    }
}
