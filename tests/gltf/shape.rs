//! Hand-made files: which triangles and positions are read.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError, SkippedPrimitives};
use rimline::mesh::Weld;
use serde_json::{Value, json};

use crate::check::like_poser;
use crate::maker::{Maker, SQUARE, U8, U16};
use crate::rows::primitive;
use crate::{Outcome, check, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("shape::strips_and_fans", strips_and_fans),
        test("shape::primitives_share_vertices", sharing),
        test("shape::points_and_lines_are_skipped", skipping),
        test("shape::files_of_nothing", nothing),
        test("shape::component_types_of_positions", component_types),
        test("shape::strides_and_sparse_offsets", strides),
        test("shape::compressed_with_plain_data", fallbacks),
        test("shape::data_uris_and_files", uris),
        test("shape::glb_chunks_and_versions", glb_chunks),
        test("shape::welding", welding),
        test("shape::welding_in_one_point_is_linear", one_point),
    ]
}

fn strips_and_fans() -> Outcome {
    let points: Vec<f32> = (0..5).flat_map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
    for mode in [5, 6] {
        let mut maker = Maker::new();
        let positions = maker.floats("VEC3", &points);
        maker.mesh(&json!({ "attributes": { "POSITION": positions }, "mode": mode }));
        maker.push("nodes", json!({ "mesh": 0 }));
        like_poser(&maker, &[])?;
        let indices = maker.indices(U8, &[4, 3, 2, 1, 0, 0]);
        primitive(&mut maker)["indices"] = json!(indices);
        like_poser(&maker, &[])?;
        for count in 0..3 {
            maker.json["accessors"][indices]["count"] = json!(count);
            same(&maker.load()?.model().instances().len(), &0, "instances of less than three corners")?;
        }
    }
    Ok(())
}

/// Primitives of one accessor have its vertices once; those of an equal one have their own.
fn sharing() -> Outcome {
    let mut maker = Maker::square();
    let first = primitive(&mut maker).clone();
    let (other, three) = (maker.floats("VEC3", &SQUARE), maker.indices(U16, &[0, 1, 3]));
    maker.json["meshes"][0]["primitives"] = json!([
        first,
        { "attributes": { "POSITION": 0 }, "indices": three },
        { "attributes": { "POSITION": other }, "indices": three },
    ]);
    let asset = maker.load()?;
    let geometry = &asset.model().geometries()[0];
    same(&geometry.faces().to_vec(), &vec![[0, 1, 2], [0, 2, 3], [0, 1, 3], [4, 5, 7]], "faces")?;
    same(&geometry.source_vertices().to_vec(), &(0..8).collect(), "source vertices")
}

/// A file without content, lists without elements, and elements of nothing: a model of nothing, or an error.
fn nothing() -> Outcome {
    let header = b"glTF\x02\0\0\0\0\0\0\0";
    for bytes in [&b""[..], b" ", b"{}", b"[]", b"glT", b"glTF", header, b"\xff\xfe", b"ply\n", b"null"] {
        ensure(Asset::from_slice(bytes, None, Weld::Position).is_err(), || format!("{bytes:?} was accepted"))?;
    }
    let lists = ["accessors", "animations", "buffers", "bufferViews", "meshes", "nodes", "scenes", "skins", "textures"];
    let mut contents = lists.map(|list| json!({ list: [] })).to_vec();
    contents.extend([
        json!({ "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "children": [], "weights": [] }] }),
        json!({ "meshes": [{ "primitives": [] }], "nodes": [{ "mesh": 0 }] }),
        json!({ "meshes": [{ "primitives": [{ "attributes": {}, "targets": [] }], "weights": [] }] }),
        json!({ "skins": [{ "joints": [] }], "nodes": [{ "skin": 0 }] }),
        json!({ "animations": [{ "samplers": [], "channels": [] }] }),
        json!({ "buffers": [{ "byteLength": 0 }] }),
    ]);
    let mut loaded = 0;
    for content in contents {
        let mut maker = Maker::new();
        for (name, value) in content.as_object().into_iter().flatten() {
            maker.json[name] = value.clone();
        }
        let Ok(asset) = maker.load() else { continue };
        let (model, pose) = (asset.model(), asset.pose(0..asset.animations().len(), 0.0)?);
        let empty = model.check(&pose).is_ok() && model.vertex_count() == 0 && model.mesh(&pose).is_err();
        ensure(empty && asset.lights([], 0.0)?.is_empty(), || format!("{content} has content"))?;
        loaded += 1;
    }
    ensure(loaded > 3, || format!("{loaded} files load"))
}

fn skipping() -> Outcome {
    let mut maker = Maker::square();
    let with_mode = |mode: u32| json!({ "attributes": { "POSITION": 0 }, "mode": mode });
    let mut primitives: Vec<Value> = [0, 1, 2, 3, 0].map(with_mode).to_vec();
    primitives.push(json!({ "attributes": {} }));
    maker.push("meshes", json!({ "primitives": primitives }));
    maker.push("nodes", json!({ "mesh": 1 }));
    let asset = maker.load()?;
    let expected = SkippedPrimitives { points: 2, lines: 3, without_position: 1 };
    same(&asset.skipped(), &expected, "skipped")?;
    same(&(asset.model().instances().len(), asset.meshes()[1].primitives), &(1, 6), "instances and primitives")
}

/// Each component type that the extension allows, the lowest number included; none without it.
fn component_types() -> Outcome {
    for (component, bytes) in [(5120, 1), (5121, 1), (5122, 2), (5123, 2)] {
        for normalized in [false, true] {
            let mut maker = Maker::new();
            // Little-endian: the last byte of a pair has the sign.
            let data =
                [0x80, 0, 51, 127, 0, 255, 200, 1, 0].map(|byte| [vec![0; bytes - 1], vec![byte]].concat()).concat();
            let positions = maker.accessor(component, "VEC3", 3, &data);
            maker.json["accessors"][positions]["normalized"] = json!(normalized);
            maker.mesh(&json!({
                "attributes": { "POSITION": positions }, "targets": [{ "POSITION": positions }],
            }));
            maker.push("nodes", json!({ "mesh": 0, "weights": [0.5] }));
            ensure(maker.load().is_err(), || format!("{component} was accepted without the extension"))?;
            maker.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            like_poser(&maker, &[])?;
        }
    }
    Ok(())
}

/// Elements between others, of which the last ends where its own bytes end; both byte offsets of sparse data.
fn strides() -> Outcome {
    let mut maker = Maker::square();
    let interleaved: Vec<f32> = SQUARE.chunks(3).flat_map(|p| [p[0], p[1], p[2], 99.0]).collect();
    let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let view = maker.view(&bytes(&interleaved[..15]));
    maker.json["bufferViews"][view]["byteStride"] = json!(16);
    maker.json["accessors"][0]["bufferView"] = json!(view);
    like_poser(&maker, &[])?;
    let indices = maker.view(&[3, 0, 1, 0, 2, 0]);
    let values = maker.view(&bytes(&[9.0, 9.0, 9.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]));
    maker.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "byteOffset": 2, "componentType": U16 },
        "values": { "bufferView": values, "byteOffset": 12 },
    });
    like_poser(&maker, &[])
}

fn fallbacks() -> Outcome {
    let draco = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": { "POSITION": 0 } } });
    let meshopt = json!({ "EXT_meshopt_compression": { "buffer": 0, "byteLength": 4, "byteStride": 12, "count": 4 } });
    for (at, extension) in [("/meshes/0/primitives/0", draco), ("/bufferViews/0", meshopt)] {
        let mut maker = Maker::square();
        maker.json["extensionsUsed"] =
            extension.as_object().into_iter().flatten().map(|(name, _)| json!(name)).collect();
        maker.json.pointer_mut(at).ok_or("no such part")?["extensions"] = extension;
        like_poser(&maker, &[])?;
    }
    Ok(())
}

fn uris() -> Outcome {
    let maker = Maker::square();
    let expected = maker.load()?;
    let text = String::from_utf8(maker.gltf()).map_err(|error| error.to_string())?;
    // Scheme and parameters of a URI are the same in capitals (RFC 3986, section 3.1; RFC 2045, section 6.1).
    let loud = text.replace("data:application/octet-stream;base64,", "DATA:application/octet-stream;BASE64,");
    for text in [text.clone(), loud, format!("\u{feff}{text}")] {
        same(Asset::from_slice(text.as_bytes(), None, Weld::Keep)?.model(), expected.model(), &text[..40])?;
    }
    let folder = tempfile::tempdir()?;
    std::fs::create_dir(folder.path().join("some data"))?;
    std::fs::write(folder.path().join("some data/ä.bin"), &maker.bytes)?;
    let percent = percent_encoding::percent_encode(&maker.bytes, percent_encoding::NON_ALPHANUMERIC);
    let path = folder.path().join("model.gltf");
    for uri in ["some%20data/%C3%A4.bin", "./some data/ä.bin", &format!("data:,{percent}")] {
        let mut maker = maker.clone();
        crate::rows::uri(&mut maker, uri);
        std::fs::write(&path, maker.json.to_string())?;
        same(Asset::open(&path, Weld::Keep)?.model(), expected.model(), uri)?;
    }
    // A GLB under another name.
    std::fs::write(&path, maker.glb())?;
    same(Asset::open(&path, Weld::Keep)?.model(), expected.model(), "GLB")
}

/// A chunk of another type, and a second one of the same. Bytes after the end do not count.
fn glb_chunks() -> Outcome {
    let maker = Maker::square();
    for (kind, bytes) in [(b"WHAT", &b"what"[..]), (b"BIN\0", &[0; 60])] {
        let mut file = maker.glb();
        file.extend((bytes.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(bytes);
        let length = file.len() as u32;
        file[8..12].copy_from_slice(&length.to_le_bytes());
        file.extend(b"bytes after the end");
        same(Asset::from_slice(&file, None, Weld::Keep)?.model(), maker.load()?.model(), "model")?;
    }
    for version in [0, 1, 3] {
        let mut file = maker.glb();
        file[4] = version;
        let found = Asset::from_slice(&file, None, Weld::Keep);
        let is_named = matches!(&found, Err(GltfError::Version { version: found }) if *found == version.to_string());
        ensure(is_named, || format!("version {version}: {found:?}"))?;
    }
    Ok(())
}

/// All corners at one position, the last one on another joint.
fn welding() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [1.0, 0.0, 0.0, 0.0]);
    let positions = maker.floats("VEC3", &[1.0; 12]);
    let joints = maker.accessor(U8, "VEC4", 4, &[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    let attributes = &mut maker.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["POSITION"] = json!(positions);
    attributes["JOINTS_0"] = json!(joints);
    for (weld, after, apart) in [(Weld::Keep, 4, 0), (Weld::Position, 1, 0), (Weld::Data, 2, 1)] {
        let asset = Asset::from_slice(&maker.glb(), None, weld)?;
        let counts = asset.weld_counts(0).ok_or("no counts")?;
        same(&(counts.before, counts.after, counts.apart), &(4, after, apart), "counts")?;
        check::asset(&asset, 0, false)?;
    }
    Ok(())
}

/// A reproduction: welding compared every pair of vertices that share a position and differ in the rest, which would
/// take a quarter of an hour here.
fn one_point() -> Outcome {
    let count = 600_000_u32;
    let mut maker = Maker::new();
    let offsets: Vec<f32> = (0..count).flat_map(|v| [v as f32, 0.0, 0.0]).collect();
    let target = maker.floats("VEC3", &offsets);
    let positions = maker.zeros(u64::from(count));
    maker.mesh(&json!({ "attributes": { "POSITION": positions }, "targets": [{ "POSITION": target }] }));
    let asset = Asset::from_slice(&maker.glb(), None, Weld::Data)?;
    let counts = asset.weld_counts(0).ok_or("no counts")?;
    same(&(counts.after, counts.apart), &(600_000, 599_999), "counts")
}
