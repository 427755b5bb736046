//! The CPU's contestants.

use std::hint::black_box;

use rimline::internals::cpu::{self, Threads};
use rimline::{Light, Mesh};

use super::method::{OnCpu, Share};
use super::subject::Case;
use crate::engine::{Contender, Metric, Sample, clock};

/// Runs a contestant again and again; memory is kept from run to run.
pub(super) fn contender<'a>(case: &'a Case<'_>, on_cpu: OnCpu, share: Share) -> Contender<'a> {
    let Case { positions, mesh, lights } = case;
    let threads = threads(share);
    let (mut facing, mut silhouettes) = (Vec::new(), Vec::new());
    if on_cpu == OnCpu::Plain {
        let (mut facing, mut silhouettes) = (vec![0; mesh.faces().len()], vec![0; mesh.edges().len()]);
        return Box::new(move || {
            let ms = clock(|| plain_loop(positions, mesh, lights[0], threads.count(), &mut facing, &mut silhouettes));
            black_box((&facing, &silhouettes));
            Ok(sample(ms))
        });
    }
    Box::new(move || {
        let facing_ms = clock(|| {
            fill_facing(&mut facing, case, on_cpu, threads);
        });
        let edges_ms = clock(|| {
            cpu::silhouettes_into(&mut silhouettes, mesh.edges(), &facing, mesh.faces().len(), lights.len(), threads);
        });
        black_box((&facing, &silhouettes));
        let mut sample = sample(facing_ms + edges_ms);
        sample.extend([(Metric::Stage("facing"), facing_ms), (Metric::Stage("edges"), edges_ms)]);
        Ok(sample)
    })
}

fn sample(ms: f64) -> Sample {
    vec![(Metric::Time("time"), ms), (Metric::Time("wall"), ms)]
}

/// Bits of a contestant. For the plain loop these are the CPU reference's bits, because both use the same arithmetic.
pub(super) fn extraction(case: &Case<'_>, on_cpu: OnCpu) -> cpu::Extraction {
    let mut found = cpu::Extraction::default();
    found.statistics = fill_facing(&mut found.facing, case, on_cpu, Threads::all());
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

fn threads(share: Share) -> Threads {
    match share {
        Share::OneThread => Threads::ONE,
        Share::AllThreads => Threads::all(),
    }
}

fn fill_facing(facing: &mut Vec<u32>, case: &Case<'_>, on_cpu: OnCpu, threads: Threads) -> cpu::FacingStatistics {
    let Case { positions, mesh, lights } = case;
    match on_cpu {
        OnCpu::Reference(predicate) => cpu::facing_into(facing, positions, mesh.faces(), lights, predicate, threads),
        OnCpu::Plain => cpu::facing_into(facing, positions, mesh.faces(), lights, rimline::Predicate::Fast, threads),
        OnCpu::Double => {
            fill_planes(facing, case, threads, double_mask);
            cpu::FacingStatistics::default()
        }
    }
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
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let n = normal(a, b, c, |p, q| p - q, |p, q, r, s| p * q - r * s);
    lights.iter().enumerate().fold(0, |mask, (bit, light)| {
        let [x, y, z, w] = light.to_array().map(f64::from);
        let d = n[0] * (x - w * a[0]) + n[1] * (y - w * a[1]) + n[2] * (z - w * a[2]);
        mask | u32::from(d > 0.0) << bit
    })
}

/// `(b − a) × (c − a)` in some arithmetic.
fn normal<T: Copy>(a: [T; 3], b: [T; 3], c: [T; 3], minus: fn(T, T) -> T, cross: fn(T, T, T, T) -> T) -> [T; 3] {
    let difference = |p: [T; 3], q: [T; 3]| [minus(p[0], q[0]), minus(p[1], q[1]), minus(p[2], q[2])];
    let (u, v) = (difference(b, a), difference(c, a));
    [cross(u[1], v[2], u[2], v[1]), cross(u[2], v[0], u[0], v[2]), cross(u[0], v[1], u[1], v[0])]
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
            let [a, b, c] = face.map(|v| positions[v as usize]);
            let n = normal(a, b, c, |p, q| p - q, |p, q, r, s| p * q - r * s);
            let d = n[0] * (x - w * a[0]) + n[1] * (y - w * a[1]) + n[2] * (z - w * a[2]);
            *facing = u8::from(d > 0.0);
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
fn share<T: Send, S: Sync>(threads: usize, results: &mut [T], items: &[S], work: impl Fn(&mut [T], &[S]) + Sync) {
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
