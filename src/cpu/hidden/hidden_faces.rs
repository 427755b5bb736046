//! Which faces of static casters need not cast for a light.

use std::ops::ControlFlow;

use super::order::order;
use super::tree::{Face, Found, Tree};
use crate::cpu::common::positions::{is_finite, position};
use crate::cpu::extract::exact_facing::exact_facing;
use crate::light::{Light, LightError, check_shadow_lights};
use crate::mesh::{Mesh, is_degenerate};

/// A static caster in world space.
#[derive(Clone, Copy, Debug)]
pub struct HiddenCaster<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// The positions of the mesh's source vertices, in world space: the bits that the scene has. Of a rigid caster of a scene
    /// these are the positions of its mesh, and its transform is the identity.
    pub positions: &'a [[f32; 3]],
    /// The version of the positions, as in [`Scene::set_position_version`](crate::gpu::Scene::set_position_version). `None` for
    /// a rigid caster.
    pub version: Option<u64>,
}

/// Bounds on the work. What they leave out stays a caster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HiddenOptions {
    /// The most nodes of the tree. A node and its planes take up to some 400 bytes. From there on no face hides others that did
    /// not before.
    pub max_nodes: usize,
    /// The most nodes and leaves that a face visits.
    pub max_steps: usize,
}

impl Default for HiddenOptions {
    fn default() -> Self {
        Self { max_nodes: 1 << 21, max_steps: 4096 }
    }
}

/// Why no hidden faces were found.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HiddenError {
    /// The light is refused.
    #[error(transparent)]
    Light(#[from] LightError),
    /// Positions are missing.
    #[error("caster {caster} has {given} positions, and its mesh has {needed} vertices; give one for each")]
    TooFewPositions {
        /// Number of the caster.
        caster: usize,
        /// Positions given.
        given: usize,
        /// Vertices of the mesh.
        needed: u32,
    },
    /// The caller ended it.
    #[error("the search for hidden faces was cancelled")]
    Cancelled,
}

/// Counts of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HiddenStatistics {
    /// Faces that were tried: all but those that are not finite or have the light in their plane.
    pub tried: usize,
    /// Faces that are hidden.
    pub hidden: usize,
    /// Faces that stay since they met the bound on steps.
    pub undecided: usize,
    /// Faces that stay and hide nothing new, since the tree was full.
    pub without_room: usize,
    /// Nodes of the tree.
    pub nodes: usize,
}

/// The faces of static casters whose shadow lies wholly in the shadow of other faces, for one light. They need not cast: see
/// [`Scene::set_hidden_faces`](crate::gpu::Scene::set_hidden_faces). All decisions are exact.
///
/// The faces that hide others are averted ones of closed meshes, and all of others. They are never hidden themselves. The
/// method is Batagelo and Costa Júnior's (1999): an SVBSP grows front to back, and a face that straddles a plane goes to both
/// sides.
#[derive(Clone, Debug, PartialEq)]
pub struct HiddenFaces {
    light: Light,
    casters: Vec<HiddenOfCaster>,
    statistics: HiddenStatistics,
}

/// What was found of a caster, and what it was found for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HiddenOfCaster {
    pub(crate) version: Option<u64>,
    pub(crate) face_count: usize,
    /// Ascending.
    pub(crate) faces: Vec<u32>,
}

/// Faces from one call of the progress to the next.
const STRIDE: usize = 256;

impl HiddenFaces {
    /// Finds the hidden faces. It takes no device and may run on a thread of its own. `progress` is called now and then with the
    /// number of faces tried and of all to try; [`ControlFlow::Break`] ends the search.
    ///
    /// # Errors
    /// [`HiddenError`] for a light that shadows refuse, missing positions, or if `progress` ends it.
    pub fn find(
        light: Light,
        casters: &[HiddenCaster<'_>],
        options: HiddenOptions,
        mut progress: impl FnMut(usize, usize) -> ControlFlow<()>,
    ) -> Result<Self, HiddenError> {
        check_shadow_lights(&[light], 1)?;
        let (mut faces, mut owners) = (Vec::new(), Vec::new());
        for (number, caster) in casters.iter().enumerate() {
            let needed = caster.mesh.vertex_count();
            if caster.positions.len() < needed as usize {
                let given = caster.positions.len();
                return Err(HiddenError::TooFewPositions { caster: number, given, needed });
            }
            let found = participants(caster, light);
            owners.extend(found.iter().map(|&(face, _)| (number, face)));
            faces.extend(found.into_iter().map(|(_, face)| face));
        }
        let mut tree = Tree::new(light, options.max_nodes, options.max_steps);
        let mut statistics = HiddenStatistics { tried: faces.len(), ..Default::default() };
        let mut of_casters: Vec<HiddenOfCaster> = casters
            .iter()
            .map(|caster| HiddenOfCaster {
                version: caster.version,
                face_count: caster.mesh.faces().len(),
                faces: Vec::new(),
            })
            .collect();
        for (done, number) in order(&faces, light).into_iter().enumerate() {
            if done % STRIDE == 0 && progress(done, faces.len()).is_break() {
                return Err(HiddenError::Cancelled);
            }
            let (Some(face), Some(&(caster, own))) = (faces.get(number), owners.get(number)) else { continue };
            match tree.take(face) {
                Found::Hidden => {
                    statistics.hidden += 1;
                    if let Some(of_caster) = of_casters.get_mut(caster) {
                        of_caster.faces.push(own);
                    }
                }
                Found::Undecided => statistics.undecided += 1,
                Found::Seen => statistics.without_room += usize::from(face.may_hide && tree.is_full()),
            }
        }
        for of_caster in &mut of_casters {
            of_caster.faces.sort_unstable();
        }
        statistics.nodes = tree.nodes();
        Ok(Self { light, casters: of_casters, statistics })
    }

    /// The light.
    pub fn light(&self) -> Light {
        self.light
    }

    /// The hidden faces of a caster, by its number in the list that was given. They are ascending numbers of faces in its mesh.
    pub fn faces(&self, caster: usize) -> &[u32] {
        self.casters.get(caster).map_or(&[], |of_caster| &of_caster.faces)
    }

    /// Counts of the search.
    pub fn statistics(&self) -> HiddenStatistics {
        self.statistics
    }

    pub(crate) fn casters(&self) -> &[HiddenOfCaster] {
        &self.casters
    }
}

/// The faces of a caster that cast at all, with their numbers.
fn participants(caster: &HiddenCaster<'_>, light: Light) -> Vec<(u32, Face)> {
    let is_closed = caster.mesh.is_closed();
    let face = |face: &[u32; 3]| {
        let corners = face.map(|vertex| position(caster.positions, vertex));
        if is_degenerate(*face) || !corners.into_iter().all(is_finite) {
            return None;
        }
        let [a, b, c] = corners;
        let side = exact_facing(a, b, c, light.to_array());
        (side != 0).then_some(Face { corners, side, may_hide: side < 0 || !is_closed })
    };
    let faces = (0_u32..).zip(caster.mesh.faces());
    faces.filter_map(|(number, corners)| Some((number, face(corners)?))).collect()
}
