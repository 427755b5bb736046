//! The model file, whatever its format, and the mesh it makes at one posed.

use std::borrow::Cow;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use rimline::gltf::{Asset, GltfError, GltfWarning, LoadOptions, SceneLight};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::light::check_lights;
use rimline::mesh::{Weld, WeldCounts, WeldDistance};
use rimline::{
    Geometry, GeometryOptions, Instance, InstancePose, Light, LightError, MAX_LIGHTS, Mesh, MeshError, Model,
    ModelError, Origin, Pose,
};

use crate::failure::{Failure, InputError, UsageError};
use crate::input_args::{ModelArgs, TakenPolygons};
use crate::output::note;
use crate::report::Times;
use crate::shown::listed;
use crate::source::{Begins, begins};
use crate::spec::LightSpec;
use crate::{npz, obj, source};

pub(crate) struct Input {
    pub(crate) file: PathBuf,
    pub(crate) source: Source,
    /// Origin of positions and lights: the file's own at first, the run's once the file has moved there.
    pub(crate) origin: Origin,
}

pub(crate) struct ChosenLight {
    pub(crate) light: Light,
    /// The light in the file, if it comes from the file.
    pub(crate) own: Option<SceneLight>,
}

pub(crate) enum Source {
    Gltf(Box<Asset>),
    /// World-space positions less the origin, welded: one geometry, one instance.
    World {
        model: Model,
        weld: WeldCounts,
        /// The mesh, if polygons are taken whole. The model has their triangles.
        polygons: Option<Box<Mesh>>,
        /// Polygons that are taken as triangles, as they are in the file, where a description is wanted.
        described: Option<Box<GivenPolygons>>,
    },
}

pub(crate) struct GivenPolygons {
    pub(crate) mesh: Mesh,
    pub(crate) positions: Vec<[f32; 3]>,
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

    pub(crate) fn read(file: &Path, options: LoadOptions, taken: TakenPolygons) -> Result<Self, Failure> {
        let (source, origin) = open(file, options, taken).map_err(Failure::input(file))?;
        let input = Self { file: file.to_owned(), source, origin };
        input.note_warnings();
        input.note_non_finite();
        if let Weld::Distance(distance) = options.weld {
            input.note_wide_groups(distance);
        }
        Ok(input)
    }

    /// A chain of vertices, each near the next, becomes one point.
    fn note_wide_groups(&self, distance: WeldDistance) {
        let counts = (0..self.model().geometries().len()).map(|geometry| self.weld_counts(geometry));
        let count = counts.map(|counts| counts.wide).sum::<usize>();
        if count > 0 {
            let (groups, are, theirs) =
                if count == 1 { ("group", "is", "it lies") } else { ("groups", "are", "they lie") };
            note(&format!(
                "warning: {}: {count} {groups} of vertices joined by --weld-distance {:e} {are} wider than 10 times that, since \
                 {theirs} in chains; each is one point now, so give a smaller distance if that is not meant",
                self.file.display(),
                distance.get()
            ));
        }
    }

    /// Prints the warnings about contents that the reader of glTF skips or changes.
    fn note_warnings(&self) {
        const SHOWN: usize = 20;
        let Source::Gltf(asset) = &self.source else { return };
        // Positions that are not finite are told for every format.
        let is_told = |warning: &&GltfWarning| !matches!(warning, GltfWarning::NonFinite { is_target: false, .. });
        let file = self.file.display();
        let warnings: Vec<&GltfWarning> = asset.warnings().iter().filter(is_told).collect();
        for warning in warnings.iter().take(SHOWN) {
            note(&format!("warning: {file}: {warning}"));
        }
        if warnings.len() > SHOWN {
            note(&format!(
                "warning: {file}: {} more warnings; `rimline info --json` lists them",
                warnings.len() - SHOWN
            ));
        }
    }

    /// Every subcommand takes positions that are infinite or NaN alike, so it is said where every one reads its model.
    fn note_non_finite(&self) {
        let is_finite = |position: &&[f32; 3]| position.iter().all(|c| c.is_finite());
        let positions = self.model().geometries().iter().flat_map(Geometry::positions);
        let count = positions.filter(|position| !is_finite(position)).count();
        if count > 0 {
            let (vertices, are, their) =
                if count == 1 { ("vertex", "is", "its") } else { ("vertices", "are", "their") };
            note(&format!(
                "warning: {}: {count} {vertices} {are} infinite or NaN; {their} faces face no light, cast no shadow and are \
                 not drawn",
                self.file.display()
            ));
        }
    }

    /// The file, and those that it names, textures included.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        let named = if let Source::Gltf(asset) = &self.source { asset.named_files() } else { &[] };
        std::iter::once(&*self.file).chain(named.iter().map(PathBuf::as_path))
    }

    pub(crate) fn model(&self) -> &Model {
        match &self.source {
            Source::Gltf(asset) => asset.model(),
            Source::World { model, .. } => model,
        }
    }

    /// Result of welding one of the model's geometries.
    pub(crate) fn weld_counts(&self, geometry: usize) -> WeldCounts {
        match &self.source {
            Source::Gltf(asset) => asset.weld_counts(geometry).unwrap_or_default(),
            Source::World { weld, .. } => *weld,
        }
    }

    /// Why there is no pose: the file is damaged, or the command line asks for what cannot be.
    pub(crate) fn not_posed(&self, error: GltfError) -> Failure {
        match error {
            GltfError::SameProperty { .. } => UsageError::Together { file: self.file.clone(), error }.into(),
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
        let pose = match &self.source {
            Source::Gltf(asset) => {
                return match asset.pose(animations.iter().copied(), time_s) {
                    Ok(pose) => Ok(Shape::Posed { model: asset.model(), pose }),
                    Err(error) => Err(self.not_posed(error)),
                };
            }
            Source::World { polygons: Some(_), .. } if displaced => Err(InputError::PolygonsDisplaced),
            Source::World { model, .. } if !displaced => return Ok(Shape::World(model.geometries()[0].positions())),
            Source::World { .. } => resting().map_err(InputError::from),
        };
        let pose = pose.map_err(Failure::input(&self.file))?;
        Ok(Shape::Posed { model: self.model(), pose })
    }

    /// The mesh, if the file has polygons that are taken whole.
    pub(crate) fn polygons(&self) -> Option<&Mesh> {
        let Source::World { polygons, .. } = &self.source else { return None };
        polygons.as_deref()
    }

    /// The polygons of a file that are taken as triangles, if they were to be described.
    pub(crate) fn described(&self) -> Option<&GivenPolygons> {
        let Source::World { described, .. } = &self.source else { return None };
        described.as_deref()
    }

    /// The mesh that all instances make.
    pub(crate) fn mesh(&self, shape: &Shape<'_>) -> Result<Mesh, Failure> {
        if let (Source::World { polygons: Some(mesh), .. }, Shape::World(_)) = (&self.source, shape) {
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
        match (&self.source, error) {
            (Source::Gltf(_), MeshError::NoFaces) => InputError::EmptyScene,
            (Source::World { polygons: Some(_), .. }, MeshError::NoFaces) => InputError::NoArea,
            (_, error) => error.into(),
        }
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
        let own = match &self.source {
            Source::Gltf(asset) if specs.iter().any(|spec| !matches!(spec, LightSpec::Given(_))) => {
                let lights = asset.each_light(animations.iter().copied(), time_s);
                let names = asset.light_names().into_iter().map(|name| name.map(str::to_owned));
                names.zip(lights.map_err(|error| self.not_posed(error))?).collect()
            }
            _ => Vec::new(),
        };
        let origin = self.origin;
        let of_file = |(_, own): &(Option<String>, Result<SceneLight, GltfError>)| match own {
            Ok(own) => Ok(ChosenLight { light: own.light, own: Some(own.clone()) }),
            Err(error) => Err(self.not_posed(error.clone())),
        };
        let mut chosen = Vec::with_capacity(specs.len());
        for spec in specs {
            match spec {
                LightSpec::Given(given) => chosen.push(ChosenLight { light: given.relative_to(origin), own: None }),
                LightSpec::All if own.is_empty() => return Err(UsageError::NoFileLights.into()),
                LightSpec::All => {
                    for own in &own {
                        chosen.push(of_file(own)?);
                    }
                }
                LightSpec::Named(wanted) => {
                    let named = own.iter().find(|(name, _)| name.as_ref() == Some(wanted));
                    let numbered = || wanted.parse().ok().and_then(|index: usize| own.get(index));
                    let missing = || UsageError::FileLight {
                        wanted: wanted.clone(),
                        there: listed("light", own.iter().map(|(name, _)| name.as_deref())),
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

/// Opens a file by how it begins, or, where that says nothing, by its ending.
fn open(file: &Path, options: LoadOptions, taken: TakenPolygons) -> Result<(Source, Origin), InputError> {
    if source::is_stdin(file) {
        return open_stdin(options, taken);
    }
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let mut reader = source::open(file)?;
    match (begins(&mut reader)?, ending.as_deref()) {
        (Begins::Archive, _) | (Begins::Unknown, Some("npz")) => open_npz(reader, options),
        (Begins::Glb, _) | (Begins::Json, Some("obj" | "npz")) => open_gltf(file, options),
        (Begins::Obj, Some("gltf" | "glb" | "npz")) | (_, Some("obj")) => {
            of_arrays(read_obj(BufReader::new(reader), options, taken)?, options, taken)
        }
        (_, Some("gltf" | "glb")) => open_gltf(file, options),
        // Any text may begin like an OBJ.
        (_, _) => {
            let what = ending.map_or_else(|| "a file of this format".to_owned(), |ending| format!(".{ending}"));
            Err(InputError::Format { what })
        }
    }
}

fn open_stdin(options: LoadOptions, taken: TakenPolygons) -> Result<(Source, Origin), InputError> {
    let bytes = source::read(Path::new("-"))?;
    match begins(&mut Cursor::new(&bytes))? {
        Begins::Archive => open_npz(Cursor::new(bytes), options),
        Begins::Glb | Begins::Json => {
            let asset = Asset::from_slice(&bytes, None, options);
            asset.map(of_asset).map_err(|error| of_gltf(Path::new("-"), error))
        }
        Begins::Obj => of_arrays(read_obj(&*bytes, options, taken)?, options, taken),
        Begins::Unknown => Err(InputError::Format { what: "a file of this format".to_owned() }),
    }
}

fn open_gltf(file: &Path, options: LoadOptions) -> Result<(Source, Origin), InputError> {
    Asset::open(file, options).map(of_asset).map_err(|error| of_gltf(file, error))
}

fn of_asset(asset: Asset) -> (Source, Origin) {
    (Source::Gltf(Box::new(asset)), Origin::ZERO)
}

/// Converts an error of a glTF, with advice for users of the command.
fn of_gltf(file: &Path, error: GltfError) -> InputError {
    match error {
        // The file is named already; only other files that it names need to be.
        GltfError::Read { path, source } if path == file => {
            InputError::Read(std::io::Error::new(source.kind(), source))
        }
        // The advice is to give the options of the command.
        GltfError::TooLarge { what, needed, limit } => {
            let is_whole = Path::new(&what) == file;
            InputError::TooLarge { what: if is_whole { "the file".into() } else { what }, needed, limit }
        }
        GltfError::Outside { json_path, uri, path } => InputError::Outside { place: json_path, uri, path },
        error => error.into(),
    }
}

fn read_obj(reader: impl BufRead, options: LoadOptions, taken: TakenPolygons) -> Result<npz::Arrays, InputError> {
    Ok(obj::read(reader, options.memory_limit, taken != TakenPolygons::Triangles)?)
}

fn open_npz(reader: impl Read + Seek, options: LoadOptions) -> Result<(Source, Origin), InputError> {
    of_arrays(npz::read(reader, options.memory_limit)?, options, TakenPolygons::Whole)
}

fn of_arrays(arrays: npz::Arrays, options: LoadOptions, taken: TakenPolygons) -> Result<(Source, Origin), InputError> {
    let npz::Arrays { positions, mut faces, polygons, origin } = arrays;
    let by_loop =
        |polygons: &npz::PolygonArrays| Mesh::from_polygons_by_loop(&positions, polygons.loops(), options.weld);
    let (mut described, mut collapsed) = (None, 0);
    match (polygons, taken) {
        (None, _) => {}
        (Some(polygons), TakenPolygons::Whole) => {
            let mesh = by_loop(&polygons)?;
            drop(polygons);
            let geometry = Geometry::new(positions, mesh.faces().to_vec(), GeometryOptions::default())?;
            let model = Model::new(vec![geometry], vec![Instance::new(0, None)])?;
            let (weld, polygons) = (mesh.weld_counts(), Some(Box::new(mesh)));
            return Ok((Source::World { model, weld, polygons, described }, origin));
        }
        (Some(polygons), taken) => {
            if taken == TakenPolygons::Described {
                described = Some(Box::new(GivenPolygons { mesh: by_loop(&polygons)?, positions: positions.clone() }));
            }
            let (triangles, counts) = polygons.loops().triangulate(&positions, options.weld)?;
            (faces, collapsed) = (triangles, counts.collapsed);
        }
    }
    let geometry = Geometry::new(positions, faces, GeometryOptions::default())?;
    let (geometry, mut weld) = geometry.welded(options.weld);
    weld.collapsed += collapsed;
    let model = Model::new(vec![geometry], vec![Instance::new(0, None)])?;
    Ok((Source::World { model, weld, polygons: None, described }, origin))
}

/// Everything where it is.
pub(crate) fn resting() -> Result<Pose, ModelError> {
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    Ok(Pose::new(vec![InstancePose::new(vec![identity], Vec::new())?]))
}
