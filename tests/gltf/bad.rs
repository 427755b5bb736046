//! Every bad file of the catalogue and of the shared models gives a typed error, or a warning, that names the JSON path.

use std::path::Path;

use libtest_mimic::Trial;
use rimline::MeshError;
use rimline::gltf::{Asset, SkippedPrimitives};
use rimline::mesh::Weld;
use rimline_models::catalogue::{BAD, Fate};
use rimline_testkit::harness::{on_both, on_files, on_made};
use rimline_testkit::refusals::{self, refusal};
use rimline_testkit::{assets, files};

use crate::{Outcome, ensure, test};

/// File, and what its error must say.
const ROWS: &[(&str, &[&str])] = &[
    ("BoxDraco.gltf", &["KHR_draco_mesh_compression", "decompress"]),
    ("IndexOutOfRange.gltf", &["meshes[0].primitives[0]", "is 255", "24 vertices"]),
    ("chunk_too_big.glb", &["byte 12", "ends inside a header"]),
    ("index_buffer_oob.gltf", &["meshes[0].primitives[0]", "4 vertices"]),
    ("indices_invalid_format.gltf", &["accessors[1]", "meshes[0].primitives[0].indices", "F32 Scalar"]),
    ("invalid_json_chunk.glb", &["JSON"]),
    ("missing_bin/missing_bin.gltf", &["cannot read", "BoxTextured0.bin"]),
    ("morph_attribute_invalid_count.gltf", &["meshes[0].primitives[0].targets[0].POSITION", "4 elements, expected 3"]),
    ("node_loop.gltf", &["nodes[0]", "ancestor"]),
    ("own_box_truncated.glb", &["byte 8", "1664 bytes, there are 1564"]),
    ("position_accessor_invalid_format.gltf", &["accessors[0]", "attributes.POSITION", "F32 Vec4"]),
    ("truncated_chunk_data.glb", &["byte 8", "48 bytes, there are 47"]),
    ("unresolved_positions.gltf", &["meshes[0].primitives[0].attributes.POSITION is 0", "0 accessors"]),
];
/// File, and what one of its warnings must say: nothing that is shown needs what is wrong, or it can be read all the same.
const WARNED: &[(&str, &[&str])] = &[
    ("BoxWithInfinites.glb", &["meshes[0].primitives[0].attributes.POSITION", "infinite or NaN"]),
    ("badUint.gltf", &["materials[0].pbrMetallicRoughness.baseColorTexture.index", "found -1"]),
    ("bufferview_invalid_length.gltf", &["bufferViews[0]", "5 bytes", "only 4"]),
    ("ibm_invalid_count.gltf", &["skins[2].inverseBindMatrices", "2 elements, expected 3"]),
    ("index_buffer_primitive_restart.gltf", &["meshes[0].primitives[0]", "restart value 255", "read as a vertex"]),
    ("invalid-buffer-view-index.gltf", &["accessors[0].bufferView is 1", "1 bufferViews"]),
    ("joints_weights_complex.gltf", &["meshes[0].primitives[0].attributes.WEIGHTS_", "weight -"]),
    ("own_box_nan_position.glb", &["meshes[0].primitives[0].attributes.POSITION", "infinite or NaN"]),
];
/// Legal: nothing to draw.
const LEGAL: &str = "primitive_no_position.gltf";

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        on_both("bad::no_position", ["no_position.glb", "bad/primitive_no_position.gltf"], no_position),
        test("bad::control", control),
    ];
    tests.extend(on_made("bad::", BAD.iter().map(|bad| bad.name), |path| {
        let bad = BAD.iter().find(|bad| path.ends_with(bad.name)).ok_or("no row")?;
        if bad.fate == Fate::Refused { refused(path, bad.says) } else { warned(path, bad.says) }
    }));
    let names: Vec<_> = ROWS.iter().chain(WARNED).map(|row| row.0).collect();
    let folder = assets().map(|folder| folder.join("bad"));
    tests.extend(folder.clone().map(|folder| test("bad::table_is_complete", move || table_is_complete(&folder))));
    tests.extend(on_files("bad::", folder, &names, |path| {
        let says = |rows: &[(&str, &'static [&str])]| rows.iter().find(|row| path.ends_with(row.0)).map(|row| row.1);
        says(ROWS).map_or_else(|| warned(path, says(WARNED).unwrap_or_default()), |says| refused(path, says))
    }));
    tests
}

fn refused(path: &Path, says: &[&str]) -> Outcome {
    Ok(refusals::refused([refusal(path.display(), Asset::open(path, Weld::Data), refusals::says(says))])?)
}

fn warned(path: &Path, says: &[&str]) -> Outcome {
    let asset = Asset::open(path, Weld::Data)?;
    crate::check::asset(&asset, 0, false)?;
    let warnings = crate::check::said(&asset);
    let one = warnings.iter().any(|warning| says.iter().all(|part| warning.contains(part)));
    ensure(one, || format!("{warnings:?} do not say {says:?}"))
}

fn no_position(path: &Path) -> Outcome {
    let asset = Asset::open(path, Weld::Data)?;
    let skipped = SkippedPrimitives { without_position: 1, ..SkippedPrimitives::default() };
    ensure(asset.skipped() == skipped, || format!("{:?}", asset.skipped()))?;
    let mesh = asset.model().mesh(&asset.pose(None, 0.0)?);
    ensure(mesh == Err(MeshError::NoFaces.into()), || format!("{mesh:?}"))
}

fn control() -> Outcome {
    let is_refused = |name: &str, says: &[&str]| Ok::<_, String>(refused(&files::made(name)?.path, says).is_ok());
    ensure(!is_refused("cube.glb", &[])?, || "a good file passed as bad".to_owned())?;
    ensure(!is_refused(BAD[1].name, &["meshes[7]"])?, || "a wrong path passed".to_owned())?;
    ensure(is_refused(BAD[1].name, &["meshes[0]"])?, || "the right one did not".to_owned())
}

fn table_is_complete(folder: &Path) -> Outcome {
    for entry in std::fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let known = name == LEGAL || ROWS.iter().chain(WARNED).any(|row| row.0.split('/').next() == Some(&name));
        ensure(known || Path::new(&name).extension() == Some("bin".as_ref()), || format!("no row for {name}"))?;
    }
    Ok(())
}
