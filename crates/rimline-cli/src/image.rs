//! Pictures from the GPU to PNG files.

use std::io::{self, Write};
use std::path::Path;

use rimline::gpu::read_back;
use rimline::wgpu;

use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::shown::Line;

pub(crate) fn wrote(file: &Path, [width, height]: [u32; 2]) -> String {
    format!("wrote {} ({width}×{height})", Line(file.display()))
}

/// Rows of 8-bit sRGB with alpha, or of 8-bit grey, top first, as they lie in a buffer.
pub(crate) struct Picture {
    size: [u32; 2],
    /// Bytes from a row to the next, and of a pixel: 4 or 1.
    pitch: usize,
    depth: usize,
    bytes: Vec<u8>,
}

impl Picture {
    /// Copies a texture with four bytes a pixel or one. Waits for the device.
    pub(crate) fn read(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Self, GpuError> {
        let (width, height) = (texture.width(), texture.height());
        let depth = texture.format().block_copy_size(None).unwrap_or(4);
        let pitch = (depth * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(pitch) * u64::from(height);
        let buffer = gpu.buffer("picture", size, wgpu::BufferUsages::COPY_SRC);
        let mut encoder = gpu.encoder("picture");
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: None },
            },
            texture.size(),
        );
        gpu.submit(encoder);
        let mut bytes = Vec::with_capacity(pitch as usize * height as usize);
        read_back(&gpu.device, &gpu.queue, &buffer, |piece| bytes.extend_from_slice(piece))?;
        Ok(Self { size: [width, height], pitch: pitch as usize, depth: depth as usize, bytes })
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = &[u8]> {
        self.bytes.chunks(self.pitch).map(|row| &row[..self.depth * self.size[0] as usize])
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// All rows without alpha, of a picture in colour.
    pub(crate) fn rgb(&self) -> Vec<u8> {
        self.rows().flat_map(|row| row.chunks_exact(4)).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }

    /// The mean of pictures of one size, each byte rounded to the nearest; at least one picture.
    pub(crate) fn mean(mut pictures: Vec<Self>) -> Self {
        let mut mean = pictures.swap_remove(0);
        let count = pictures.len() as u32 + 1;
        if count > 1 {
            for (at, byte) in mean.bytes.iter_mut().enumerate() {
                let sum = u32::from(*byte) + pictures.iter().map(|other| u32::from(other.bytes[at])).sum::<u32>();
                *byte = ((2 * sum + count) / (2 * count)) as u8;
            }
        }
        mean
    }

    /// Writes an opaque PNG, in colour or grey, with a text under a keyword, if any.
    pub(crate) fn write_png(&self, to: impl Write, text: Option<(&str, &str)>) -> io::Result<()> {
        let [width, height] = self.size;
        let mut encoder = png::Encoder::new(to, width, height);
        let is_grey = self.depth == 1;
        encoder.set_color(if is_grey { png::ColorType::Grayscale } else { png::ColorType::Rgb });
        encoder.set_depth(png::BitDepth::Eight);
        // Flat colours and noise that keeps gradients from showing bands: filters make them longer, and take most of
        // the time.
        encoder.set_filter(png::Filter::NoFilter);
        encoder.set_deflate_compression(png::DeflateCompression::Level(5));
        if !is_grey {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        if let Some((keyword, text)) = text {
            encoder.add_text_chunk(keyword.to_owned(), text.to_owned()).map_err(io::Error::from)?;
        }
        let mut header = encoder.write_header().map_err(io::Error::from)?;
        let mut rows = header.stream_writer().map_err(io::Error::from)?;
        for row in self.rows() {
            if is_grey {
                rows.write_all(row)?;
            } else {
                let colours: Vec<u8> = row.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
                rows.write_all(&colours)?;
            }
        }
        rows.finish().map_err(io::Error::from)
    }
}
