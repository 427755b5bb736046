//! Every good file of the catalogue and of the shared models loads and poses at any time, those of the catalogue with the counts
//! that it states.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use libtest_mimic::Trial;
use rimline::gltf::Asset;
use rimline::mesh::Weld;
use rimline::model::Geometry;

use rimline_models::catalogue::GOOD;
use rimline_testkit::files;
use rimline_testkit::harness::{on_both, on_made, on_models};

use crate::{Outcome, check, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        on_both("good::corners_are_joined_when_welded_by_data", ["skinned_without_indices.glb", "Fox.glb"], corners),
        test("good::counts_control", control),
    ];
    tests.extend(on_made("good::counts of ", GOOD.iter().map(|good| good.name), |path| {
        let good = GOOD.iter().find(|good| path.ends_with(good.name)).ok_or("no row")?;
        has_counts(path, good.counts, good.parts)
    }));
    tests.extend(on_models("good::", |path: &Path| {
        [(Weld::Position, usize::MAX), (Weld::Data, 3), (Weld::Keep, 0)].into_iter().try_for_each(
            |(weld, animations)| {
                let asset = Asset::open(path, weld)?;
                check::asset(&asset, animations, false)
            },
        )
    }));
    tests
}

fn has_counts(path: &Path, expected: [usize; 10], parts: [usize; 4]) -> Outcome {
    let asset = Asset::open(path, Weld::Position)?;
    same(&counts(&asset), &expected, "counts")?;
    let found = [
        asset.model().instances().len(),
        asset.skins().iter().map(|skin| skin.joints).sum(),
        asset.meshes().iter().map(|mesh| mesh.morph_targets).sum(),
        asset.animations().len(),
    ];
    same(&found, &parts, "instances, joints, targets, animations")
}

fn counts(asset: &Asset) -> [usize; 10] {
    let mut found = [0; 10];
    for (mesh, info) in asset.meshes().iter().enumerate() {
        assert_eq!(info.geometries[0], mesh);
        let geometry = &asset.model().geometries()[mesh];
        if !geometry.faces().is_empty() {
            let before = asset.weld_counts(mesh).map_or(0, |weld| weld.before);
            found.iter_mut().zip(counts_of(geometry, before)).for_each(|(sum, count)| *sum += count);
        }
    }
    found
}

/// Counted anew from the faces, not by the library's edge records.
fn counts_of(geometry: &Geometry, vertices: usize) -> [usize; 10] {
    let mut edges: HashMap<[u32; 2], [usize; 2]> = HashMap::new();
    let (mut seen, mut used) = (HashSet::new(), HashSet::new());
    let (mut degenerate, mut duplicate) = (0, 0);
    for &[a, b, c] in geometry.faces() {
        if a == b || b == c || c == a {
            degenerate += 1;
            continue;
        }
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        duplicate += usize::from(!seen.insert(sorted));
        for [from, to] in [[a, b], [b, c], [c, a]] {
            used.insert(from);
            edges.entry([from.min(to), from.max(to)]).or_default()[usize::from(from > to)] += 1;
        }
    }
    let number = |test: fn(usize, usize) -> bool| edges.values().filter(|&&[up, down]| test(up, down)).count();
    let boundary = number(|up, down| up + down == 1);
    let non_manifold = number(|up, down| up + down > 2);
    let misoriented = number(|up, down| up + down == 2 && up != down);
    let closed = usize::from(boundary == 0 && non_manifold == 0);
    let triangles = geometry.faces().len();
    [triangles, vertices, used.len(), boundary, non_manifold, misoriented, degenerate, duplicate, closed, 1]
}

fn control() -> Outcome {
    let (made, row) = (files::made(GOOD[0].name)?, &GOOD[0]);
    for column in 0..14 {
        let (mut counts, mut parts) = (row.counts, row.parts);
        *counts.iter_mut().chain(&mut parts).nth(column).ok_or("a column")? += 1;
        ensure(has_counts(&made.path, counts, parts).is_err(), || format!("column {column} went unnoticed"))?;
    }
    Ok(())
}

fn corners(path: &Path) -> Outcome {
    for (weld, is_closed) in [(Weld::Data, true), (Weld::Keep, false)] {
        let asset = Asset::open(path, weld)?;
        let mesh = asset.model().mesh(&asset.pose(Some(0), 0.5)?)?;
        same(&mesh.is_closed(), &is_closed, "closed")?;
    }
    Ok(())
}
