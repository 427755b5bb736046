//! Pictures from the GPU to PNG files.

use std::io::{self, Write};
use std::path::Path;

use rimline::gpu::{DeviceError, read_back};
use rimline::wgpu;
use rimline_picture::Bounds;

use crate::device::{self, Gpu, GpuError};
use crate::failure::{Cause, Failure};
use crate::output::Line;

pub(crate) fn wrote(file: &Path, [width, height]: [u32; 2]) -> String {
    format!("wrote {} ({width}×{height})", Line(file.display()))
}

/// Rows of 8-bit sRGB with alpha, or of 8-bit grey, top first, as they lie in a buffer; or of floats, which are only read by
/// [`Picture::rows`].
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
        let is_grey = self.depth == 1;
        let mut encoder = png_encoder(to, self.size, is_grey);
        if let Some((keyword, text)) = text {
            encoder.add_text_chunk(keyword.to_owned(), text.to_owned())?;
        }
        let mut header = encoder.write_header()?;
        let mut rows = header.stream_writer()?;
        for row in self.rows() {
            if is_grey {
                rows.write_all(row)?;
            } else {
                let colours: Vec<u8> = row.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
                rows.write_all(&colours)?;
            }
        }
        Ok(rows.finish()?)
    }
}

/// Writes opaque PNGs, in colour or grey.
pub(crate) fn png_encoder<W: Write>(to: W, [width, height]: [u32; 2], is_grey: bool) -> png::Encoder<'static, W> {
    let mut encoder = png::Encoder::new(to, width, height);
    encoder.set_color(if is_grey { png::ColorType::Grayscale } else { png::ColorType::Rgb });
    encoder.set_depth(png::BitDepth::Eight);
    // Flat colours and noise that keeps gradients from showing bands: filters make them longer, and take most of
    // the time.
    encoder.set_filter(png::Filter::NoFilter);
    encoder.set_deflate_compression(png::DeflateCompression::Level(5));
    if !is_grey {
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    }
    encoder
}

/// Refuses bounds that no camera and no light can be chosen by.
pub(crate) fn check_bounds(bounds: &Bounds) -> Result<(), Cause> {
    if bounds.extent().is_finite() {
        Ok(())
    } else {
        Err("the model is larger than 32-bit numbers can say, so no camera can see it; scale it down".into())
    }
}

/// Why a picture that takes so many bytes a pixel in one array cannot be drawn, and one that can.
pub(crate) fn too_large(gpu: &Gpu, [width, height]: [u32; 2], bytes: u64) -> Failure {
    let needed = (bytes * u64::from(width) * u64::from(height)) >> 20;
    let adapter = device::describe(&gpu.info);
    let fits = fitting([width, height], gpu.device.limits().max_buffer_size / bytes);
    Failure::usage(format!(
        "--size {width}x{height} needs {needed} MiB in one array, more than {adapter} has; try --size {}x{}",
        fits[0], fits[1]
    ))
}

/// A smaller picture of about the same shape and at most so many pixels: half of each side, if that is enough.
fn fitting([width, height]: [u32; 2], pixels: u64) -> [u32; 2] {
    let asked = f64::from(width) * f64::from(height);
    let part = (pixels as f64 / asked).sqrt().min(0.5);
    [width, height].map(|side| ((f64::from(side) * part) as u32).max(1))
}

/// Refuses pictures that the device cannot draw or read back, with so many bytes a pixel in the largest array.
pub(crate) fn check_size(gpu: &Gpu, size: [u32; 2], bytes: u64) -> Result<(), Failure> {
    let [width, height] = size;
    let limits = gpu.device.limits();
    let limit = limits.max_texture_dimension_2d;
    if width.max(height) > limit {
        let adapter = device::describe(&gpu.info);
        return Err(Failure::usage(format!(
            "--size {width}x{height} is too large: {adapter} can draw at most {limit} pixels in each direction"
        )));
    }
    let [width, height] = size.map(u64::from);
    // Rows are padded to be copied.
    let read = (4 * width).next_multiple_of(256) * height;
    if read.max(bytes * width * height) > limits.max_buffer_size {
        // With room for padding.
        return Err(too_large(gpu, size, bytes.max(5)));
    }
    Ok(())
}

/// Refuses models of which the device cannot read all faces and vertices at once, as pictures do.
pub(crate) fn check_model(gpu: &Gpu, faces: usize, vertices: usize) -> Result<(), GpuError> {
    const BYTES: u64 = 12;
    let limit = gpu.device.limits().max_storage_buffer_binding_size;
    for (what, count) in [("the model's array of faces", faces), ("its array of positions", vertices)] {
        let bytes = BYTES * count as u64;
        if bytes > limit {
            return Err(DeviceError::BindingTooLarge { what, bytes, limit }.into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_that_is_advised_fits() {
        for (size, pixels, advised) in
            [([16384, 16384], 1 << 27, [8192, 8192]), ([16384, 8192], 1 << 23, [4096, 2048]), ([9, 9], 1, [1, 1])]
        {
            assert_eq!(fitting(size, pixels), advised);
            assert!(u64::from(advised[0]) * u64::from(advised[1]) <= pixels);
        }
    }
}
