//! PLY and STL files.

use std::io::Cursor;

use rimline_files::{ply, stl};
use rimline_testkit::mutate;
use rimline_testkit::random::Random;

use super::obj::{MEMORY_LIMIT, check};

const PLY_TEXTS: [&str; 3] = [
    "ply\nformat ascii 1.0\ncomment a\nelement vertex 5\nproperty float x\nproperty double y\nproperty float z\n\
     property uchar red\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
     end_header\n0 0 0 9\n2 .5 0 9\n2. 0 2 9\n0 0 2 9\n1 1e0 nan 9\n4 0 1 2 3 0\n3 1 0 4 1 .5\n",
    "ply\r\nformat ascii 1.0\r\nelement face 1\r\nproperty list int uint vertex_index\r\nelement vertex 3\r\n\
     property list char char a\r\nproperty short x\r\nproperty short y\r\nproperty short z\r\nelement edge 4000000000\r\n\
     end_header\r\n3 0 1 2\r\n0 0 0 0\r\n1 7 1 0 0\r\n0 0 1 0\r\n",
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
     property uchar green\nproperty uchar blue\nelement face 2\nproperty float blue\nproperty list uchar int vertex_index\n\
     property float green\nproperty list uchar int vertex_indices\nproperty float red\nend_header\n0 0 0 255 0 0\n\
     1 0 0 0 255 0\n0 1 0 0 0 999\n0 1 0 1 2 3\n.5 3 0 1 2 nan 4 0 1 2 3 1\n1 3 0 1 2 1 3 0 2 3 1e9\n",
];

const STL_TEXTS: [&str; 1] = [
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n\
     solid\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 1 0\nVERTEX 1 0 0\nVERTEX 1 1e0 nan\nENDLOOP\nENDFACET\nENDSOLID\n",
];

const DICTIONARY: [&str; 26] = [
    "element vertex ",
    "element face ",
    "property list uchar int vertex_indices\n",
    "property float x\n",
    "property uchar red\nproperty uchar green\nproperty uchar blue\n",
    "property float red\nproperty float green\nproperty float blue\n",
    "end_header\n",
    "4000000000",
    "18446744073709551615",
    "-1",
    "1e300",
    "nan",
    "inf",
    " ",
    "\n",
    "\r\n",
    "ascii",
    "binary_little_endian",
    "binary_big_endian",
    "list",
    "double",
    "vertex 0 0 0\n",
    "endloop\n",
    "facet",
    "solid ",
    "endsolid\n",
];

/// A PLY in binary: a tetrahedron.
fn binary_ply(is_big: bool) -> Vec<u8> {
    let order = if is_big { "big" } else { "little" };
    let ordered = |mut number: [u8; 4]| {
        if is_big {
            number.reverse();
        }
        number
    };
    let header = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         element face 4\nproperty list uchar uint vertex_indices\nend_header\n"
    );
    let mut bytes = header.into_bytes();
    bytes.extend([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1].iter().flat_map(|&c: &u8| ordered(f32::from(c).to_le_bytes())));
    for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|v: &u32| ordered(v.to_le_bytes())));
    }
    bytes
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid of a program".to_vec();
    bytes.resize(80, 0);
    bytes.extend(2_u32.to_le_bytes());
    for triangle in 0..2_u8 {
        bytes.extend((0..12_u8).flat_map(|c| f32::from(c * triangle % 5).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn case(binary: &[Vec<u8>], texts: &[&str], random: &mut Random) -> Vec<u8> {
    let chosen = random.below(binary.len() + texts.len());
    let Some(mut bytes) = binary.get(chosen).cloned() else {
        let mut text = texts[chosen - binary.len()].to_owned();
        (0..random.below(5)).for_each(|_| mutate::text(&mut text, &DICTIONARY, random));
        return text.into_bytes();
    };
    (0..random.below(5)).for_each(|_| mutate::bytes(&mut bytes, random));
    bytes
}

pub(crate) fn ply_case(random: &mut Random) -> Vec<u8> {
    case(&[binary_ply(false), binary_ply(true)], &PLY_TEXTS, random)
}

pub(crate) fn stl_case(random: &mut Random) -> Vec<u8> {
    case(&[binary_stl()], &STL_TEXTS, random)
}

pub(crate) fn run_ply(bytes: &[u8]) -> Result<bool, String> {
    check(bytes.len(), ply::read(Cursor::new(bytes), MEMORY_LIMIT, true))
}

pub(crate) fn run_stl(bytes: &[u8]) -> Result<bool, String> {
    check(bytes.len(), stl::read(Cursor::new(bytes), MEMORY_LIMIT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_accepted_by_their_targets() {
        let (binary, stl) = ([binary_ply(false), binary_ply(true)], binary_stl());
        for bytes in PLY_TEXTS.map(str::as_bytes).into_iter().chain(binary.iter().map(Vec::as_slice)) {
            assert_eq!(run_ply(bytes), Ok(true), "{}", String::from_utf8_lossy(bytes));
        }
        for bytes in STL_TEXTS.map(str::as_bytes).into_iter().chain([stl.as_slice()]) {
            assert_eq!(run_stl(bytes), Ok(true), "{}", String::from_utf8_lossy(bytes));
        }
    }
}
