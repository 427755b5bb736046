//! Reads [`Document`] from JSON: buffers, accessors, meshes, skins.

use std::fmt::Write as _;

use glam::DVec3;
use serde_json::Value;

use super::budget::{Budget, NODE};
use super::document::{
    Accessor, ArrayStart, Buffer, Component, Document, InfluenceSet, KINDS, Mesh, Mode, Named, Node, Part, Primitive,
    Skin, Sparse, View,
};
use super::error::GltfError;
use super::extensions;
use super::json::{INDEX, Json, List, shorten, whole, wrong};
use super::warning::{GltfWarning, Warnings};

/// The lists that indices point into, and the warnings so far.
pub(super) struct Parser<'w> {
    buffers: List,
    views: List,
    pub(super) accessors: List,
    pub(super) meshes: List,
    pub(super) skins: List,
    pub(super) nodes: List,
    pub(super) lights: List,
    materials: List,
    cameras: List,
    pub(super) warnings: &'w Warnings<'w>,
}

/// Reads a document and checks its version, its required extensions, and every index that is used. A fault of a part
/// that the scene may not need is stored with the part.
pub(super) fn document(value: &Value, budget: &Budget, warnings: &Warnings<'_>) -> Result<Document, GltfError> {
    let root = Json::root(value)?;
    version(&root)?;
    let used = extensions::check(&root, warnings)?;
    warnings.leave_out(texture_indices(value))?;
    let punctual = warnings.leave_out(root.extension("KHR_lights_punctual"))?.flatten();
    // A value that is no array counts as an empty list.
    let lenient =
        |json: &Json<'_>, name| Ok(warnings.leave_out(json.length(name))?.unwrap_or(List { name, length: 0 }));
    let parser = Parser {
        buffers: root.length("buffers")?,
        views: root.length("bufferViews")?,
        accessors: root.length("accessors")?,
        meshes: root.length("meshes")?,
        skins: lenient(&root, "skins")?,
        nodes: root.length("nodes")?,
        lights: punctual.as_ref().map_or(Ok(List { name: "lights", length: 0 }), |all| lenient(all, "lights"))?,
        materials: lenient(&root, "materials")?,
        cameras: root.length("cameras").unwrap_or(List { name: "cameras", length: 0 }),
        warnings,
    };
    let (scenes, animations) = (root.length("scenes")?, lenient(&root, "animations")?);
    budget.charge(parser.nodes.length as u64, NODE, &|| "nodes".to_owned())?;
    let buffers = parser.parts(&root, parser.buffers, buffer)?;
    let meshes = parser.named(&root, parser.meshes, |mesh| parser.mesh(mesh))?;
    Ok(Document {
        accessors: parser.parts(&root, parser.accessors, |json| parser.accessor(json))?,
        views: parser.parts(&root, parser.views, |json| parser.view(json, &buffers))?,
        skins: parser.named(&root, parser.skins, |skin| parser.skin(skin))?,
        nodes: parser.nodes(&root, &meshes)?,
        scenes: parser.parts(&root, scenes, |scene| scene.indices("nodes", parser.nodes))?,
        scene: root.index("scene", scenes)?,
        animations: parser.named(&root, animations, |animation| parser.animation(animation))?,
        lights: punctual
            .map_or(Ok(Vec::new()), |json| parser.named(&json, parser.lights, super::parse_scene::light))?,
        cameras: parser.named(&root, parser.cameras, super::parse_scene::projection)?,
        materials: parser.named(&root, parser.materials, base_color)?,
        quantized: used.iter().any(|name| name == "KHR_mesh_quantization"),
        center: center(&root)?,
        buffers,
        meshes,
    })
}

/// The center of `CESIUM_RTC`. The file's list of used extensions may lack it.
fn center(root: &Json<'_>) -> Result<DVec3, GltfError> {
    root.extension("CESIUM_RTC")?.map_or(Ok(DVec3::ZERO), |json| json.need("center").map(DVec3::from_array))
}

fn version(root: &Json<'_>) -> Result<(), GltfError> {
    let asset: Json<'_> = root.need("asset")?;
    let version: &str = asset.need("version")?;
    let needed = asset.get("minVersion")?.unwrap_or("2.0");
    let is_other = |version: &&str| version.split('.').next() != Some("2");
    match [version, needed].into_iter().find(is_other).or((needed != "2.0").then_some(needed)) {
        Some(version) => Err(GltfError::Version { version: shorten(version) }),
        None => Ok(()),
    }
}

/// Checks texture indices. Textures are not read, but an impossible index shows that the file is damaged.
fn texture_indices(root: &Value) -> Result<(), GltfError> {
    root.get("materials").map_or(Ok(()), |materials| walk(materials, &mut "materials".to_owned(), false))
}

fn walk(value: &Value, path: &mut String, in_texture: bool) -> Result<(), GltfError> {
    let length = path.len();
    for (i, item) in value.as_array().into_iter().flatten().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(path, "[{i}]");
        walk(item, path, false)?;
        path.truncate(length);
    }
    for (key, item) in value.as_object().into_iter().flatten().filter(|(key, _)| *key != "extras") {
        // A key may be as long as the file.
        let _ = write!(path, ".{key:.60}");
        if in_texture && key == "index" && whole(item).is_none() {
            return Err(wrong(path.clone(), INDEX, item));
        }
        walk(item, path, key.ends_with("Texture"))?;
        path.truncate(length);
    }
    Ok(())
}

fn buffer(json: &Json<'_>) -> Result<Buffer, GltfError> {
    Ok(Buffer { uri: json.get("uri")?.map(str::to_owned), bytes: json.need("byteLength")? })
}

/// The base colour factor of a material, without alpha.
fn base_color(json: &Json<'_>) -> Result<[f32; 3], GltfError> {
    let metallic: Option<Json<'_>> = json.get("pbrMetallicRoughness")?;
    let factor = metallic.map_or(Ok(None), |metallic| metallic.get("baseColorFactor"))?;
    let [red, green, blue, _]: [f64; 4] = factor.unwrap_or([1.0; 4]);
    Ok([red, green, blue].map(|component| component as f32))
}

fn component(json: &Json<'_>) -> Result<Component, GltfError> {
    let number: u64 = json.need("componentType")?;
    let component = Component::ALL.into_iter().find(|component| *component as u64 == number);
    let expected = "a component type (5120, 5121, 5122, 5123, 5125 or 5126)";
    component.ok_or_else(|| json.wrong("componentType", expected))
}

/// The index of a set of attributes. glTF writes it without a sign and without leading zeros.
fn set_index(text: &str) -> Option<u32> {
    text.parse().ok().filter(|set: &u32| set.to_string() == text)
}

fn offset(json: &Json<'_>) -> Result<u64, GltfError> {
    Ok(json.get("byteOffset")?.unwrap_or(0))
}

impl Parser<'_> {
    /// The elements of a list, each with its fault.
    fn parts<T>(
        &self,
        root: &Json<'_>,
        list: List,
        read: impl Fn(&Json<'_>) -> Result<T, GltfError>,
    ) -> Result<Vec<Part<T>>, GltfError> {
        root.elements(list.name)?.map(|json| self.warnings.keep(json.and_then(|json| read(&json)))).collect()
    }

    /// The same for parts that have names. There are none where `list` is empty, also because the value is no array.
    fn named<T>(
        &self,
        root: &Json<'_>,
        list: List,
        read: impl Fn(&Json<'_>) -> Result<T, GltfError>,
    ) -> Result<Vec<Named<T>>, GltfError> {
        if list.length == 0 {
            return Ok(Vec::new());
        }
        let element = |json| match self.warnings.keep(json)? {
            Ok(json) => Ok(Named { name: Json::name(&json, self.warnings)?, part: self.warnings.keep(read(&json))? }),
            Err(fault) => Ok(Named { name: None, part: Err(fault) }),
        };
        root.elements(list.name)?.map(element).collect()
    }

    fn nodes(&self, root: &Json<'_>, meshes: &[Named<Mesh>]) -> Result<Vec<Node>, GltfError> {
        let nodes = self.named(root, self.nodes, |json| self.node(json, meshes))?;
        let node = |(Named { name, part }, json): (_, Result<Json<'_>, _>)| {
            // Light and camera of a node are there even if the rest has a fault.
            let camera = |json: &Json<'_>| Ok(self.warnings.keep(json.index("camera", self.cameras))?.transpose());
            let (light, camera) =
                json.map_or(Ok((None, None)), |json| Ok::<_, GltfError>((self.light_index(&json)?, camera(&json)?)))?;
            let content = part.unwrap_or_else(|fault| Node { fault: Some(fault), ..Node::default() });
            Ok(Node { name, light, camera, ..content })
        };
        nodes.into_iter().zip(root.elements("nodes")?).map(node).collect()
    }

    fn view(&self, json: &Json<'_>, buffers: &[Part<Buffer>]) -> Result<View, GltfError> {
        let mut compressed = None;
        for name in extensions::MESHOPT {
            compressed = json.extension(name)?.map(|_| name).or(compressed);
        }
        let view = View {
            buffer: json.need_index("buffer", self.buffers)?,
            offset: offset(json)?,
            bytes: json.need("byteLength")?,
            stride: json.get("byteStride")?,
            compressed,
        };
        // A buffer that cannot be read is refused where it is read.
        let available = buffers[view.buffer].as_ref().map_or(u64::MAX, |buffer| buffer.bytes);
        let needed = view.offset.saturating_add(view.bytes);
        if needed > available {
            let json_path = format!("{} (byteOffset and byteLength)", json.path);
            return Err(GltfError::too_short(json_path, needed, available));
        }
        Ok(view)
    }

    fn accessor(&self, json: &Json<'_>) -> Result<Accessor, GltfError> {
        let name: &str = json.need("type")?;
        let kind = KINDS.into_iter().find(|kind| kind.0 == name);
        let kind = kind.ok_or_else(|| json.wrong("type", "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4"))?;
        Ok(Accessor {
            view: json.index("bufferView", self.views)?,
            offset: offset(json)?,
            count: json.need("count")?,
            component: component(json)?,
            kind,
            normalized: json.get("normalized")?.unwrap_or(false),
            sparse: json.get("sparse")?.map(|sparse| self.sparse(&sparse)).transpose()?,
        })
    }

    fn sparse(&self, json: &Json<'_>) -> Result<Sparse, GltfError> {
        let (indices, values): (Json<'_>, Json<'_>) = (json.need("indices")?, json.need("values")?);
        let start = |json: &Json<'_>| -> Result<ArrayStart, GltfError> {
            Ok(ArrayStart { view: json.need_index("bufferView", self.views)?, offset: offset(json)? })
        };
        let (index_start, component) = (start(&indices)?, component(&indices)?);
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(indices.wrong("componentType", "an unsigned integer type (5121, 5123 or 5125)"));
        }
        Ok(Sparse { count: json.need("count")?, indices: index_start, component, values: start(&values)? })
    }

    fn mesh(&self, json: &Json<'_>) -> Result<Mesh, GltfError> {
        let primitives: Vec<Json<'_>> = json.list("primitives")?;
        let primitives: Vec<_> = primitives.iter().map(|json| self.primitive(json)).collect::<Result<_, _>>()?;
        let targets = primitives.first().map_or(0, |p| p.targets.len());
        if let Some(other) = primitives.iter().position(|p| p.targets.len() != targets) {
            let json_path = format!("{}.primitives[{other}].targets", json.path);
            return Err(GltfError::count(json_path, primitives[other].targets.len(), targets));
        }
        let weights = self.weights(json.get("weights")?, targets, || json.path_of("weights"))?;
        Ok(Mesh { primitives, weights, targets })
    }

    /// Checks that there are as many morph weights as targets. Weights without any target are left out.
    pub(super) fn weights(
        &self,
        weights: Option<Vec<f64>>,
        targets: usize,
        json_path: impl Fn() -> String,
    ) -> Result<Option<Vec<f64>>, GltfError> {
        match weights.as_ref().map(Vec::len) {
            Some(count) if targets == 0 && count > 0 => {
                let problem = format!(" has {count} morph weights, but there are no morph targets; they are ignored");
                self.warnings.push(GltfWarning::Changed { json_path: json_path(), problem })?;
                Ok(None)
            }
            Some(count) if count != targets => Err(GltfError::count(json_path(), count, targets)),
            _ => Ok(weights),
        }
    }

    fn primitive(&self, json: &Json<'_>) -> Result<Primitive, GltfError> {
        let mode = match json.get("mode")? {
            Some(0) => Mode::Points,
            Some(1..=3) => Mode::Lines,
            None | Some(4) => Mode::Triangles,
            Some(5) => Mode::Strip,
            Some(6) => Mode::Fan,
            Some(_) => return Err(json.wrong("mode", "a primitive mode from 0 to 6")),
        };
        let attributes: Json<'_> = json.need("attributes")?;
        let targets: Vec<Json<'_>> = json.list("targets")?;
        let position = |json: &Json<'_>| json.index("POSITION", self.accessors);
        Ok(Primitive {
            mode,
            targets: targets.iter().map(position).collect::<Result<_, _>>()?,
            influences: self.warnings.keep(self.influences(&attributes))?,
            indices: json.index("indices", self.accessors)?,
            position: position(&attributes)?,
            material: self.warnings.keep(json.index("material", self.materials))?,
            color: self.warnings.keep(attributes.index("COLOR_0", self.accessors))?,
            draco: json.extension(extensions::DRACO)?.is_some(),
        })
    }

    /// Pairs `JOINTS_n` with `WEIGHTS_n`. It is an error if one of them is missing. Names that glTF does not allow, such as
    /// `JOINTS_00` and `WEIGHTS_00`, are ignored.
    fn influences(&self, attributes: &Json<'_>) -> Result<Vec<InfluenceSet>, GltfError> {
        let mut sets = Vec::new();
        for key in attributes.keys() {
            let set_of = |prefix: &str| key.strip_prefix(prefix).and_then(set_index);
            if let Some(joints) = set_of("WEIGHTS_").map(|set| format!("JOINTS_{set}"))
                && !attributes.has(&joints)
            {
                return Err(GltfError::missing(attributes.path_of(&joints)));
            }
            let Some(set) = set_of("JOINTS_") else { continue };
            let index = |key: &str| attributes.need_index(key, self.accessors);
            sets.push(InfluenceSet { set, joints: index(key)?, weights: index(&format!("WEIGHTS_{set}"))? });
        }
        sets.sort_by_key(|set| set.set);
        Ok(sets)
    }

    fn skin(&self, json: &Json<'_>) -> Result<Skin, GltfError> {
        let joints = json.indices("joints", self.nodes)?;
        if joints.is_empty() {
            return Err(GltfError::missing(json.path_of("joints")));
        }
        Ok(Skin { joints, inverse_binds: json.index("inverseBindMatrices", self.accessors)? })
    }
}
