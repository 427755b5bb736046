//! Formats of files. They are recognised by their first bytes, because an ending is a name that anybody may give.

use std::io::{self, Read, Seek};
use std::path::Path;

use zip::ZipArchive;

use crate::line::text;
use crate::{obj, stl};

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// glTF 2.0, as .gltf or as .glb.
    Gltf,
    /// Wavefront OBJ.
    Obj,
    /// PLY, as text or in binary.
    Ply,
    /// STL, as text or in binary.
    Stl,
    /// A NumPy archive with `positions`, and `faces` or `polygon_loops`.
    Npz,
}

impl Format {
    /// The name of the format, as the command takes it: `gltf`, `obj`, `ply`, `stl` or `npz`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Npz => "npz",
        }
    }

    /// The format of a file: by how it begins, or, where that says nothing, by its ending. `None` if neither says it. Leaves
    /// the reader at its start.
    ///
    /// # Errors
    /// [`FormatError::Foreign`] for a file that is certainly of another kind.
    pub(crate) fn of(reader: &mut (impl Read + Seek), name: Option<&Path>) -> Result<Option<Self>, FormatError> {
        let ending = name.and_then(ending);
        Ok(match (begins(reader)?, ending.as_deref()) {
            (Begins::Ply, _) | (Begins::Unknown, Some("ply")) => Some(Self::Ply),
            (Begins::Stl, _) | (Begins::Unknown, Some("stl")) => Some(Self::Stl),
            (Begins::Archive, _) | (Begins::Unknown, Some("npz")) => Some(Self::Npz),
            (Begins::Glb, _) | (Begins::Json, Some("obj" | "npz" | "ply" | "stl")) => Some(Self::Gltf),
            (Begins::Json, _) if name.is_none() => Some(Self::Gltf),
            (Begins::Obj, Some("gltf" | "glb" | "npz" | "ply" | "stl")) | (_, Some("obj")) => Some(Self::Obj),
            (Begins::Obj, _) if name.is_none() => Some(Self::Obj),
            (_, Some("gltf" | "glb")) => Some(Self::Gltf),
            // Any text may begin like an OBJ.
            (_, _) => None,
        })
    }
}

/// The ending of a name, in small letters.
pub(crate) fn ending(name: &Path) -> Option<String> {
    name.extension().map(|ending| ending.to_string_lossy().to_lowercase())
}

/// How a file begins.
enum Begins {
    Glb,
    Archive,
    Ply,
    Stl,
    /// Text that is a glTF if it is a model at all.
    Json,
    /// Text that is an OBJ if it is a model at all.
    Obj,
    /// It says nothing, so the ending decides.
    Unknown,
}

/// A format that is not read, with advice for the user.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is {what}, which is not read here; {advice}")]
pub struct Foreign {
    what: &'static str,
    advice: &'static str,
}

/// Why a file is not taken.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// It is certainly of a format that is not read.
    #[error(transparent)]
    Foreign(#[from] Foreign),
}

const FAR: u64 = 1 << 16;

const SURFACE: &str = "convert it to .glb or .obj, in Blender or by Python: \
                       `import trimesh; trimesh.load(\"IN\").export(\"OUT.glb\")`";
const SCENE: &str = "convert it to .glb, in Blender or by `assimp export IN OUT.glb`";
const BLENDER: &str = "open it in Blender and export it as .glb";
const UNPACK: &str = "unpack it and give the model file in it";
const ARCHIVE: &str = "give an .npz, as `numpy.savez` writes it";
const NO_MODEL: &str = "give a .glb, .gltf, .obj, .ply, .stl or .npz";

const FIRST_BYTES: &[(&[u8], &str, &str)] = &[
    (b"Kaydara FBX Binary", "an FBX file", SCENE),
    (b"BLENDER", "a Blender file", BLENDER),
    (b"PXR-USDC", "a USD file", BLENDER),
    (b"Ogawa", "an Alembic file", BLENDER),
    (
        b"\x93NUMPY",
        "a single array (.npy)",
        "put it into an .npz by its name: `numpy.savez(\"FILE.npz\", NAME=numpy.load(\"FILE.npy\"))`",
    ),
    (b"DRACO", "a Draco file", "decode it to .obj by `draco_decoder -i IN -o OUT.obj`"),
    (b"\x1f\x8b", "compressed by gzip", UNPACK),
    (b"\x28\xb5\x2f\xfd", "compressed by Zstandard (as Blender compresses its files)", UNPACK),
    (b"\xfd7zXZ\0", "compressed by xz", UNPACK),
    (b"BZh", "compressed by bzip2", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"Rar!", "a RAR archive", UNPACK),
    (b"\x89PNG", "a picture", NO_MODEL),
    (b"\xff\xd8\xff", "a picture", NO_MODEL),
    (b"%PDF", "a PDF", NO_MODEL),
];

/// First words of other files of text, in small letters.
const FIRST_WORDS: &[(&[u8], &str, &str)] = &[
    (b"; fbx", "an FBX file", SCENE),
    (b"#usda", "a USD file", BLENDER),
    (b"#vrml", "a VRML file", SCENE),
    (b"iso-10303-21", "a STEP file", "mesh it in a CAD program, and export that as .glb or .obj"),
    (b"# vtk datafile", "a VTK file", SURFACE),
    (b"off\n", "an OFF file", SURFACE),
    (b"off\r", "an OFF file", SURFACE),
    (
        b"version https://git-lfs.github.com/",
        "a pointer of Git LFS, not the file itself",
        "fetch the file by `git lfs pull`",
    ),
];

/// Finds the format of a file by its first bytes, and leaves the reader at its start.
fn begins(reader: &mut (impl Read + Seek)) -> Result<Begins, FormatError> {
    let start = first_bytes(reader)?;
    if start.starts_with(b"glTF") {
        return Ok(Begins::Glb);
    }
    if let Some(found) = ply_or_stl(&start, length(reader)?) {
        return Ok(found);
    }
    let is_zip = start.starts_with(b"PK\x03\x04") || start.starts_with(b"PK\x05\x06");
    if let Some(foreign) = if is_zip { in_zip(reader)? } else { foreign(&start, length(reader)?) } {
        return Err(foreign.into());
    }
    Ok(match text(&start) {
        _ if is_zip => Begins::Archive,
        text if text.starts_with(b"{") => Begins::Json,
        _ if obj::begins_like(&start) => Begins::Obj,
        _ => Begins::Unknown,
    })
}

/// Refuses what is certainly no archive of arrays, where nothing else is read.
///
/// # Errors
/// [`FormatError::Foreign`] says what it is instead.
pub fn archive<R: Read + Seek>(mut reader: R) -> Result<R, FormatError> {
    match begins(&mut reader) {
        Err(FormatError::Foreign(foreign)) if [SURFACE, SCENE, BLENDER, NO_MODEL].contains(&foreign.advice) => {
            Err(Foreign { advice: ARCHIVE, ..foreign }.into())
        }
        Ok(Begins::Glb | Begins::Json) => Err(Foreign { what: "a glTF", advice: ARCHIVE }.into()),
        Ok(Begins::Ply) => Err(Foreign { what: "a PLY file", advice: ARCHIVE }.into()),
        Ok(Begins::Stl) => Err(Foreign { what: "an STL file", advice: ARCHIVE }.into()),
        Ok(Begins::Obj) => Err(Foreign { what: "an OBJ file", advice: ARCHIVE }.into()),
        found => found.map(|_| reader),
    }
}

fn first_bytes(reader: &mut (impl Read + Seek)) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    reader.by_ref().take(FAR).read_to_end(&mut start)?;
    reader.rewind()?;
    Ok(start)
}

fn length(reader: &mut impl Seek) -> io::Result<u64> {
    let length = reader.seek(io::SeekFrom::End(0))?;
    reader.rewind()?;
    Ok(length)
}

/// Finds models that are recognised by more than their first word.
fn ply_or_stl(start: &[u8], length: u64) -> Option<Begins> {
    let is_foreign = FIRST_BYTES.iter().any(|(first, ..)| start.starts_with(first));
    if stl::is_binary(start, length) && !is_foreign {
        return Some(Begins::Stl);
    }
    if stl::is_text(start) {
        return Some(Begins::Stl);
    }
    let is_ply = [&b"ply\n"[..], b"ply\r"].iter().any(|first| start.starts_with(first));
    (is_ply && start.windows(6).any(|word| word == b"format")).then_some(Begins::Ply)
}

/// Finds a format that is not read, by the first bytes and the length of the file.
fn foreign(start: &[u8], length: u64) -> Option<Foreign> {
    let of = |what, advice| Some(Foreign { what, advice });
    if let Some(&(_, what, advice)) = FIRST_BYTES.iter().find(|(first, ..)| start.starts_with(first)) {
        return of(what, advice);
    }
    if is_utf16(start) {
        return of("text in UTF-16 or UTF-32", "save it as UTF-8, or by `iconv -f UTF-16 -t UTF-8 IN > OUT`");
    }
    // A chunk that is as long as the file.
    let chunk = start.get(2..6).and_then(|length| length.try_into().ok()).map(u32::from_le_bytes);
    if start.starts_with(b"MM") && chunk.is_some_and(|chunk| u64::from(chunk) == length) {
        return of("a 3DS file", SCENE);
    }
    let text = text(start).to_ascii_lowercase();
    let contains = |word: &[u8]| text.windows(word.len()).any(|window| window == word);
    if let Some(&(_, what, advice)) = FIRST_WORDS.iter().find(|(first, ..)| text.starts_with(first)) {
        return of(what, advice);
    }
    match text.first() {
        Some(b'<') if contains(b"<collada") => of("a COLLADA file", SCENE),
        Some(b'<') if contains(b"<x3d") => of("an X3D file", SCENE),
        Some(b'<') if contains(b"<html") || contains(b"<!doctype html") => {
            of("a page of the web (HTML)", "download the model itself; the page may hold a link to it, or say why not")
        }
        Some(b'<') if contains(b"<?xml") || contains(b"xmlns") => of("an XML file", NO_MODEL),
        _ => None,
    }
}

/// A byte order mark, or a zero beside each of the first letters.
fn is_utf16(start: &[u8]) -> bool {
    let is_text = |byte: &u8| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~');
    let (pairs, _) = start.get(..8).unwrap_or_default().as_chunks::<2>();
    let marks = [&b"\xff\xfe"[..], b"\xfe\xff", b"\0\0\xfe\xff"];
    marks.iter().any(|mark| start.starts_with(mark))
        || !pairs.is_empty()
            && (pairs.iter().all(|[low, high]| is_text(low) && *high == 0)
                || pairs.iter().all(|[high, low]| is_text(low) && *high == 0))
}

/// Finds the format of an archive without arrays, by the names of its entries. Returns `None` for any other archive,
/// readable or not: the reader of arrays then says what is missing.
fn in_zip(reader: &mut (impl Read + Seek)) -> Result<Option<Foreign>, FormatError> {
    let archive = ZipArchive::new(&mut *reader);
    let of = |what, advice| Some(Foreign { what, advice });
    let found = archive.ok().and_then(|archive| {
        let names: Vec<String> =
            archive.file_names().filter_map(|name| Some(name.ok()?.to_ascii_lowercase())).collect();
        let has = |endings: &[&str]| names.iter().any(|name| endings.iter().any(|ending| name.ends_with(ending)));
        if has(&[".npy"]) {
            None
        } else if has(&["3d/3dmodel.model"]) {
            of("a 3MF file", SURFACE)
        } else if has(&[".usdc", ".usda", ".usd"]) {
            of("a USDZ file", BLENDER)
        } else if has(&[".glb", ".gltf", ".obj", ".npz"]) {
            of("a ZIP archive with a model in it", UNPACK)
        } else {
            None
        }
    });
    reader.rewind()?;
    Ok(found)
}
