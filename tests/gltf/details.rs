//! Details of the specification, each with a file that only this detail decides. Each test catches a change of the loader
//! that no other test notices.

use std::f32::consts::FRAC_PI_2;

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError, SceneLight};
use rimline::mesh::Weld;
use serde_json::{Value, json};

use crate::check::close;
use crate::maker::{Maker, SQUARE, U8, U16};
use crate::refuse::primitive;
use crate::shape::same;
use crate::{Outcome, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("details::duration_is_the_last_key_of_all_channels", duration),
        test("details::a_buffer_one_byte_short", one_byte_short),
        test("details::data_uris_in_capitals", capitals),
        test("details::glb_of_version_1", glb_version),
        test("details::the_first_binary_chunk_counts", second_chunk),
        test("details::byte_order_mark", byte_order_mark),
        test("details::other_joints_are_other_vertices", other_joints),
        test("details::other_targets_are_other_vertices", other_targets),
        test("details::points_of_drawn_vertices_make_no_faces", points),
        test("details::strips_and_fans_of_a_corner_or_none", few_corners),
        test("details::children_keep_their_order", children),
        test("details::joints_out_of_range_in_a_later_primitive", later_joint),
        test("details::extras_are_not_read", extras),
        test("details::quaternions_of_any_length", quaternions),
        test("details::last_rows_up_to_rounding", last_rows),
        test("details::lights_at_the_edge_of_what_is_allowed", lights),
        test("details::cones_of_stretched_and_flat_nodes", cones),
        test("details::joints_that_a_palette_needs", joints_needed),
        test("details::required_extensions_of_surfaces", surfaces),
        test("details::sparse_offsets", sparse_offsets),
        test("details::normalised_where_it_must_be", normalised),
    ]
}

fn refused(maker: &Maker, parts: &[&str]) -> Outcome {
    let message = match maker.load() {
        Ok(_) => return Err("it was accepted".into()),
        Err(error) => error.to_string(),
    };
    ensure(parts.iter().all(|part| message.contains(part)), || format!("{message:?} does not say {parts:?}"))
}

fn duration() -> Outcome {
    let mut maker = Maker::square();
    let (long, short) = (maker.floats("SCALAR", &[0.0, 3.0]), maker.floats("SCALAR", &[0.0, 2.0]));
    let output = maker.floats("VEC3", &[0.0; 6]);
    let channel = |sampler: u32, path: &str| json!({ "sampler": sampler, "target": { "node": 0, "path": path } });
    maker.push(
        "animations",
        json!({
            "samplers": [{ "input": long, "output": output }, { "input": short, "output": output }],
            "channels": [channel(0, "translation"), channel(1, "scale")],
        }),
    );
    same(&maker.load()?.animations()[0].duration_s, &3.0, "duration")
}

/// No view reaches the byte that is missing, and the buffer is refused for it.
fn one_byte_short() -> Outcome {
    let mut maker = Maker::square();
    let uri = format!("data:,{}", "A".repeat(maker.bytes.len()));
    maker.json["buffers"] = json!([{ "byteLength": maker.bytes.len() + 1, "uri": uri }]);
    refused(&maker, &["buffers[0].byteLength"])?;
    maker.json["buffers"][0]["byteLength"] = json!(maker.bytes.len());
    match maker.load() {
        // The letters are no good indices, so it gets that far.
        Err(GltfError::IndexOutOfRange { .. }) => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// Scheme and parameters of a URI are the same in capitals (RFC 3986, section 3.1; RFC 2045, section 6.1).
fn capitals() -> Outcome {
    let maker = Maker::square();
    let text = String::from_utf8(maker.gltf()).map_err(|error| error.to_string())?;
    let loud = text.replace("data:application/octet-stream;base64,", "DATA:application/octet-stream;BASE64,");
    ensure(loud != text, || "nothing was changed".to_owned())?;
    let asset = Asset::from_slice(loud.as_bytes(), None, Weld::Keep)?;
    same(asset.model(), maker.load()?.model(), "model")
}

fn glb_version() -> Outcome {
    for version in [0, 1, 3] {
        let mut file = Maker::square().glb();
        file[4] = version;
        match Asset::from_slice(&file, None, Weld::Keep) {
            Err(GltfError::Version { version: found }) if found == version.to_string() => {}
            other => return Err(format!("version {version}: {other:?}").into()),
        }
    }
    Ok(())
}

fn second_chunk() -> Outcome {
    let maker = Maker::square();
    let mut file = maker.glb();
    let zeros = vec![0; maker.bytes.len().next_multiple_of(4)];
    file.extend((zeros.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(zeros);
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    same(Asset::from_slice(&file, None, Weld::Keep)?.model(), maker.load()?.model(), "model")
}

fn byte_order_mark() -> Outcome {
    let maker = Maker::square();
    let text = [&b"\xef\xbb\xbf"[..], &maker.gltf()].concat();
    same(Asset::from_slice(&text, None, Weld::Keep)?.model(), maker.load()?.model(), "model")
}

/// Adds a copy of the first primitive.
fn copy_primitive(maker: &mut Maker) -> &mut Value {
    let copy = primitive(maker).clone();
    let list = maker.json["meshes"][0]["primitives"].as_array_mut().expect("a list");
    list.push(copy);
    list.last_mut().expect("one was added")
}

fn other_joints() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [1.0, 0.0, 0.0, 0.0]);
    let joints = maker.accessor(U8, "VEC4", 4, &[1, 0, 0, 0].repeat(4));
    copy_primitive(&mut maker)["attributes"]["JOINTS_0"] = json!(joints);
    let asset = maker.load()?;
    let influences = asset.model().geometries()[0].influences().ok_or("no influences")?;
    same(&influences.joints().to_vec(), &vec![0, 0, 0, 0, 1, 1, 1, 1], "joints")
}

fn other_targets() -> Outcome {
    let mut maker = Maker::square();
    let targets = [1.0, 2.0].map(|by| maker.floats("VEC3", &[by; 12]));
    primitive(&mut maker)["targets"] = json!([{ "POSITION": targets[0] }]);
    copy_primitive(&mut maker)["targets"] = json!([{ "POSITION": targets[1] }]);
    let found = maker.load()?.model().geometries()[0].morph_targets().to_vec();
    same(&found, &vec![[vec![[1.0; 3]; 4], vec![[2.0; 3]; 4]].concat()], "offsets")
}

fn points() -> Outcome {
    let mut maker = Maker::square();
    copy_primitive(&mut maker)["mode"] = json!(0);
    let asset = maker.load()?;
    same(&asset.model().geometries()[0].faces().len(), &2, "faces")?;
    same(&asset.skipped().points, &1, "points")
}

fn few_corners() -> Outcome {
    for (mode, count) in [(5, 0), (5, 1), (6, 0), (6, 1)] {
        let mut maker = Maker::square();
        primitive(&mut maker)["mode"] = json!(mode);
        maker.json["accessors"][1]["count"] = json!(count);
        same(&maker.load()?.model().geometries()[0].faces().len(), &0, "faces")?;
    }
    Ok(())
}

fn children() -> Outcome {
    let mut maker = Maker::square();
    maker.json["nodes"] = json!([
        { "name": "top", "mesh": 0, "children": [2, 1] },
        { "name": "b", "mesh": 0 },
        { "name": "a", "mesh": 0, "children": [3] },
        { "name": "below a", "mesh": 0 },
    ]);
    let asset = maker.load()?;
    let names: Vec<_> = asset.model().instances().iter().filter_map(|instance| instance.name()).collect();
    same(&names, &vec!["top", "a", "below a", "b"], "instances")
}

fn later_joint() -> Outcome {
    let mut maker = Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    let joints = maker.accessor(U8, "VEC4", 4, &[0, 7, 0, 0].repeat(4));
    copy_primitive(&mut maker)["attributes"]["JOINTS_0"] = json!(joints);
    refused(&maker, &["meshes[0].primitives[1].attributes.JOINTS_0", "joint 7"])
}

fn extras() -> Outcome {
    let mut maker = Maker::square();
    let damaged = json!({ "aTexture": { "index": -1 } });
    maker.json["materials"] = json!([{ "extras": damaged }]);
    same(&maker.load()?.warnings().len(), &0, "warnings")?;
    maker.json["materials"] = json!([damaged]);
    let warning = maker.load()?.warnings().first().map(ToString::to_string).unwrap_or_default();
    ensure(warning.contains("materials[0].aTexture.index"), || warning.clone())
}

/// A point of an instance, moved.
fn moved(maker: &Maker, point: [f32; 3]) -> Result<[f64; 3], libtest_mimic::Failed> {
    Ok(crate::check::map(&maker.load()?.pose(None, 0.0)?.instances()[0].palette()[0], point))
}

/// Their squares are beyond what a number holds.
fn quaternions() -> Outcome {
    for length in [1e-200, 1e200, 1.0] {
        let mut maker = Maker::square();
        maker.json["nodes"][0]["rotation"] = json!([0.0, 0.0, 0.6 * length, 0.8 * length]);
        // Twice the angle of cosine 0.8: cosine 0.28, sine 0.96.
        close(&moved(&maker, [1.0, 0.0, 0.0])?, &[0.28, 0.96, 0.0], 1e-6, &format!("length {length}"))?;
    }
    Ok(())
}

fn last_rows() -> Outcome {
    for (off, good) in [(0.0, true), (9e-6, true), (2e-5, false), (1e-3, false)] {
        for entry in [3, 7, 11, 15] {
            let mut maker = Maker::square();
            let mut matrix: Vec<f64> = (0..16).map(|i| if i % 5 == 0 { 1.0 } else { 0.0 }).collect();
            matrix[entry] -= off;
            maker.json["nodes"][0]["matrix"] = json!(matrix);
            if good {
                close(&moved(&maker, [1.0, 2.0, 3.0])?, &[1.0, 2.0, 3.0], 0.0, "the last row is as good as exact")?;
            } else {
                refused(&maker, &["nodes[0].matrix", "last row"])?;
            }
        }
    }
    Ok(())
}

/// A light on a node of this scale.
fn light(light: &Value, scale: [f32; 3]) -> Result<SceneLight, libtest_mimic::Failed> {
    let mut maker = Maker::new();
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let extensions = json!({ "KHR_lights_punctual": { "light": 0 } });
    maker.push("nodes", json!({ "scale": scale, "extensions": extensions }));
    Ok(maker.load()?.lights(None, 0.0)?.remove(0))
}

fn lights() -> Outcome {
    let bright =
        light(&json!({ "type": "point", "intensity": 1e300, "range": 1e-300, "color": [1e300, 0, 0] }), [1.0; 3])?;
    same(&(bright.intensity, bright.range), &(f32::MAX, Some(f32::MIN_POSITIVE)), "intensity and range")?;
    same(&bright.color, &[f32::MAX, 0.0, 0.0], "color")?;
    let spot = |inner: f64, outer: f64| {
        let cone = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
        light(&json!({ "type": "spot", "spot": cone }), [1.0; 3])
    };
    let hard = spot(0.5, 0.5)?.cone.ok_or("no cone")?;
    same(&(hard.inner_angle, hard.outer_angle), &(0.5, 0.5), "a cone without a soft rim")?;
    let wide = spot(0.0, std::f64::consts::FRAC_PI_2 + 9e-6)?.cone.ok_or("no cone")?;
    same(&wide.outer_angle, &FRAC_PI_2, "half a turn, rounded up on export")?;
    ensure(spot(0.0, std::f64::consts::FRAC_PI_2 + 2e-5).is_err(), || "more than half a turn".to_owned())
}

fn cones() -> Outcome {
    let spot = json!({ "type": "spot" });
    let cone = light(&spot, [1.0, 1.0, 5.0])?.cone.ok_or("no cone")?;
    same(&cone.direction, &[0.0, 0.0, -1.0], "the direction of a stretched node")?;
    same(&light(&spot, [1.0, 1.0, 0.0])?.cone, &None, "the cone of a flat node")
}

fn joints_needed() -> Outcome {
    let needed = |maker: &Maker| maker.load().map(|asset| asset.model().geometries()[0].joints_needed());
    same(&needed(&Maker::square())?, &1, "rigid")?;
    same(&needed(&Maker::skinned([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]))?, &2, "two joints")?;
    let mut none = Maker::skinned([0; 4], [1.0; 4]);
    primitive(&mut none)["mode"] = json!(0);
    same(&needed(&none)?, &0, "skinned without vertices")
}

fn surfaces() -> Outcome {
    let mut maker = Maker::square();
    maker.json["extensionsRequired"] = json!(["KHR_materials_unlit", "KHR_texture_transform", "KHR_xmp_json_ld"]);
    maker.load()?;
    maker.json["extensionsRequired"] = json!(["KHR_material"]);
    refused(&maker, &["KHR_material", "not supported"])
}

/// Both byte offsets of sparse data; the values' view has a stranger before them, the indices', too.
fn sparse_offsets() -> Outcome {
    let mut maker = Maker::square();
    let indices = maker.view(&[3, 0, 1, 0, 2, 0]);
    let values: Vec<u8> =
        [9.0_f32, 9.0, 9.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let values = maker.view(&values);
    maker.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "byteOffset": 2, "componentType": U16 },
        "values": { "bufferView": values, "byteOffset": 12 },
    });
    let mut expected = SQUARE.as_chunks().0.to_vec();
    expected[1] = [4.0, 5.0, 6.0];
    expected[2] = [7.0, 8.0, 9.0];
    same(&maker.load()?.model().geometries()[0].positions().to_vec(), &expected, "positions")
}

/// Joints and indices are never normalised, weights of integers always are.
fn normalised() -> Outcome {
    let with = |accessor: &str, normalized: bool| {
        let mut maker = Maker::skinned([0, 1, 0, 0], [1.0, 0.0, 0.0, 0.0]);
        let weights = maker.accessor(U8, "VEC4", 4, &[255, 0, 0, 0].repeat(4));
        maker.json["accessors"][weights]["normalized"] = json!(true);
        let primitive = primitive(&mut maker);
        primitive["attributes"]["WEIGHTS_0"] = json!(weights);
        let at = if accessor == "indices" { &primitive["indices"] } else { &primitive["attributes"][accessor] };
        let at = at.as_u64().expect("an index") as usize;
        maker.json["accessors"][at]["normalized"] = json!(normalized);
        maker
    };
    for (accessor, right) in [("JOINTS_0", false), ("WEIGHTS_0", true), ("indices", false)] {
        with(accessor, right).load()?;
        refused(&with(accessor, !right), &[accessor, "expected"])?;
    }
    Ok(())
}
