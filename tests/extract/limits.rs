//! Devices with less: results equal those of the shared device. Input that does not fit is in `refusals.rs`.

use std::collections::BTreeSet;

use rimline::gpu::{EdgeTopology, Extractor, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::internals::Method;

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{compare, interleaved, limited, read, repeated_torus, text};
use rimline_testkit::random::Random;
use rimline_testkit::{lights, same};

pub(crate) const TESTS: &[Test] = &[("small_limits_change_nothing", unchanged)];

/// Bytes a binding and a buffer, workgroups, rings, segments, repeated faces, offset and stride: positions and facing
/// masks span one to four bindings.
type Limited = (u64, u64, u32, [u32; 2], usize, [u64; 2]);

const CASES: [Limited; 6] = [
    (16 << 10, 1 << 20, 64, [20, 16], 0, [0, 12]),
    (16 << 10, 1 << 20, 2, [60, 40], 0, [4, 12]),
    (16 << 10, 1 << 20, 7, [70, 50], 3000, [260, 12]),
    (16 << 10, 1 << 20, 64, [100, 54], 4000, [0, 12]),
    (64 << 10, 256 << 10, 3, [80, 60], 0, [1000, 20]),
    (64 << 10, 512 << 10, 64, [96, 64], 0, [8, 20]),
];

fn unchanged() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(71);
    let mut spans = [BTreeSet::new(), BTreeSet::new()];
    for (binding, buffer, workgroups, [rings, segments], repeated, [offset, stride]) in CASES {
        let small = limited(binding, buffer, workgroups)?;
        let shape = repeated_torus(rings, segments, repeated);
        let mesh = shape.mesh().map_err(text)?;
        spans[0].insert((offset % 256 + shape.positions.len() as u64 * stride).div_ceil(binding));
        spans[1].insert((mesh.faces().len() as u64 * 4).div_ceil(binding));
        // Once so small that underflow could be anything, so that every face is undecided.
        for (count, capacity, scale) in [(1, 2000, 1.0), (33, 100, 1.0), (3, 1000, 1e-30)] {
            let lights = lights(&mut random, count);
            let positions: Vec<_> = shape.positions.iter().map(|position| position.map(|c| c * scale)).collect();
            let words = interleaved(&positions, offset, stride);
            for (method, ordered) in [(Method::FaceMask, false), (Method::FaceMask, true), (Method::PerEdge, true)] {
                // Per-edge lists have room for all edges; where a binding does not, only the masks are compared.
                let list_bytes = 4 * mesh.edges().len() as u64 * count.min(32) as u64;
                let fits = method == Method::FaceMask || list_bytes <= binding;
                let lists = ListOptions { capacity: Some(capacity), ordered, topology: EdgeTopology::TriangleList };
                let options = ExtractorOptions {
                    max_lights: count,
                    method,
                    masks: true,
                    lists: fits.then_some(lists),
                    for_volumes: true,
                    ..Default::default()
                };
                let run = |gpu: &Gpu| {
                    let buffer = gpu.storage(&words);
                    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
                    let bound = PositionBuffer { buffer: &buffer, offset, stride };
                    gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
                    read(gpu, &extractor, &mesh, count)
                };
                let what = format!("{binding} bytes, {workgroups} workgroups, {rings}·{segments}, {count}, {method:?}");
                compare(&what, &run(&small)?, &run(gpu)?, capacity, ordered)?;
            }
        }
    }
    let all = BTreeSet::from([1, 2, 3, 4]);
    same("bindings spanned by positions and facing masks", &spans, &[all.clone(), all])
}
