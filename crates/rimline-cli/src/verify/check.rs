//! One file on each device.

use std::io::Cursor;
use std::path::Path;

use rimline::MAX_LIGHTS;
use rimline::gltf::LoadOptions;
use rimline::internals::light::check_lights;
use rimline::{Light, Mesh};

use crate::device::Device;
use crate::extract::{arrays, extract_exactly};
use crate::failure::{Failure, InputError};
use crate::input::{Scene, Shape};
use crate::npz::{self, Arrays, Difference};
use crate::source;

/// Contents of a file, and results of each device for it.
pub(super) struct Checked {
    pub(super) faces: usize,
    pub(super) edges: usize,
    pub(super) lights: usize,
    /// One a device; empty where its bytes are the file's.
    pub(super) results: Vec<Result<Vec<Difference>, Failure>>,
}

/// Finds everything again from positions, faces and lights, on each device, and compares the archives.
pub(super) fn file(file: &Path, devices: &[Device]) -> Result<Checked, Failure> {
    let failed = Failure::input(file);
    let given = source::read(file).map_err(|error| failed(error.into()))?;
    let (arrays, lights) = read(&given).map_err(&failed)?;
    let Arrays { positions, faces, polygons: _, origin } = arrays;
    let mesh = Mesh::from_faces(positions.len(), faces).map_err(|error| failed(error.into()))?;
    let scene = Scene { mesh, shape: Shape::World(&positions) };
    let (faces, edges) = (scene.mesh.faces().len(), scene.mesh.edges().len());
    let mut results = Vec::with_capacity(devices.len());
    for device in devices {
        let found = extract_exactly(device, &scene, &lights);
        let written = found.and_then(|found| {
            let mut bytes = Vec::with_capacity(given.len());
            let target = file.to_owned();
            arrays::write(Cursor::new(&mut bytes), &scene.mesh, &lights, &found, origin)
                .map_err(|source| Failure::Output { file: target, source })?;
            Ok(bytes)
        });
        results.push(match written {
            // An array that cannot be read is the file's fault on every device.
            Ok(written) => Ok(npz::compare(&given, &written).map_err(|error| failed(error.into()))?),
            Err(failure) => Err(failure),
        });
    }
    Ok(Checked { faces, edges, lights: lights.len(), results })
}

fn read(archive: &[u8]) -> Result<(Arrays, Vec<Light>), InputError> {
    let (arrays, lights) = npz::read_with_lights(Cursor::new(archive), LoadOptions::DEFAULT_MEMORY_LIMIT)?;
    let lights: Vec<Light> = lights.into_iter().map(Light::homogeneous).collect();
    check_lights(&lights, MAX_LIGHTS).map_err(InputError::Lights)?;
    Ok((arrays, lights))
}
