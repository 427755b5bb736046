//! Making pipelines before the first frame.

use super::common::device_error::DeviceError;
use super::common::pipelines::{Pipelines, Program};
use super::common::requirements::Subject;
use super::extract::options::ExtractorOptions;
use super::extract::stages as extraction;
use super::scene::options::SceneOptions;
use super::scene::stages as scene;
use super::shadow::ShadowPipelines;
use super::shadow::pipelines::Part;
use super::shadow::stages as shadow;
use crate::stages::{NEEDS, RECEIVER_DEPTH, RECEIVER_PYRAMID, RECEIVER_SAMPLES};

/// A use that [`Pipelines::warm_up`] makes pipelines for. None covers the stages of polygons
/// ([`Mesh::from_polygons_by_loop`](crate::Mesh::from_polygons_by_loop)): their pipelines are made when first needed.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Use<'a> {
    /// [`Extractor::new`](crate::gpu::Extractor::new) with these options, for meshes of triangles whose arrays each fit one
    /// binding.
    Extraction(&'a ExtractorOptions),
    /// The encodes of a [`Scene`](crate::gpu::Scene) with these options, without cameras.
    Scene(&'a SceneOptions),
    /// The encodes of a [`Scene`](crate::gpu::Scene) with these options, with cameras. It includes [`Self::Scene`].
    SceneShadows(&'a SceneOptions),
    /// The pipelines that [`Receivers`](crate::gpu::Receivers) of this many samples a pixel add to [`Self::SceneShadows`].
    Receivers {
        /// The sample count of the depth attachment.
        samples: u32,
    },
    /// The pipelines that models without displacement ([`Scene::insert_model`](crate::gpu::Scene::insert_model)) add to an
    /// encode.
    SceneModels,
    /// The pipelines that [`SceneOptions::end_at_range`] adds to the draws of a scene. `ShadowPipelines::new` makes the
    /// others.
    EndedVolumes(&'a ShadowPipelines),
    /// The pipelines that casters which are not in the depth buffer ([`Caster::in_depth`](crate::gpu::Caster::in_depth)) add
    /// to the draws of a scene.
    Proxies(&'a ShadowPipelines),
}

impl Pipelines {
    /// Makes what is missing for these uses, on as many threads as the machine runs at the same time, and returns when all
    /// is made. A browser's device belongs to one thread, which makes all.
    ///
    /// Without this call, a constructor makes what it needs, and the first frame that needs something makes that. A
    /// [`Scene`](crate::gpu::Scene) makes pipelines at its first encode, and at the first with cameras, with
    /// [`Receivers`](crate::gpu::Receivers) or with a model. It makes more at the first draw whose volumes end or whose
    /// casters are not in the depth buffer. No frame makes what an earlier frame of the same scene and options had.
    ///
    /// On software Vulkan (llvmpipe, Mesa 22.3.6, two cores that were busy otherwise too) a scene's first encode with a
    /// camera took 0.6 s to make its 16 pipelines on one thread. Many drivers compile a shader when it first runs, even if
    /// its pipeline exists: another 3 s there, unless the driver finds all in its cache. An engine that cannot have that in
    /// its first frame also submits an encode with a small mesh beforehand.
    ///
    /// A pipeline that the device refuses is not cached. The constructor or frame that needs it then gives the error.
    ///
    /// ```no_run
    /// # use rimline::gpu::{DeviceError, Pipelines, SceneOptions, Use};
    /// # fn warm(device: &rimline::wgpu::Device) -> Result<Pipelines, DeviceError> {
    /// let pipelines = Pipelines::new(device);
    /// pipelines.warm_up(&[Use::SceneShadows(&SceneOptions::default()), Use::Receivers { samples: 1 }])?;
    /// # Ok(pipelines)
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`DeviceError`] if the device lacks what a use needs, or is lost.
    pub fn warm_up(&self, uses: &[Use<'_>]) -> Result<(), DeviceError> {
        let mut programs: Vec<Program> = Vec::new();
        for needed in uses {
            let is_extraction = matches!(needed, Use::Extraction(_) | Use::Scene(_));
            let subject = if is_extraction { Subject::Extract } else { Subject::Shadow };
            // Only the checks of the device: nothing is made here.
            self.construct(subject, || Ok::<_, DeviceError>(()))?;
            match *needed {
                Use::Extraction(options) => programs.extend(extraction::of_triangles(self.device(), options)),
                Use::Scene(_) => programs.extend(scene::programs()),
                Use::SceneShadows(options) => {
                    programs.extend(scene::programs());
                    // `false`: without the stages for pieces of twisted polygons.
                    programs.extend(shadow::programs(false, options));
                }
                Use::Receivers { samples } => {
                    let of_tiles = if samples == 1 { &RECEIVER_DEPTH } else { &RECEIVER_SAMPLES };
                    programs.extend([of_tiles, &RECEIVER_PYRAMID].map(|stage| Program::of(stage, &[])));
                }
                Use::SceneModels => programs.extend([Program::of(&NEEDS, &[]), Program::deform(None, None)]),
                // `of` makes the pipelines of a part if they are missing.
                Use::EndedVolumes(pipelines) => _ = pipelines.volumes.of(Part::Ends),
                Use::Proxies(pipelines) => _ = pipelines.volumes.of(Part::Proxies),
            }
        }
        self.make_together(&programs);
        Ok(())
    }
}
