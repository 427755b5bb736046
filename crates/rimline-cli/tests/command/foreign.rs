//! Files of other kinds, under any ending: the message says what they are and what to do.

use std::ffi::OsString;

use super::archive::{Entry, FIRST_DAY, write_zip};
use super::inputs::fed;
use super::npz_input::tetrahedron;
use super::own_gltf::{self, Names};
use super::run::{folder, is_empty, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("foreign::what_a_file_is_is_said_whatever_its_ending", kinds),
    ("foreign::models_are_read_under_another_ending", renamed),
    ("foreign::points_and_depth_maps_are_looked_at_too", archives),
];

/// An archive of empty files.
fn zip(names: &[&str]) -> Vec<u8> {
    let entry = |name: &&str| Entry { name: (*name).into(), flags: 0, method: 0, time: FIRST_DAY, bytes: vec![] };
    write_zip(&names.iter().map(entry).collect::<Vec<_>>())
}

/// So many triangles of zeros. Headers may begin like those of the other kind.
fn binary_stl(triangles: u32) -> Vec<u8> {
    let mut stl = b"solid of a program".to_vec();
    stl.resize(80, 0);
    stl.extend(triangles.to_le_bytes());
    stl.resize(84 + 50 * triangles as usize, 0);
    stl
}

fn utf16(text: &str, mark: bool, big: bool) -> Vec<u8> {
    let units = mark.then_some(0xfeff).into_iter().chain(text.encode_utf16());
    units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect()
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\n";
const COLLADA: &str = "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/\" version=\"1.4.1\">\n";
const POINTER: &str = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n";

/// Files of other formats, the name of each format, and a word of the advice.
fn others() -> Vec<(Vec<u8>, &'static str, &'static str)> {
    let text = |text: &str| text.as_bytes().to_vec();
    vec![
        (zip(&["[Content_Types].xml", "3D/3dmodel.model"]), "a 3MF file", "trimesh"),
        (zip(&["model.usdc", "0/texture.png"]), "a USDZ file", "Blender"),
        (zip(&["model/fox.glb"]), "a ZIP archive with a model in it", "unpack"),
        (binary_stl(2), "an STL file", "trimesh"),
        ([binary_stl(12), vec![0; 2]].concat(), "an STL file", "trimesh"),
        (text(STL), "an STL file", "trimesh"),
        (text(PLY), "a PLY file", "trimesh"),
        (text(&PLY.replace('\n', "\r\n")), "a PLY file", "trimesh"),
        (text("OFF\n3 1 0\n"), "an OFF file", "trimesh"),
        (text("Kaydara FBX Binary  \0\x1a\0"), "an FBX file", "assimp"),
        (text("; FBX 7.4.0 project file\n"), "an FBX file", "assimp"),
        (text("BLENDER-v300REND"), "a Blender file", "export"),
        (text(COLLADA), "a COLLADA file", "assimp"),
        (text("PXR-USDC\0\0"), "a USD file", "Blender"),
        (text("#usda 1.0\n"), "a USD file", "Blender"),
        (b"\x1f\x8b\x08\0\0\0\0\0".to_vec(), "compressed by gzip", "unpack"),
        (text("\n<!DOCTYPE html>\n<html lang=en>"), "a page of the web (HTML)", "download"),
        (text("<html><body>404</body></html>"), "a page of the web (HTML)", "download"),
        (text(POINTER), "a pointer of Git LFS", "git lfs pull"),
        (b"\x93NUMPY\x01\0v\0{'descr': '<f4'".to_vec(), "a single array (.npy)", "savez"),
        (utf16(OBJ, true, false), "UTF-16", "UTF-8"),
        (utf16(OBJ, true, true), "UTF-16", "UTF-8"),
        (utf16(OBJ, false, false), "UTF-16", "UTF-8"),
        (utf16("{\"asset\": {}}", false, true), "UTF-16", "UTF-8"),
        (b"\x89PNG\r\n\x1a\n".to_vec(), "a picture", ".npz"),
    ]
}

fn kinds() -> Outcome {
    let folder = folder();
    for (bytes, what, advice) in others() {
        for ending in ["stl", "glb", "gltf", "obj", "npz", "bin"] {
            let file = folder.path().join(format!("a.{ending}"));
            write_file(&file, &bytes)?;
            let run = rimline([OsString::from("info"), file.clone().into()]);
            std::fs::remove_file(file).map_err(|error| error.to_string())?;
            let parts = [&format!("a.{ending}: it is "), what, "which is not read here; ", advice];
            run.expect(1, &parts).map_err(|error| format!("{what}, .{ending}: {error}"))?;
        }
        fed(&bytes, &["info", "-"])?.expect(1, &["-: it is ", what, advice])?;
    }
    // Some hundred bytes more, and it is no STL for certain. Text that only begins like the word is none, either.
    for (bytes, ending) in [([binary_stl(2), vec![0; 600]].concat(), "stl"), (b"solid ground\n".to_vec(), "txt")] {
        let file = folder.path().join(format!("a.{ending}"));
        write_file(&file, bytes)?;
        let run = rimline([OsString::from("info"), file.clone().into()]);
        run.expect(1, &[&format!("cannot read .{ending}"), "use .glb, .gltf, .obj or .npz", "convert"])?;
        std::fs::remove_file(file).map_err(|error| error.to_string())?;
    }
    is_empty(folder.path())
}

fn renamed() -> Outcome {
    let folder = folder();
    let buffer = own_gltf::buffer().iter().map(|byte| format!("%{byte:02x}")).collect::<Vec<_>>().concat();
    let buffer = format!("data:application/octet-stream,{buffer}");
    let gltf = own_gltf::text(&Names { buffer: &buffer, ..Names::default() }).into_bytes();
    // A comment that another format begins with, and a group of a name like one.
    let obj = format!("# vtk\ng solid\n{OBJ}").into_bytes();
    for (bytes, faces) in [(gltf, 4), (tetrahedron(), 4), (obj, 1)] {
        for ending in ["glb", "gltf", "obj", "npz"] {
            let file = folder.path().join(format!("a.{ending}"));
            write_file(&file, &bytes)?;
            let json = rimline([OsString::from("info"), "--json".into(), file.into()]).json()?;
            ensure!(json["total"]["faces"] == faces, "{ending}: {}", json["total"]);
        }
    }
    Ok(())
}

fn archives() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).into_os_string();
    write_file(at("model.npz"), tetrahedron())?;
    let obj = (OBJ.as_bytes().to_vec(), "an OBJ file", "savez");
    let npy = (b"\x93NUMPY\x01\0v\0{".to_vec(), "a single array (.npy)", "savez");
    for (bytes, what, advice) in
        [obj, npy, (binary_stl(1), "an STL file", "savez"), (POINTER.into(), "Git LFS", "pull")]
    {
        write_file(at("points.npz"), bytes)?;
        let given = |words: &[&str]| {
            let files = ["--out".into(), at(if words[0] == "query" { "out.npz" } else { "out.png" }), at("model.npz")];
            rimline(words.iter().map(OsString::from).chain([at("points.npz")]).chain(files))
        };
        for words in [["query", "--light", "dir:0,0,1", "--points"], ["shadow", "--light", "dir:0,0,1", "--depth"]] {
            given(&words).expect(1, &["points.npz: it is ", what, advice])?;
        }
    }
    Ok(())
}
