//! Pictures, and the viewer without a page that draws the same.

use rimline_testkit::device::Gpu as Device;
use rimline_view::{Gpu, Picture, Renderer, Viewer};

use crate::browser::say;

/// Two pixels differ if a channel does by more than this: edges are smoothed by other samples on another device.
const CHANNEL: u8 = 24;

/// The part of the pixels that may differ between devices.
pub(crate) const TOLERANCE: f64 = 0.001;

/// The part of the pixels that differ between a screenshot of the page and one of this process, by this machine's driver.
pub(crate) fn from_desktop(page: &Picture, viewer: &Viewer) -> Result<f64, String> {
    let shared = Device::shared()?;
    let gpu = Gpu::of(shared.device.clone(), shared.queue.clone(), shared.name.clone(), true);
    let picture = Renderer::new(gpu).map_err(say)?.screenshot(viewer, 1).map_err(say)?;
    shared.device.poll(wgpu::PollType::wait_indefinitely()).map_err(say)?;
    different(page, &pollster::block_on(picture).map_err(say)?)
}

/// The part of the pixels that differ.
pub(crate) fn different(a: &Picture, b: &Picture) -> Result<f64, String> {
    if a.size != b.size {
        return Err(format!("{:?} and {:?} pixels", a.size, b.size));
    }
    let is_other = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).any(|channel| a[channel].abs_diff(b[channel]) > CHANNEL);
    let count = a.pixels.iter().zip(&b.pixels).filter(|&pair| is_other(pair)).count();
    Ok(count as f64 / a.pixels.len() as f64)
}

/// A PNG of the page.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().map_err(say)?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or("too large")?];
    let info = reader.next_frame(&mut pixels).map_err(say)?;
    let pixels = pixels.chunks_exact(info.color_type.samples()).map(|pixel| [pixel[0], pixel[1], pixel[2], 255]);
    Ok(Picture { size: [info.width, info.height], pixels: pixels.collect() })
}
