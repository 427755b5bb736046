//! Materials of an OBJ file: the diffuse colours of .mtl files beside it, which may hold anything.

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Read as _};
use std::path::{Path, PathBuf};

use crate::collected::WHITE;
use crate::coordinates::number;
use crate::line::{Next, Statements};

/// An .mtl file is not read if it has more bytes.
const MAX_BYTES: u64 = 16 << 20;
/// Bytes of a name that count.
const MAX_NAME: usize = 4096;
/// So many names of .mtl files are looked up at most. The same one several times in turn is one.
const MAX_FILES: usize = 64;
/// Bytes of memory that each byte of an .mtl file may take: a material of a short name takes most.
pub(crate) const BYTES: u64 = 20;

/// The materials so far.
#[derive(Default)]
pub struct Materials<'a> {
    /// The folder of the OBJ, if it is in one.
    folder: Option<&'a Path>,
    /// Linear colours, by name.
    colors: HashMap<Vec<u8>, [f32; 3]>,
    /// Where colours are missing, in words.
    pub(crate) notes: Vec<String>,
    /// The files that the OBJ names. They need not exist.
    pub(crate) files: Vec<PathBuf>,
    has_unknown: bool,
}

/// The linear value of an sRGB component. It is from 0 to 1; NaN gives 0.
pub(crate) fn linear(component: f64) -> f32 {
    let component = if component.is_nan() { 0.0 } else { component.clamp(0.0, 1.0) };
    if component <= 0.04045 {
        return (component / 12.92) as f32;
    }
    ((component + 0.055) / 1.055).powf(2.4) as f32
}

impl<'a> Materials<'a> {
    /// The files are looked for in this folder. Without one none is read.
    pub fn new(folder: Option<&'a Path>) -> Self {
        Self { folder, ..Self::default() }
    }

    /// The colour of a material, or white if it is not known.
    pub(crate) fn color(&mut self, line: usize, name: &[u8]) -> [f32; 3] {
        let color = self.colors.get(name).copied();
        // Where a file was not read, there is a note already.
        if color.is_none() && self.notes.is_empty() && !std::mem::replace(&mut self.has_unknown, true) {
            let name = String::from_utf8_lossy(name);
            self.notes.push(format!("line {line}: no material is named {:?}; its faces are white", shortened(&name)));
        }
        color.unwrap_or(WHITE)
    }

    /// Reads a file that an OBJ names in this line, of at most `most` bytes. Returns how many it has, or 0 if it is not read.
    pub(crate) fn read(&mut self, line: usize, name: &str, most: u64) -> u64 {
        if self.files.len() == MAX_FILES {
            return 0;
        }
        let Some(folder) = self.folder else {
            let (name, is_first) = (shortened(name), self.notes.is_empty());
            let note =
                || format!("line {line}: {name:?} is not read, since only the OBJ was given; its faces are white");
            self.notes.extend(is_first.then(note));
            return 0;
        };
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let name = name.replace('\\', "/");
        // Exporters write paths of their own machine, too.
        let alone = name.rsplit('/').next().unwrap_or_default();
        let found = inside(folder, &name).or_else(|_| inside(folder, alone));
        let file = found.as_ref().map_or_else(|_| folder.join(alone), PathBuf::clone);
        // Some programs name the same file before each object.
        if self.files.last() == Some(&file) {
            return 0;
        }
        self.files.push(file);
        found.and_then(|path| self.take(&path, most.min(MAX_BYTES))).unwrap_or_else(|error| {
            self.notes.push(format!("line {line}: {:?} is not read: {error}; its faces are white", shortened(&name)));
            0
        })
    }

    fn take(&mut self, path: &Path, most: u64) -> io::Result<u64> {
        let file = crate::open_regular(path)?;
        let length = file.metadata()?.len();
        if length > most {
            return Err(io::Error::other("it is too large"));
        }
        self.parse(BufReader::new(file.take(length)))?;
        Ok(length)
    }

    /// Takes the colours of a file. Other statements are skipped, those that name files, too.
    ///
    /// # Errors
    /// An error of the reader.
    pub fn parse(&mut self, reader: impl BufRead) -> io::Result<()> {
        let (mut lines, mut name) = (Statements::with_folders(reader), None);
        while let Next::Statement(statement) = lines.next(MAX_BYTES)? {
            let mut words = statement.words();
            match words.next() {
                Some(b"newmtl") => {
                    let new = joined(statement.name());
                    self.colors.insert(new.clone(), WHITE);
                    name = Some(new);
                }
                Some(b"Kd") => {
                    let numbers = words.map_while(|word| number(std::str::from_utf8(word).ok()?));
                    let numbers: Vec<f64> = numbers.take(3).collect();
                    let color = match numbers[..] {
                        [grey] => Some([grey; 3]),
                        [red, green, blue] => Some([red, green, blue]),
                        _ => None,
                    };
                    let old = name.as_ref().and_then(|name| self.colors.get_mut(name));
                    if let (Some(old), Some(color)) = (old, color) {
                        *old = color.map(linear);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// A name that may have blanks, cut where it is longer than names are.
pub(crate) fn joined<'a>(words: impl Iterator<Item = &'a [u8]>) -> Vec<u8> {
    let bytes = words.enumerate().flat_map(|(at, word)| (at > 0).then_some(&b' ').into_iter().chain(word));
    bytes.take(MAX_NAME).copied().collect()
}

fn shortened(name: &str) -> String {
    name.chars().take(60).collect()
}

/// The file of a folder, which is there. No link may lead out of the folder.
fn inside(folder: &Path, name: &str) -> io::Result<PathBuf> {
    let path = folder.join(name).canonicalize()?;
    if path.starts_with(folder.canonicalize()?) {
        Ok(path)
    } else {
        Err(io::Error::other("it is outside the OBJ's folder"))
    }
}

#[cfg(test)]
mod tests {
    use std::error::Error;
    use std::path::Path;

    use rimline::gltf::Colors;
    use rimline::mesh::Weld;

    use super::WHITE;
    use crate::{File, FileError, Polygons, ReadOptions, read, read_bytes};

    const RED: [f32; 3] = [1.0, 0.0, 0.0];
    /// sRGB 0.5.
    const GREY: f32 = 0.214_041_14;

    const SQUARES: &str = "mtllib a b.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nusemtl red\nf 4 3 2 1\n\
                           usemtl two words\nf 1 2 3\nusemtl ?\nf 3 2 1\n";

    fn model(folder: &Path, text: &str, polygons: Polygons) -> Result<File, FileError> {
        let path = folder.join("a.obj");
        std::fs::write(&path, text)?;
        read(&path, &ReadOptions { polygons, ..ReadOptions::default() })
    }

    #[test]
    fn materials_color_their_triangles() -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        std::fs::write(
            folder.path().join("a b.mtl"),
            "Kd 9 9 9\nmtllib a.mtl\nnewmtl red\nKd 1 0 nan\nnewmtl two words\nKd .5\nKd spectral x.rfl\nmap_Kd x.png\n",
        )?;
        let grey = [GREY; 3];
        let expected = vec![WHITE, WHITE, RED, RED, grey, WHITE];
        for polygons in [Polygons::Triangles, Polygons::Whole] {
            let file = model(folder.path(), SQUARES, polygons)?;
            assert_eq!(file.colors(0), Some(&Colors { faces: Some(expected.clone()), vertices: None }));
            assert_eq!(file.model().geometries()[0].faces().len(), 6);
            assert_eq!(file.color_notes(), ["line 11: no material is named \"?\"; its faces are white"]);
            assert_eq!(file.named_files(), [folder.path().canonicalize()?.join("a b.mtl")]);
        }
        let plain = model(folder.path(), "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n", Polygons::Triangles)?;
        assert_eq!(plain.colors(0), None, "all is white");
        Ok(())
    }

    #[test]
    fn files_that_are_not_read_are_noted() -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let inner = folder.path().join("inner");
        std::fs::create_dir_all(inner.join("folder.mtl"))?;
        std::fs::write(folder.path().join("out.mtl"), "newmtl red\nKd 1 0 0\n")?;
        std::fs::File::create(inner.join("huge.mtl"))?.set_len(super::MAX_BYTES + 1)?;
        let square = |names: &str| format!("mtllib {names}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
        for (name, says) in [
            ("none.mtl", "No such file"),
            ("../out.mtl", "No such file"),
            ("folder.mtl", "folder"),
            ("huge.mtl", "too large"),
        ] {
            let file = model(&inner, &square(name), Polygons::Triangles)?;
            assert!(file.colors(0).is_none(), "{name}");
            let [note] = file.color_notes() else { panic!("{:?}", file.color_notes()) };
            assert!(note.contains(name) && note.contains(says), "{note}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("../out.mtl", inner.join("link.mtl"))?;
            let file = model(&inner, &square("link.mtl"), Polygons::Triangles)?;
            assert!(file.colors(0).is_none() && file.color_notes()[0].contains("outside"), "{:?}", file.color_notes());
        }
        let many = (0..100).map(|n| format!("{n}.mtl")).collect::<Vec<_>>().join(" ");
        assert_eq!(model(&inner, &square(&many), Polygons::Triangles)?.color_notes().len(), super::MAX_FILES);
        // The file that is beside it, wherever the exporter had it, and one of two names.
        std::fs::write(inner.join("in.mtl"), "newmtl red\r\nKd 1 0 0\r\n")?;
        for name in ["C:\\x\\in.mtl", "/x/in.mtl", "in.mtl none.mtl", "./in.mtl"] {
            let file = model(&inner, &square(name), Polygons::Triangles)?;
            assert_eq!(file.colors(0).and_then(|colors| colors.faces.clone()), Some(vec![RED]), "{name}");
        }
        let file = read_bytes(square("in.mtl").as_bytes(), None, &ReadOptions::default())?;
        assert!(file.color_notes()[0].contains("only the OBJ was given"), "{:?}", file.color_notes());
        Ok(())
    }

    #[test]
    fn a_name_may_have_a_number_sign() -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let materials = "newmtl Material #1 #red\nKd 1 \\\n0 0\nmap_Kd C:\\maps\\\nnewmtl Material #2 # grey\nKd .5\n";
        std::fs::write(folder.path().join("a #2.mtl"), materials)?;
        let vertices = "mtllib a #2.mtl # b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let text = format!("{vertices}usemtl Material #1\nf 1 2 3\nusemtl Material #2 #grey\nf 3 2 1 # 4\n");
        let file = model(folder.path(), &text, Polygons::Triangles)?;
        assert!(file.color_notes().is_empty(), "{:?}", file.color_notes());
        assert_eq!(file.colors(0).and_then(|colors| colors.faces.clone()), Some(vec![RED, [GREY; 3]]));
        Ok(())
    }

    #[test]
    fn a_file_that_is_named_again_is_read_once() -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        std::fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 1 0 0\n")?;
        let names = ["none.mtl", "a.mtl"].map(|name| format!("mtllib {name}\n").repeat(100)).concat();
        let text = names + "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
        let file = model(folder.path(), &text, Polygons::Triangles)?;
        assert_eq!(file.colors(0).and_then(|colors| colors.faces.clone()), Some(vec![RED]));
        assert_eq!((file.color_notes().len(), file.named_files().len()), (1, 2));
        Ok(())
    }

    #[test]
    fn colors_of_vertices_survive_welding() -> Result<(), Box<dyn Error>> {
        let ply = |vertices: &str, faces: &str| {
            let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
            let axes = "property float x\nproperty float y\nproperty float z\n";
            let lists = "property list uchar int vertex_indices\n";
            let count = |text: &str| text.lines().count();
            let (v, f) = (count(vertices), count(faces));
            let header = format!("element vertex {v}\n{axes}{colors}element face {f}\n{lists}end_header\n");
            format!("ply\nformat ascii 1.0\n{header}{vertices}{faces}")
        };
        let read =
            |text: &str| read_bytes(text.as_bytes(), None, &ReadOptions { weld: Weld::Data, ..Default::default() });
        // A square of two triangles; their common vertices are there twice.
        let square = |shared: &str| {
            let first = format!("0 0 0 255 0 0\n1 0 0 255 0 0\n1 1 0 255 0 0\n0 0 0 {shared}\n");
            ply(&format!("{first}1 1 0 {shared}\n0 1 0 {shared}\n"), "3 0 1 2\n3 3 4 5\n")
        };
        let same = read(&square("255 0 0"))?;
        assert_eq!(same.colors(0), Some(&Colors { faces: None, vertices: Some(vec![RED; 4]) }));
        let seam = read(&square("188 0 0"))?;
        let dark = [0.502_886_5, 0.0, 0.0];
        assert_eq!(seam.colors(0), Some(&Colors { faces: Some(vec![RED, dark]), vertices: None }));
        // The same as a quadrilateral and a triangle.
        let seam = read(&square("188 0 0").replace("3 0 1 2", "4 0 1 2 5"))?;
        let faces = seam.colors(0).and_then(|colors| colors.faces.clone()).unwrap_or_default();
        assert_eq!((faces.len(), faces[0], faces[2]), (3, faces[1], dark));
        assert!(faces[0][0] < 1.0 && faces[0][0] > dark[0], "{faces:?}");
        let obj = read("v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 .5 .5 .5\nf 1 2 3\n")?;
        assert_eq!(obj.colors(0).and_then(|colors| colors.vertices.clone()), Some(vec![RED, WHITE, [GREY; 3]]));
        Ok(())
    }

    #[test]
    fn faces_of_a_ply_have_colors() -> Result<(), Box<dyn Error>> {
        let header = |kind: &str| {
            format!(
                "ply\nformat ascii 1.0\nelement face 2\nproperty {kind} blue\nproperty list uchar int vertex_index\nproperty {kind} \
                 green\nproperty {kind} red\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
            )
        };
        for (kind, one) in [("uchar", 255.0), ("ushort", 65535.0), ("float", 1.0), ("int", 255.0)] {
            let faces = format!("0 4 0 1 2 3 0 {one}\n-7 3 2 1 0 1e9 nan\n");
            let text = header(kind) + &faces + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
            let file = read_bytes(text.as_bytes(), None, &ReadOptions::default())?;
            let expected = vec![RED, RED, [0.0, 1.0, 0.0]];
            assert_eq!(file.colors(0).and_then(|colors| colors.faces.clone()), Some(expected), "{kind}");
        }
        Ok(())
    }
}
