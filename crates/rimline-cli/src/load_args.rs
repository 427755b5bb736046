//! The options of every command that reads models.

use clap::Args;
use rimline::gltf::LoadOptions;
use rimline::mesh::Weld;

/// Limits for model files.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct LoadArgs {
    /// The largest memory that reading one file, and making its mesh, may take at one time, such as 512MiB, 16GiB or a number
    /// of bytes. A file that states more is refused before its data is read. Small files can need a lot of memory
    #[arg(long, value_name = "SIZE", default_value = "4GiB", value_parser = bytes)]
    pub(crate) memory_limit: u64,

    /// Allow a glTF file to read buffers outside its folder, through `..`, an absolute path or a symbolic link
    #[arg(long)]
    allow_outside: bool,
}

impl LoadArgs {
    pub(crate) fn options(self, weld: Weld) -> LoadOptions {
        LoadOptions { weld, memory_limit: self.memory_limit, allow_outside: self.allow_outside }
    }
}

/// How polygons of an .obj are taken. Polygons of an .npz are always taken whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TakenPolygons {
    /// Triangles, which are drawn.
    Triangles,
    /// Triangles, and polygons to describe.
    Described,
    /// Each is one face.
    Whole,
}

/// Units of sizes, and how many bits to shift by.
const UNITS: [(&str, u32); 4] = [("KiB", 10), ("MiB", 20), ("GiB", 30), ("TiB", 40)];

/// A number of bytes, or of one of [`UNITS`].
fn bytes(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let shift = match unit.trim_start() {
        "" => Some(0),
        unit => UNITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit)).map(|(_, shift)| *shift),
    };
    let size = shift.zip(number.parse::<u64>().ok()).and_then(|(shift, number)| number.checked_mul(1 << shift));
    let size = size.filter(|&size| size > 0);
    size.ok_or_else(|| {
        "a size is a whole number of bytes, KiB, MiB, GiB or TiB, such as 512MiB, from 1 byte to less than 16777216TiB"
            .to_owned()
    })
}

/// A number of bytes for people: in the largest unit of which there is one, rounded up to a tenth.
pub(crate) fn size(bytes: u64) -> String {
    match UNITS.iter().rev().find(|(_, shift)| bytes >> shift > 0) {
        Some((name, shift)) => {
            let tenths = (u128::from(bytes) * 10).div_ceil(1 << shift);
            match tenths % 10 {
                0 => format!("{} {name}", tenths / 10),
                tenth => format!("{}.{tenth} {name}", tenths / 10),
            }
        }
        None => format!("{bytes} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        for (text, expected) in [
            ("1", 1),
            ("1000", 1000),
            ("1KiB", 1024),
            ("4GiB", 4 << 30),
            ("4 gib", 4 << 30),
            ("3TiB", 3 << 40),
            ("18446744073709551615", u64::MAX),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for text in ["", "0", "0GiB", "GiB", "-1", "1.5GiB", "4GB", "4g", "1 2", "18446744073709551616", "16777216TiB"]
        {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_are_written() {
        for (bytes, expected) in [
            (0, "0 bytes"),
            (1023, "1023 bytes"),
            (1024, "1 KiB"),
            (1025, "1.1 KiB"),
            (4 << 30, "4 GiB"),
            ((9 << 30) + (1 << 29), "9.5 GiB"),
            (u64::MAX, "16777216 TiB"),
        ] {
            assert_eq!(size(bytes), expected);
        }
    }

    #[test]
    fn the_default_is_the_library_s() {
        assert_eq!(bytes("4GiB"), Ok(LoadOptions::DEFAULT_MEMORY_LIMIT));
    }
}
