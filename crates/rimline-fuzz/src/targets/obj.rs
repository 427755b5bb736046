//! Wavefront OBJ files.

use std::io::Cursor;

use rimline::mesh::Weld;
use rimline_files::mtl::Materials;
use rimline_files::npz::Arrays;
use rimline_files::obj;
use rimline_testkit::random::Random;

use super::npz::check_polygons;
use rimline_testkit::mutate;

/// A file may take this much memory.
pub(super) const MEMORY_LIMIT: u64 = 64 << 20;

const SEEDS: [&str; 6] = [
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
     f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n",
    "# a\r\nmtllib a.mtl\r\no Pentagon\r\nv -1 0 0 1\r\nv 0 1 0 1.0\r\nv 1.5e0 0 +.25\r\nv 1 -1 NaN\r\nv -1 -1 1e99\r\n\
     usemtl red\r\ng a b\r\ns off\r\nf -1 -2 -3 \\\r\n -4 -5\r\nl 1 2 3\r\np 1\r\n",
    "\u{feff}f 1/1/1 2//2 3/3 4 1\nv 0 0 0 1 0 0\nv 2 0 0 .5 .5 .5\nv 2 2 1 1 1 1\nv 0 2 0\nvt 0 0\nvn 0 0 1\n",
    "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\nf 4 3 2 1\nf 1 1 2 2\ncurv 0 1 1 2\nend\n",
    "newmtl red\nKd 1 0.5 nan\nmtllib a.mtl b.mtl\nnewmtl a b\nKd .2\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 1 .5 inf\n\
     usemtl red\nf 1 2 3\nusemtl a b\nf 3 2 1 1\nusemtl\n",
];

const DICTIONARY: [&str; 26] = [
    "v", "f", "fo", "vt", "vn", "vp", "l", "p", "o", "g", "surf", "bzp", "\\\n", "\n", "\r\n", "#", "/", "//", "-",
    "inf", " ", "\u{feff}", "usemtl", "mtllib", "newmtl", "Kd",
];

pub(crate) fn case(random: &mut Random) -> Vec<u8> {
    let mut text = SEEDS[random.below(SEEDS.len())].to_owned();
    for _ in 0..random.below(5) {
        if random.below(8) == 0 {
            text.push_str(SEEDS[random.below(SEEDS.len())]);
        } else {
            mutate::text(&mut text, &DICTIONARY, random);
        }
    }
    let mut bytes = text.into_bytes();
    if random.below(4) == 0 {
        mutate::bytes(&mut bytes, random);
    }
    bytes
}

pub(crate) fn run(bytes: &[u8]) -> Result<bool, String> {
    obj::begins_like(bytes);
    let mut materials = Materials::new(None);
    materials.parse(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    check(bytes.len(), obj::read(Cursor::new(bytes), &mut materials, MEMORY_LIMIT, true))
}

/// Whether a model was read, and is one.
pub(super) fn check<E: std::fmt::Display>(length: usize, model: Result<Arrays, E>) -> Result<bool, String> {
    let model = match model {
        Ok(model) => model,
        Err(error) if error.to_string().len() > 1000 => return Err(format!("a long message: {error}")),
        Err(_) => return Ok(false),
    };
    if model.faces.iter().flatten().any(|&vertex| vertex as usize >= model.positions.len()) {
        return Err("a face names a vertex that is not there".to_owned());
    }
    if model.faces.is_empty() == model.polygons.is_none() {
        return Err("triangles and polygons, or neither".to_owned());
    }
    let polygons = model.polygons.as_ref().map_or(model.faces.len(), |polygons| polygons.loops().loop_sizes.len());
    for (colors, count) in [(&model.colors.faces, polygons), (&model.colors.vertices, model.positions.len())] {
        let is_wrong = |color: &[f32; 3]| !color.iter().all(|component| (0.0..=1.0).contains(component));
        if colors.as_ref().is_some_and(|colors| colors.len() != count || colors.iter().any(is_wrong)) {
            return Err("colours that are no colours, or too few or too many".to_owned());
        }
    }
    if let Some(polygons) = &model.polygons {
        let weld = [Weld::Position, Weld::Keep][length % 2];
        if !check_polygons(&model.positions, polygons.loops(), weld)? {
            return Err("polygons that the file is right to have are refused".to_owned());
        }
    }
    Ok(true)
}
