//! Depth maps that cast in a scene, beside its meshes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use slotmap::{DefaultKey, SlotMap};

use super::cast::Cast;
use super::caster::{
    DepthMapCaster, DepthMapCasterCounts, DepthMapCasterHandle, DepthMapCasterVolumes, DepthMapCastersOptions,
    DepthMapCubeCaster,
};
use super::casters_errors::DepthMapCastersError;
use super::casters_frame::{DepthMapCastersFrame, DrawnCaster};
use super::convex::Convex;
use super::cube::DepthMapCube;
use super::frame::DepthMapNearCap;
use super::recording::Planned;
use super::volumes::DepthMapVolumes;
use crate::gpu::common::requirements::{check_alive, check_same, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::scene::handles::{LightHandle, SceneId};
use crate::gpu::{Scene, SceneFrame};
use crate::{Light, ShadowCamera};

#[derive(Debug)]
struct Entry {
    cast: Cast,
    kept: Option<Kept>,
}

/// The cells of an encode before.
#[derive(Debug)]
struct Kept {
    version: u64,
    /// The encoder was dropped, so there are none.
    is_lost: Arc<AtomicBool>,
}

/// Goes with the commands of an encoder: it is dropped with them, or told of their submission.
struct Submission {
    is_lost: Arc<AtomicBool>,
    is_submitted: bool,
}

impl Submission {
    fn submitted(mut self) {
        self.is_submitted = true;
    }
}

impl Drop for Submission {
    fn drop(&mut self) {
        if !self.is_submitted {
            self.is_lost.store(true, Ordering::Relaxed);
        }
    }
}

/// Casters of a [`Scene`] that have no mesh: depth maps of its lights, one or six around it. They are encoded after the scene and
/// drawn beside its frame, into the same stencil. So parities of maps have bits above those that counts of meshes own
/// ([`SceneOptions::count_bits`](crate::gpu::SceneOptions::count_bits)).
///
/// The cells of a map that did not change are kept, and maps are skipped that cannot darken what is seen. All of this is decided
/// on the CPU, from cameras and lights.
///
/// ```no_run
/// use rimline::gpu::{DepthMapCaster, DepthMapCasters, DepthMapCastersOptions, DepthMapOptions, DepthMapVolumes};
/// # use rimline::gpu::{DepthMapPipelines, LightHandle, Scene, ScenePipelines};
/// # use rimline::{ShadowCamera, wgpu};
///
/// # fn shadows(
/// #     (counting, parity): (&ScenePipelines, &DepthMapPipelines),
/// #     encoder: &mut wgpu::CommandEncoder,
/// #     (scene, light): (&mut Scene, LightHandle),
/// #     (depth, at_light, version): (wgpu::TextureView, ShadowCamera, u64),
/// #     camera: ShadowCamera,
/// #     mut light_pass: impl FnMut(LightHandle) -> wgpu::RenderPass<'static>,
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// // `counting` and the scene have a `count_bits` of 7, and `parity` draws into bit 7. Once, for a map of a light of the scene:
/// let mut maps = DepthMapCasters::new(scene, DepthMapCastersOptions::default());
/// let volumes = DepthMapVolumes::new(parity, [512, 512], DepthMapOptions::default())?;
/// let caster = DepthMapCaster { light, texture: depth, objects: None, camera: at_light, version: Some(version) };
/// let tree = maps.insert(volumes, caster)?;
/// // When it was drawn again:
/// maps.set_version(tree, Some(version + 1))?;
/// // Every frame:
/// let meshes = scene.encode(encoder, &[camera], None)?;
/// let mapped = maps.encode(encoder, &meshes, &[camera], None)?;
/// // For each light, in its pass:
/// let mut pass = light_pass(light);
/// meshes.draw(&mut pass, counting, 0, light)?;
/// mapped.draw(&mut pass, parity, 0, light)?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct DepthMapCasters {
    id: SceneId,
    scene: SceneId,
    device: wgpu::Device,
    options: DepthMapCastersOptions,
    casters: SlotMap<DefaultKey, Entry>,
}

impl DepthMapCasters {
    /// None, for the lights of a scene.
    pub fn new(scene: &Scene, options: DepthMapCastersOptions) -> Self {
        let device = scene.pipelines.device().clone();
        Self { id: SceneId::next(), scene: scene.id, device, options, casters: SlotMap::new() }
    }

    /// Adds a map, whose cells the volumes have room for.
    ///
    /// # Errors
    /// [`DepthMapCastersError`] if a texture does not fit the volumes, the light is of another scene, or the volumes are of
    /// another device.
    pub fn insert(
        &mut self,
        volumes: DepthMapVolumes,
        caster: DepthMapCaster,
    ) -> Result<DepthMapCasterHandle, DepthMapCastersError> {
        self.insert_cast(Cast::Map(Box::new(volumes), Box::new(caster)))
    }

    /// Adds six maps around a light. Their volumes take the cameras of `caster`.
    ///
    /// # Errors
    /// [`DepthMapCastersError`], as for [`Self::insert`], or if the maps of the cameras do not meet.
    pub fn insert_cube(
        &mut self,
        cube: DepthMapCube,
        caster: DepthMapCubeCaster,
    ) -> Result<DepthMapCasterHandle, DepthMapCastersError> {
        self.insert_cast(Cast::Cube(Box::new(cube), Box::new(caster)))
    }

    fn insert_cast(&mut self, mut cast: Cast) -> Result<DepthMapCasterHandle, DepthMapCastersError> {
        check_same(["the volumes", "the scene"], [cast.device(), &self.device])?;
        self.check_light(cast.light())?;
        cast.begin()?;
        let key = self.casters.insert(Entry { cast, kept: None });
        Ok(DepthMapCasterHandle { casters: self.id, key })
    }

    /// Changes what one map casts. The handle stays. Cells are kept if nothing but the light differs.
    ///
    /// # Errors
    /// [`DepthMapCastersError`], as for [`Self::insert`], or of the handle. The caster stays as it was then.
    pub fn set(&mut self, handle: DepthMapCasterHandle, caster: DepthMapCaster) -> Result<(), DepthMapCastersError> {
        self.change(handle, caster.light, |cast| cast.set_map(caster))
    }

    /// Changes what six maps cast, as [`Self::set`] does.
    ///
    /// # Errors
    /// [`DepthMapCastersError`], as for [`Self::insert_cube`], or of the handle. The caster stays as it was then.
    pub fn set_cube(
        &mut self,
        handle: DepthMapCasterHandle,
        caster: DepthMapCubeCaster,
    ) -> Result<(), DepthMapCastersError> {
        self.change(handle, caster.light, |cast| cast.set_cube(caster))
    }

    fn change(
        &mut self,
        handle: DepthMapCasterHandle,
        light: LightHandle,
        change: impl FnOnce(&mut Cast) -> Result<bool, DepthMapCastersError>,
    ) -> Result<(), DepthMapCastersError> {
        let key = self.key(handle)?;
        self.check_light(light)?;
        let entry = self.casters.get_mut(key).ok_or(DepthMapCastersError::Stale)?;
        if !change(&mut entry.cast)? {
            entry.kept = None;
        }
        Ok(())
    }

    /// Says which version of a map is in its textures ([`DepthMapCaster::version`]).
    ///
    /// # Errors
    /// [`DepthMapCastersError`] of the handle.
    pub fn set_version(
        &mut self,
        handle: DepthMapCasterHandle,
        version: Option<u64>,
    ) -> Result<(), DepthMapCastersError> {
        let key = self.key(handle)?;
        self.casters.get_mut(key).ok_or(DepthMapCastersError::Stale)?.cast.set_version(version);
        Ok(())
    }

    /// Removes a caster. Its volumes may be given to another.
    ///
    /// # Errors
    /// [`DepthMapCastersError`] of the handle.
    pub fn remove(&mut self, handle: DepthMapCasterHandle) -> Result<DepthMapCasterVolumes, DepthMapCastersError> {
        let key = self.key(handle)?;
        self.casters.remove(key).map(|entry| entry.cast.into_volumes()).ok_or(DepthMapCastersError::Stale)
    }

    /// Records what finds the cells of maps that are not kept or skipped. `frame` is the scene's, with the lights of this encode.
    /// `cameras` are the views that volumes are drawn for. `timer` takes the time of each stage. What was encoded before can be
    /// drawn as long as its cells are kept.
    ///
    /// **Submit encoders in the order of their encodes**: cells that are kept were found by the commands of an encode before. If
    /// its encoder was dropped before this call, they are found again.
    ///
    /// # Errors
    /// [`DepthMapCastersError`] if a camera is refused, a texture cannot be read, or the frame is of another scene. Nothing is
    /// recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &SceneFrame,
        cameras: &[ShadowCamera],
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapCastersFrame, DepthMapCastersError> {
        self.encode_for(encoder, frame, cameras, &[], timer)
    }

    /// As [`Self::encode`], with boxes for the first cameras: all that receives shadows is in them, by their lowest and highest
    /// corners in world space. Shadows of maps may be missing outside.
    ///
    /// # Errors
    /// As [`Self::encode`], and [`DepthMapCastersError::Bounds`] or [`DepthMapCastersError::TooManyBounds`].
    pub fn encode_for(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &SceneFrame,
        cameras: &[ShadowCamera],
        receivers: &[Option<[[f32; 3]; 2]>],
        mut timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapCastersFrame, DepthMapCastersError> {
        check_timer(timer.as_deref(), &self.device)?;
        check_alive(&self.device)?;
        if frame.scene != self.scene {
            return Err(DepthMapCastersError::OtherScene { what: "frame" });
        }
        let seen = self.seen(cameras, receivers)?;
        let mut counts = DepthMapCasterCounts::default();
        let mut plans = Vec::new();
        for (key, entry) in &self.casters {
            let light = frame.lights.iter().find(|(handle, _)| *handle == entry.cast.light());
            let handle = DepthMapCasterHandle { casters: self.id, key };
            let planned = self.plan(entry, light.map(|(_, light)| light), (cameras, &seen), &mut counts);
            let refused = |(view, error)| {
                let light = entry.cast.light();
                DepthMapCastersError::Map { caster: handle, light, view, error }
            };
            let (plan, views) = planned.map_err(refused)?;
            plans.push((handle, plan, views));
        }
        let mut drawn = Vec::with_capacity(plans.len());
        let mut found = Vec::new();
        for (handle, plan, views) in plans {
            let light = self.casters.get(handle.key).map(|entry| entry.cast.light());
            if plan.as_ref().is_some_and(Planned::is_listed_anew) {
                found.push(handle.key);
            }
            let frames = plan.map_or_else(Vec::new, |plan| plan.record(encoder, timer.as_deref_mut()));
            let frames = views.into_iter().zip(frames).collect();
            drawn.extend(light.map(|light| DrawnCaster { handle, light, frames }));
        }
        for key in found {
            if let Some(entry) = self.casters.get_mut(key) {
                entry.kept = entry.cast.version().map(|version| Kept::of(encoder, version));
            }
        }
        Ok(DepthMapCastersFrame {
            device: self.device.clone(),
            casters: self.id,
            scene: self.scene,
            lights: Arc::clone(&frame.lights),
            views: cameras.len(),
            count_bits: frame.views.first().map(|convention| convention.count_bits),
            drawn,
            counts,
        })
    }

    /// What each camera sees, and the box of what receives.
    fn seen(
        &self,
        cameras: &[ShadowCamera],
        receivers: &[Option<[[f32; 3]; 2]>],
    ) -> Result<Vec<Vec<Convex>>, DepthMapCastersError> {
        let (given, views) = (receivers.len(), cameras.len());
        if given > views {
            return Err(DepthMapCastersError::TooManyBounds { given, views });
        }
        let boxes = receivers.iter().copied().chain(std::iter::repeat(None));
        let of_view = |view: usize, camera: &ShadowCamera, bounds: Option<[[f32; 3]; 2]>| {
            camera.check_any_hand().map_err(|error| DepthMapCastersError::Camera { view, error })?;
            let mut seen = Vec::new();
            if self.options.skip_unseen {
                seen.push(Convex::frustum(camera, [0.0; 2]));
            }
            if let Some([low, high]) = bounds {
                if !low.iter().zip(high).all(|(low, high)| low.is_finite() && high.is_finite() && *low <= high) {
                    return Err(DepthMapCastersError::Bounds { view, low, high });
                }
                if self.options.skip_hidden {
                    seen.push(Convex::cuboid([low, high]));
                }
            }
            Ok(seen)
        };
        cameras.iter().zip(boxes).enumerate().map(|(view, (camera, bounds))| of_view(view, camera, bounds)).collect()
    }

    /// Binds what a caster needs, and the numbers of the cameras that draw it. All is checked, even if it is skipped.
    fn plan<'a>(
        &self,
        Entry { cast, kept }: &'a Entry,
        light: Option<&Light>,
        (cameras, seen): (&'a [ShadowCamera], &[Vec<Convex>]),
        counts: &mut DepthMapCasterCounts,
    ) -> Result<(Option<Planned<'a>>, Vec<usize>), (usize, super::frame_errors::DepthMapEncodeError)> {
        let eyes = cast.eyes(cameras)?;
        let shadow = cast.shadow();
        let is_unlit = light.is_none();
        let lit = light.filter(|_| self.options.skip_unreached);
        let is_unreached = lit.is_some_and(|light| shadow.iter().all(|part| part.is_unlit(light)));
        let is_apart = |seen: &Convex| {
            lit.is_some_and(|light| seen.is_unlit(light)) || shadow.iter().all(|part| part.is_apart(seen))
        };
        let is_drawn =
            |view: usize| !is_unlit && !is_unreached && seen.get(view).is_some_and(|seen| !seen.iter().any(is_apart));
        let views: Vec<_> = (0..eyes.len()).filter(|&view| is_drawn(view)).collect();
        let Some(&first) = views.first() else {
            counts.skipped += 1;
            counts.unlit += u32::from(is_unlit);
            counts.unreached += u32::from(is_unreached);
            return Ok((None, views));
        };
        let is_kept = self.options.keep_cells && kept.as_ref().is_some_and(|kept| kept.is_of(cast.version()));
        let eyes: Vec<_> = eyes.into_iter().enumerate().filter(|(view, _)| views.contains(view)).collect();
        let eyes: Vec<_> = eyes.into_iter().map(|(_, eye)| eye).collect();
        let plan = cast.plan(&eyes, !is_kept).map_err(|error| (first, error))?;
        counts.encoded += u32::from(!is_kept);
        counts.kept += u32::from(is_kept);
        counts.draws += views.len() as u32;
        for near_cap in plan.near_caps() {
            counts.near_caps_lit += u32::from(*near_cap == DepthMapNearCap::Lit);
            counts.near_caps_told += u32::from(matches!(near_cap, DepthMapNearCap::Told(_)));
        }
        Ok((Some(plan), views))
    }

    fn check_light(&self, light: LightHandle) -> Result<(), DepthMapCastersError> {
        if light.scene == self.scene { Ok(()) } else { Err(DepthMapCastersError::OtherScene { what: "light" }) }
    }

    fn key(&self, handle: DepthMapCasterHandle) -> Result<DefaultKey, DepthMapCastersError> {
        if handle.casters == self.id {
            Ok(handle.key)
        } else {
            Err(DepthMapCastersError::OtherScene { what: "caster" })
        }
    }
}

impl Kept {
    /// The cells that the commands of an encoder find.
    fn of(encoder: &wgpu::CommandEncoder, version: u64) -> Self {
        let is_lost = Arc::<AtomicBool>::default();
        let submission = Submission { is_lost: Arc::clone(&is_lost), is_submitted: false };
        encoder.on_submitted_work_done(move || submission.submitted());
        Self { version, is_lost }
    }

    fn is_of(&self, version: Option<u64>) -> bool {
        version == Some(self.version) && !self.is_lost.load(Ordering::Relaxed)
    }
}
