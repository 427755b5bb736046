//! The extensions that a file may require, and those that it may use without a warning.

use std::collections::{BTreeSet, HashSet};

use super::error::GltfError;
use super::json::{Json, shorten};
use super::warning::{GltfWarning, Warnings};

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

/// The extensions that a file may require. The loader reads those before compression, and skips each channel of an
/// animation that names a pointer, with a warning. Compressed views are refused where the plain data is missing. The others
/// are of surfaces, sounds and descriptions, and do not change where triangles are. A star stands for the rest of a name.
const SUPPORTED: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "KHR_node_visibility",
    "KHR_animation_pointer",
    "EXT_mesh_gpu_instancing",
    "CESIUM_RTC",
    MESHOPT[0],
    MESHOPT[1],
    "KHR_materials_*",
    "KHR_texture_*",
    "KHR_audio*",
    "KHR_node_hoverability*",
    "KHR_node_selectability*",
    "KHR_techniques_webgl",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_materials_*",
    "EXT_texture_*",
    "EXT_lights_image_based",
    "EXT_lights_ies",
    "EXT_mesh_features",
    "EXT_instance_features",
    "EXT_structural_metadata",
    "EXT_mesh_manifold",
    "ADOBE_materials_*",
    "AGI_articulations",
    "AGI_stk_metadata",
    "CESIUM_primitive_outline",
    "FB_geometry_metadata",
    "FB_ngon_encoding",
    "GRIFFEL_bim_data",
    "MSFT_audio_*",
    "MSFT_packing_*",
    "MSFT_texture_dds",
    "NV_materials_*",
    "OMI_audio_*",
    "VRMC_materials_*",
];

fn is_supported(name: &str) -> bool {
    SUPPORTED.iter().any(|known| known.strip_suffix('*').map_or(*known == name, |prefix| name.starts_with(prefix)))
}

/// Refuses required extensions that are not supported, and warns of others that may change the result. Returns all that the
/// file uses.
pub(super) fn check(root: &Json<'_>, warnings: &Warnings<'_>) -> Result<Vec<String>, GltfError> {
    let required: Vec<&str> = root.list("extensionsRequired")?;
    for &name in &required {
        if !is_supported(name) {
            return Err(GltfError::Extension {
                name: shorten(name),
                json_path: "the file (extensionsRequired)".to_owned(),
                advice: if name == DRACO { DRACO_ADVICE } else { "export the file without it" },
            });
        }
    }
    let used: Vec<&str> = warnings.leave_out(root.list("extensionsUsed"))?.unwrap_or_default();
    let listed: HashSet<&str> = used.iter().copied().collect();
    // A file ought to list what its nodes have, and may not do so.
    let nodes = root.elements("nodes").into_iter().flatten().flatten();
    let of_nodes = nodes
        .filter_map(|node| node.get::<Json<'_>>("extensions").ok().flatten())
        .flat_map(|extensions| extensions.keys());
    let unlisted: BTreeSet<&str> = of_nodes.filter(|name| !listed.contains(name)).collect();
    for &name in used.iter().chain(&unlisted) {
        // Where the plain data beside Draco data is missing, the mesh is refused.
        if !is_supported(name) && name != DRACO {
            warnings.push(GltfWarning::Extension { name: shorten(name) })?;
        }
    }
    Ok(used.into_iter().chain(required).map(str::to_owned).collect())
}
