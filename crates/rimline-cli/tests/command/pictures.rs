//! Pictures that the command wrote.

use std::path::Path;

use super::ensure;
use super::run::read_file;

/// A grey or colour PNG of 8 bits a channel, without alpha: all that the command writes.
pub(crate) struct Image {
    pub(crate) size: [usize; 2],
    color: png::ColorType,
    /// One value a pixel of a grey one, three of one in colour, top row first.
    pub(crate) bytes: Vec<u8>,
}

impl Image {
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let file = std::io::Cursor::new(read_file(path)?);
        let mut reader = png::Decoder::new(file).read_info().map_err(|error| failed(&error))?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
        let info = reader.next_frame(&mut bytes).map_err(|error| failed(&error))?;
        let is_known = [png::ColorType::Grayscale, png::ColorType::Rgb].contains(&info.color_type);
        ensure!(
            is_known && info.bit_depth == png::BitDepth::Eight,
            "{}: {:?}, {:?} bits",
            path.display(),
            info.color_type,
            info.bit_depth
        );
        Ok(Self { size: [info.width, info.height].map(|side| side as usize), color: info.color_type, bytes })
    }

    /// A shadow mask of a light without an area: 0 is in shadow, 128 background, 255 lit; no other value stands there.
    pub(crate) fn mask(path: &Path) -> Result<Self, String> {
        let image = Self::read(path)?;
        ensure!(image.color == png::ColorType::Grayscale, "{:?}", image.color);
        let other = image.bytes.iter().find(|value| ![0, 128, 255].contains(*value));
        ensure!(other.is_none(), "a mask holds {other:?}");
        Ok(image)
    }

    /// The value of a pixel of a grey one. It panics outside the picture.
    pub(crate) fn at(&self, x: usize, y: usize) -> u8 {
        self.bytes[y * self.size[0]..][..self.size[0]][x]
    }

    /// How many values of a grey one are this.
    pub(crate) fn count(&self, value: u8) -> usize {
        self.bytes.iter().map(|byte| usize::from(*byte == value)).sum()
    }

    /// The pixels of one in colour.
    pub(crate) fn pixels(&self) -> &[[u8; 3]] {
        self.bytes.as_chunks().0
    }

    pub(crate) fn pixels_mut(&mut self) -> &mut [[u8; 3]] {
        self.bytes.as_chunks_mut().0
    }

    /// How many pixels of one in colour are so.
    pub(crate) fn count_pixels(&self, is_counted: fn([u8; 3]) -> bool) -> Result<usize, String> {
        ensure!(self.color == png::ColorType::Rgb, "{:?}", self.color);
        Ok(self.pixels().iter().filter(|pixel| is_counted(**pixel)).count())
    }
}

/// Near black, which lines and letters are.
pub(crate) fn is_ink(pixel: [u8; 3]) -> bool {
    pixel.iter().all(|&c| c < 60)
}

/// Much more red than blue, which boundaries in orange are; red and yellow are so, too.
pub(crate) fn is_orange([red, _, blue]: [u8; 3]) -> bool {
    red > 120 && red > blue.saturating_add(80)
}

/// How many pixels of `channels` values differ in two pictures of one size: any of their values by more than `by`. With one
/// channel, how many values do.
pub(crate) fn apart([one, other]: [&[u8]; 2], channels: usize, by: u8) -> Result<usize, String> {
    ensure!(one.len() == other.len(), "pictures of {} and {} values", one.len(), other.len());
    let is_apart = |(p, q): &(&[u8], &[u8])| p.iter().zip(*q).any(|(p, q)| p.abs_diff(*q) > by);
    Ok(one.chunks(channels).zip(other.chunks(channels)).filter(is_apart).count())
}
