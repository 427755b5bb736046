//! The required extensions that a file may have.

use super::error::GltfError;
use super::json::{Json, shorten};

/// Extensions for compressed buffer views. The loader reads such a file if the plain data is there too.
pub(super) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The advice for a file with meshopt data.
pub(super) const MESHOPT_ADVICE: &str = "decompress the file first (gltfpack without -c, or gltf-transform copy), or export it \
    with an uncompressed \
     fallback buffer";
/// The advice for a file with Draco data.
pub(super) const DRACO_ADVICE: &str =
    "decompress the file first (gltf-transform copy), or export it without Draco compression";
/// The name of the Draco extension.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// The extensions that the loader reads.
const READ: &[&str] = &["KHR_mesh_quantization", "KHR_lights_punctual", "EXT_mesh_gpu_instancing", "CESIUM_RTC"];

/// Extensions of surfaces and of descriptions. They do not change where triangles are.
const HARMLESS_PREFIXES: &[&str] =
    &["KHR_materials_", "KHR_texture_", "EXT_texture_", "ADOBE_materials_", "MSFT_packing_"];
const HARMLESS: &[&str] = &[
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_lights_image_based",
    "EXT_lights_ies",
    "EXT_mesh_features",
    "EXT_instance_features",
    "EXT_structural_metadata",
    "EXT_mesh_manifold",
    "CESIUM_primitive_outline",
    "MSFT_texture_dds",
    "FB_geometry_metadata",
    "AGI_articulations",
    "AGI_stk_metadata",
];

/// Refuses required extensions that are not supported. Returns all that the file uses.
pub(super) fn check(root: &Json<'_>) -> Result<Vec<String>, GltfError> {
    let required = root.strings("extensionsRequired")?;
    for &name in &required {
        let harmless = READ.contains(&name)
            || MESHOPT.contains(&name)
            || HARMLESS.contains(&name)
            || HARMLESS_PREFIXES.iter().any(|prefix| name.starts_with(prefix));
        if !harmless {
            return Err(GltfError::Extension {
                name: shorten(name),
                place: "the file (extensionsRequired)".to_owned(),
                advice: if name == DRACO { DRACO_ADVICE } else { "export the file without it" },
            });
        }
    }
    let used = root.strings("extensionsUsed")?;
    Ok(used.into_iter().chain(required).map(str::to_owned).collect())
}
