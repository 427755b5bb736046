//! Devices with less: results equal those of the shared device. Input that does not fit is in `refusals.rs`.

use rimline::gpu::{EdgeTopology, Extractor, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::internals::Method;
use rimline::{Light, Mesh};
use rimline_testkit::shapes::Shape;

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::lights;
use rimline_testkit::on_gpu::{Found, compare, interleaved, limited, read, repeated_torus, text};
use rimline_testkit::random::Random;

pub(crate) const TESTS: &[Test] = &[("small_limits_change_nothing", unchanged)];

/// How a case is run, on both devices alike.
struct Run<'a> {
    shape: &'a Shape,
    lights: &'a [Light],
    offset: u64,
    stride: u64,
    options: ExtractorOptions,
}

impl Run<'_> {
    fn on(&self, gpu: &Gpu, mesh: &Mesh) -> Result<Found, String> {
        let buffer = gpu.storage(&interleaved(&self.shape.positions, self.offset, self.stride));
        let mut extractor = Extractor::new(&gpu.pipelines, mesh, self.options).map_err(text)?;
        let bound = PositionBuffer { buffer: &buffer, offset: self.offset, stride: self.stride };
        gpu.submit(|encoder| extractor.encode(encoder, bound, self.lights).map_err(text))?;
        read(gpu, &extractor, mesh, self.options.max_lights)
    }
}

fn scaled(shape: &Shape, scale: f32) -> Shape {
    let positions = shape.positions.iter().map(|position| position.map(|c| c * scale)).collect();
    Shape { positions, ..shape.clone() }
}

/// Bytes a binding and a buffer, workgroups, rings, segments, repeated faces, offset and stride: by the arithmetic in
/// `windows`, positions and facing masks span one to four bindings.
type Limited = (u64, u64, u32, [u32; 2], usize, [u64; 2]);

const CASES: [Limited; 6] = [
    (16 << 10, 1 << 20, 64, [20, 16], 0, [0, 12]),
    (16 << 10, 1 << 20, 2, [60, 40], 0, [4, 12]),
    (16 << 10, 1 << 20, 7, [70, 50], 3000, [260, 12]),
    (16 << 10, 1 << 20, 64, [100, 54], 4000, [0, 12]),
    (64 << 10, 256 << 10, 3, [80, 60], 0, [1000, 20]),
    (64 << 10, 512 << 10, 64, [96, 64], 0, [8, 20]),
];

fn windows(bytes: u64, binding: u64) -> u64 {
    bytes.div_ceil(binding)
}

fn unchanged() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(71);
    let mut spans = [std::collections::BTreeSet::new(), std::collections::BTreeSet::new()];
    for (binding, buffer, workgroups, [rings, segments], repeated, [offset, stride]) in CASES {
        let small = limited(binding, buffer, workgroups)?;
        let shape = repeated_torus(rings, segments, repeated);
        let mesh = shape.mesh().map_err(text)?;
        spans[0].insert(windows(offset % 256 + shape.positions.len() as u64 * stride, binding));
        spans[1].insert(windows(mesh.faces().len() as u64 * 4, binding));
        for (count, capacity) in [(1, 2000), (33, 100), (3, 1000)] {
            let lights = lights(&mut random, count);
            // Once so small that underflow could be anything, so that every face is undecided.
            let scale = if count == 3 { 1e-30 } else { 1.0 };
            let shape = scaled(&shape, scale);
            for (method, ordered) in [(Method::FaceMask, false), (Method::FaceMask, true), (Method::PerEdge, true)] {
                // Per-edge lists have room for all edges; where a binding does not, only the masks are compared.
                let list_bytes = 4 * mesh.edges().len() as u64 * count.min(32) as u64;
                let fits = method == Method::FaceMask || list_bytes <= binding;
                let lists = ListOptions { capacity: Some(capacity), ordered, topology: EdgeTopology::TriangleList };
                let run = Run {
                    shape: &shape,
                    lights: &lights,
                    offset,
                    stride,
                    options: ExtractorOptions {
                        max_lights: count,
                        method,
                        masks: true,
                        lists: fits.then_some(lists),
                        for_volumes: true,
                        ..Default::default()
                    },
                };
                let found = run.on(&small, &mesh)?;
                let expected = run.on(gpu, &mesh)?;
                let what = format!("{binding} bytes, {workgroups} workgroups, {rings}·{segments}, {count}, {method:?}");
                compare(&what, &found, &expected, capacity, ordered)?;
            }
        }
    }
    let all = [1, 2, 3, 4].into();
    if spans == [all, [1, 2, 3, 4].into()] {
        Ok(())
    } else {
        Err(format!("bindings spanned by positions and facing masks: {spans:?}, meant to be 1 to 4 each"))
    }
}
