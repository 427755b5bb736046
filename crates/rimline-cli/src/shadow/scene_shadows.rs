//! The casters of all files in one scene: a mesh for each geometry of a file, and a caster for each of its instances. A file
//! with polygons is one caster.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use rimline::cpu::OccludedFaces;
use rimline::gpu::{
    Capacities, Caster, CasterHandle, ExtractionStatistics, FrameInputs, LightHandle, MeshHandle, Scene, SceneFrame,
    SceneOptions, ShadowError, ShadowStatistics, StageTimer,
};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::{Counting, Light, wgpu};
use rimline_picture::FacingMasks;

use super::casting::{CastInputs, Extracted, Occlusion, PosedModel, Topology, VERSION, set_lights};
use super::layers::Layers;
use super::shadows::{Choice, Found, Shadows, VolumePipelines, each, scene_options};
use crate::device::{Gpu, GpuError, On as _};
use crate::failure::Failure;

pub(super) struct SceneShadows<'a> {
    gpu: &'a Gpu,
    scene: Scene,
    counting: Counting,
    /// Each light has the bit of its number.
    lights: Vec<LightHandle>,
    files: Vec<File>,
    frame: Option<SceneFrame>,
    max_lights: usize,
    /// If the bound of the stages leaves it open whether the stencil counts to what lies over each other.
    layers: Option<Layers>,
    /// Pieces of twisted polygons without room, in all encodes.
    lost_pieces: u32,
}

/// Meshes and casters of a file in the scene. Each file has its own buffer of positions, so no group of casters has those
/// of two files.
#[derive(Default)]
struct File {
    meshes: BTreeMap<Topology, MeshHandle>,
    casters: Vec<(Topology, CasterHandle)>,
    /// Triangles of polygons, which are drawn. A polygon may be front-facing to a light while one of its triangles is
    /// back-facing.
    surface: Option<Extracted>,
}

impl<'a> SceneShadows<'a> {
    pub(super) fn new(gpu: &'a Gpu, counting: Counting, max_lights: usize) -> Result<Self, GpuError> {
        let scene = Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions { max_lights, ..scene_options(counting) })?;
        Ok(Self {
            gpu,
            scene,
            counting,
            lights: Vec::new(),
            files: Vec::new(),
            frame: None,
            max_lights,
            layers: None,
            lost_pieces: 0,
        })
    }

    /// Encodes and submits, again with more room while the device finds that pieces of twisted polygons have none.
    fn encode_polygons(
        &mut self,
        inputs: &CastInputs<'_>,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<SceneFrame, GpuError> {
        let mut room = 0;
        loop {
            let mut encoder = self.gpu.encoder("polygons");
            let timer = timer.as_deref_mut();
            let frame = self
                .scene
                .encode(&mut encoder, FrameInputs { timer, ..FrameInputs::new(&[(*inputs.camera).into()]) })?;
            self.gpu.submit(encoder);
            let Some(statistics) = frame.shadow_statistics() else { return Ok(frame) };
            let ShadowStatistics { lost_pieces, most_pieces, .. } = self.gpu.read_first(statistics)?;
            if lost_pieces == 0 || most_pieces <= room {
                self.lost_pieces = self.lost_pieces.saturating_add(lost_pieces);
                return Ok(frame);
            }
            // Room for more than a binding holds is not made.
            room = most_pieces;
            self.scene.set_capacities(Capacities { pieces: Some(room), ..Capacities::default() });
        }
    }

    fn frame(&self) -> Result<&SceneFrame, ShadowError> {
        self.frame.as_ref().ok_or(ShadowError::NotEncoded)
    }
}

impl Shadows for SceneShadows<'_> {
    /// An instance that is mirrored anew has other faces, so another caster replaces it.
    fn set_bodies(&mut self, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        self.layers = None;
        let Self { gpu, scene, files, max_lights, .. } = self;
        files.resize_with(bodies.len(), File::default);
        for (File { meshes, casters, surface }, body) in files.iter_mut().zip(bodies) {
            if surface.is_none() {
                let triangles = body.triangles()?;
                *surface = triangles.map(|mesh| Extracted::new(gpu, &mesh, body, *max_lights)).transpose()?;
            }
            for (instance, &topology) in body.topologies.iter().enumerate() {
                let old = casters.get(instance).copied();
                if old.is_some_and(|(of, _)| of == topology) {
                    continue;
                }
                let mesh = match meshes.entry(topology) {
                    Entry::Occupied(mesh) => *mesh.get(),
                    Entry::Vacant(entry) => {
                        let rest = body.input.model().geometries()[topology.geometry].positions();
                        let mesh = if body.has_polygons() { body.mesh()? } else { body.mesh_of(topology)? };
                        *entry.insert(scene.add_mesh(&mesh, rest).on(gpu)?)
                    }
                };
                let Some(positions) = body.positions.of_instance(instance) else { break };
                let caster = scene.insert(Caster::in_buffer(mesh, positions)).on(gpu)?;
                match old {
                    None => casters.push((topology, caster)),
                    Some((_, old)) => {
                        scene.remove(old).on(gpu)?;
                        casters[instance] = (topology, caster);
                    }
                }
            }
        }
        Ok(())
    }

    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: CastInputs<'_>,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for (file, body) in self.files.iter_mut().zip(inputs.bodies) {
            if let Some(surface) = &mut file.surface {
                surface.encode(encoder, body, inputs.lights, timer.as_deref_mut())?;
            }
        }
        set_lights(&mut self.scene, &mut self.lights, inputs.lights)?;
        let frame = if inputs.bodies.iter().any(PosedModel::has_polygons) {
            self.encode_polygons(&inputs, timer)?
        } else {
            self.scene.encode(encoder, FrameInputs { timer, ..FrameInputs::new(&[(*inputs.camera).into()]) })?
        };
        self.frame = Some(frame);
        self.layers.as_mut().map_or(Ok(()), |layers| layers.encode(encoder, &inputs))
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &VolumePipelines, light: usize) -> Result<(), GpuError> {
        let VolumePipelines::Scene(plain, batches) = pipelines else { return Ok(()) };
        if let Some(layers) = &self.layers
            && layers.draw(pass, batches, light)?
        {
            return Ok(());
        }
        let handle = *self.lights.get(light).ok_or(ShadowError::NotEncoded)?;
        Ok(self.frame()?.draw(pass, plain, 0, handle)?)
    }

    fn facing(&self, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        let frame = self.frame()?;
        let of_file = |(File { casters, surface, .. }, body): (&File, &PosedModel<'_>)| match surface {
            Some(surface) => Ok(surface.facing(body)),
            None => Ok(FacingMasks::of_scene(frame, casters.iter().map(|&(_, caster)| caster))?),
        };
        self.files.iter().zip(bodies).map(of_file).collect()
    }

    fn found(&self) -> Result<Vec<Found>, GpuError> {
        let frame = self.frame()?;
        let results = frame.results()?;
        // For each batch of lights those of all casters. A bit stands for something that costs more, or for faces that
        // cast: so casters together have the bits of any.
        let chosen: Vec<u32> = results.choices.map_or(Ok(Vec::new()), |choices| self.gpu.read(choices))?;
        let casters: usize = self.files.iter().map(|file| file.casters.len()).sum();
        let (all, lights) = (self.statistics()?, self.lights.len());
        let of_file = |file: &File| {
            let mut groups = BTreeSet::new();
            let mut words = vec![0; CHOICE_WORDS * frame.batches()];
            for &(_, caster) in &file.casters {
                let (index, group) = frame.locate(caster).ok_or(ShadowError::Removed { what: "caster" })?;
                groups.insert(group);
                for (batch, sum) in words.chunks_exact_mut(CHOICE_WORDS).enumerate() {
                    let choice = chosen.iter().skip(CHOICE_WORDS * (batch * casters + index as usize));
                    sum.iter_mut().zip(choice).for_each(|(sum, word)| *sum |= word);
                }
            }
            let mut silhouettes = vec![0; lights];
            let mut extraction: ExtractionStatistics = bytemuck::Zeroable::zeroed();
            for group in results.groups.iter().filter(|of| groups.contains(&of.group)) {
                let counted = silhouettes.iter_mut().skip(32 * group.batch);
                counted.zip(first_words(self.gpu, group.lists, 32)?).for_each(|(sum, count)| *sum += count);
                let record = first_words(self.gpu, group.record, size_of::<ExtractionStatistics>() as u64 / 4)?;
                let record = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&record));
                extraction = each(extraction, record, u32::saturating_add);
            }
            let lights = Choice::all(self.counting, &words, lights);
            let count = |casting| lights.iter().filter(|light| light.casting == casting).count() as u32;
            let (skipped, every_face) = (count(Choice::NOTHING), count(Choice::EVERY));
            // The fourth word has the lights with near caps.
            let near_capped = words.iter().skip(3).step_by(CHOICE_WORDS).map(|word| word.count_ones()).sum();
            let shadow = ShadowStatistics { skipped, every_face, near_capped, ..all };
            Ok(Found { lights, silhouettes, extraction, shadow })
        };
        self.files.iter().map(of_file).collect()
    }

    fn statistics(&self) -> Result<ShadowStatistics, GpuError> {
        let buffer = self.frame().ok().and_then(SceneFrame::shadow_statistics);
        let mut found: ShadowStatistics =
            buffer.map_or(Ok(bytemuck::Zeroable::zeroed()), |buffer| self.gpu.read_first(buffer))?;
        found.lost_pieces = self.lost_pieces;
        if let Some(layers) = &self.layers {
            found.count_bound = found.count_bound.min(layers.most.unwrap_or(u32::MAX));
            found.may_wrap = 0;
        }
        Ok(found)
    }

    fn count_layers(&mut self, inputs: CastInputs<'_>, all: &[Light]) -> Result<(), Failure> {
        let (gpu, bodies) = (self.gpu, inputs.bodies);
        self.layers = None;
        let is_counted = self.counting != Counting::ZpPlus2005 && !bodies.iter().any(PosedModel::has_polygons);
        if !is_counted || self.statistics().on(gpu)?.may_wrap == 0 {
            return Ok(());
        }
        let Some(mut layers) = Layers::new(gpu, bodies, self.counting, self.max_lights, all)? else { return Ok(()) };
        let mut encoder = gpu.encoder("batches");
        layers.encode(&mut encoder, &inputs).on(gpu)?;
        gpu.submit(encoder);
        self.layers = Some(layers);
        Ok(())
    }

    fn leave_out(&mut self, occlusion: &Occlusion) -> Result<(), GpuError> {
        let lights: Vec<Light> = occlusion.found.iter().map(OccludedFaces::light).collect();
        set_lights(&mut self.scene, &mut self.lights, &lights)?;
        let casters: Vec<CasterHandle> =
            self.files.iter().flat_map(|file| file.casters.iter().map(|&(_, caster)| caster)).collect();
        for &caster in &casters {
            self.scene.set_position_version(caster, Some(VERSION))?;
        }
        for (&light, found) in self.lights.iter().zip(&occlusion.found) {
            self.scene.set_occluded_faces(light, &casters, Some(found))?;
        }
        Ok(())
    }

    fn left_out(&self) -> usize {
        self.frame().map_or(0, |frame| frame.occluded_faces().faces)
    }
}

/// The first words of a buffer whose rest is not needed.
fn first_words(gpu: &Gpu, buffer: &wgpu::Buffer, words: u64) -> Result<Vec<u32>, GpuError> {
    let copy = gpu.buffer("first words", 4 * words, wgpu::BufferUsages::COPY_SRC);
    let mut encoder = gpu.encoder("first words");
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, 4 * words);
    gpu.submit(encoder);
    Ok(gpu.read(&copy)?)
}
