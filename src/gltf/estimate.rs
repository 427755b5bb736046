//! Estimates of the memory that a document's meshes will take, by the counts that it states, before any data is read.

use std::collections::HashSet;

use super::budget::{self, Budget};
use super::document::{Document, Mesh, Node};
use super::error::GltfError;
use super::files::path_bytes;
use super::graph::Graph;
use super::triangles;

/// The size of a mesh that is to be read. Vertices are those before welding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Size {
    vertices: u64,
    faces: u64,
    targets: usize,
}

/// Refuses a document whose meshes and instances do not fit with `files` bytes of files that are yet to be read. Everything
/// is charged when it is made; this knows earlier. Vertices count as before welding, so it may refuse what would fit.
pub(super) fn check(document: &Document, graph: &Graph, files: u64, budget: &Budget) -> Result<(), GltfError> {
    let sizes: Vec<Size> =
        document.meshes.iter().map(|mesh| mesh.part.as_ref().map_or(Size::default(), |m| size(document, m))).collect();
    let buffers = document.buffers.iter().flatten().filter_map(|buffer| Some((buffer.uri.as_ref()?, buffer.bytes)));
    let files = buffers.clone().fold(files, |sum, (_, bytes)| sum.saturating_add(bytes));
    // The most that is in use at one time, and what for: the error is to name what is enough for all.
    let mut most = (0, String::new());
    let mut take = |bytes: u64, placed: u64, what: &dyn Fn() -> String| {
        let needed = budget.needed(bytes, placed);
        if needed > most.0 {
            most = (needed, what());
        }
    };
    let mut lasting: u64 = buffers.map(|(uri, _)| path_bytes(uri)).sum();
    for (m, &Size { vertices, faces, targets }) in sizes.iter().enumerate() {
        let welding = budget::welding(vertices, targets, faces);
        take(lasting.saturating_add(files).saturating_add(welding), 0, &|| format!("meshes[{m}]"));
        lasting = lasting.saturating_add(budget::geometry(vertices, targets, faces));
    }
    let mut placed: u64 = 0;
    let mut add = |mesh: usize, count: u64| {
        if let Some(&Size { vertices, faces, .. }) = sizes.get(mesh).filter(|size| size.faces > 0) {
            placed = placed.saturating_add(budget::placed(vertices, faces).saturating_mul(count));
            lasting = lasting.saturating_add(budget::RIGID_INSTANCE.saturating_mul(count));
            take(lasting, placed, &|| format!("meshes[{mesh}] (its instances)"));
        }
    };
    for node in graph.scene.iter().filter_map(|&n| document.nodes.get(n)) {
        if let Some(mesh) = node.mesh {
            add(mesh, instances(document, node));
        }
    }
    if document.scenes.is_empty() {
        let used: HashSet<usize> = document.nodes.iter().filter_map(|node| node.mesh).collect();
        (0..sizes.len()).filter(|mesh| !used.contains(mesh)).for_each(|mesh| add(mesh, 1));
    }
    let (needed, what) = most;
    budget.refuse(needed, &|| what.clone())
}

/// The elements of an accessor, if its view can hold them. Else reading it gives the error. Zeros without a view take no
/// time to read, and are charged then.
fn count(document: &Document, accessor: usize) -> u64 {
    let Ok(accessor) = &document.accessors[accessor] else { return 0 };
    let Some(Ok(view)) = accessor.view.map(|view| &document.views[view]) else { return 0 };
    let Ok(buffer) = &document.buffers[view.buffer] else { return 0 };
    let [_, length] = view.extent(accessor.count, accessor.element() as u64);
    let is_there = view.offset.saturating_add(view.bytes) <= buffer.bytes;
    if is_there && length.saturating_add(accessor.offset) <= view.bytes { accessor.count } else { 0 }
}

/// Primitives with the same positions mostly share their vertices.
fn size(document: &Document, mesh: &Mesh) -> Size {
    let mut size = Size { targets: mesh.targets, ..Size::default() };
    let mut counted = HashSet::new();
    for primitive in mesh.primitives.iter().filter(|primitive| primitive.mode.has_triangles()) {
        let Some(position) = primitive.position else { continue };
        if counted.insert(position) {
            size.vertices = size.vertices.saturating_add(count(document, position));
        }
        let corners = count(document, primitive.indices.unwrap_or(position));
        size.faces = size.faces.saturating_add(triangles::face_count(primitive.mode, corners));
    }
    size
}

/// The instances that a node makes of its mesh.
fn instances(document: &Document, node: &Node) -> u64 {
    node.instancing
        .map_or(1, |all| all.into_iter().flatten().map(|accessor| count(document, accessor)).min().unwrap_or(0))
}
