//! How a glTF file is loaded.

use crate::mesh::Weld;

/// What a caller may choose of [`Asset::open`](super::Asset::open).
///
/// ```no_run
/// use rimline::gltf::{Asset, LoadOptions};
///
/// // An upload: what takes more than 256 MiB is refused.
/// let asset = Asset::open("upload.glb", LoadOptions { memory_limit: 256 << 20, ..LoadOptions::default() })?;
/// # Ok::<(), rimline::gltf::GltfError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Which vertices become one.
    pub weld: Weld,
    /// The most bytes of memory that the file may make this process take: for the files read, for their JSON and data,
    /// for the asset, and for a pose, the lights and the mesh that all instances make ([`Model::mesh`]). The asset is
    /// refused with [`GltfError::TooLarge`] before more is taken.
    ///
    /// Everything that is made on the way counts, given back or not, so the memory in use at any time is less; a mesh of
    /// a million faces and one instance counts about 0.4 GiB. The bytes handed to
    /// [`Asset::from_slice`](super::Asset::from_slice) do not count, and neither does what is made of the model later, such as a
    /// copy on the GPU. Default: [`LoadOptions::DEFAULT_MEMORY_LIMIT`].
    ///
    /// [`Model::mesh`]: crate::Model::mesh
    /// [`GltfError::TooLarge`]: super::GltfError::TooLarge
    pub memory_limit: u64,
    /// Reads buffers that lie outside the glTF's folder, by `..`, an absolute path or a symbolic link. They are files that
    /// whoever wrote the glTF chose. Default: no, which is [`GltfError::Outside`](super::GltfError::Outside).
    pub allow_outside: bool,
}

impl LoadOptions {
    /// 4 GiB: about ten million faces.
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
