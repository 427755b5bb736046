//! Which faces of static casters need not cast for a light.

use std::ops::ControlFlow;

use super::cones::cones;
use super::options::OcclusionOptions;
use super::order::order;
use super::search::{search, total};
use super::silhouette::Silhouette;
use super::tree::Face;
use crate::cpu::common::positions::{is_finite, position};
use crate::cpu::error::CpuError;
use crate::cpu::extract::exact_facing::exact_facing;
use crate::cpu::polygon::polygon_turns::convex;
use crate::light::{Light, check_shadow_lights};
use crate::mesh::{Mesh, Polygons, is_degenerate};

/// A static caster in world space.
#[derive(Clone, Copy, Debug)]
pub struct OcclusionCaster<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// The positions of the mesh's source vertices, in world space. Their bits are those that the scene has. A rigid caster
    /// has the positions of its mesh, and its transform in the scene is the identity.
    pub positions: &'a [[f32; 3]],
    /// The version of the positions, as in [`Scene::set_position_version`](crate::gpu::Scene::set_position_version).
    /// `None` for a rigid caster.
    pub version: Option<u64>,
}

/// Counts of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OcclusionStatistics {
    /// Faces that were searched: all finite ones, but for triangles that name a vertex twice, and polygons that have holes or
    /// are not exactly planar and strictly convex as seen from the light.
    pub tried: usize,
    /// Faces that are occluded.
    pub occluded: usize,
    /// Occluded faces that are left out.
    pub left_out: usize,
    /// Sides of all casters' volumes with all faces, where back-facing faces of closed meshes cast. An edge counts as often
    /// as its side is drawn.
    pub sides: usize,
    /// The same without the faces left out. It is at most [`Self::sides`], but for [`OcclusionOptions::leave_out_all`].
    pub sides_left: usize,
    /// Faces that still cast because they exceeded [`OcclusionOptions::max_steps`]. Here and in `without_room`, a face
    /// counts in each cone of directions that it is in, and a polygon by its triangles.
    pub undecided: usize,
    /// Faces that still cast and occlude no other face, or only by a part of them, because the tree was full.
    pub without_room: usize,
    /// Nodes of all trees, without those of the planes between cones.
    pub nodes: usize,
}

/// The faces of static casters whose shadow lies wholly in the shadow of other faces, for one light. They need not cast: see
/// [`Scene::set_occluded_faces`](crate::gpu::Scene::set_occluded_faces). All decisions are exact.
///
/// Faces that may occlude others are back-facing ones of closed meshes, and all of other meshes that the light is not in the
/// plane of. One that occludes another is not occluded itself. Polygons take part if they have no holes and are exactly
/// planar and strictly convex, as a whole. The method is Batagelo and Costa Júnior's (1999): an SVBSP grows front to back,
/// and a face that straddles a plane goes to both sides. The choice among the occluded faces gives silhouettes the fewest
/// edges, so they never gain any, unless [`OcclusionOptions::leave_out_all`] is set.
#[derive(Clone, Debug, PartialEq)]
pub struct OccludedFaces {
    light: Light,
    pub(crate) casters: Vec<OccludedOfCaster>,
    statistics: OcclusionStatistics,
}

/// The result for one caster, and the state of the caster that it holds for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OccludedOfCaster {
    pub(crate) version: Option<u64>,
    pub(crate) face_count: usize,
    /// Ascending.
    pub(crate) faces: Vec<u32>,
}

impl OccludedFaces {
    /// Finds the occluded faces. It takes no device and may run on a thread of its own. `progress` is called now and
    /// then with the number of faces tried and of all to try; [`ControlFlow::Break`] ends the search. A face counts in each
    /// cone of directions that it is in. The first number never becomes smaller, and the second stays the same. Range and
    /// cone of the light have no effect.
    ///
    /// # Errors
    /// [`CpuError`] for a light that shadows refuse, missing positions, or if `progress` ends it.
    pub fn find(
        light: Light,
        casters: &[OcclusionCaster<'_>],
        options: OcclusionOptions,
        mut progress: impl FnMut(usize, usize) -> ControlFlow<()>,
    ) -> Result<Self, CpuError> {
        check_shadow_lights(&[light], 1)?;
        let participants = Participants::of(casters, light)?;
        let faces = &participants.faces;
        let cones = cones(faces, order(faces, light), light);
        let total = total(&cones);
        let searched = search(faces, light, options, &cones, &mut progress).ok_or(CpuError::Cancelled)?;
        let mut statistics = OcclusionStatistics {
            tried: participants.tried,
            undecided: searched.undecided,
            without_room: searched.without_room,
            nodes: searched.nodes,
            ..Default::default()
        };
        let mut of_casters = participants.occluded(casters, searched.staying);
        for ((caster, facing), of_caster) in casters.iter().zip(&participants.facing).zip(&mut of_casters) {
            if progress(total, total).is_break() {
                return Err(CpuError::Cancelled);
            }
            of_caster.faces = whole(caster.mesh, std::mem::take(&mut of_caster.faces));
            statistics.occluded += of_caster.faces.len();
            let silhouette = Silhouette { mesh: caster.mesh, facing };
            statistics.sides += silhouette.sides(&[]);
            if !options.leave_out_all {
                of_caster.faces = silhouette.shortest(&of_caster.faces);
            }
            statistics.left_out += of_caster.faces.len();
            statistics.sides_left += silhouette.sides(&of_caster.faces);
        }
        Ok(Self { light, casters: of_casters, statistics })
    }

    /// The light.
    pub fn light(&self) -> Light {
        self.light
    }

    /// The occluded faces of a caster that are left out, by its number in the list that was given. They are ascending
    /// numbers below [`Mesh::face_count`]: in a mesh with polygons those of polygons, else indices in [`Mesh::faces`].
    pub fn faces(&self, caster: usize) -> &[u32] {
        self.casters.get(caster).map_or(&[], |of_caster| &of_caster.faces)
    }

    /// Counts of the search.
    pub fn statistics(&self) -> OcclusionStatistics {
        self.statistics
    }
}

/// The faces of all casters that are searched. A polygon is searched as a fan of triangles.
#[derive(Default)]
struct Participants {
    faces: Vec<Face>,
    /// For each of `faces` the caster, and the face's index in its mesh.
    owners: Vec<(usize, u32)>,
    /// For each caster which faces of its mesh are front-facing. Faces that are not searched, or in a plane with the light,
    /// count as back-facing.
    facing: Vec<Vec<bool>>,
    /// How many faces are searched. A polygon counts once.
    tried: usize,
}

impl Participants {
    fn of(casters: &[OcclusionCaster<'_>], light: Light) -> Result<Self, CpuError> {
        let mut all = Self::default();
        for (number, caster) in casters.iter().enumerate() {
            let needed = caster.mesh.vertex_count();
            if caster.positions.len() < needed as usize {
                let given = caster.positions.len();
                return Err(CpuError::TooFewCasterPositions { caster: number, given, needed });
            }
            let participants = participants(caster, light);
            let mut is_facing = vec![false; caster.mesh.face_count()];
            for (number, face) in &participants {
                if let Some(is_facing) = is_facing.get_mut(*number as usize) {
                    *is_facing = face.side > 0;
                }
            }
            all.facing.push(is_facing);
            all.owners.extend(participants.iter().map(|&(face, _)| (number, face)));
            all.tried += participants.chunk_by(|(before, _), (face, _)| before == face).count();
            all.faces.extend(participants.into_iter().map(|(_, face)| face));
        }
        Ok(all)
    }

    /// For each caster the faces that are not `staying`, whose indices are ascending. A polygon is there once for each of its
    /// occluded triangles.
    fn occluded(&self, casters: &[OcclusionCaster<'_>], staying: Vec<usize>) -> Vec<OccludedOfCaster> {
        let of_caster = |caster: &OcclusionCaster<'_>| OccludedOfCaster {
            version: caster.version,
            face_count: caster.mesh.face_count(),
            faces: Vec::new(),
        };
        let mut of_casters: Vec<_> = casters.iter().map(of_caster).collect();
        let mut staying = staying.into_iter().peekable();
        for (index, &(caster, face)) in self.owners.iter().enumerate() {
            if staying.next_if_eq(&index).is_none()
                && let Some(of_caster) = of_casters.get_mut(caster)
            {
                of_caster.faces.push(face);
            }
        }
        of_casters
    }
}

/// The faces of a caster that are searched, with their indices, ascending. A polygon is searched as a fan of triangles.
fn participants(caster: &OcclusionCaster<'_>, light: Light) -> Vec<(u32, Face)> {
    let is_closed = caster.mesh.is_closed();
    let may_occlude = |side: i32| side < 0 || (side > 0 && !is_closed);
    let face = |corners: [[f32; 3]; 3], side: i32| Face { corners, side, may_occlude: may_occlude(side) };
    let triangle = |(number, of): (u32, &[u32; 3])| {
        let corners = of.map(|vertex| position(caster.positions, vertex));
        if is_degenerate(*of) || !corners.into_iter().all(is_finite) {
            return None;
        }
        let [a, b, c] = corners;
        let side = exact_facing(a, b, c, light.to_array());
        Some((number, face(corners, side)))
    };
    let Some(polygons) = caster.mesh.polygons() else {
        return (0_u32..).zip(caster.mesh.faces()).filter_map(triangle).collect();
    };
    let mut participants = Vec::new();
    for number in 0..polygons.len() {
        let Some(corners) = single_loop(polygons, number) else { continue };
        let corners: Vec<[f32; 3]> = corners.iter().map(|&vertex| position(caster.positions, vertex)).collect();
        let side = planar_and_convex(&corners, light);
        if let (Some(&first), true) = (corners.first(), side != 0) {
            let fan = corners.windows(2).skip(1).take(corners.len() - 2);
            participants.extend(fan.map(|pair| (number as u32, face([first, pair[0], pair[1]], side))));
        }
    }
    participants
}

/// The corners of a polygon without holes.
fn single_loop(polygons: &Polygons, number: usize) -> Option<&[u32]> {
    let mut loops = polygons.loops(number);
    loops.next().filter(|_| loops.len() == 0)
}

/// The side of its plane that the light is on, if the polygon lies in a plane exactly and is strictly convex. Otherwise 0.
fn planar_and_convex(corners: &[[f32; 3]], light: Light) -> i32 {
    let [a, b, c, rest @ ..] = corners else { return 0 };
    let is_finite = corners.iter().copied().all(is_finite);
    if is_finite && rest.iter().all(|&[x, y, z]| exact_facing(*a, *b, *c, [x, y, z, 1.0]) == 0) {
        convex(corners, light.to_array())
    } else {
        0
    }
}

/// The faces all of whose triangles are occluded, ascending.
fn whole(mesh: &Mesh, mut occluded: Vec<u32>) -> Vec<u32> {
    occluded.sort_unstable();
    let Some(polygons) = mesh.polygons() else { return occluded };
    let triangles = |face: u32| single_loop(polygons, face as usize).map_or(0, <[u32]>::len).saturating_sub(2);
    let faces = occluded.chunk_by(|before, face| before == face);
    faces.filter_map(|of| of.first().copied().filter(|&face| of.len() == triangles(face))).collect()
}
