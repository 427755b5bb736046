//! Reading files of each format.

use std::fs;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek};
use std::path::Path;

use rimline::gltf::{Asset, Colors, GltfError, LoadOptions};
use rimline::mesh::Weld;
use rimline::{Geometry, GeometryOptions, Instance, Mesh, Model, Origin};

use crate::error::FileError;
use crate::file::{File, GivenPolygons};
use crate::format::{Format, ending};
use crate::mtl::Materials;
use crate::npz::PolygonArrays;
use crate::{coordinates, npz, obj, ply, stl};

/// How polygons of an OBJ or a PLY are taken. Those of an .npz are always taken whole. glTF and STL have triangles only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Polygons {
    /// Polygons become triangles, which are drawn.
    #[default]
    Triangles,
    /// Polygons become triangles, and are kept beside them to describe: [`File::described`].
    Described,
    /// Each is one face: [`File::polygons`].
    Whole,
}

/// The axis of a file that is up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// Nothing is turned.
    #[default]
    Y,
    /// (x, y, z) of the file becomes (x, z, −y), also its origin.
    Z,
}

impl Up {
    fn turned<T: Copy + std::ops::Sub<Output = T> + Default>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Self::Y => [x, y, z],
            // No −0.
            Self::Z => [x, z, T::default() - y],
        }
    }
}

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// The format. Default: the one that the file begins like, or, where that says nothing, the one of its name.
    pub format: Option<Format>,
    /// Which vertices are welded.
    pub weld: Weld,
    /// The largest memory, in bytes, that reading the file and making its mesh may take at one time. Default:
    /// [`LoadOptions::DEFAULT_MEMORY_LIMIT`].
    pub memory_limit: u64,
    /// Whether a glTF may name files outside its folder. Default: no.
    pub allow_outside: bool,
    /// How polygons are taken. Default: as triangles.
    pub polygons: Polygons,
    /// The axis that is up. Default: y. A glTF is always y up, and is not turned.
    pub up: Up,
}

impl Default for ReadOptions {
    fn default() -> Self {
        let LoadOptions { weld, memory_limit, allow_outside } = LoadOptions::default();
        Self { format: None, weld, memory_limit, allow_outside, polygons: Polygons::default(), up: Up::Y }
    }
}

impl ReadOptions {
    fn of_gltf(&self) -> LoadOptions {
        LoadOptions { weld: self.weld, memory_limit: self.memory_limit, allow_outside: self.allow_outside }
    }
}

/// Opens a file that has content and an end: no folder, pipe or device, and none that is empty.
///
/// # Errors
/// An error of the system, or one that says which file to give.
pub fn open_regular(path: &Path) -> io::Result<fs::File> {
    let there = fs::metadata(path)?;
    if there.is_dir() {
        return Err(io::Error::other("it is a folder; give a file"));
    }
    if !there.is_file() {
        return Err(io::Error::other("it is not a regular file; give one, or `-` for standard input"));
    }
    if there.len() == 0 {
        return Err(io::Error::other("it is empty"));
    }
    fs::File::open(path)
}

/// Reads a file, and those that it names.
///
/// # Errors
/// [`FileError`] says what is wrong with it.
pub fn read(path: &Path, options: &ReadOptions) -> Result<File, FileError> {
    let mut reader = BufReader::with_capacity(1 << 18, open_regular(path)?);
    match format(&mut reader, Some(path), options)? {
        Format::Gltf => Asset::open(path, options.of_gltf()).map(File::of_asset).map_err(|error| of_gltf(path, error)),
        format => of_reader(format, reader, path.parent(), options),
    }
}

/// Reads the content of a file, such as standard input. The name is asked where the content does not say its format;
/// without a name, text is a glTF or an OBJ if it begins like one. Of a glTF, all buffers must be in the content.
/// Materials of an OBJ are not read.
///
/// # Errors
/// [`FileError`] says what is wrong with it.
pub fn read_bytes(bytes: &[u8], name: Option<&Path>, options: &ReadOptions) -> Result<File, FileError> {
    read_slices(bytes, name, &|_| None, options)
}

/// Reads the content of a file with others beside it, such as what was dropped on a page. `find` gives the content of the
/// file with a relative path, for the buffers of a glTF. Else this is [`read_bytes`].
///
/// # Errors
/// [`FileError`] says what is wrong with it.
pub fn read_slices(
    bytes: &[u8],
    name: Option<&Path>,
    find: &dyn Fn(&str) -> Option<Vec<u8>>,
    options: &ReadOptions,
) -> Result<File, FileError> {
    let mut reader = Cursor::new(bytes);
    match format(&mut reader, name, options)? {
        Format::Gltf => {
            let asset = Asset::from_slices(bytes, find, options.of_gltf());
            asset.map(File::of_asset).map_err(|error| of_gltf(Path::new("-"), error))
        }
        format => of_reader(format, reader, None, options),
    }
}

fn format(reader: &mut (impl Read + Seek), name: Option<&Path>, options: &ReadOptions) -> Result<Format, FileError> {
    if let Some(format) = options.format {
        return Ok(format);
    }
    let shown = |ending| format!(".{ending}");
    let what = || name.and_then(ending).map_or_else(|| "a file of this format".to_owned(), shown);
    Format::of(reader, name)?.ok_or_else(|| FileError::Format { what: what() })
}

/// Reads a file that is no glTF, from this folder.
fn of_reader(
    format: Format,
    reader: impl BufRead + Seek,
    folder: Option<&Path>,
    options: &ReadOptions,
) -> Result<File, FileError> {
    let (limit, are_kept) = (options.memory_limit, options.polygons != Polygons::Triangles);
    let mut materials = Materials::new(folder);
    let arrays = match format {
        Format::Obj => obj::read(reader, &mut materials, limit, are_kept)?,
        Format::Ply => ply::read(reader, limit, are_kept)?,
        Format::Stl => stl::read(reader, limit)?,
        Format::Npz | Format::Gltf => return of_arrays(npz::read(reader, limit)?, Polygons::Whole, options),
    };
    let Materials { notes, files, .. } = materials;
    let file = of_arrays(arrays, options.polygons, options)?;
    Ok(File { color_notes: notes, named_files: files, ..file })
}

/// Converts an error of a glTF, with advice for users of the command.
fn of_gltf(file: &Path, error: GltfError) -> FileError {
    match error {
        // The file is named already; only other files that it names need to be.
        GltfError::Read { path, source } if path == file => FileError::Read(io::Error::new(source.kind(), source)),
        // The advice is to give the options of the command.
        GltfError::TooLarge { what, needed, limit } => {
            let is_whole = Path::new(&what) == file;
            FileError::TooLarge { what: if is_whole { "the file".into() } else { what }, needed, limit }
        }
        GltfError::Outside { json_path, uri, path } => FileError::Outside { json_path, uri, path },
        error => FileError::Gltf(error),
    }
}

fn of_arrays(arrays: npz::Arrays, taken: Polygons, options: &ReadOptions) -> Result<File, FileError> {
    let ReadOptions { weld, up, .. } = *options;
    let npz::Arrays { mut positions, mut faces, polygons, mut origin, mut colors } = arrays;
    if up != Up::Y {
        for position in &mut positions {
            *position = up.turned(*position);
        }
        origin = Origin::new(up.turned(origin.to_array()));
    }
    match &polygons {
        Some(PolygonArrays { loop_sizes, loop_corners, .. }) => {
            colors.split_seams(&positions, coordinates::faces(loop_sizes, loop_corners));
        }
        None => colors.split_seams(&positions, faces.iter().map(<[u32; 3]>::as_slice)),
    }
    let of_polygons = |colors: &mut Colors, of_triangles: &[u32]| {
        let of = |colors: &Vec<[f32; 3]>| of_triangles.iter().map(|&polygon| colors[polygon as usize]).collect();
        colors.faces = colors.faces.as_ref().map(of);
    };
    let by_loop = |polygons: &PolygonArrays| Mesh::from_polygons_by_loop(&positions, polygons.loops(), weld);
    let (mut described, mut collapsed) = (None, 0);
    match (polygons, taken) {
        (None, _) => {}
        (Some(polygons), Polygons::Whole) => {
            let mesh = by_loop(&polygons)?;
            drop(polygons);
            if let Some(polygons) = mesh.polygons() {
                of_polygons(&mut colors, &polygons.triangle_polygons());
            }
            let geometry = Geometry::new(positions, mesh.faces().to_vec(), GeometryOptions::default())?;
            let weld = mesh.weld_counts();
            return Ok(File {
                weld,
                polygons: Some(Box::new(mesh)),
                colors,
                ..File::in_world(placed(geometry)?, origin)
            });
        }
        (Some(polygons), taken) => {
            if taken == Polygons::Described {
                described = Some(Box::new(GivenPolygons { mesh: by_loop(&polygons)?, positions: positions.clone() }));
            }
            let found = polygons.loops().triangulate_with_polygons(&positions, weld)?;
            of_polygons(&mut colors, &found.polygons);
            (faces, collapsed) = (found.faces, found.counts.collapsed);
        }
    }
    let geometry = Geometry::new(positions, faces, GeometryOptions::default())?;
    let (welded, mut weld) = geometry.welded(weld);
    let colors = colors.welded(geometry.faces(), &welded);
    drop(geometry);
    weld.collapsed += collapsed;
    Ok(File { weld, described, colors, ..File::in_world(placed(welded)?, origin) })
}

fn placed(geometry: Geometry) -> Result<Model, rimline::ModelError> {
    Model::new(vec![geometry], vec![Instance::new(0, None)])
}
