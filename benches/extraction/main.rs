//! `cargo bench`: per-stage times, face masks against the 2003 method, the CPU twins, topology, copy bandwidth; all in
//! one run, contenders interleaved. `--quick` for a small mesh and few rounds.

mod cpu;
mod gpu;
mod measure;

use std::path::PathBuf;

use rimline::mesh::Weld;
use rimline::{Light, Mesh, shapes};

use measure::{interleave, wall_ms};

fn main() {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let rounds = if quick { 3 } else { 11 };
    println!("Rimline {}, {} threads", env!("CARGO_PKG_VERSION"), rimline::cpu::Threads::all().count());
    let gpu = gpu::Gpu::new();
    if let Some(gpu) = &gpu {
        println!("adapter: {}; copies {:.1} GB/s (read + written)", gpu.name, gpu.copy_bandwidth(rounds));
    } else {
        println!("adapter: none; only the CPU is measured");
    }
    for (name, positions, faces) in meshes(quick) {
        measure_mesh(gpu.as_ref(), &name, &positions, &faces, rounds);
    }
}

/// A generated closed mesh, and a model file where there is one.
fn meshes(quick: bool) -> Vec<(String, Vec<[f32; 3]>, Vec<[u32; 3]>)> {
    let torus = if quick { shapes::torus(128, 64, 1.0, 0.4) } else { shapes::torus(1024, 512, 1.0, 0.4) };
    let mut meshes = vec![("torus".to_owned(), torus.positions, torus.faces)];
    let assets = std::env::var_os("RIMLINE_ASSETS")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/assets"), PathBuf::from);
    let file = assets.join("spot_catmull_big.glb");
    if file.is_file() && !quick {
        match rimline::gltf::Asset::open(&file, Weld::Data) {
            Ok(asset) => {
                let geometry = &asset.model().geometries[0];
                meshes.push(("spot_catmull_big".to_owned(), geometry.positions.clone(), geometry.faces.clone()));
            }
            Err(error) => println!("{}: {error}", file.display()),
        }
    }
    meshes
}

fn measure_mesh(gpu: Option<&gpu::Gpu>, name: &str, positions: &[[f32; 3]], faces: &[[u32; 3]], rounds: usize) {
    let mesh = Mesh::new(positions, faces, Weld::Position).expect("a mesh");
    let edges = mesh.edges().len();
    println!("\n{name}: {} faces, {edges} edge records", mesh.faces().len());
    let topology = || wall_ms(|| drop(Mesh::from_faces(positions.len(), faces.to_vec())));
    let topology = interleave(rounds, vec![("topology".to_owned(), Box::new(topology))]);
    let bytes = mesh.topology_bytes() as f64 / faces.len() as f64;
    println!("topology build {:.1} ms, {bytes:.1} bytes a face", topology[0].1.median());
    for count in [1, 8, 32] {
        let lights: Vec<Light> = (0..count)
            .map(|l| {
                let angle = l as f32 * 0.61;
                let towards = [3.0 * angle.cos(), 2.0 + 0.1 * l as f32, 3.0 * angle.sin()];
                if l % 2 == 0 { Light::point(towards) } else { Light::directional(towards) }
            })
            .collect();
        if let Some(gpu) = gpu {
            print_gpu(&gpu.methods(positions, &mesh, &lights, rounds), count, edges);
        }
        println!("  {count} lights, CPU");
        let rows = cpu::contenders(positions, &mesh, &lights, rounds);
        for (name, times) in &rows {
            let threads = name.rsplit(", ").next().unwrap_or_default();
            let plain = rows.iter().find(|(name, _)| name.starts_with("plain") && name.ends_with(threads));
            let ratio =
                plain.map_or(String::new(), |(_, plain)| format!("   {:.2} of the plain loop", times.ratio_to(plain)));
            println!("    {name:<26} {:>8.2} ms{ratio}", times.median());
        }
    }
}

/// A table whose ratios are to the per-edge method with a list, round by round.
fn print_gpu(rows: &[gpu::Row], lights: usize, edges: usize) {
    println!(
        "  {lights} lights, GPU               median ms  (low … high)   vs per-edge   vs fast   Medges/s   bytes/edge   stages, ms"
    );
    for row in rows {
        let (low, high) = row.wall.spread();
        let speed = rows[0].wall.ratio_to(&row.wall);
        let stages: Vec<_> = row.stages.iter().map(|(name, ms)| format!("{name} {ms:.2}")).collect();
        println!(
            "    {:<26} {:>8.2}  ({low:>7.2} … {high:>7.2})   {speed:>8.2}×   {:>6.2}×   {:>8.1}   {:>10.1}   {}",
            row.name,
            row.wall.median(),
            row.wall.ratio_to(&rows[1].wall),
            edges as f64 / row.wall.median() / 1e3,
            row.bytes_per_edge,
            stages.join(", ")
        );
    }
}
