//! Model files: those of `rimline_models::catalogue`, generated when asked for, and names of real ones that can be read.

use std::path::PathBuf;

use rimline_models::catalogue::{BAD, GOOD};

/// A file of the catalogue in a folder of its own, which is removed with the value.
pub struct Made {
    _folder: tempfile::TempDir,
    pub path: PathBuf,
}

/// Generates the file of this name.
pub fn made(name: &str) -> Result<Made, String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let good = GOOD.iter().find(|good| good.name == name).map(|good| good.write(folder.path()));
    let bad = || BAD.iter().find(|bad| bad.name == name).map(|bad| bad.write(folder.path()));
    let path = good.or_else(bad).ok_or_else(|| format!("the catalogue has no {name}"))?;
    Ok(Made { path: path.map_err(|error| format!("{name}: {error}"))?, _folder: folder })
}

/// Paths of the real models that can be read, relative to the folder of real models (`assets`).
pub const GOOD_FILES: [&str; 25] = [
    "22_vertex_color.glb",
    "AnimatedMorphCube.glb",
    "AntiqueCamera.glb",
    "Box.glb",
    "CesiumMan.glb",
    "CesiumMan_8influences_morph.glb",
    "CesiumMilkTruck_quantized.glb",
    "FlightHelmet.glb",
    "Fox.glb",
    "InfiniteSkinnedTentacle.glb",
    "InterpolationTest.glb",
    "Knight.glb",
    "MorphStressTest.gltf",
    "RobotExpressive.glb",
    "SheenCloth.glb",
    "SimpleSparseAccessor.gltf",
    "moebius.glb",
    "primitive_modes/Mesh_PrimitiveMode_04.gltf",
    "primitive_modes/Mesh_PrimitiveMode_05.gltf",
    "primitive_modes/Mesh_PrimitiveMode_14.gltf",
    "scallop.glb",
    "spot.glb",
    "spot_catmull_big.glb",
    "subpass_scene_opaque.gltf",
    "triple_vierbein.glb",
];
