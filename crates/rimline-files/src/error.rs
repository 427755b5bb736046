//! Why a file is refused.

use std::io;
use std::path::PathBuf;

use rimline::gltf::GltfError;
use rimline::{MeshError, ModelError};

use crate::format::FormatError;
use crate::npz::NpzError;
use crate::obj::ObjError;
use crate::ply::PlyError;
use crate::size::size;
use crate::stl::StlError;

/// Why a file is refused. The messages do not say its name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// Neither its first bytes nor its name say a format that is read.
    #[error(
        "cannot read {what}: use .glb, .gltf, .obj, .ply, .stl or .npz; Blender and `assimp export IN OUT.glb` convert most others"
    )]
    Format {
        /// The ending, or what stands for it.
        what: String,
    },
    /// It is certainly of a format that is not read, or its beginning, which says the format, cannot be read.
    #[error(transparent)]
    Foreign(#[from] FormatError),
    /// The fault of a glTF, or of its animations.
    #[error(transparent)]
    Gltf(GltfError),
    /// A glTF takes more memory than [`ReadOptions::memory_limit`](crate::ReadOptions::memory_limit). The faults of other
    /// formats have variants of their own for it.
    #[error(
        "{what}: this needs a --memory-limit of at least {}, and the limit is {}; give a larger one if it is meant to be \
         that large", size(*.needed), size(*.limit)
    )]
    TooLarge {
        /// A part of it, or a file that it names.
        what: String,
        /// The least limit that allows it, in bytes.
        needed: u64,
        /// Bytes.
        limit: u64,
    },
    /// A glTF names a file outside its folder, see [`ReadOptions::allow_outside`](crate::ReadOptions::allow_outside).
    #[error(
        "{json_path}: {uri:?} leads to {}, outside the file's folder, and is not read; if you trust the file, give \
         --allow-outside", .path.display()
    )]
    Outside {
        /// Where it stands.
        json_path: String,
        /// Name in the file.
        uri: String,
        /// The file that would be read.
        path: PathBuf,
    },
    /// Its parts make no model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Its faces make no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The fault of an archive.
    #[error(transparent)]
    Npz(#[from] NpzError),
    /// The fault of an OBJ.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// The fault of a PLY.
    #[error(transparent)]
    Ply(#[from] PlyError),
    /// The fault of an STL.
    #[error(transparent)]
    Stl(#[from] StlError),
}
