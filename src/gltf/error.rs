//! Why a glTF file or a pose of it is refused.

use std::path::PathBuf;
use std::sync::Arc;

use crate::model::ModelError;

/// Why a glTF file, or a part of it, is refused. Places are JSON paths into the file, such as
/// `meshes[0].primitives[2].attributes`. Two errors are equal if their messages are.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GltfError {
    /// The file, or a file that it names, cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: Arc<std::io::Error>,
    },
    /// The text is not JSON.
    #[error("the glTF JSON cannot be parsed: {0}")]
    Json(#[source] Arc<serde_json::Error>),
    /// A part of the file is missing, has an impossible value, or does not fit its use.
    #[error("{json_path}{problem}")]
    Invalid {
        /// JSON path of the part. In the container of a GLB: the byte.
        json_path: String,
        /// The fault: the words after the path in the message.
        problem: String,
    },
    /// The file has another glTF version than 2.
    #[error("glTF version {version} is not supported, only 2.0 is; convert the file")]
    Version {
        /// The version as written in the file.
        version: String,
    },
    /// The file needs an extension that is not supported.
    #[error("{json_path} needs the extension {name}, which is not supported; {advice}")]
    Extension {
        /// The extension.
        name: String,
        /// Where the file needs it.
        json_path: String,
        /// Advice to the user.
        advice: &'static str,
    },
    /// Loading would take more memory than the caller allows. This guards against small files that fill the memory.
    #[error(
        "{what}: loading needs at least {needed} bytes of memory, more than the limit of {limit}; raise the limit if \
         the file is meant to be that large, else split it"
    )]
    TooLarge {
        /// The next allocation: a file, or a JSON path.
        what: String,
        /// Bytes that would be in use at one time, including this allocation.
        needed: u64,
        /// [`LoadOptions::memory_limit`](super::LoadOptions::memory_limit).
        limit: u64,
    },
    /// A file name leads outside the folder of the glTF.
    #[error(
        "{json_path}: {uri:?} leads to {}, which is outside the glTF's folder and is not read; put the file there, or \
         allow files outside if the glTF is trusted", path.display()
    )]
    Outside {
        /// JSON path of the URI.
        json_path: String,
        /// Its first characters.
        uri: String,
        /// The path that it leads to.
        path: PathBuf,
    },
    /// There is no such animation.
    #[error("animation {index} was asked for, but the file has {count}")]
    NoAnimation {
        /// The requested index.
        index: usize,
        /// Animations in the file.
        count: usize,
    },
    /// The animation is damaged. The rest of the file can be used.
    #[error("animation {index} cannot be played: {source}")]
    DamagedAnimation {
        /// The requested index.
        index: usize,
        /// The fault, and where it is.
        source: Box<GltfError>,
    },
    /// Two of the animations move the same property of a node, so they cannot play together.
    #[error("animations {first} and {second} both move the {property} of nodes[{node}]; leave one of them out")]
    SameProperty {
        /// Index of an animation.
        first: usize,
        /// Index of another requested animation.
        second: usize,
        /// Index of the node.
        node: usize,
        /// `translation`, `rotation`, `scale` or `weights`.
        property: &'static str,
    },
    /// A light is damaged. The rest of the file can be used.
    #[error("the light of nodes[{node}] cannot be used: {source}")]
    DamagedLight {
        /// Index of the light's node.
        node: usize,
        /// The fault, and where it is.
        source: Box<GltfError>,
    },
    /// A camera is damaged. The rest of the file can be used.
    #[error("the camera of nodes[{node}] cannot be used: {source}")]
    DamagedCamera {
        /// Index of the camera's node.
        node: usize,
        /// The fault, and where it is.
        source: Box<GltfError>,
    },
    /// The time is NaN.
    #[error("the time is not a number; give seconds")]
    Time,
    /// A matrix or a morph weight is infinite or NaN.
    #[error("{json_path} has no finite transform or morph weights at {time_s} s")]
    NotFinite {
        /// JSON path of the node of the instance or light.
        json_path: String,
        /// The requested time.
        time_s: f32,
    },
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
