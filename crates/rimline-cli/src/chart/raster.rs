//! A drawing as PNG.

use std::io::{self, Write};
use std::sync::Arc;

use resvg::{tiny_skia, usvg};

/// Writes an SVG that was drawn for a file. Its lengths are pixels already, two of them to a CSS pixel: sharp on screens
/// that have so many.
pub(crate) fn write_png(svg: &str, to: impl Write) -> io::Result<()> {
    let mut options = usvg::Options { font_family: "Ubuntu".to_owned(), ..usvg::Options::default() };
    Arc::make_mut(&mut options.fontdb).load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let tree = usvg::Tree::from_str(svg, &options).map_err(io::Error::other)?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|side| side.ceil() as u32);
    let mut picture = tiny_skia::Pixmap::new(width, height).ok_or_else(|| io::Error::other("the plot has no size"))?;
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut picture.as_mut());
    // The ground is opaque, so alpha says nothing.
    let colours: Vec<u8> = picture.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut encoder = png::Encoder::new(to, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(io::Error::from)?;
    writer.write_image_data(&colours).map_err(io::Error::from)?;
    writer.finish().map_err(io::Error::from)
}
