//! The model file, whatever its format, and the mesh it makes at one moment.

use std::borrow::Cow;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use rimline::mesh::{Weld, WeldCounts};
use rimline::model::{Geometry, Instance, InstancePose};
use rimline::{Light, Mesh, Model, Pose};

use crate::args::{ModelArgs, PoseArgs};
use crate::failure::{Failure, InputError, UsageError};
use crate::npz;
use crate::spec::LightSpec;

/// A model file in memory.
pub(crate) enum Input {
    /// World-space positions, welded: one geometry, one instance.
    Npz { model: Model, weld: WeldCounts },
}

/// The input at one moment.
pub(crate) struct Scene<'a> {
    pub(crate) mesh: Mesh,
    pub(crate) shape: Shape<'a>,
}

/// Where the mesh's vertices are.
pub(crate) enum Shape<'a> {
    /// World-space positions, used bit for bit.
    World(&'a [[f32; 3]]),
    /// A model that is yet to be deformed.
    Posed { model: &'a Model, pose: Pose },
}

impl Input {
    pub(crate) fn open(args: &ModelArgs) -> Result<Self, Failure> {
        let file = args.file.as_path();
        match ending(file).as_deref() {
            Some("npz") => open_npz(file, args.weld()).map_err(Failure::input(file)),
            _ => Err(Failure::input(file)(InputError::Format)),
        }
    }

    pub(crate) fn model(&self) -> &Model {
        match self {
            Self::Npz { model, .. } => model,
        }
    }

    /// What welding did to each of the model's geometries.
    pub(crate) fn weld_counts(&self) -> Cow<'_, [WeldCounts]> {
        match self {
            Self::Npz { weld, .. } => Cow::Borrowed(std::slice::from_ref(weld)),
        }
    }

    /// The animation that `--animation` names, by its number.
    pub(crate) fn animation(&self, args: &PoseArgs) -> Result<Option<usize>, Failure> {
        let Some(wanted) = &args.animation else {
            return Ok(None);
        };
        match self {
            Self::Npz { .. } => Err(UsageError::Animation {
                wanted: wanted.clone(),
                there: "an .npz has none".into(),
            }
            .into()),
        }
    }

    /// The mesh and its shape at one moment. `displaced` shapes always come as a model, so that `displace` can run.
    pub(crate) fn scene(&self, animation: Option<usize>, time_s: f32, displaced: bool) -> Result<Scene<'_>, InputError> {
        let model = self.model();
        let shape = match self {
            Self::Npz { .. } if displaced => Shape::Posed {
                model,
                pose: resting(),
            },
            Self::Npz { model, .. } => Shape::World(&model.geometries[0].positions),
        };
        let mesh = match &shape {
            Shape::World(_) => model.mesh(&resting())?,
            Shape::Posed { pose, .. } => model.mesh(pose)?,
        };
        Ok(Scene { mesh, shape })
    }

    /// The lights asked for, in the order asked for.
    pub(crate) fn lights(
        &self,
        specs: &[LightSpec],
        animation: Option<usize>,
        time_s: f32,
    ) -> Result<Vec<Light>, Failure> {
        let mut lights = Vec::with_capacity(specs.len());
        let own: Vec<(Option<String>, Light)> = Vec::new();
        let names = || -> Vec<String> { own.iter().filter_map(|(name, _)| name.clone()).collect() };
        for spec in specs {
            match spec {
                LightSpec::Given(light) => lights.push(*light),
                LightSpec::All if own.is_empty() => return Err(UsageError::NoFileLights.into()),
                LightSpec::All => lights.extend(own.iter().map(|(_, light)| *light)),
                LightSpec::Named(wanted) => match own.iter().find(|(name, _)| name.as_ref() == Some(wanted)) {
                    Some((_, light)) => lights.push(*light),
                    None => {
                        return Err(UsageError::FileLight {
                            wanted: wanted.clone(),
                            there: names(),
                        }
                        .into());
                    }
                },
            }
        }
        Ok(lights)
    }
}

fn ending(file: &Path) -> Option<String> {
    Some(file.extension()?.to_string_lossy().to_lowercase())
}

fn open_npz(file: &Path, weld: Weld) -> Result<Input, InputError> {
    let arrays = npz::read(BufReader::with_capacity(1 << 18, File::open(file)?))?;
    let geometry = Geometry {
        source_vertices: (0..arrays.positions.len() as u32).collect(),
        positions: arrays.positions,
        faces: arrays.faces,
        ..Geometry::default()
    };
    let (geometry, weld) = geometry.welded(weld);
    let model = Model {
        geometries: vec![geometry],
        instances: vec![Instance {
            geometry: 0,
            name: None,
        }],
    };
    Ok(Input::Npz { model, weld })
}

/// Everything where it is.
fn resting() -> Pose {
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    Pose {
        instances: vec![InstancePose {
            palette: vec![identity],
            ..InstancePose::default()
        }],
        ..Pose::default()
    }
}
