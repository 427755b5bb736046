//! Pictures that were read back.

use super::error::RenderError;

/// A picture in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Red, green, blue and opacity of each pixel, row by row from the top, as sRGB.
    pub pixels: Vec<[u8; 4]>,
}

impl Picture {
    /// The pixel at a position, from the upper left corner. Outside of the picture all is 0.
    pub fn at(&self, [x, y]: [u32; 2]) -> [u8; 4] {
        let row = self.pixels.chunks(self.size[0].max(1) as usize).nth(y as usize);
        row.and_then(|row| row.get(x as usize)).copied().unwrap_or_default()
    }

    /// The picture as a PNG.
    ///
    /// # Errors
    /// [`RenderError::Png`] if there is no room.
    pub fn png(&self) -> Result<Vec<u8>, RenderError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let colors: Vec<u8> = self.pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
        encoder.write_header()?.write_image_data(&colors)?;
        Ok(bytes)
    }
}

/// A buffer that a texture of four bytes a pixel is copied to: rows begin at multiples of 256 bytes.
pub(super) struct Copy {
    buffer: wgpu::Buffer,
    size: [u32; 2],
    row: u32,
}

impl Copy {
    /// For textures of this size.
    pub(super) fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let row = (4 * size[0]).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row) * u64::from(size[1]),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Self { buffer, size, row }
    }

    pub(super) fn record(&self, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture) {
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(self.row), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    }

    /// The picture, once its encoder was submitted.
    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    pub(super) fn picture(&self, words: &[u32]) -> Picture {
        let rows = words.chunks(self.row as usize / 4);
        let pixels = rows.flat_map(|row| row.iter().take(self.size[0] as usize).map(|word| word.to_le_bytes()));
        Picture { size: self.size, pixels: pixels.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::Picture;

    #[test]
    fn no_pixel_is_outside() {
        let picture = Picture { size: [2, 2], pixels: vec![[1; 4], [2; 4], [3; 4], [4; 4]] };
        let pixels = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|at| picture.at(at)[0]);
        assert_eq!(pixels, [1, 2, 3, 4]);
        for at in [[2, 0], [0, 2], [u32::MAX; 2]] {
            assert_eq!(picture.at(at), [0; 4], "{at:?}");
        }
    }
}
