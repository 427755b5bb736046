//! A caller's own position buffer: any offset and stride, the caller's own vertex order, and what is refused.

use rimline::gpu::{DeviceError, Extractor, ExtractorError, ExtractorOptions, ListOptions, PositionBuffer};
use rimline_testkit::shapes;

use rimline_testkit::cases::{case, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{extract, interleaved, read, text};
use rimline_testkit::random::Random;
use rimline_testkit::{lights, same};

pub(crate) const TESTS: &[Test] = &[
    ("positions_lie_at_any_offset_and_stride", any_offset),
    ("one_buffer_has_positions_at_several_offsets", several_offsets),
    ("wrong_position_buffers_are_typed_errors", refused),
];

fn options() -> ExtractorOptions {
    ExtractorOptions {
        max_lights: 33,
        masks: true,
        lists: Some(ListOptions { ordered: true, ..Default::default() }),
        ..Default::default()
    }
}

fn any_offset() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let lights = lights(&mut Random::new(51), 33);
    for (name, positions, mesh) in topologies() {
        let expected = extract(gpu, &positions, &mesh, &lights, options())?;
        // One extractor for all, so that bind groups must follow the slice of the buffer.
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options()).map_err(text)?;
        for offset in [0, 4, 252, 256, 260, 1000, 65_536 + 12] {
            for stride in [12, 16, 20, 32, 48] {
                let buffer = gpu.storage(&interleaved(&positions, offset, stride));
                let bound = PositionBuffer { buffer: &buffer, offset, stride };
                gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
                let found = read(gpu, &extractor, &mesh, lights.len())?;
                let what = format!("{name}, offset {offset}, stride {stride}");
                same(&what, &found.facing, &expected.facing)?;
                same(&what, &found.masks, &expected.masks)?;
                same(&what, &found.lists, &expected.lists)?;
                same(&what, &[found.statistics], &[expected.statistics])?;
            }
        }
    }
    Ok(())
}

/// Two poses in one buffer, far apart and with another stride: what was bound for one is not read for the other.
fn several_offsets() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let lights = lights(&mut Random::new(52), 33);
    for (name, positions, mesh) in topologies() {
        let turned: Vec<[f32; 3]> = positions.iter().map(|&[x, y, z]| [y - 1.0, 2.0 * z, x]).collect();
        let mut words = interleaved(&positions, 0, 12);
        let second = (4 * words.len() as u64).next_multiple_of(256) + 1024 + 4;
        let tail = interleaved(&turned, second, 20);
        words.extend_from_slice(&tail[words.len()..]);
        let buffer = gpu.storage(&words);
        let poses = [(&positions, 0, 12), (&turned, second, 20)];
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options()).map_err(text)?;
        for pose in [0, 1, 0] {
            let (positions, offset, stride) = poses[pose];
            let expected = extract(gpu, positions, &mesh, &lights, options())?;
            let bound = PositionBuffer { buffer: &buffer, offset, stride };
            gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
            let found = read(gpu, &extractor, &mesh, lights.len())?;
            same(&format!("{name}, pose {pose}"), &found.facing, &expected.facing)?;
            same(&format!("{name}, pose {pose}"), &found.lists, &expected.lists)?;
        }
    }
    Ok(())
}

fn refused() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (_, positions, mesh) = case("cube", shapes::cube());
    let buffer = gpu.storage(&positions);
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions::default()).map_err(text)?;
    let lights = lights(&mut Random::new(52), 1);
    let alignment = |offset, stride| DeviceError::PositionLayout { offset, stride };
    let too_short =
        |offset, stride, needed| DeviceError::PositionsTooShort { vertices: 8, offset, stride, needed, bytes: 96 };
    let mut cases = vec![
        (0, 12, None),
        (1, 12, Some(alignment(1, 12))),
        (2, 12, Some(alignment(2, 12))),
        (0, 13, Some(alignment(0, 13))),
        (0, 8, Some(alignment(0, 8))),
        (0, 0, Some(alignment(0, 0))),
        (4, 12, Some(too_short(4, 12, 100))),
        (0, 16, Some(too_short(0, 16, 124))),
        (1 << 40, 12, Some(too_short(1 << 40, 12, 96 + (1 << 40)))),
        (0, u64::MAX - 3, Some(too_short(0, u64::MAX - 3, u64::MAX))),
        (u64::MAX - 3, 12, Some(too_short(u64::MAX - 3, 12, u64::MAX))),
    ];
    gpu.submit(|encoder| {
        for (offset, stride, expected) in cases.drain(..) {
            let bound = PositionBuffer { buffer: &buffer, offset, stride };
            let error = extractor.encode(encoder, bound, &lights).err();
            let what = format!("offset {offset}, stride {stride}");
            same(&what, &[error], &[expected.map(ExtractorError::Device)])?;
        }
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vertices"),
            size: 96,
            usage: wgpu::BufferUsages::VERTEX,
            mapped_at_creation: false,
        });
        let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
        let error = extractor.encode(encoder, bound, &lights).err();
        same("no STORAGE", &[error], &[Some(ExtractorError::Device(DeviceError::NotStorage))])
    })
}
