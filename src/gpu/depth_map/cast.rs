//! What a caster of a scene is inside: volumes of one map or of six, with what they are encoded from.

use super::caster::{DepthMapCaster, DepthMapCasterVolumes, DepthMapCubeCaster};
use super::casters_errors::DepthMapCastersError;
use super::convex::Convex;
use super::cube::DepthMapCube;
use super::frame_errors::{DepthMapEncodeError, DepthMapTexture};
use super::jitter::jitters;
use super::recording::{Eye, Planned};
use super::texture::{check_objects, check_texture};
use super::volumes::DepthMapVolumes;
use crate::ShadowCamera;
use crate::gpu::scene::handles::LightHandle;

/// The volumes, and what casts.
#[derive(Debug)]
pub(super) enum Cast {
    Map(Box<DepthMapVolumes>, Box<DepthMapCaster>),
    Cube(Box<DepthMapCube>, Box<DepthMapCubeCaster>),
}

/// References to views that may not be there.
fn views(of: &[Option<wgpu::TextureView>; 6]) -> [Option<&wgpu::TextureView>; 6] {
    of.each_ref().map(Option::as_ref)
}

impl Cast {
    pub(super) fn light(&self) -> LightHandle {
        match self {
            Self::Map(_, caster) => caster.light,
            Self::Cube(_, caster) => caster.light,
        }
    }

    pub(super) fn version(&self) -> Option<u64> {
        match self {
            Self::Map(_, caster) => caster.version,
            Self::Cube(_, caster) => caster.version,
        }
    }

    pub(super) fn set_version(&mut self, version: Option<u64>) {
        match self {
            Self::Map(_, caster) => caster.version = version,
            Self::Cube(_, caster) => caster.version = version,
        }
    }

    pub(super) fn device(&self) -> &wgpu::Device {
        match self {
            Self::Map(volumes, _) => volumes.shared.device(),
            Self::Cube(cube, _) => cube.volumes.shared.device(),
        }
    }

    pub(super) fn into_volumes(self) -> DepthMapCasterVolumes {
        match self {
            Self::Map(volumes, _) => DepthMapCasterVolumes::Map(volumes),
            Self::Cube(cube, _) => DepthMapCasterVolumes::Cube(cube),
        }
    }

    /// Takes the cameras, or refuses what casts.
    pub(super) fn begin(&mut self) -> Result<(), DepthMapCastersError> {
        match self {
            Self::Map(volumes, caster) => check_map(volumes, caster),
            Self::Cube(cube, caster) => {
                check_cube(cube, caster)?;
                Ok(cube.set_cameras(&caster.cameras)?)
            }
        }
    }

    /// Changes what one map casts. Returns whether its cells are the same.
    pub(super) fn set_map(&mut self, to: DepthMapCaster) -> Result<bool, DepthMapCastersError> {
        let Self::Map(volumes, caster) = self else {
            return Err(DepthMapCastersError::Kind { own: "six maps", with: "set_cube" });
        };
        check_map(volumes, &to)?;
        let of = |caster: &DepthMapCaster| (caster.texture.clone(), caster.objects.clone(), caster.camera);
        let is_same = of(caster) == of(&to);
        **caster = to;
        Ok(is_same)
    }

    /// The same of six maps.
    pub(super) fn set_cube(&mut self, to: DepthMapCubeCaster) -> Result<bool, DepthMapCastersError> {
        let Self::Cube(cube, caster) = self else {
            return Err(DepthMapCastersError::Kind { own: "one map", with: "set" });
        };
        check_cube(cube, &to)?;
        cube.set_cameras(&to.cameras)?;
        let of = |caster: &DepthMapCubeCaster| (caster.textures.clone(), caster.objects.clone(), caster.cameras);
        let is_same = of(caster) == of(&to);
        **caster = to;
        Ok(is_same)
    }

    /// What it may darken is in these together.
    pub(super) fn shadow(&self) -> Vec<Convex> {
        match self {
            Self::Map(volumes, caster) => vec![Convex::shadow(&caster.camera, volumes.shape.size)],
            // A map that is not there has samples of its neighbours at its border.
            Self::Cube(_, caster) => caster.cameras.iter().map(|camera| Convex::frustum(camera, [0.0; 2])).collect(),
        }
    }

    /// Each camera with the views of the maps, or the number of a camera that is refused.
    pub(super) fn eyes<'a>(&self, cameras: &'a [ShadowCamera]) -> Result<Vec<Eye<'a>>, (usize, DepthMapEncodeError)> {
        let views = |camera: &ShadowCamera| match self {
            Self::Map(volumes, caster) => {
                let format = caster.texture.texture().format();
                let of_bit =
                    |jitter| volumes.view(&caster.camera, &[format], camera, 1.0, jitter).map(|view| vec![view]);
                jitters(volumes.bits).into_iter().map(of_bit).collect()
            }
            Self::Cube(cube, caster) => cube.views(&cube.formats(views(&caster.textures))?, camera),
        };
        let eye = |(number, camera)| views(camera).map(|views| (camera, views)).map_err(|error| (number, error));
        cameras.iter().enumerate().map(eye).collect()
    }

    /// Binds the stages, unless the cells of an encode before are drawn, and the draws for each camera.
    pub(super) fn plan(&self, eyes: &[Eye<'_>], is_listed_anew: bool) -> Result<Planned<'_>, DepthMapEncodeError> {
        match self {
            Self::Map(volumes, caster) => {
                let format = caster.texture.texture().format();
                let textures = [Some(&caster.texture), caster.objects.as_ref()];
                volumes.plan(textures, (std::slice::from_ref(&caster.camera), &[format]), eyes, is_listed_anew)
            }
            Self::Cube(cube, caster) => {
                let [maps, objects] = [&caster.textures, &caster.objects].map(views);
                cube.plan(maps, objects, &cube.formats(maps)?, eyes, is_listed_anew)
            }
        }
    }
}

/// Refuses textures and a camera that do not fit volumes.
fn check_map(volumes: &DepthMapVolumes, caster: &DepthMapCaster) -> Result<(), DepthMapCastersError> {
    use DepthMapEncodeError::{Light, NoObjects, UnusedObjects};
    check_texture(caster.texture.texture(), volumes.shape.size, DepthMapTexture::Map)
        .map_err(DepthMapCastersError::Refused)?;
    match (&caster.objects, volumes.shape.objects == 1) {
        (None, true) => return Err(DepthMapCastersError::Refused(NoObjects { face: None })),
        (Some(_), false) => return Err(DepthMapCastersError::Refused(UnusedObjects)),
        (Some(objects), true) => {
            check_objects(objects.texture(), volumes.shape.size, DepthMapTexture::Objects)
                .map_err(DepthMapCastersError::Refused)?;
        }
        (None, false) => {}
    }
    caster.camera.check_any_hand().map_err(|error| DepthMapCastersError::Refused(Light(error)))
}

/// Refuses textures that do not fit a cube.
fn check_cube(cube: &DepthMapCube, caster: &DepthMapCubeCaster) -> Result<(), DepthMapCastersError> {
    let [maps, objects] = [&caster.textures, &caster.objects].map(views);
    cube.formats(maps).map_err(DepthMapCastersError::Refused)?;
    cube.check_objects(maps, objects).map_err(DepthMapCastersError::Refused)
}
