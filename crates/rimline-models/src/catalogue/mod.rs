//! A small glTF file for each class of inputs, good and bad, so that no test needs models from elsewhere.

mod bad;
mod good;
mod moving;
mod still;

use std::path::{Path, PathBuf};

pub use bad::BAD;
pub use good::GOOD;

use crate::maker::Maker;

/// A file that loads. Its name ends as its form does: a binary, or JSON with its buffer in a data URI or in a file
/// beside it.
pub struct Good {
    pub name: &'static str,
    make: fn() -> Maker,
    /// Over its meshes, welded by position: triangles; vertices, before and after welding; edges with one face, with
    /// more than two and with two of one direction; degenerate and duplicate triangles; closed meshes; meshes.
    pub counts: [usize; 10],
    /// Instances, joints of all skins, morph targets, animations.
    pub parts: [usize; 4],
}

/// A file with a fault.
pub struct Bad {
    pub name: &'static str,
    /// Makes a good file bad: its content, then its bytes.
    change: fn(&mut Maker),
    damage: fn(&mut Vec<u8>),
    pub fate: Fate,
    /// Parts of the error, or of a warning.
    pub says: &'static [&'static str],
}

/// How a file with a fault is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// With an error.
    Refused,
    /// With a warning; its scene shows nothing.
    Empty,
    /// With a warning; something is left to draw.
    Warned,
}

impl Good {
    /// Writes the file, and its buffer where that is a file, into a folder.
    pub fn write(&self, folder: &Path) -> std::io::Result<PathBuf> {
        let maker = (self.make)();
        if let Some(uri) = maker.json["buffers"][0]["uri"].as_str() {
            std::fs::write(folder.join(uri), &maker.bytes)?;
        }
        written(folder, self.name, &bytes(self.name, &maker))
    }
}

impl Bad {
    /// Writes the file into a folder.
    pub fn write(&self, folder: &Path) -> std::io::Result<PathBuf> {
        let mut maker = Maker::square();
        (self.change)(&mut maker);
        if self.fate == Fate::Empty {
            maker.scene(&[]);
        }
        let mut bytes = bytes(self.name, &maker);
        (self.damage)(&mut bytes);
        written(folder, self.name, &bytes)
    }
}

fn bytes(name: &str, maker: &Maker) -> Vec<u8> {
    if Path::new(name).extension() == Some("glb".as_ref()) { maker.glb() } else { maker.gltf() }
}

fn written(folder: &Path, name: &str, bytes: &[u8]) -> std::io::Result<PathBuf> {
    let path = folder.join(name);
    std::fs::write(&path, bytes).map(|()| path)
}
