//! Reading back and timing without waiting, and timers whose figures mean nothing.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll, Wake, Waker};

use rimline::gpu::{
    DeviceError, Extractor, ExtractorOptions, StageTimer, StageTimes, read_back, read_back_async, read_back_vec,
    read_back_vec_async,
};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::{CLEARED, depth_pass};
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same};

use crate::watched::{LIGHT, Watched, caster, depth_stencil, packed};

pub(crate) const TESTS: &[Test] = &[
    ("reading_without_waiting_gives_what_waiting_gives", like_waiting),
    ("a_future_reads_what_the_buffer_held_when_it_was_made", when_made),
    ("a_buffer_is_read_up_to_its_last_word", words),
    ("a_reading_future_wakes_its_task", wakes),
    ("errors_come_without_waiting_too", errors),
    ("stages_are_timed_without_waiting", timed),
    ("a_timer_whose_clock_stands_still_says_so", still),
    ("times_that_are_taken_late_are_none", late),
];

/// Counts how often a task was woken.
#[derive(Default)]
struct Woken(AtomicUsize);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.0.fetch_add(1, Ordering::SeqCst);
    }
}

/// May be sent to another thread, and outlives what it was made of.
fn sendable<T: Send + 'static>(future: T) -> T {
    future
}

fn like_waiting() -> Result<(), String> {
    let watched = Watched::plain()?;
    let mut random = Random::new(95);
    // Below a piece of 16 MiB, and past two; items of 12 bytes lie across the pieces' ends.
    for words in [3, 1000, (33 << 20) / 4] {
        let contents: Vec<u32> = (0..words).map(|_| random.next_u64() as u32).collect();
        let buffer = watched.gpu.storage(&contents);
        let gpu = &watched.gpu;
        let waited: Vec<[u32; 3]> = read_back_vec(&gpu.device, &gpu.queue, &buffer).map_err(text)?;
        let future = sendable(read_back_vec_async::<[u32; 3]>(&gpu.device, &gpu.queue, &buffer));
        let mut found = gpu.finish(future)?.map_err(text)?;
        let expected: Vec<[u32; 3]> = contents.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        same(&format!("{words} words"), &found[..expected.len()], &expected)?;
        same(&format!("{words} words, waiting"), &waited, &found)?;
        let [mut all, mut pieces] = [Vec::new(), Vec::new()];
        read_back(&gpu.device, &gpu.queue, &buffer, |bytes| all.extend_from_slice(bytes)).map_err(text)?;
        let future = read_back_async(&gpu.device, &gpu.queue, &buffer, |bytes| pieces.extend_from_slice(bytes));
        gpu.finish(future)?.map_err(text)?;
        same(&format!("{words} words, bytes"), &pieces, &all)?;
        found[0][1] ^= 1;
        must_fail("a bit", &same("wrong", &found, &waited))?;
    }
    watched.quiet("reading")
}

fn when_made() -> Result<(), String> {
    let watched = Watched::plain()?;
    let words = (20 << 20) / 4;
    let buffer = watched.gpu.storage(&vec![1_u32; words]);
    let future = read_back_vec_async::<u32>(&watched.gpu.device, &watched.gpu.queue, &buffer);
    // Written again before the future is polled at all, in both pieces.
    watched.gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&vec![2_u32; words]));
    let found = watched.gpu.finish(future)?.map_err(text)?;
    same("as it was", &[found.iter().all(|word| *word == 1), found.len() == words], &[true, true])?;
    let now: Vec<u32> = watched.gpu.read(&buffer, words)?;
    same("as it is", &[now.iter().all(|word| *word == 2)], &[true])?;
    // A future that nobody wants any more.
    drop(read_back_vec_async::<u32>(&watched.gpu.device, &watched.gpu.queue, &buffer));
    watched.quiet("reading")
}

fn words() -> Result<(), String> {
    let watched = Watched::plain()?;
    let Gpu { device, queue, .. } = &watched.gpu;
    for (size, bytes) in [(2, 0), (6, 4), (11, 8), (12, 12)] {
        let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let buffer =
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
        let contents: Vec<u8> = (1..=bytes).collect();
        queue.write_buffer(&buffer, 0, &contents);
        let mut all = Vec::new();
        read_back(device, queue, &buffer, |piece| all.extend_from_slice(piece)).map_err(text)?;
        let waited = read_back_vec::<[u8; 3]>(device, queue, &buffer).map_err(text)?;
        let found = watched.gpu.finish(read_back_vec_async::<[u8; 3]>(device, queue, &buffer))?.map_err(text)?;
        same(&format!("{size} bytes"), &all, &contents)?;
        same(&format!("{size} bytes, items"), waited.as_flattened(), &contents[..contents.len() / 3 * 3])?;
        same(&format!("{size} bytes, not waiting"), &found, &waited)?;
    }
    watched.quiet("reading")
}

fn wakes() -> Result<(), String> {
    let watched = Watched::plain()?;
    let buffer = watched.gpu.storage(&[7_u32; 4]);
    let woken = Arc::new(Woken::default());
    let waker = Waker::from(Arc::clone(&woken));
    let mut context = Context::from_waker(&waker);
    let mut future = pin!(read_back_vec_async::<u32>(&watched.gpu.device, &watched.gpu.queue, &buffer));
    // Nothing polled the device, so nothing can have called back.
    same("pending", &[future.as_mut().poll(&mut context).is_pending()], &[true])?;
    same("woken", &[woken.0.load(Ordering::SeqCst)], &[0])?;
    watched.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(text)?;
    same("woken", &[woken.0.load(Ordering::SeqCst)], &[1])?;
    let Poll::Ready(found) = future.as_mut().poll(&mut context) else { return Err("still pending".to_owned()) };
    same("contents", &found.map_err(text)?, &[7; 4])
}

fn errors() -> Result<(), String> {
    let watched = Watched::plain()?;
    let Gpu { device, queue, .. } = &watched.gpu;
    let descriptor = wgpu::BufferDescriptor {
        label: Some("not for copies"),
        size: 16,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    };
    let [destroyed, left] = [(); 2].map(|()| watched.gpu.storage(&[1_u32; 4]));
    destroyed.destroy();
    let read = |buffer: &wgpu::Buffer| watched.gpu.finish(read_back_vec_async::<u32>(device, queue, buffer));
    same("no copy source", &[read(&device.create_buffer(&descriptor))?], &[Err(DeviceError::NotCopySource)])?;
    let mut all = vec![read_back_vec::<u32>(device, queue, &destroyed), read(&destroyed)?];
    device.destroy();
    all.push(read(&left)?);
    match all.iter().find(|found| !matches!(found, Err(DeviceError::ReadBack { bytes: 16, .. }))) {
        Some(found) => Err(format!("destroyed or lost: {found:?}")),
        None => watched.quiet("destroyed and lost"),
    }
}

/// An extraction that is timed, on a device with timestamps.
struct Timed {
    watched: Watched,
    positions: wgpu::Buffer,
    extractor: Extractor,
    timer: StageTimer,
}

impl Timed {
    fn new() -> Result<Self, String> {
        let watched = Watched::new(wgpu::Features::TIMESTAMP_QUERY, wgpu::Limits::default())?;
        let gpu = &watched.gpu;
        let (shape, mesh) = caster()?;
        let positions = gpu.storage(&shape.positions);
        let extractor = Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions::default()).map_err(text)?;
        let timer = StageTimer::new(&gpu.device, &gpu.queue).ok_or("no timer")?;
        Ok(Self { watched, positions, extractor, timer })
    }

    fn encode(&mut self) -> Result<(), String> {
        let Self { watched, positions, extractor, timer } = self;
        timer.clear();
        watched.gpu.submit(|encoder| {
            extractor.encode_timed(encoder, packed(positions), &[LIGHT], Some(timer)).map(drop).map_err(text)?;
            timer.resolve(encoder);
            Ok(())
        })
    }
}

fn timed() -> Result<(), String> {
    let mut timed = Timed::new()?;
    timed.encode()?;
    let Timed { watched, timer, .. } = &timed;
    let gpu = &watched.gpu;
    let future = sendable(timer.read_async(&gpu.device, &gpu.queue));
    let waited = timer.read(&gpu.device, &gpu.queue).map_err(text)?;
    // The timer is free again at once.
    timed.encode()?;
    let Timed { watched, timer, .. } = &timed;
    let gpu = &watched.gpu;
    let found = gpu.finish(future)?.map_err(text)?;
    same("times", std::slice::from_ref(&found), &[waited])?;
    let names: Vec<_> = found.stages.iter().map(|(name, _)| *name).collect();
    same("names", &names, &["facing", "exact_facing", "edges", "arguments"])?;
    let sum: f64 = found.stages.iter().map(|(_, ms)| ms).sum();
    // Stages do not overlap here: each waits for the one before.
    same("no more than the span", &[sum > 0.0 && sum <= found.span_ms * 1.000_001], &[true])?;
    let is_cpu = gpu.device.adapter_info().device_type == wgpu::DeviceType::Cpu;
    same("software", &[timer.is_software()], &[is_cpu])?;
    watched.quiet("timing")
}

fn still() -> Result<(), String> {
    let watched = Watched::new(wgpu::Features::TIMESTAMP_QUERY, wgpu::Limits::default())?;
    let gpu = &watched.gpu;
    let mut timer = StageTimer::new(&gpu.device, &gpu.queue).ok_or("no timer")?;
    // Timestamps that no pass takes stay 0.
    let _ = timer.compute_pass("nothing");
    let _ = timer.compute_pass("nothing else");
    gpu.submit(|encoder| {
        timer.resolve(encoder);
        Ok(())
    })?;
    same("waiting", &[timer.read(&gpu.device, &gpu.queue)], &[Err(DeviceError::ClockStill { passes: 2 })])?;
    let found = watched.gpu.finish(timer.read_async(&gpu.device, &gpu.queue))?;
    same("without", &[found.map(|times| times.span_ms)], &[Err(DeviceError::ClockStill { passes: 2 })])?;
    timer.clear();
    let nothing = StageTimes { stages: Vec::new(), span_ms: 0.0 };
    same("nothing timed", &[timer.read(&gpu.device, &gpu.queue)], &[Ok(nothing)])?;
    watched.quiet("standing still")
}

/// On llvmpipe the timestamps of compute passes mean nothing once the device has drawn: then there are no times.
fn late() -> Result<(), String> {
    let mut timed = Timed::new()?;
    let encoded = |timed: &mut Timed| {
        timed.encode()?;
        let Timed { watched, timer, .. } = timed;
        let Gpu { device, queue, .. } = &watched.gpu;
        let waited = timer.read(device, queue).map(drop);
        let found = watched.gpu.finish(timer.read_async(device, queue))?.map(drop);
        Ok::<_, String>([waited, found])
    };
    same("before", &encoded(&mut timed)?, &[Ok(()), Ok(())])?;
    same("stages", &timed.timer.stages(), &["facing", "exact_facing", "edges", "arguments"])?;
    // A pass that clears, by itself and timed.
    let view = depth_stencil(&timed.watched);
    let cleared = |watched: &Watched, timer: Option<&mut StageTimer>| {
        watched.gpu.submit(|encoder| {
            let timestamp_writes = timer.and_then(|timer| timer.render_pass("clear"));
            let pass = wgpu::RenderPassDescriptor { timestamp_writes, ..depth_pass(&view, CLEARED) };
            drop(encoder.begin_render_pass(&pass));
            Ok(())
        })
    };
    cleared(&timed.watched, None)?;
    let after = encoded(&mut timed)?;
    let name = &timed.watched.gpu.name;
    let is_llvmpipe = name.contains("llvmpipe") && name.contains("Vulkan");
    println!("{name}: {after:?}");
    let is_late =
        |found: &Result<(), DeviceError>| matches!(found, Err(DeviceError::ClockLate { ms, .. }) if *ms < 0.1);
    if !after.iter().all(if is_llvmpipe { is_late } else { |found: &Result<(), DeviceError>| found.is_ok() }) {
        return Err(format!("after a draw: {after:?}"));
    }
    // Render passes have times.
    let Timed { watched, timer, .. } = &mut timed;
    timer.clear();
    cleared(watched, Some(timer))?;
    watched.gpu.submit(|encoder| {
        timer.resolve(encoder);
        Ok(())
    })?;
    let found = timer.read(&watched.gpu.device, &watched.gpu.queue).map_err(text)?;
    same("a render pass", &[found.stages.len()], &[1])?;
    watched.quiet("timing after a draw")
}
