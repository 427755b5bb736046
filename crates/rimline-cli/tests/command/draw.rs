//! Pictures: there, of the right size, the same twice, with the lines that belong there.

use super::npz_input::tetrahedron;
use super::run::{folder, is_empty, read_file, rimline, write_file};
use super::{Outcome, Test, ensure};
use crate::archive::{array, write_zip};

pub(crate) const TESTS: &[Test] = &[
    ("draw::a_closed_model_has_an_outline", closed),
    ("draw::an_open_model_shows_its_boundary", open),
    ("draw::an_eye_inside_or_straight_above_works", eyes),
    ("draw::without_a_finite_position_there_is_no_picture", nothing),
];

pub(crate) struct Picture {
    bytes: Vec<u8>,
    pub(crate) size: [u32; 2],
    pub(crate) pixels: Vec<[u8; 3]>,
}

fn draw(model: &[u8], options: &str) -> Result<Picture, String> {
    draw_with(model, options, "auto")
}

pub(crate) fn draw_with(model: &[u8], options: &str, device: &str) -> Result<Picture, String> {
    let folder = folder();
    let (file, out) = (folder.path().join("m.npz"), folder.path().join("p.png"));
    write_file(&file, model)?;
    let (file, out) = (file.to_string_lossy(), out.to_string_lossy());
    let line = ["draw", &file, "--out", &out, "--device", device].into_iter().chain(options.split_whitespace());
    rimline(line).expect(0, &[])?;
    png(out.as_ref().as_ref())
}

/// Reads a picture in colour.
pub(crate) fn png(file: &std::path::Path) -> Result<Picture, String> {
    let bytes = read_file(file)?;
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().map_err(|error| error.to_string())?;
    let mut data = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
    let info = reader.next_frame(&mut data).map_err(|error| error.to_string())?;
    ensure!(info.color_type == png::ColorType::Rgb, "{:?}", info.color_type);
    let pixels = data.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    Ok(Picture { bytes, size: [info.width, info.height], pixels })
}

impl Picture {
    fn count(&self, is_counted: fn([u8; 3]) -> bool) -> usize {
        self.pixels.iter().filter(|pixel| is_counted(**pixel)).count()
    }
}

pub(crate) fn is_ink(pixel: [u8; 3]) -> bool {
    pixel.iter().all(|&c| c < 60)
}

pub(crate) fn is_orange([red, _, blue]: [u8; 3]) -> bool {
    red > 120 && red > blue.saturating_add(80)
}

fn closed() -> Outcome {
    let options = "--size 601x403 --eye 3,2,4";
    let picture = draw(&tetrahedron(), options)?;
    ensure!(picture.size == [601, 403], "{:?}", picture.size);
    ensure!(picture.count(is_ink) > 150, "{} pixels of ink", picture.count(is_ink));
    ensure!(picture.count(is_orange) == 0, "a boundary on a closed model");
    let again = draw(&tetrahedron(), options)?;
    ensure!(picture.bytes == again.bytes, "two runs differ");
    // Another eye, another picture: the comparison above can fail.
    let other = draw(&tetrahedron(), "--size 601x403 --eye 3,2,3")?;
    ensure!(picture.bytes != other.bytes, "two eyes see the same");
    Ok(())
}

fn triangle(coordinates: [f32; 9]) -> Vec<u8> {
    let data: Vec<u8> = coordinates.iter().flat_map(|c| c.to_le_bytes()).collect();
    write_zip(&[
        array("positions", "<f4", "False", "(3, 3)", &data),
        array("faces", "|u1", "False", "(1, 3)", &[0, 1, 2]),
    ])
}

fn open() -> Outcome {
    let picture = draw(&triangle([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]), "--size 200x200 --show-boundary")?;
    ensure!(picture.count(is_orange) > 150, "{} orange pixels", picture.count(is_orange));
    ensure!(picture.count(is_ink) == 0, "a silhouette on a flat model");
    let picture = draw(&triangle([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]), "--size 200x200")?;
    ensure!(picture.count(is_orange) == 0 && picture.count(is_ink) > 150, "a boundary that has no colour of its own");
    Ok(())
}

fn eyes() -> Outcome {
    for eye in ["0.1,0.1,0.1", "0.25,5,0.25", "0.25,-5,0.25", "-1e3,2e0,.5", "1e30,0,0"] {
        draw(&tetrahedron(), &format!("--size 64x64 --eye {eye}")).map_err(|error| format!("{eye}: {error}"))?;
    }
    // So far from the origin that neighbouring floats are 2 apart.
    let far = [2.5e7, 2.5e7, 2.5e7, 2.5e7 + 64.0, 2.5e7, 2.5e7, 2.5e7, 2.5e7 + 64.0, 2.5e7];
    let picture = draw(&triangle(far), "--size 128x128 --show-boundary")?;
    ensure!(picture.count(is_orange) > 60, "{} orange pixels", picture.count(is_orange));
    // One point three times.
    draw(&triangle([1.0; 9]), "--size 64x64 --no-weld").map(|_| ())
}

fn nothing() -> Outcome {
    let folder = folder();
    let file = folder.path().join("m.npz");
    write_file(&file, triangle([f32::NAN; 9]))?;
    let out = folder.path().join("results");
    std::fs::create_dir(&out).map_err(|error| error.to_string())?;
    let (file, png) = (file.to_string_lossy(), out.join("p.png"));
    rimline(["draw", &file, "--out", &png.to_string_lossy()]).expect(1, &["finite"])?;
    is_empty(&out)
}
