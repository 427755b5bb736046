//! Pictures from the GPU to PNG files.

use std::io::{self, Write};

use rimline::gpu::read_back;
use rimline::wgpu;

use crate::device::Gpu;
use crate::gpu_error::GpuError;

/// Rows of 8-bit sRGB with alpha, top first, as they lie in a buffer.
pub(crate) struct Picture {
    size: [u32; 2],
    /// Bytes from a row to the next.
    pitch: usize,
    bytes: Vec<u8>,
}

impl Picture {
    /// Copies a texture with four bytes a pixel. Waits for the device.
    pub(crate) fn read(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Self, GpuError> {
        let (width, height) = (texture.width(), texture.height());
        let pitch = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(pitch) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: None },
            },
            texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let mut bytes = Vec::with_capacity(pitch as usize * height as usize);
        read_back(&gpu.device, &gpu.queue, &buffer, |piece| bytes.extend_from_slice(piece))?;
        Ok(Self { size: [width, height], pitch: pitch as usize, bytes })
    }

    /// Writes an opaque PNG.
    pub(crate) fn write_png(&self, to: impl Write) -> io::Result<()> {
        let [width, height] = self.size;
        let mut encoder = png::Encoder::new(to, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut header = encoder.write_header().map_err(io::Error::from)?;
        let mut rows = header.stream_writer().map_err(io::Error::from)?;
        for row in self.bytes.chunks(self.pitch) {
            let pixels = row[..4 * width as usize].chunks_exact(4);
            let colours: Vec<u8> = pixels.flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
            rows.write_all(&colours)?;
        }
        rows.finish().map_err(io::Error::from)
    }
}
