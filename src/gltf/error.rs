//! Why a glTF file or a pose of it is refused.

use std::path::PathBuf;
use std::sync::Arc;

use crate::model::ModelError;

/// Why a glTF file, or a part of it, is refused. Places are JSON paths into the file, such as
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
    /// A part of the file is missing, has an impossible value, or does not fit its use. In the container of a GLB the path
    /// names a byte. `problem` has the words behind the path.
    #[error("{json_path}{problem}")]
    Invalid { json_path: String, problem: String },
    /// The file has another glTF version than 2.
    #[error("glTF version {version} is not supported, only 2.0 is; convert the file")]
    Version { version: String },
    /// The file needs an extension that is not supported.
    #[error("{json_path} needs the extension {name}, which is not supported; {advice}")]
    Extension { name: String, json_path: String, advice: &'static str },
    /// Loading would take more memory than [`LoadOptions::memory_limit`](super::LoadOptions::memory_limit). This guards
    /// against small files that fill the memory. `what` is the next allocation, which is among the bytes needed: a file, or
    /// a JSON path.
    #[error(
        "{what}: loading needs at least {needed} bytes of memory, more than the limit of {limit}; raise the limit if \
         the file is meant to be that large, else split it"
    )]
    TooLarge { what: String, needed: u64, limit: u64 },
    /// The machine has no room for what a part of the file takes, though the memory limit allows it.
    #[error("{what}: {bytes} bytes do not fit into the memory of this machine; split the file")]
    Memory { what: String, bytes: u64 },
    /// A file name leads outside the folder of the glTF. `uri` has its first characters.
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
    /// A light is damaged. The rest of the file can be used.
    #[error("the light of nodes[{node}] cannot be used: {source}")]
    DamagedLight { node: usize, source: Box<GltfError> },
    /// A camera is damaged. The rest of the file can be used.
    #[error("the camera of nodes[{node}] cannot be used: {source}")]
    DamagedCamera { node: usize, source: Box<GltfError> },
    /// The time is NaN.
    #[error("the time is not a number; give seconds")]
    Time,
    /// A matrix or a morph weight is infinite or NaN.
    #[error("{json_path} has no finite transform or morph weights at {time_s} s")]
    NotFinite { json_path: String, time_s: f32 },
}

impl GltfError {
    /// An error about a part of the file. `problem` follows the path in the message.
    pub(super) fn invalid(json_path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { json_path: json_path.into(), problem: problem.into() }
    }

    /// The content of the file does not make a model.
    pub(super) fn model(json_path: impl Into<String>) -> impl FnOnce(ModelError) -> Self {
        |error| Self::invalid(json_path, format!(": {error}"))
    }

    pub(super) fn missing(json_path: impl Into<String>) -> Self {
        Self::invalid(json_path, " is missing")
    }

    /// A list that must be as long as another has another length.
    pub(super) fn count(json_path: impl Into<String>, count: usize, expected: usize) -> Self {
        Self::invalid(json_path, format!(" has {count} elements, expected {expected}"))
    }

    /// A buffer, or a view into it, is longer than its data.
    pub(super) fn too_short(json_path: impl Into<String>, needed: u64, available: u64) -> Self {
        Self::invalid(json_path, format!(" needs {needed} bytes, but only {available} are there"))
    }
}

impl PartialEq for GltfError {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}
