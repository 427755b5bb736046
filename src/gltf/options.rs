//! How a glTF file is loaded.

use crate::mesh::Weld;

/// Options of [`Asset::open`](super::Asset::open) and [`Asset::from_slice`](super::Asset::from_slice).
///
/// ```no_run
/// use rimline::gltf::{Asset, LoadOptions};
///
/// // An upload: refuse it if it takes more than 256 MiB.
/// let asset = Asset::open("upload.glb", LoadOptions { memory_limit: 256 << 20, ..LoadOptions::default() })?;
/// # Ok::<(), rimline::gltf::GltfError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Which vertices are welded.
    pub weld: Weld,
    /// The largest memory, in bytes, that the file may take. It counts the files read, their JSON and data, the asset,
    /// and one pose, the lights and the mesh of all instances ([`Model::mesh`]). [`GltfError::TooLarge`] refuses the
    /// asset before more is taken.
    ///
    /// The most that is in use at one time counts. A mesh of a million faces and one instance counts about 0.1 GiB. It is
    /// refused by the counts that the JSON states, before its data is read. All allocations together, also those given
    /// back, may be eight times the limit, which bounds the time. The bytes given to
    /// [`Asset::from_slice`](super::Asset::from_slice) do not count, nor does later data such as a copy on the GPU.
    /// Default: [`LoadOptions::DEFAULT_MEMORY_LIMIT`].
    ///
    /// [`Model::mesh`]: crate::Model::mesh
    /// [`GltfError::TooLarge`]: super::GltfError::TooLarge
    pub memory_limit: u64,
    /// Whether to read buffers outside the folder of the glTF, by `..`, an absolute path or a symbolic link. The author
    /// of the glTF chooses these files. Default: no, which gives [`GltfError::Outside`](super::GltfError::Outside).
    pub allow_outside: bool,
}

impl LoadOptions {
    /// 4 GiB, which is about forty million faces.
    pub const DEFAULT_MEMORY_LIMIT: u64 = 4 << 30;
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { weld: Weld::default(), memory_limit: Self::DEFAULT_MEMORY_LIMIT, allow_outside: false }
    }
}

impl From<Weld> for LoadOptions {
    fn from(weld: Weld) -> Self {
        Self { weld, ..Self::default() }
    }
}
