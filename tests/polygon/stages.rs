//! The stages of polygons against their twins.

use std::collections::BTreeMap;

use rimline::gpu::{Extractor, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::mesh::Weld;
use rimline::reference::cpu::{self, Outline, Piece, PieceEnd, PolygonMasks, Seen, Threads, cut_edges};
use rimline::{Light, Mesh, Predicate};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{Found, compare, extract, extract_with, text};
use rimline_testkit::polygons::{PolygonSet, edge_on_polygon, folded_polygon, outline_in_planes, random_set};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, polygon_oracle, same};

use crate::lights::light_for;

pub(crate) const TESTS: &[Test] = &[
    ("masks_equal_their_twin", masks),
    ("pieces_are_those_of_their_twin", pieces),
    ("pieces_of_outlines_in_planes_with_the_light_close", in_planes),
];

fn random_lights(random: &mut Random, set: &PolygonSet, count: usize) -> Vec<Light> {
    let any = std::iter::repeat_with(|| light_for(random, &set.positions).1);
    any.filter(|light| light.to_array() != [0.0; 4]).take(count).collect()
}

/// Compares the bits of triangles with the facing and twisted bits of their polygons.
pub(crate) fn check_facing(mesh: &Mesh, found: &Found, masks: &[PolygonMasks]) -> Result<(), String> {
    same("facing", &found.facing, &of_triangles(mesh, masks, |masks| masks.facing)?)?;
    // A row a polygon, as the CPU has it; a polygon without triangles faces nothing there, too.
    let (polygons, triangles) = (mesh.polygons().ok_or("no polygons")?, mesh.faces().len().max(1));
    let rows: Vec<u32> = found.facing.chunks(triangles).flat_map(|plane| polygons.masks_of(plane)).collect();
    let expected: Vec<u32> = masks.iter().map(|masks| masks.facing).collect();
    same("facing of polygons", &rows, &expected[..rows.len()])?;
    if let Some(first) = expected.iter().position(|facing| *facing != 0).filter(|_| !rows.is_empty()) {
        let mut wrong = expected.clone();
        wrong[first] ^= 1;
        must_fail("a facing bit of a polygon", &same("facing of polygons", &rows, &wrong[..rows.len()]))?;
    }
    same("twisted", &found.twisted, &of_triangles(mesh, masks, |masks| masks.twisted)?)
}

fn check_masks(mesh: &Mesh, found: &Found, masks: &[PolygonMasks]) -> Result<(), String> {
    check_facing(mesh, found, masks)?;
    same("excluded", &found.excluded, &of_triangles(mesh, masks, |masks| masks.excluded)?)
}

fn of_triangles(mesh: &Mesh, masks: &[PolygonMasks], of: fn(&PolygonMasks) -> u32) -> Result<Vec<u32>, String> {
    let polygons = mesh.polygons().ok_or("no polygons")?;
    let plane = |plane: &[PolygonMasks]| {
        polygons.triangle_polygons().into_iter().map(|polygon| of(&plane[polygon as usize])).collect::<Vec<_>>()
    };
    Ok(masks.chunks(polygons.len()).flat_map(plane).collect())
}

fn masks() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 31_000;
    println!("seeds from {first}");
    let (mut twisted, mut large, mut not_finite) = (0, 0, 0);
    for seed in first..first + if is_long() { 600 } else { 40 } {
        let mut random = Random::new(seed);
        let most = [6, 12, 33, 64, 100][random.below(5)];
        let mut set = random_set(&mut random, most);
        let count = [1, 2, 16, 17, 32, 35][random.below(6)];
        let lights = random_lights(&mut random, &set, count);
        if seed % 5 == 0 {
            let vertex = random.below(set.positions.len());
            set.positions[vertex][random.below(3)] = [f32::NAN, f32::INFINITY][random.below(2)];
        }
        if seed % 7 == 0 {
            let scale = [1e-30, 1e18, 1e30][random.below(3)];
            set.positions.iter_mut().for_each(|p| *p = p.map(|c| c * scale));
        }
        let mesh = set.mesh(Weld::Position).map_err(|error| error.to_string())?;
        let Some(polygons) = mesh.polygons() else { continue };
        let (masks, statistics) = cpu::polygon_facing(&set.positions, polygons, &lights, Threads::ONE);
        let lists = ListOptions { capacity: Some(u32::MAX), ordered: random.below(2) == 0, ..ListOptions::default() };
        let options =
            ExtractorOptions { max_lights: count, masks: true, lists: Some(lists), ..ExtractorOptions::default() };
        let found = extract(gpu, &set.positions, &mesh, &lights, options)?;
        check_masks(&mesh, &found, &masks).map_err(|error| format!("seed {seed}: {error}"))?;
        let expected = cpu::extract(&set.positions, &mesh, &lights, Predicate::Exact, Threads::ONE)
            .map_err(|error| error.to_string())?;
        same(&format!("seed {seed}, masks"), &found.masks, &expected.masks)?;
        same(
            &format!("seed {seed}, not finite"),
            &[found.statistics.non_finite_faces],
            &[statistics.non_finite_faces],
        )?;
        for light in 0..count {
            let plane = &expected.masks[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
            let silhouettes = plane.iter().filter(|masks| masks.silhouette >> (light % 32) & 1 != 0).count();
            same(&format!("seed {seed}, light {light}, count"), &[found.counts[light]], &[silhouettes as u32])?;
        }
        twisted += masks.iter().map(|masks| masks.twisted.count_ones()).sum::<u32>();
        large += (0..polygons.len()).filter(|&polygon| polygons.outline(polygon).len() > 32).count();
        not_finite += statistics.non_finite_faces;
        let mut wrong = masks.clone();
        let at = random.below(wrong.len());
        if !polygons.triangles(at % polygons.len()).is_empty() {
            wrong[at].twisted ^= 1;
            must_fail("a twisted bit", &check_masks(&mesh, &found, &wrong))?;
        }
        let plain = extract_with(gpu, &set.positions, &mesh, &lights, options)?;
        let public = Found { excluded: Vec::new(), ..found };
        compare(&format!("seed {seed}, not for volumes"), &plain, &public, u32::MAX, lists.ordered)?;
        same("twisted", &plain.twisted, &public.twisted)?;
    }
    println!("{twisted} twisted pairs, {large} large outlines, {not_finite} not finite");
    if twisted > 1000 && large > 50 && not_finite > 0 { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// A piece as the GPU lists it: where it begins and ends, and the middle of its polygon.
pub(crate) type Listed = [[f32; 3]; 3];

fn extracted(gpu: &Gpu, set: &PolygonSet, mesh: &Mesh, lights: &[Light]) -> Result<Extractor, String> {
    let options = ExtractorOptions { max_lights: lights.len(), for_volumes: true, ..ExtractorOptions::default() };
    let buffer = gpu.storage(&set.positions);
    let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?;
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    gpu.submit(|encoder| extractor.encode(encoder, positions, lights).map_err(text))?;
    Ok(extractor)
}

/// How many pieces each of up to 32 lights has, and how many there is room for.
pub(crate) fn piece_counts(
    gpu: &Gpu,
    set: &PolygonSet,
    mesh: &Mesh,
    lights: &[Light],
) -> Result<(Vec<u32>, u32), String> {
    let extractor = extracted(gpu, set, mesh, lights)?;
    let buffer = extractor.pieces().first().ok_or("no pieces")?;
    Ok((gpu.read(buffer, lights.len())?, extractor.piece_capacity()))
}

pub(crate) fn listed(gpu: &Gpu, set: &PolygonSet, mesh: &Mesh, lights: &[Light]) -> Result<Vec<Vec<Listed>>, String> {
    let extractor = extracted(gpu, set, mesh, lights)?;
    let capacity = extractor.piece_capacity() as usize;
    let mut lists = Vec::new();
    for (batch, buffer) in extractor.pieces().iter().enumerate() {
        let words: Vec<u32> = gpu.read(buffer, usize::MAX)?;
        for light in 0..(lights.len() - 32 * batch).min(32) {
            let count = words[light] as usize;
            if count > capacity {
                return Err(format!("{count} pieces, and room for {capacity}"));
            }
            let words = &words[32 + 9 * light * capacity..][..9 * count];
            let point = |at: &[u32]| [0, 1, 2].map(|axis| f32::from_bits(at[axis]));
            lists.push(words.chunks(9).map(|at| [point(&at[..3]), point(&at[3..6]), point(&at[6..])]).collect());
        }
    }
    Ok(lists)
}

/// The number of pieces that begin at a point, bit for bit, equals the number that end there.
pub(crate) fn check_closed(pieces: &[Listed]) -> Result<(), String> {
    let mut balance = BTreeMap::<[u32; 3], i32>::new();
    for [from, to, _] in pieces {
        *balance.entry(from.map(|c| (c + 0.0).to_bits())).or_default() += 1;
        *balance.entry(to.map(|c| (c + 0.0).to_bits())).or_default() -= 1;
    }
    match balance.into_iter().find(|&(_, sum)| sum != 0) {
        None => Ok(()),
        Some((point, sum)) => Err(format!("{sum} pieces too many begin at {:?}", point.map(f32::from_bits))),
    }
}

/// How far a point is from where an end of the twin's piece is. At a crossing it is on the earlier of both edges, and in the
/// plane through the light and the other. How far along depends on rounding where edges are seen as nearly parallel.
fn distance_from(outline: &Outline, piece: &Piece, end: usize, light: Light, point: [f32; 3]) -> f64 {
    let edge = |index: usize| outline.edges()[index].map(|p| p.map(f64::from));
    let p = point.map(f64::from);
    let from = |corner| if corner == p { 0.0 } else { length(difference(p, corner)) };
    let other = match piece.ends[end] {
        PieceEnd::Corner => return from(edge(piece.edge)[end]),
        PieceEnd::Touch(end) => return from(end.map(f64::from)),
        PieceEnd::Crossing { edge, .. } => edge,
    };
    let [a, b] = edge(piece.edge.min(other));
    let [c, d] = edge(piece.edge.max(other));
    let height = dot(plane_of([c, d].map(|p| p.map(|c| c as f32)), light), difference(p, c)).abs();
    let along = difference(b, a);
    let part = (dot(along, difference(p, a)) / dot(along, along)).clamp(0.0, 1.0);
    let on_edge = [0, 1, 2].map(|axis| a[axis] + part * along[axis]);
    height.max(length(difference(p, on_edge)))
}

fn difference(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| p[axis] - q[axis])
}

fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn dot(u: [f64; 3], v: [f64; 3]) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// The pieces of the twin are there, each once and no other, within rounding.
pub(crate) fn check_listed(
    found: &[Listed],
    expected: &[Piece],
    outline: &Outline,
    light: Light,
) -> Result<(), String> {
    if found.len() != expected.len() {
        return Err(format!("{} pieces, expected {}", found.len(), expected.len()));
    }
    let mut left = found.to_vec();
    for piece in expected {
        let distance = |listed: &Listed| {
            let from = usize::from(piece.is_turned);
            let of_end = |end: usize, point| distance_from(outline, piece, end, light, point);
            of_end(from, listed[0]).max(of_end(1 - from, listed[1]))
        };
        let nearest = (0..left.len()).min_by(|&p, &q| distance(&left[p]).total_cmp(&distance(&left[q])));
        let nearest = nearest.ok_or("none is left")?;
        if distance(&left[nearest]) > 1e-4 {
            return Err(format!("{piece:?} is not there; {} from {:?}", distance(&left[nearest]), left[nearest]));
        }
        left.swap_remove(nearest);
    }
    Ok(())
}

/// The same where the twin has the places of crossings, to a thousandth of the outline's size.
fn check_ends(found: &[Listed], expected: &[Piece], outline: &Outline) -> Result<(), String> {
    let mut places = BTreeMap::new();
    for piece in expected {
        for end in piece.ends {
            if let PieceEnd::Crossing { edge, at } = end {
                places.insert((piece.edge, edge), at);
            }
        }
    }
    let place = |piece: &Piece, end: usize| match piece.ends[end] {
        PieceEnd::Corner => outline.edges()[piece.edge][end].map(f64::from),
        PieceEnd::Touch(point) => point.map(f64::from),
        PieceEnd::Crossing { edge, .. } => {
            let (first, second) = (piece.edge.min(edge), piece.edge.max(edge));
            let [a, b] = outline.edges()[first].map(|p| p.map(f64::from));
            let at = places[&(first, second)];
            [0, 1, 2].map(|axis| a[axis] + at * (b[axis] - a[axis]))
        }
    };
    let size = outline.edges().iter().flatten().flatten().fold(0.0, |size: f64, &c| size.max(f64::from(c).abs()));
    let mut left: Vec<_> = found.iter().map(|&[from, to, _]| [from, to].map(|p| p.map(f64::from))).collect();
    for piece in expected {
        let first = usize::from(piece.is_turned);
        let ends = [place(piece, first), place(piece, 1 - first)];
        let distance =
            |other: &[[f64; 3]; 2]| length(difference(ends[0], other[0])).max(length(difference(ends[1], other[1])));
        let nearest = (0..left.len()).min_by(|&p, &q| distance(&left[p]).total_cmp(&distance(&left[q])));
        match nearest.map(|at| left.swap_remove(at)) {
            Some(nearest) if distance(&nearest) <= 1e-3 * size => {}
            nearest => return Err(format!("{piece:?} is not there, from {ends:?}, but {nearest:?}")),
        }
    }
    if left.is_empty() { Ok(()) } else { Err(format!("{} pieces too many", left.len())) }
}

/// Whether the light is on the polygon or next to it, where rounding tells what it sees.
fn is_lit_from_within(triangles: &[[[f32; 3]; 3]], light: Light) -> bool {
    let [x, y, z, w] = light.to_array().map(f64::from);
    let at = [x / w, y / w, z / w];
    let is_near = |triangle: &[[f32; 3]; 3]| {
        let [a, b, c] = triangle.map(|p| p.map(f64::from));
        let normal = cross(difference(b, a), difference(c, a));
        let area = length(normal);
        let is_within = |p, q| dot(cross(difference(q, p), difference(at, p)), normal) > -1e-3 * area * area;
        let height = dot(normal, difference(at, a)).abs();
        area < 1e-6 || height < 1e-3 * area && is_within(a, b) && is_within(b, c) && is_within(c, a)
    };
    w != 0.0 && triangles.iter().any(is_near)
}

/// The normal of the plane through an edge and the light. It has no length if the edge is seen end-on.
fn plane_of([a, b]: [[f32; 3]; 2], light: Light) -> [f64; 3] {
    let [a, b] = [a, b].map(|p| p.map(f64::from));
    let [x, y, z, w] = light.to_array().map(f64::from);
    let towards = [x - w * a[0], y - w * a[1], z - w * a[2]];
    let normal = cross(difference(b, a), towards);
    let size = length(normal);
    if size < 1e-3 * length(difference(b, a)) * length(towards) { [0.0; 3] } else { normal.map(|c| c / size) }
}

/// Whether two cuts of an edge are nearly one, or an edge is cut by one that is seen as nearly parallel.
fn has_near_cuts(pieces: &[Piece], outline: &Outline, light: Light) -> bool {
    pieces.iter().any(|piece| {
        let is_flat = |end| match end {
            PieceEnd::Crossing { edge, .. } => {
                let [p, q] = [piece.edge, edge].map(|edge| plane_of(outline.edges()[edge], light));
                length(cross(p, q)) < 1e-3
            }
            PieceEnd::Corner | PieceEnd::Touch(_) => false,
        };
        let is_short = match piece.ends {
            [PieceEnd::Crossing { at: from, .. }, PieceEnd::Crossing { at: to, .. }] => to - from < 1e-4,
            _ => false,
        };
        is_short || piece.ends.into_iter().any(is_flat)
    })
}

fn pieces() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 57_000;
    println!("seeds from {first}");
    let (mut count, mut large, mut near, mut touching) = (0, 0, 0, 0);
    for seed in first..first + if is_long() { 400 } else { 24 } {
        let mut random = Random::new(seed);
        let most = [6, 8, 12, 24, 36][random.below(5)];
        let (mut set, mut lights) = (random_set(&mut random, most), Vec::new());
        for _ in 0..random.below(9) {
            set.push_points(&[folded_polygon(&mut random)]);
            let (points, light) = edge_on_polygon(&mut random);
            set.push_points(&[points]);
            lights.push(Light::point(light));
        }
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        let Some(polygons) = mesh.polygons() else { continue };
        let light_count = [2, 17, 25][random.below(3)];
        lights.extend(random_lights(&mut random, &set, light_count));
        let lists = listed(gpu, &set, &mesh, &lights)?;
        for (light, list) in lights.iter().zip(&lists) {
            let mut expected = 0;
            for polygon in 0..polygons.len() {
                let edges = polygons.outline(polygon);
                let outline = Outline::new(edges, &set.positions).ok_or("not finite")?;
                if edges.is_empty() || outline.seen(light.to_array()).0 != Seen::Twisted {
                    continue;
                }
                let triangles = mesh.faces()[polygons.triangles(polygon)].iter();
                let triangles: Vec<_> = triangles.map(|face| face.map(|v| set.positions[v as usize])).collect();
                let cut = cut_edges(&outline, &triangles, light.to_array());
                expected += cut.len();
                large += usize::from(edges.len() > 32);
                if is_lit_from_within(&triangles, *light) {
                    continue;
                }
                let places: Vec<_> = edges.iter().map(|edge| edge.map(|v| set.positions[v as usize])).collect();
                touching += usize::from(polygon_oracle::find(&places, *light).touches);
                let corner = |quarter: usize| set.positions[edges[quarter * edges.len() / 4][0] as usize];
                let [a, b, c, d] = [0, 1, 2, 3].map(corner);
                let middle = [0, 1, 2].map(|axis| ((a[axis] + b[axis]) + (c[axis] + d[axis])) * 0.25);
                let of_polygon: Vec<_> = list.iter().copied().filter(|piece| piece[2] == middle).collect();
                // Others may have the same middle.
                if of_polygon.len() != cut.len() {
                    continue;
                }
                let what = format!("seed {seed}, polygon {polygon}, {light:?}");
                check_closed(&of_polygon).map_err(|error| format!("{what}: {error}"))?;
                count += cut.len();
                // Which of two cuts that are nearly one comes first is known to the exact twin only.
                if has_near_cuts(&cut, &outline, *light) {
                    near += 1;
                    continue;
                }
                check_listed(&of_polygon, &cut, &outline, *light).map_err(|error| format!("{what}: {error}"))?;
                if count % 16 == 0 {
                    let mut wrong = of_polygon.clone();
                    let size = |piece: &Listed| {
                        let [from, to, _] = piece.map(|p| p.map(f64::from));
                        length(difference(to, from))
                    };
                    let longest = wrong.iter_mut().max_by(|p, q| size(p).total_cmp(&size(q))).ok_or("no piece")?;
                    longest.swap(0, 1);
                    must_fail("a turned piece", &check_closed(&wrong))?;
                    must_fail("a turned piece", &check_listed(&wrong, &cut, &outline, *light))?;
                }
            }
            same(&format!("seed {seed}, {light:?}, pieces"), &[list.len()], &[expected])?;
        }
    }
    println!("{count} pieces, {large} large outlines, {near} with cuts that are nearly one");
    println!("{touching} outlines touch themselves");
    if count > 5000 && large > 50 && touching > 50 { Ok(()) } else { Err("too few".to_owned()) }
}

/// Corners in planes with the light but for some: the pieces close, there are as many as the twin has, and where the planes are those
/// of axes, so that all that are seen in line cut each other in the middle, they are the same.
fn in_planes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 700_100;
    println!("seeds from {first}");
    let (mut count, mut same_ends) = (0, 0);
    for (planes, others) in [(1, 1), (1, 2), (1, 5), (2, 0), (2, 1), (3, 0)] {
        for seed in first..first + if is_long() { 200 } else { 12 } {
            let mut random = Random::new(seed);
            let (points, light) = outline_in_planes(&mut random, planes, others);
            let mut set = PolygonSet::default();
            set.push_points(&[points]);
            let mesh = set.mesh(Weld::Position).map_err(text)?;
            let Some(polygons) = mesh.polygons() else { continue };
            let outline = Outline::new(polygons.outline(0), &set.positions).ok_or("not finite")?;
            if outline.seen(light.to_array()).0 != Seen::Twisted {
                continue;
            }
            let what = format!("{planes} planes, {others} others, seed {seed}");
            let list = listed(gpu, &set, &mesh, &[light])?.pop().ok_or("no list")?;
            let triangles: Vec<_> = mesh.faces().iter().map(|face| face.map(|v| set.positions[v as usize])).collect();
            let cut = cut_edges(&outline, &triangles, light.to_array());
            same(&format!("{what}, pieces"), &[list.len()], &[cut.len()])?;
            let places: Vec<_> = outline.edges().to_vec();
            if planes == 1 || !polygon_oracle::find(&places, light).touches {
                check_closed(&list).map_err(|error| format!("{what}: {error}"))?;
                count += list.len();
            }
            let is_flat = |axis: usize| outline.edges().iter().filter(|[p, _]| p[axis] != 0.0).count() <= others;
            if planes == 1 && (0..3).any(is_flat) {
                check_ends(&list, &cut, &outline).map_err(|error| format!("{what}: {error}"))?;
                same_ends += 1;
            }
        }
    }
    println!("{count} pieces, {same_ends} outlines have the ends that the twin says");
    if count > 2000 && same_ends > 5 { Ok(()) } else { Err("too few".to_owned()) }
}
