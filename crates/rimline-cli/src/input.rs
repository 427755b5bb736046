//! The model file, whatever its format, and the mesh it makes at one posed.

use std::borrow::Cow;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use rimline::gltf::{GltfError, SceneCamera, SceneLight};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::light::check_lights;
use rimline::mesh::Weld;
use rimline::{InstancePose, Light, LightError, MAX_LIGHTS, Mesh, MeshError, Model, ModelError, Pose};
pub(crate) use rimline_files::resting;
use rimline_files::{File, FileError, Polygons, ReadOptions, read_bytes};
use rimline_picture::corner_colors;

use crate::failure::{Failure, InputError, UsageError};
use crate::input_args::{CameraArgs, ModelArgs, PlacedView, ViewArgs};
use crate::output::note;
use crate::report::Times;
use crate::shown::listed;
use crate::source;
use crate::spec::LightSpec;

pub(crate) struct Input {
    pub(crate) file: PathBuf,
    pub(crate) content: File,
}

impl Deref for Input {
    type Target = File;

    fn deref(&self) -> &File {
        &self.content
    }
}

pub(crate) struct ChosenLight {
    pub(crate) light: Light,
    /// The light in the file, if it comes from the file.
    pub(crate) of_file: Option<SceneLight>,
}

/// The input at one posed.
pub(crate) struct Scene<'a> {
    pub(crate) mesh: Mesh,
    pub(crate) shape: Shape<'a>,
}

pub(crate) enum Shape<'a> {
    /// World-space positions, used bit for bit.
    World(&'a [[f32; 3]]),
    /// A model that is yet to be deformed.
    Posed { model: &'a Model, pose: Pose },
}

impl<'a> Shape<'a> {
    pub(crate) fn on_cpu(&self, times: &mut Times) -> Result<Cow<'a, [[f32; 3]]>, Failure> {
        match self {
            Self::World(positions) => Ok(Cow::Borrowed(positions)),
            Self::Posed { model, pose } => {
                let deformed = times.measure("deform", || cpu::deform(model, pose, 0.0, None, Threads::all()));
                Ok(Cow::Owned(deformed?))
            }
        }
    }
}

impl Input {
    pub(crate) fn open(args: &ModelArgs) -> Result<Self, Failure> {
        Self::read(&args.file, args.options(), args.polygons.taken())
    }

    pub(crate) fn read(file: &Path, options: ReadOptions, polygons: Polygons) -> Result<Self, Failure> {
        let options = ReadOptions { polygons, ..options };
        let content = if source::is_stdin(file) {
            source::read(file).map_err(FileError::from).and_then(|bytes| read_bytes(&bytes, None, &options))
        } else {
            rimline_files::read(file, &options)
        };
        let input =
            Self { file: file.to_owned(), content: content.map_err(|error| Failure::input(file)(error.into()))? };
        input.note_warnings();
        input.warn(input.non_finite());
        if let Weld::Distance(distance) = options.weld {
            input.warn(input.wide_groups(distance));
        }
        Ok(input)
    }

    fn warn(&self, warning: Option<String>) {
        if let Some(warning) = warning {
            note(&format!("warning: {}: {warning}", self.file.display()));
        }
    }

    /// Prints the warnings about contents that the reader of glTF skips or changes.
    fn note_warnings(&self) {
        const SHOWN: usize = 20;
        self.warnings().take(SHOWN).for_each(|warning| self.warn(Some(warning.to_string())));
        let more = self.warnings().count().saturating_sub(SHOWN);
        self.warn((more > 0).then(|| format!("{more} more warnings; `rimline info --json` lists them")));
    }

    /// The file, and those that it names, textures included.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&*self.file).chain(self.named_files().iter().map(PathBuf::as_path))
    }

    /// Why there is no pose: the file is damaged, or the command line asks for what cannot be.
    pub(crate) fn not_posed(&self, error: GltfError) -> Failure {
        match error {
            GltfError::SameProperty { .. } => UsageError::Together { file: self.file.clone(), error }.into(),
            error => self.failed(FileError::Gltf(error)),
        }
    }

    /// The same, where something else may be wrong.
    pub(crate) fn failed(&self, error: FileError) -> Failure {
        match error {
            FileError::Gltf(error @ GltfError::SameProperty { .. }) => self.not_posed(error),
            error => Failure::input(&self.file)(error.into()),
        }
    }

    /// The mesh and its shape at one posed. `displaced` shapes always come as a model, so that `displace` can run.
    pub(crate) fn scene(&self, animations: &[usize], time_s: f32, displaced: bool) -> Result<Scene<'_>, Failure> {
        let shape = self.shape(animations, time_s, displaced)?;
        Ok(Scene { mesh: self.mesh(&shape)?, shape })
    }

    /// The shape at one posed, without a mesh of all instances.
    pub(crate) fn shape(&self, animations: &[usize], time_s: f32, displaced: bool) -> Result<Shape<'_>, Failure> {
        match self.world_positions() {
            Some(_) if displaced && self.polygons().is_some() => {
                Err(Failure::input(&self.file)(InputError::PolygonsDisplaced))
            }
            Some(positions) if !displaced => Ok(Shape::World(positions)),
            _ => {
                let pose = self.pose(animations, time_s).map_err(|error| self.failed(error))?;
                Ok(Shape::Posed { model: self.model(), pose })
            }
        }
    }

    /// Whether the faces of each instance are turned.
    pub(crate) fn turned(&self, shape: &Shape<'_>) -> impl Iterator<Item = bool> {
        let pose = match shape {
            Shape::World(_) => None,
            Shape::Posed { pose, .. } => Some(pose.instances()),
        };
        let is_turned =
            move |instance: usize| pose.and_then(|pose| pose.get(instance)).is_some_and(InstancePose::faces_turned);
        (0..self.model().instances().len()).map(is_turned)
    }

    /// The base colours of the corners of all instances, if the file has some.
    pub(crate) fn corner_colors(&self, shape: &Shape<'_>) -> Option<Vec<[u32; 3]>> {
        corner_colors(self.model(), self.turned(shape), |geometry| self.colors(geometry))
    }

    /// Tells the user why base colours are missing.
    pub(crate) fn note_colors(&self) {
        self.color_notes().iter().for_each(|note| self.warn(Some(note.clone())));
    }

    /// The mesh that all instances make.
    pub(crate) fn mesh(&self, shape: &Shape<'_>) -> Result<Mesh, Failure> {
        if let (Some(mesh), Shape::World(_)) = (self.polygons(), shape) {
            return Ok(Mesh::clone(mesh));
        }
        let mesh = match shape {
            Shape::Posed { model, pose } => model.mesh(pose).map_err(|error| match error {
                ModelError::Mesh(error) => self.no_mesh(error),
                error => error.into(),
            }),
            Shape::World(_) => resting().map_err(InputError::from).and_then(|pose| Ok(self.model().mesh(&pose)?)),
        };
        mesh.map_err(Failure::input(&self.file))
    }

    /// Why there is no mesh, in words for the whole file.
    pub(crate) fn no_mesh(&self, error: MeshError) -> InputError {
        match error {
            MeshError::NoFaces if self.asset().is_some() => InputError::EmptyScene,
            MeshError::NoFaces if self.polygons().is_some() => InputError::NoArea,
            error => error.into(),
        }
    }

    /// The view that is asked for, at a time.
    pub(crate) fn view(&self, args: &ViewArgs, animations: &[usize], time_s: f32) -> Result<PlacedView, Failure> {
        let camera = self.camera(&args.camera, animations, time_s)?;
        Ok(PlacedView { camera, ..args.relative_to(self.origin()) })
    }

    /// The camera of the file that is asked for, at a time.
    pub(crate) fn camera(
        &self,
        args: &CameraArgs,
        animations: &[usize],
        time_s: f32,
    ) -> Result<Option<SceneCamera>, Failure> {
        let Some(wanted) = args.wanted.as_deref() else { return Ok(None) };
        let file = || self.file.clone();
        let asset = self.asset().filter(|asset| !asset.camera_names().is_empty());
        let asset = asset.ok_or_else(|| UsageError::NoFileCameras { file: file() })?;
        let names = asset.camera_names();
        let numbered = || wanted.parse().ok().filter(|&index: &usize| index < names.len());
        let index = names.iter().position(|name| *name == Some(wanted)).or_else(numbered).ok_or_else(|| {
            let there = listed("camera", names.iter().copied());
            UsageError::FileCamera { file: file(), wanted: wanted.to_owned(), there }
        })?;
        let cameras = asset.each_camera(animations.iter().copied(), time_s).map_err(|error| self.not_posed(error))?;
        let camera = cameras.into_iter().nth(index).ok_or_else(|| UsageError::NoFileCameras { file: file() })?;
        camera.map(Some).map_err(|error| self.not_posed(error))
    }

    /// The lights asked for, in the order asked for, fit for an extraction.
    pub(crate) fn lights(&self, specs: &[LightSpec], animations: &[usize], time_s: f32) -> Result<Vec<Light>, Failure> {
        Ok(self.chosen_lights(specs, animations, time_s)?.into_iter().map(|chosen| chosen.light).collect())
    }

    /// The same, with what the file says of its own.
    pub(crate) fn chosen_lights(
        &self,
        specs: &[LightSpec],
        animations: &[usize],
        time_s: f32,
    ) -> Result<Vec<ChosenLight>, Failure> {
        let file_lights = match self.asset() {
            Some(asset) if specs.iter().any(|spec| !matches!(spec, LightSpec::Given(_))) => {
                let lights = asset.each_light(animations.iter().copied(), time_s);
                let names = asset.light_names().into_iter().map(|name| name.map(str::to_owned));
                names.zip(lights.map_err(|error| self.not_posed(error))?).collect()
            }
            _ => Vec::new(),
        };
        let origin = self.origin();
        let of_file = |(_, file_light): &(Option<String>, Result<SceneLight, GltfError>)| match file_light {
            Ok(file_light) => Ok(ChosenLight { light: file_light.light, of_file: Some(file_light.clone()) }),
            Err(error) => Err(self.not_posed(error.clone())),
        };
        let mut chosen = Vec::with_capacity(specs.len());
        for spec in specs {
            match spec {
                LightSpec::Given(given) => chosen.push(ChosenLight { light: given.relative_to(origin), of_file: None }),
                LightSpec::All if file_lights.is_empty() => return Err(UsageError::NoFileLights.into()),
                LightSpec::All => {
                    for file_lights in &file_lights {
                        chosen.push(of_file(file_lights)?);
                    }
                }
                LightSpec::Named(wanted) => {
                    let named = file_lights.iter().find(|(name, _)| name.as_ref() == Some(wanted));
                    let numbered = || wanted.parse().ok().and_then(|index: usize| file_lights.get(index));
                    let missing = || UsageError::FileLight {
                        wanted: wanted.clone(),
                        there: listed("light", file_lights.iter().map(|(name, _)| name.as_deref())),
                    };
                    chosen.push(of_file(named.or_else(numbered).ok_or_else(missing)?)?);
                }
            }
        }
        let lights: Vec<Light> = chosen.iter().map(|chosen| chosen.light).collect();
        match check_lights(&lights, MAX_LIGHTS) {
            Ok(()) => Ok(chosen),
            Err(error @ (LightError::NoRoom | LightError::TooMany { .. })) => Err(UsageError::Lights(error).into()),
            // Lights of the command line were checked when they were parsed, so the file has the wrong one.
            Err(error) => Err(Failure::input(&self.file)(InputError::Lights(error))),
        }
    }
}
