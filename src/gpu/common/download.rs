//! Copies a part of a buffer to the CPU, as a future.

use std::ops::Range;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::{self, Thread};

use super::cache::lock;
use super::device_error::DeviceError;
use super::memory::any_error;

/// State that the callback of the mapping and the future share.
#[derive(Default)]
struct Answer {
    result: Option<Result<(), wgpu::BufferAsyncError>>,
    waker: Option<Waker>,
}

/// A copy that was submitted. It is a future, ready once the copy can be read.
pub(crate) struct Download {
    /// `None` once the future is ready.
    copied: Option<Copied>,
    answer: Arc<Mutex<Answer>>,
}

/// Bytes in a mapped buffer.
pub(crate) struct Copied {
    staging: wgpu::Buffer,
    bytes: u64,
}

impl Download {
    /// Submits the copy of a range of whole words, which is not empty.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        buffer: &wgpu::Buffer,
        range: Range<u64>,
    ) -> Result<Self, DeviceError> {
        let bytes = range.end - range.start;
        let answer = Arc::new(Mutex::new(Answer::default()));
        let submit = || {
            let staging = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("read_back"),
                size: bytes,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let descriptor = wgpu::CommandEncoderDescriptor { label: Some("read_back") };
            let mut encoder = device.create_command_encoder(&descriptor);
            encoder.copy_buffer_to_buffer(buffer, range.start, &staging, 0, bytes);
            queue.submit([encoder.finish()]);
            let sender = Arc::clone(&answer);
            staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
                let mut answer = lock(&sender);
                answer.result = Some(result);
                let waker = answer.waker.take();
                drop(answer);
                waker.into_iter().for_each(Waker::wake);
            });
            staging
        };
        let staging = any_error(device, submit).map_err(|message| DeviceError::ReadBack { bytes, message })?;
        Ok(Self { copied: Some(Copied { staging, bytes }), answer })
    }
}

impl Future for Download {
    type Output = Result<Copied, DeviceError>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let mut answer = lock(&self.answer);
        let Some(result) = answer.result.take() else {
            answer.waker = Some(context.waker().clone());
            return Poll::Pending;
        };
        drop(answer);
        let Some(copied) = self.copied.take() else { return Poll::Pending };
        let failed = |error: wgpu::BufferAsyncError| {
            let message = format!("{error}; the device may be lost");
            DeviceError::ReadBack { bytes: copied.bytes, message }
        };
        Poll::Ready(result.map_err(failed).map(|()| copied))
    }
}

impl Copied {
    /// Gives the bytes to `take`.
    pub(crate) fn hand_to(self, take: &mut impl FnMut(&[u8])) -> Result<(), DeviceError> {
        let Self { staging, bytes } = self;
        let view = staging.slice(..).get_mapped_range();
        take(&view.map_err(|error| DeviceError::ReadBack { bytes, message: error.to_string() })?);
        Ok(())
    }
}

/// Wakes a waiting thread.
struct Unpark(Thread);

impl Wake for Unpark {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// Waits for the device and the copy.
pub(crate) fn wait(device: &wgpu::Device, mut download: Download) -> Result<Copied, DeviceError> {
    if cfg!(target_family = "wasm") {
        return Err(DeviceError::CannotWait);
    }
    let bytes = download.copied.as_ref().map_or(0, |copied| copied.bytes);
    let waker = Waker::from(Arc::new(Unpark(thread::current())));
    let mut context = Context::from_waker(&waker);
    loop {
        if let Poll::Ready(copied) = Pin::new(&mut download).poll(&mut context) {
            return copied;
        }
        device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| DeviceError::ReadBack { bytes, message: error.to_string() })?;
        if let Poll::Ready(copied) = Pin::new(&mut download).poll(&mut context) {
            return copied;
        }
        // Another thread polled the device and is about to call back.
        thread::park();
    }
}
