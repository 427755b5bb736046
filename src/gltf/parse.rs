//! Reads [`Document`] from JSON.

use std::fmt::Write as _;

use glam::DVec3;
use gltf::json::Value;
use gltf::json::accessor::{ComponentType, Type};

use super::budget::Budget;
use super::document::{Accessor, Buffer, Document, Node, Part, Sparse, View};
use super::error::GltfError;
use super::json::{Json, whole, wrong};
use super::lengths::Lengths;
use super::warning::Warnings;
use super::{extensions, parse_mesh, parse_scene};

const COMPONENT: &str = "a component type (5120, 5121, 5122, 5123, 5125 or 5126)";

/// Reads a document and checks its version, its required extensions, and every index that is used. A fault of a part that the
/// scene may not need is kept with the part.
pub(super) fn document(value: &Value, budget: &Budget, warnings: &Warnings<'_>) -> Result<Document, GltfError> {
    let root = Json::new(value, String::new())?;
    version(&root)?;
    let used = extensions::check(&root, warnings)?;
    warnings.leave_out(texture_indices(value, &mut String::new()))?;
    let punctual = warnings.leave_out(root.extension("KHR_lights_punctual"))?.flatten();
    // A list that is none leaves out what it was to hold.
    let count = |json: &Json<'_>, key: &str| warnings.leave_out(json.count(key)).map(Option::unwrap_or_default);
    let lengths = Lengths {
        buffers: root.count("buffers")?,
        views: root.count("bufferViews")?,
        accessors: root.count("accessors")?,
        meshes: root.count("meshes")?,
        skins: count(&root, "skins")?,
        nodes: root.count("nodes")?,
        scenes: root.count("scenes")?,
        lights: punctual.as_ref().map_or(Ok(0), |lights| count(lights, "lights"))?,
    };
    budget.charge_nodes(lengths.nodes)?;
    let animations = count(&root, "animations")?;
    let mut document = Document {
        buffers: parts(&root, "buffers", warnings, buffer)?,
        accessors: parts(&root, "accessors", warnings, |a| accessor(a, lengths))?,
        views: Vec::new(),
        meshes: all(&root, "meshes", lengths.meshes, |mesh| parse_mesh::mesh(mesh, lengths, warnings))?,
        skins: all(&root, "skins", lengths.skins, |skin| parse_mesh::skin(skin, lengths, warnings))?,
        nodes: all(&root, "nodes", lengths.nodes, |node| parse_scene::node(node, lengths, warnings))?,
        scenes: parts(&root, "scenes", warnings, |scene| scene.indices("nodes", "nodes", lengths.nodes))?,
        scene: root.index("scene", "scenes", lengths.scenes)?,
        animations: all(&root, "animations", animations, |json| parse_scene::animation(json, lengths, warnings))?,
        lights: match &punctual {
            Some(lights) => all(lights, "lights", lengths.lights, |light| parse_scene::light(light, warnings))?,
            None => Vec::new(),
        },
        quantized: used.iter().any(|name| name == "KHR_mesh_quantization"),
        center: center(&root)?,
    };
    for (index, json) in root.elements("bufferViews")?.enumerate() {
        let read = json.and_then(|json| view(&json, index, lengths, &document.buffers));
        document.views.push(warnings.keep(read)?);
    }
    check_weights(&mut document, warnings)?;
    Ok(document)
}

/// The elements of a list, each with its fault.
fn parts<T>(
    root: &Json<'_>,
    key: &str,
    warnings: &Warnings<'_>,
    read: impl Fn(&Json<'_>) -> Result<T, GltfError>,
) -> Result<Vec<Part<T>>, GltfError> {
    root.elements(key)?.map(|json| warnings.keep(json.and_then(|json| read(&json)))).collect()
}

/// The elements of a list, which know their faults themselves. There are none where the list is none.
fn all<'a, T>(
    root: &Json<'a>,
    key: &str,
    count: usize,
    read: impl Fn(Result<Json<'a>, GltfError>) -> Result<T, GltfError>,
) -> Result<Vec<T>, GltfError> {
    if count == 0 { Ok(Vec::new()) } else { root.elements(key)?.map(read).collect() }
}

/// Checks that each node has as many morph weights as its mesh has targets.
fn check_weights(document: &mut Document, warnings: &Warnings<'_>) -> Result<(), GltfError> {
    let Document { nodes, meshes, .. } = document;
    for (n, node) in nodes.iter_mut().enumerate() {
        let Node { weights, mesh, fault, .. } = node;
        let (Some(given), targets) = (weights.take(), mesh.map_or(0, |mesh| meshes[mesh].targets)) else { continue };
        if mesh.is_some_and(|mesh| meshes[mesh].fault.is_some()) {
            continue;
        }
        let checked = parse_mesh::checked_weights(given, targets, || format!("nodes[{n}].weights"), warnings);
        match warnings.keep(checked)? {
            Ok(checked) => *weights = checked,
            Err(wrong) => *fault = fault.take().or(Some(wrong)),
        }
    }
    Ok(())
}

/// The center of `CESIUM_RTC`. The file's list of used extensions may lack it.
fn center(root: &Json<'_>) -> Result<DVec3, GltfError> {
    let Some(relative) = root.extension("CESIUM_RTC")? else { return Ok(DVec3::ZERO) };
    Ok(DVec3::from_array(relative.required("center", relative.vector("center")?)?))
}

fn version(root: &Json<'_>) -> Result<(), GltfError> {
    let asset = root.required("asset", root.object("asset")?)?;
    let version = asset.required("version", asset.string("version")?)?;
    let needed = asset.string("minVersion")?.unwrap_or("2.0");
    for version in [version, needed] {
        if version.split('.').next() != Some("2") {
            let version = super::json::shorten(version);
            return Err(GltfError::Version { version });
        }
    }
    if needed != "2.0" {
        let version = super::json::shorten(needed);
        return Err(GltfError::Version { version });
    }
    Ok(())
}

/// Checks texture indices. Textures are not read, but an impossible index tells that the file is damaged.
fn texture_indices(root: &Value, path: &mut String) -> Result<(), GltfError> {
    let Some(materials) = root.get("materials") else {
        return Ok(());
    };
    path.push_str("materials");
    walk(materials, path, false)
}

fn walk(value: &Value, path: &mut String, in_texture: bool) -> Result<(), GltfError> {
    let length = path.len();
    if let Some(items) = value.as_array() {
        for (i, item) in items.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(path, "[{i}]");
            walk(item, path, false)?;
            path.truncate(length);
        }
    }
    for (key, item) in value.as_object().into_iter().flatten() {
        if key == "extras" {
            continue;
        }
        path.push('.');
        path.push_str(key);
        if in_texture && key == "index" && whole(item).is_none() {
            let expected = "an index (a whole number of 0 or more)";
            return Err(wrong(path.clone(), expected, item));
        }
        walk(item, path, key.ends_with("Texture"))?;
        path.truncate(length);
    }
    Ok(())
}

fn buffer(json: &Json<'_>) -> Result<Buffer, GltfError> {
    Ok(Buffer {
        uri: json.string("uri")?.map(str::to_owned),
        bytes: json.required("byteLength", json.whole("byteLength")?)?,
    })
}

fn view(json: &Json<'_>, index: usize, lengths: Lengths, buffers: &[Part<Buffer>]) -> Result<View, GltfError> {
    let mut compressed = None;
    for name in extensions::MESHOPT {
        if json.extension(name)?.is_some() {
            compressed = Some(name);
        }
    }
    let view = View {
        buffer: json.required("buffer", json.index("buffer", "buffers", lengths.buffers)?)?,
        offset: json.whole("byteOffset")?.unwrap_or(0),
        bytes: json.required("byteLength", json.whole("byteLength")?)?,
        stride: json.whole("byteStride")?,
        compressed,
    };
    // A buffer that cannot be read is refused where it is read.
    let available = buffers[view.buffer].as_ref().map_or(u64::MAX, |buffer| buffer.bytes);
    let needed = view.offset.saturating_add(view.bytes);
    if needed > available {
        let place = format!("bufferViews[{index}] (byteOffset and byteLength)");
        return Err(GltfError::TooShort { place, needed, available });
    }
    Ok(view)
}

fn accessor(json: &Json<'_>, lengths: Lengths) -> Result<Accessor, GltfError> {
    let kind = match json.required("type", json.string("type")?)? {
        "SCALAR" => Type::Scalar,
        "VEC2" => Type::Vec2,
        "VEC3" => Type::Vec3,
        "VEC4" => Type::Vec4,
        "MAT2" => Type::Mat2,
        "MAT3" => Type::Mat3,
        "MAT4" => Type::Mat4,
        _ => return Err(json.wrong("type", "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4")),
    };
    Ok(Accessor {
        view: json.index("bufferView", "bufferViews", lengths.views)?,
        offset: json.whole("byteOffset")?.unwrap_or(0),
        count: json.required("count", json.whole("count")?)?,
        component: component(json)?,
        kind,
        normalized: json.flag("normalized")?,
        sparse: json.object("sparse")?.map(|s| sparse(&s, lengths)).transpose()?,
    })
}

fn component(json: &Json<'_>) -> Result<ComponentType, GltfError> {
    Ok(match json.required("componentType", json.whole("componentType")?)? {
        5120 => ComponentType::I8,
        5121 => ComponentType::U8,
        5122 => ComponentType::I16,
        5123 => ComponentType::U16,
        5125 => ComponentType::U32,
        5126 => ComponentType::F32,
        _ => return Err(json.wrong("componentType", COMPONENT)),
    })
}

fn sparse(json: &Json<'_>, lengths: Lengths) -> Result<Sparse, GltfError> {
    let indices = json.required("indices", json.object("indices")?)?;
    let values = json.required("values", json.object("values")?)?;
    let place = |json: &Json<'_>| {
        let view = json.index("bufferView", "bufferViews", lengths.views)?;
        let offset = json.whole("byteOffset")?.unwrap_or(0);
        Ok::<_, GltfError>((json.required("bufferView", view)?, offset))
    };
    let (view, offset) = place(&indices)?;
    let component = component(&indices)?;
    if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
        return Err(indices.wrong("componentType", "an unsigned integer type (5121, 5123 or 5125)"));
    }
    Ok(Sparse {
        count: json.required("count", json.whole("count")?)?,
        indices: (view, offset, component),
        values: place(&values)?,
    })
}
