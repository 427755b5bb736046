//! Why a glTF file or a pose of it is refused.

use std::path::PathBuf;
use std::sync::Arc;

use crate::model::ModelError;

/// Why a glTF file, a part of it or a pose is refused. Errors name a part by its JSON path in the file, such as
/// `meshes[0].primitives[2].attributes`. Two errors are equal if their messages are.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum GltfError {
    /// The file, or a file that it names, cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read { path: PathBuf, source: Arc<std::io::Error> },
    /// The text is not JSON.
    #[error("the glTF JSON cannot be parsed: {0}")]
    Json(#[source] Arc<serde_json::Error>),
    /// A part of the file is missing, has an impossible value, or does not fit its use. For the container of a GLB the path
    /// is the offset of a byte. `problem` follows the path in the message.
    #[error("{json_path}{problem}")]
    Invalid { json_path: String, problem: String },
    /// The major version of the file is not 2, or its `minVersion` is not 2.0. `version` is the refused one.
    #[error("glTF version {version} is not supported, only 2.0 is; convert the file")]
    Version { version: String },
    /// The file or a part of it needs an extension that is not supported.
    #[error("{json_path} needs the extension {name}, which is not supported; {advice}")]
    Extension { name: String, json_path: String, advice: &'static str },
    /// Loading would take more memory than [`LoadOptions::memory_limit`](super::LoadOptions::memory_limit), or all its
    /// allocations together more than eight times that. This guards against small files that fill the memory. `what` is the
    /// file or the JSON path that the refused allocation is for, and `needed` the limit that allows it: the memory in use,
    /// or an eighth of all allocations. The rest of the file may need more.
    #[error(
        "{what}: loading needs a memory limit of at least {needed} bytes, and it is {limit}; raise it if the file is meant to \
         be that large, else split the file"
    )]
    TooLarge { what: String, needed: u64, limit: u64 },
    /// The memory limit allows the allocation for a part of the file, but it fails.
    #[error("{what}: {bytes} bytes do not fit into the memory of this machine; split the file")]
    Memory { what: String, bytes: u64 },
    /// A URI leads outside the folder of the glTF. `uri` has at most its first 60 characters, `path` is where it leads.
    #[error(
        "{json_path}: {uri:?} leads to {}, which is outside the glTF's folder and is not read; put the file there, or \
         allow files outside if the glTF is trusted", path.display()
    )]
    Outside { json_path: String, uri: String, path: PathBuf },
    /// There is no such animation.
    #[error("animation {index} was asked for, but the file has {count}")]
    NoAnimation { index: usize, count: usize },
    /// The animation is damaged. The rest of the file can be used.
    #[error("animation {index} cannot be played: {source}")]
    DamagedAnimation { index: usize, source: Box<GltfError> },
    /// Two of the animations move the same property of a node, so they cannot play together.
    #[error("animations {first} and {second} both move the {property} of nodes[{node}]; leave one of them out")]
    SameProperty { first: usize, second: usize, node: usize, property: &'static str },
    /// A light, or its node's reference to it, is damaged. The rest of the file can be used.
    #[error("the light of nodes[{node}] cannot be used: {source}")]
    DamagedLight { node: usize, source: Box<GltfError> },
    /// A camera, or the node that has it, is damaged. The rest of the file can be used.
    #[error("the camera of nodes[{node}] cannot be used: {source}")]
    DamagedCamera { node: usize, source: Box<GltfError> },
    /// The time is NaN.
    #[error("the time is not a number; give seconds")]
    Time,
    /// A transform or morph weight at this time is not finite in `f32`, or a directional light or a camera has no
    /// direction because its node is scaled to 0.
    #[error("{json_path} has no finite transform or morph weights at {time_s} s")]
    NotFinite { json_path: String, time_s: f32 },
}

impl GltfError {
    /// An error about a part of the file. `problem` follows the path in the message.
    pub(super) fn invalid(json_path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { json_path: json_path.into(), problem: problem.into() }
    }

    /// Makes the error of a model an error about a part of the file.
    pub(super) fn model(json_path: impl Into<String>) -> impl FnOnce(ModelError) -> Self {
        |error| Self::invalid(json_path, format!(": {error}"))
    }

    pub(super) fn missing(json_path: impl Into<String>) -> Self {
        Self::invalid(json_path, " is missing")
    }

    /// The error for a list that has another length than it must have.
    pub(super) fn count(json_path: impl Into<String>, count: usize, expected: usize) -> Self {
        Self::invalid(json_path, format!(" has {count} elements, expected {expected}"))
    }

    /// The error for a buffer that is longer than its data, or a view that ends behind its buffer.
    pub(super) fn too_short(json_path: impl Into<String>, needed: u64, available: u64) -> Self {
        Self::invalid(json_path, format!(" needs {needed} bytes, but only {available} are there"))
    }
}

impl PartialEq for GltfError {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}
