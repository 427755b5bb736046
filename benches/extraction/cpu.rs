//! CPU contenders: the twins, and the plainest loop that does the same for one light.

use std::hint::black_box;

use rimline::cpu::{self, Threads};
use rimline::{Light, Mesh, Predicate};

use crate::measure::{Contender, Times, interleave, wall_ms};

/// The twins on one and on all threads beside a plain loop over facing bytes and edge xor on as many.
pub(crate) fn contenders(positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light], rounds: usize) -> Vec<(String, Times)> {
    let mut list: Vec<Contender<'_>> = Vec::new();
    let mut counts = vec![1, Threads::all().count()];
    counts.dedup();
    for threads in counts {
        for (name, predicate) in [("exact", Predicate::Exact), ("fast", Predicate::Fast)] {
            let (mut facing, mut silhouettes) = (Vec::new(), Vec::new());
            let twin = move || {
                let (threads, faces, count) = (Threads::new(threads), mesh.faces(), lights.len());
                wall_ms(|| {
                    cpu::facing_into(&mut facing, positions, faces, lights, predicate, threads);
                    cpu::silhouettes_into(&mut silhouettes, mesh.edges(), &facing, faces.len(), count, threads);
                    black_box((&facing, &silhouettes));
                })
            };
            list.push((format!("twin, {name}, {threads} threads"), Box::new(twin)));
        }
        if let [light] = lights {
            let (edges, light) = (mesh.edges().packed_faces(), light.to_array());
            let (mut facing, mut silhouette) = (vec![0_u8; mesh.faces().len()], vec![0_u8; edges.len()]);
            let plain = move || {
                wall_ms(|| {
                    plain_loop(positions, mesh.faces(), edges, light, threads, &mut facing, &mut silhouette);
                    black_box((&facing, &silhouette));
                })
            };
            list.push((format!("plain loop, {threads} threads"), Box::new(plain)));
        }
    }
    interleave(rounds, list)
}

/// What one writes down first: a byte a face, then a byte an edge.
fn plain_loop(
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    edges: &[[u32; 2]],
    light: [f32; 4],
    threads: usize,
    facing: &mut [u8],
    silhouette: &mut [u8],
) {
    let [lx, ly, lz, w] = light;
    let run = faces.len().div_ceil(threads);
    std::thread::scope(|scope| {
        for (facing, faces) in facing.chunks_mut(run).zip(faces.chunks(run)) {
            scope.spawn(move || {
                for (facing, face) in facing.iter_mut().zip(faces) {
                    let [a, b, c] = face.map(|v| positions[v as usize]);
                    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
                    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
                    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                    let l = [lx - w * a[0], ly - w * a[1], lz - w * a[2]];
                    *facing = u8::from(n[0] * l[0] + n[1] * l[1] + n[2] * l[2] > 0.0);
                }
            });
        }
    });
    let run = edges.len().div_ceil(threads);
    let facing_bytes = &*facing;
    std::thread::scope(|scope| {
        for (silhouette, edges) in silhouette.chunks_mut(run).zip(edges.chunks(run)) {
            scope.spawn(move || {
                for (silhouette, [f0, f1]) in silhouette.iter_mut().zip(edges) {
                    *silhouette = facing_bytes[*f0 as usize] ^ facing_bytes[*f1 as usize];
                }
            });
        }
    });
}
