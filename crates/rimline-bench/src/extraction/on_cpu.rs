//! The CPU's contestants.

use std::hint::black_box;

use glam::{DVec3, Vec3};
use rimline::internals::cpu::{self, Threads};
use rimline::{Light, Mesh, Predicate};

use super::subject::Case;
use crate::engine::{Contender, Metric, clock, times};

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Algorithm {
    /// The library's CPU references.
    Reference(Predicate),
    /// A plain loop over facing in `f64`, and the CPU reference of the edge stage.
    Double,
    /// The naive loop for one light and a closed mesh: a byte a face in `f32`, then a byte an edge.
    Plain,
}

/// Runs a contestant again and again, on all threads if it is shared; memory is kept from run to run.
pub(super) fn contender<'a>(case: &'a Case<'_>, algorithm: Algorithm, is_shared: bool) -> Contender<'a> {
    let Case { positions, mesh, lights } = case;
    let threads = if is_shared { Threads::all() } else { Threads::ONE };
    if algorithm == Algorithm::Plain {
        let (mut facing, mut silhouettes) = (vec![0; mesh.faces().len()], vec![0; mesh.edges().len()]);
        return Box::new(move || {
            let ms = clock(|| plain_loop(positions, mesh, lights[0], threads.count(), &mut facing, &mut silhouettes));
            black_box((&facing, &silhouettes));
            Ok(times([("time", ms), ("wall", ms)]))
        });
    }
    let (mut facing, mut silhouettes) = (Vec::new(), Vec::new());
    Box::new(move || {
        let facing_ms = clock(|| {
            fill_facing(&mut facing, case, algorithm, threads);
        });
        let edges_ms = clock(|| {
            cpu::silhouettes_into(&mut silhouettes, mesh.edges(), &facing, mesh.faces().len(), lights.len(), threads);
        });
        black_box((&facing, &silhouettes));
        let mut sample = times([("time", facing_ms + edges_ms), ("wall", facing_ms + edges_ms)]);
        sample.extend([(Metric::Stage("facing"), facing_ms), (Metric::Stage("edges"), edges_ms)]);
        Ok(sample)
    })
}

/// Bits of a contestant. For the plain loop these are the CPU reference's bits, because both use the same arithmetic.
pub(super) fn extraction(case: &Case<'_>, algorithm: Algorithm) -> cpu::Extraction {
    let mut found = cpu::Extraction::default();
    found.statistics = fill_facing(&mut found.facing, case, algorithm, Threads::all());
    add_masks(case, found)
}

fn add_masks(case: &Case<'_>, mut found: cpu::Extraction) -> cpu::Extraction {
    let Case { mesh, lights, .. } = case;
    found.masks = cpu::edges(mesh.edges(), &found.facing, mesh.faces().len(), lights.len(), Threads::all());
    found
}

/// The reference: the sign of each pair, computed in integers without a filter.
pub(super) fn reference(case: &Case<'_>) -> cpu::Extraction {
    let mut found = cpu::Extraction::default();
    let sign = |[a, b, c]: [[f32; 3]; 3], light: Light| cpu::exact_facing(a, b, c, light.to_array()) > 0;
    fill_planes(&mut found.facing, case, Threads::all(), |corners, lights| {
        if !corners.as_flattened().iter().all(|c| c.is_finite()) {
            return 0;
        }
        lights.iter().enumerate().fold(0, |mask, (bit, &light)| mask | u32::from(sign(corners, light)) << bit)
    });
    add_masks(case, found)
}

fn fill_facing(facing: &mut Vec<u32>, case: &Case<'_>, by: Algorithm, threads: Threads) -> cpu::FacingStatistics {
    let Case { positions, mesh, lights } = case;
    let predicate = match by {
        Algorithm::Reference(predicate) => predicate,
        Algorithm::Plain => Predicate::Fast,
        Algorithm::Double => {
            fill_planes(facing, case, threads, double_mask);
            return cpu::FacingStatistics::default();
        }
    };
    cpu::facing_into(facing, positions, mesh.faces(), lights, predicate, threads)
}

/// Facing masks from `mask(corners, up to 32 lights)`; faces that name a vertex twice face nothing.
fn fill_planes(
    facing: &mut Vec<u32>,
    case: &Case<'_>,
    threads: Threads,
    mask: impl Fn([[f32; 3]; 3], &[Light]) -> u32 + Sync,
) {
    let Case { positions, mesh, lights } = case;
    let faces = mesh.faces();
    facing.resize(faces.len() * lights.len().div_ceil(32), 0);
    for (lights, plane) in lights.chunks(32).zip(facing.chunks_mut(faces.len())) {
        share(threads.count(), plane, faces, |masks, faces| {
            for (found, &[a, b, c]) in masks.iter_mut().zip(faces) {
                let corners = [a, b, c].map(|v| positions[v as usize]);
                *found = if a == b || b == c || c == a { 0 } else { mask(corners, lights) };
            }
        });
    }
}

/// `n · (l − w·a)` in `f64`, as good as one writes it without thinking of more.
fn double_mask(corners: [[f32; 3]; 3], lights: &[Light]) -> u32 {
    let [a, b, c] = corners.map(|corner| DVec3::from_array(corner.map(f64::from)));
    let n = (b - a).cross(c - a);
    lights.iter().enumerate().fold(0, |mask, (bit, light)| {
        let [x, y, z, w] = light.to_array().map(f64::from);
        mask | u32::from(n.dot(DVec3::new(x, y, z) - w * a) > 0.0) << bit
    })
}

/// A byte a face, then a byte an edge; of a closed mesh.
fn plain_loop(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    light: Light,
    threads: usize,
    facing: &mut [u8],
    silhouettes: &mut [u8],
) {
    let [x, y, z, w] = light.to_array();
    share(threads, facing, mesh.faces(), |facing, faces| {
        for (facing, face) in facing.iter_mut().zip(faces) {
            let [a, b, c] = face.map(|v| Vec3::from(positions[v as usize]));
            *facing = u8::from((b - a).cross(c - a).dot(Vec3::new(x, y, z) - w * a) > 0.0);
        }
    });
    let facing = &*facing;
    share(threads, silhouettes, mesh.edges().packed_faces(), |silhouettes, edges| {
        for (silhouette, [f0, f1]) in silhouettes.iter_mut().zip(edges) {
            *silhouette = facing[*f0 as usize] ^ facing[*f1 as usize];
        }
    });
}

/// Cuts both slices into a run a thread, none shorter than the library's own, and works on them at the same time; the
/// calling thread takes the first.
pub(crate) fn share<T: Send, S: Sync>(
    threads: usize,
    results: &mut [T],
    items: &[S],
    work: impl Fn(&mut [T], &[S]) + Sync,
) {
    let run = items.len().div_ceil(threads).max(4096);
    let mut runs = results.chunks_mut(run).zip(items.chunks(run));
    let Some((first_results, first_items)) = runs.next() else { return };
    std::thread::scope(|scope| {
        let work = &work;
        for (results, items) in runs {
            scope.spawn(move || work(results, items));
        }
        work(first_results, first_items);
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    /// The report has the reference's bits for the plain loop.
    #[test]
    fn the_plain_loop_finds_what_its_reference_does() {
        let shape = shapes::blob(30, 0.4, 3);
        let mesh = shape.mesh().expect("a blob is a mesh");
        for light in [Light::point([0.3, 2.0, 1.0]), Light::directional([1.0, -0.5, 0.2])] {
            let lights = [light];
            let case = Case { positions: &shape.positions, mesh: &mesh, lights: &lights };
            let expected = extraction(&case, Algorithm::Plain);
            let expected_silhouettes: Vec<u32> = expected.masks.iter().map(|masks| masks.silhouette).collect();
            for threads in [1, 3] {
                let (mut facing, mut silhouettes) = (vec![2; mesh.faces().len()], vec![2; mesh.edges().len()]);
                plain_loop(&shape.positions, &mesh, light, threads, &mut facing, &mut silhouettes);
                let words = |bytes: &[u8]| bytes.iter().copied().map(u32::from).collect::<Vec<_>>();
                assert_eq!(words(&facing), expected.facing);
                assert_eq!(words(&silhouettes), expected_silhouettes);
                assert!(facing.contains(&0) && facing.contains(&1) && silhouettes.contains(&1));
            }
        }
    }
}
