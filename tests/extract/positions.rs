//! A caller's own position buffer: any offset and stride, the caller's own vertex order.

use rimline::Predicate;
use rimline::gpu::{Extractor, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::internals::cpu::{self, Threads};

use rimline_testkit::cases::topologies;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::lights;
use rimline_testkit::on_gpu::{interleaved, read, text};
use rimline_testkit::random::Random;

use crate::stages::check;

pub(crate) const TESTS: &[Test] = &[("positions_lie_at_any_offset_and_stride", any_offset)];

/// Two poses in one buffer, far apart, and one extractor for all: what was bound for one is not read for the other.
fn any_offset() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let lights = lights(&mut Random::new(51), 33);
    let lists = Some(ListOptions { ordered: true, ..Default::default() });
    let options = ExtractorOptions { max_lights: 33, masks: true, lists, ..Default::default() };
    for (name, positions, mesh) in topologies() {
        let turned: Vec<[f32; 3]> = positions.iter().map(|&[x, y, z]| [y - 1.0, 2.0 * z, x]).collect();
        let twin = |positions: &[[f32; 3]]| {
            cpu::extract(positions, &mesh, &lights, Predicate::Exact, Threads::all()).map_err(text)
        };
        let twins = [twin(&positions)?, twin(&turned)?];
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
        for first in [[0, 12], [4, 16], [252, 20], [256, 32], [260, 48], [1000, 12], [65_536 + 12, 20]] {
            let mut words = interleaved(&positions, first[0], first[1]);
            let second = [(4 * words.len() as u64).next_multiple_of(256) + 1024 + 4, 20];
            words.extend_from_slice(&interleaved(&turned, second[0], second[1])[words.len()..]);
            let buffer = gpu.storage(&words);
            for (pose, [offset, stride]) in [(0, first), (1, second), (0, first)] {
                let bound = PositionBuffer { buffer: &buffer, offset, stride };
                gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
                let found = read(gpu, &extractor, &mesh, lights.len())?;
                let what = format!("{name}, pose {pose}, offset {offset}, stride {stride}");
                check(&what, &found, &twins[pose], lights.len(), &options)?;
            }
        }
    }
    Ok(())
}
