//! `NumPy` archives: as models, with polygons, with lights, as points, as depth maps, and compared with another archive.

use std::collections::BTreeMap;
use std::io::{Cursor, Write as _};

use rimline::cpu::{self, Threads};
use rimline::mesh::{NO_FACE, PolygonLoops, Weld};
use rimline::{Light, Mesh, Origin, Predicate};
use rimline_files::npz;
use rimline_testkit::random::Random;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use rimline_testkit::mutate;

/// An archive may take this much memory.
const MEMORY_LIMIT: u64 = 64 << 20;

#[derive(Clone)]
struct Array {
    name: String,
    version: u8,
    header: String,
    data: Vec<u8>,
    is_packed: bool,
}

pub(crate) struct Seeds {
    archives: Vec<Vec<Array>>,
    /// Others are compared with it.
    sound: Vec<u8>,
}

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, f32::NAN, f32::INFINITY]];
const FACES: [[u8; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

/// A quadrilateral and a triangle with a hole, of the positions.
fn polygons(positions: &Array) -> Vec<Array> {
    let row = |name, values: &[u8]| array(name, "|u1", "False", &format!("({},)", values.len()), values);
    vec![
        positions.clone(),
        row("polygon_loops", &[1, 2]),
        row("loop_sizes", &[4, 3, 3]),
        row("loop_corners", &[0, 1, 2, 3, 0, 2, 1, 3, 1, 2]),
    ]
}

/// Four points, and the faces that they are on.
fn on_faces(points: Array, descr: &str, faces: &[u8]) -> Vec<Array> {
    vec![points, array("on_face", descr, "False", "(4,)", faces)]
}

/// A depth map, or six, of two texels.
fn depth_map(maps: &str, order: &str) -> Vec<Array> {
    let count: usize = if maps.is_empty() { 1 } else { 6 };
    let matrix = [1.0_f32, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, -1.0, 0.0];
    let matrices: Vec<u8> = matrix.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>().repeat(count);
    let depths: Vec<u8> = [0.5_f32, f32::NAN].iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>().repeat(count);
    vec![
        array("depth", "<f4", order, &format!("({maps}1, 2)"), &depths),
        array("view_projection", "<f4", order, &format!("({maps}4, 4)"), &matrices),
        array("origin", "<f4", "False", "(3,)", &[0; 12]),
        array("reversed", "|b1", "False", "()", &[1]),
        array("depth_bits", "|u1", "False", "(1,)", &[24]),
        array("metric", "|u1", "False", "()", &[2]),
        array("objects", "<u2", order, "(1, 2)", &[1, 0, 2, 0]),
    ]
}

impl Seeds {
    pub(crate) fn new() -> Result<Self, String> {
        let little: Vec<u8> = POSITIONS.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
        let big: Vec<u8> = POSITIONS.as_flattened().iter().flat_map(|c| c.to_be_bytes()).collect();
        let indices = |width: usize| -> Vec<u8> {
            FACES.as_flattened().iter().flat_map(|&index| u64::from(index).to_le_bytes()[..width].to_vec()).collect()
        };
        let positions = array("positions", "<f4", "False", "(4, 3)", &little);
        let lights = array("lights", "<f4", "False", "(2, 4)", &little[..32]);
        let points = array("points", "<f4", "False", "(4, 3)", &little);
        let faces = |descr, width, order| array("faces", descr, order, "(4, 3)", &indices(width));
        let archives = vec![
            vec![positions.clone(), faces("<u4", 4, "False"), lights.clone()],
            vec![packed(positions.clone()), packed(faces("|u1", 1, "True")), lights.clone()],
            vec![array("positions", ">f4", "True", "(4,3)", &big), faces("<i8", 8, "False"), lights],
            polygons(&positions),
            vec![faces("<i2", 2, "False"), array("extra", "<c8", "False", "()", &[0; 8]), positions],
            vec![points.clone()],
            on_faces(points.clone(), "<i4", &[0, -1, 3, 1].map(i32::to_le_bytes).concat()),
            on_faces(packed(points.clone()), "|i1", &[1, 255, 2, 0]),
            on_faces(
                array("points", "<f8", "True", "(4, 3)", &[0; 96]),
                ">u8",
                &[0, 1, 2, 9_u64].map(u64::to_be_bytes).concat(),
            ),
            vec![packed(points)],
            depth_map("", "False"),
            depth_map("6, ", "True"),
            vec![
                packed(array("positions", "<f4", "False", "(100000, 3)", &vec![0; 1_200_000])),
                faces("|u1", 1, "False"),
            ],
        ];
        let sound = write(&archives[0])?;
        Ok(Self { archives, sound })
    }

    pub(crate) fn case(&self, random: &mut Random) -> Vec<u8> {
        let mut arrays = self.archives[random.below(self.archives.len())].clone();
        for _ in 0..random.below(4) {
            let at = random.below(arrays.len());
            match random.below(9) {
                0..=3 => {
                    let dictionary =
                        ["(", ")", "{", "'", "True", "False", "<f4", "|u1", ">i8", "|O", "'shape'", ",", "3L", "-"];
                    mutate::text(&mut arrays[at].header, &dictionary, random);
                }
                4 => mutate::bytes(&mut arrays[at].data, random),
                5 => {
                    let other = &self.archives[random.below(self.archives.len())];
                    arrays[at] = other[random.below(other.len())].clone();
                }
                6 => arrays[at].is_packed ^= true,
                7 => arrays[at].version = random.below(5) as u8,
                _ => {
                    let copy = arrays[at].clone();
                    arrays.push(Array { name: format!("{}{}", copy.name, arrays.len()), ..copy });
                }
            }
        }
        // Names twice are refused when an archive is written; such cases come from bytes that change.
        let mut bytes = write(&arrays).unwrap_or_else(|_| self.sound.clone());
        if random.below(2) == 0 {
            for _ in 0..=random.below(3) {
                mutate::bytes(&mut bytes, random);
            }
        }
        bytes
    }

    pub(crate) fn run(&self, bytes: &[u8]) -> Result<bool, String> {
        let model = npz::read(Cursor::new(bytes), MEMORY_LIMIT);
        let is_outside = |arrays: &npz::Arrays| {
            arrays.faces.iter().flatten().any(|&vertex| vertex as usize >= arrays.positions.len())
        };
        if model.as_ref().is_ok_and(is_outside) {
            return Err("a face names a vertex that is not there".to_owned());
        }
        if let Ok(npz::Arrays { positions, polygons: Some(polygons), .. }) = &model {
            check_polygons(positions, polygons.loops(), [Weld::Position, Weld::Keep][bytes.len() % 2])?;
        }
        let with_lights = npz::read_with_lights(Cursor::new(bytes), MEMORY_LIMIT);
        let points = npz::read_points(Cursor::new(bytes), MEMORY_LIMIT);
        let are_points = points.is_ok();
        points.map_or(Ok(()), check_points)?;
        let map = npz::read_depth_map(Cursor::new(bytes), MEMORY_LIMIT, true);
        let is_short = |map: &npz::DepthMapArrays| {
            let texels = map.size[0] as usize * map.size[1] as usize;
            let depths = match &map.depths {
                npz::Depths::F32(depths) => depths.len(),
                npz::Depths::U16(depths) => depths.len(),
            };
            let maps = map.view_projections.len();
            depths != maps * texels
                || ![1, 6].contains(&maps)
                || map.objects.as_ref().is_some_and(|of| of.len() != texels)
        };
        if map.as_ref().is_ok_and(is_short) {
            return Err("a depth map lacks values".to_owned());
        }
        let is_equal = bytes == self.sound;
        match npz::compare(bytes, &self.sound) {
            Ok(differences) if differences.is_empty() != is_equal => return Err("a difference is missed".to_owned()),
            Err(error) if error.to_string().len() > 4000 => return Err(format!("a long message: {error}")),
            _ => {}
        }
        if let Some(error) = model.as_ref().err().filter(|error| error.to_string().len() > 4000) {
            return Err(format!("a long message: {error}"));
        }
        Ok(model.is_ok() || with_lights.is_ok() || are_points || map.is_ok())
    }
}

/// Polygons make a mesh, or are refused: then it is false. The boundary of their triangles is their boundary, and
/// silhouettes can be extracted.
pub(super) fn check_polygons(positions: &[[f32; 3]], loops: PolygonLoops<'_>, weld: Weld) -> Result<bool, String> {
    let (by_loop, cut) =
        (Mesh::from_polygons_by_loop(positions, loops, weld), Mesh::from_polygons(positions, loops, weld));
    let (mesh, cut) = match (by_loop, cut) {
        (Ok(mesh), Ok(cut)) => (mesh, cut),
        (Err(one), Err(other)) if one == other => return Ok(false),
        (one, other) => return Err(format!("one constructor says {:?}, the other {:?}", one.err(), other.err())),
    };
    for mesh in [&mesh, &cut] {
        if mesh.faces().iter().flatten().any(|&vertex| vertex as usize >= positions.len()) {
            return Err("a triangle names a vertex that is not there".to_owned());
        }
    }
    if cut.polygons().is_some() || cut.face_count() < loops.polygon_loops.len() {
        return Err("a polygon has no triangle".to_owned());
    }
    let Some(polygons) = mesh.polygons() else { return Ok(true) };
    let sum = |edges: &mut dyn Iterator<Item = [u32; 2]>| {
        let mut sums = BTreeMap::new();
        edges.for_each(|[a, b]| *sums.entry([a.min(b), a.max(b)]).or_insert(0) += if a < b { 1 } else { -1 });
        sums.retain(|_, sum| *sum != 0);
        sums
    };
    for polygon in 0..polygons.len() {
        let triangles = &mesh.faces()[polygons.triangles(polygon)];
        let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        if sum(&mut { edges }) != sum(&mut polygons.boundary(polygon).iter().copied()) {
            return Err(format!("the triangles of polygon {polygon} have another boundary"));
        }
    }
    let lights = [Light::point([0.5, 0.25, 2.0]), Light::directional([0.0, 1.0, 0.0])];
    let found = cpu::extract(positions, &mesh, &lights, Predicate::Exact, Threads::ONE);
    let found = found.map_err(|error| error.to_string())?;
    if found.facing.iter().zip(&found.twisted).any(|(facing, twisted)| facing & twisted != 0) {
        return Err("a polygon faces a light for which it is twisted".to_owned());
    }
    Ok(true)
}

/// The points that are asked about at most.
const FEW: usize = 1000;

/// Faces are as many as points. Where all are faces of a mesh, each point is asked about, and else none is.
fn check_points(arrays: npz::PointArrays) -> Result<(), String> {
    let faces = FACES.map(|face| face.map(u32::from)).to_vec();
    let count = faces.len();
    let is_found = arrays.check_faces(count).is_ok();
    let npz::PointArrays { points, on_face } = arrays;
    let points = points.relative_to(Origin::ZERO);
    if on_face.as_ref().is_some_and(|on_face| on_face.len() != points.len()) {
        return Err("there is not a face for each point".to_owned());
    }
    let is_face = |&face: &u32| face == NO_FACE || (face as usize) < count;
    if is_found != on_face.iter().flatten().all(is_face) {
        return Err("a face that is none is taken, or one that is one is not".to_owned());
    }
    let few = points.len().min(FEW);
    let mesh = Mesh::from_faces(POSITIONS.len(), faces).map_err(|error| error.to_string())?;
    let lights = [Light::point([0.5, 0.25, 2.0]), Light::directional([0.0, 1.0, 0.0])];
    let few_faces = on_face.as_ref().map(|on_face| &on_face[..few]);
    let is_found = few_faces.is_none_or(|few_faces| few_faces.iter().all(is_face));
    let depths = cpu::shadow_depth_on_faces(&POSITIONS, &mesh, &points[..few], few_faces, &lights, Threads::ONE);
    match depths {
        Ok(depths) if is_found && depths.len() == few * lights.len() => Ok(()),
        Err(_) if !is_found => Ok(()),
        other => Err(format!("points on faces: {other:?}")),
    }
}

fn array(name: &str, descr: &str, fortran_order: &str, shape: &str, data: &[u8]) -> Array {
    let header = format!("{{'descr': '{descr}', 'fortran_order': {fortran_order}, 'shape': {shape}, }}");
    Array { name: name.to_owned(), version: 1, header, data: data.to_vec(), is_packed: false }
}

fn packed(array: Array) -> Array {
    Array { is_packed: true, ..array }
}

fn write(arrays: &[Array]) -> Result<Vec<u8>, String> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for Array { name, version, header, data, is_packed } in arrays {
        let method = if *is_packed { CompressionMethod::Deflated } else { CompressionMethod::Stored };
        let options = SimpleFileOptions::default().compression_method(method);
        let mut bytes = b"\x93NUMPY".to_vec();
        bytes.extend([*version, 0]);
        match version {
            1 => bytes.extend((header.len() as u16).to_le_bytes()),
            _ => bytes.extend((header.len() as u32).to_le_bytes()),
        }
        bytes.extend(header.bytes());
        bytes.extend(data);
        zip.start_file(format!("{name}.npy"), options).map_err(|error| error.to_string())?;
        zip.write_all(&bytes).map_err(|error| error.to_string())?;
    }
    Ok(zip.finish().map_err(|error| error.to_string())?.into_inner())
}
